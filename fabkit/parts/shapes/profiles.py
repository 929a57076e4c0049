"""Solids of bars: any profile, with sharp or rounded corners, or a circle, between two planes across the x axis; and
bores.

A plane is given by x at the axis and its slopes along y and z: x = plane[0] + plane[1] y + plane[2] z.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np
import shapely

from fabkit.parts.shapes.topology import SHAFT, Topology, prism_topology
from geometry.arrays import FloatArray

__all__ = ["bore_vertices", "profile_topology", "profile_vertices", "round_vertices"]

STRAIGHT_CORNER_SINE = 1e-9
"""Sine of the inward turn at a corner, up to which a piece of a profile counts as convex: rounding of a straight
corner."""
RIGHT_ANGLE_COSINE = 1e-9
"""Cosine of the angle at a corner up to which it is a right one: over a radius of 10 mm a fillet is off by 1e-8 mm."""
SAME_LEAN_SINE = 1e-9
"""Sine of the angle between the directions in which both ends of a round lean, up to which these are one: over 1 m a
rim is off its plane by 1e-6 mm."""


def profile_topology(loops: Sequence[FloatArray], radii: Sequence[float] = ()) -> Topology:
    """A bar with this profile: the corners (n, 2), as (y, z), of its outline, counter-clockwise, and of its holes,
    clockwise. radii: of the fillets at the corners of each loop, which are then right angles; 0 or none for sharp ones.

    Vertices: those of all loops in their order at the first end, two for each corner with a fillet, and the tips of the
    fillets; then the same at the second end. Faces: first end, second end, then the side from each corner to the next
    one of its loop, then the fillets. A profile with holes or fillets, or that is not convex, has a convex piece for
    each convex part of it, cut from corner to corner; they have sharp edges in place of fillets that are rounded off,
    and flat ones in place of those in hollow corners, and so contain a little more than the solid. Equal profiles have
    the same topology.

    >>> from fabkit.parts import Section, profile_topology
    >>> hollow = profile_topology(Section.of("rhs 120x60x5").loops)
    >>> hollow.n_vertices, hollow.n_faces, len(hollow.loops(0)), len(hollow.pieces)
    (16, 10, 2, 4)
    >>> section = Section.of("rhs 120x60x5 r10")
    >>> rounded = profile_topology(section.loops, section.corner_radii)
    >>> rounded.n_vertices, rounded.n_faces, len(rounded.fillets)
    (48, 18, 8)
    """
    points, loop_points, fillets = _rounded(loops, radii)
    if not fillets and len(loops) == 1 and _is_convex(loops[0]):
        return prism_topology(len(loops[0]))
    containing = _containing(loop_points, fillets)
    pieces = _convex_pieces([points[own] for own in containing])
    numbers = np.concatenate(containing).tolist()
    return _profile_topology(
        tuple(map(tuple, loop_points)), fillets, tuple(tuple(numbers[k] for k in piece) for piece in pieces)
    )


Fillet = tuple[int, int, int, int]
"""Both ends of the arc of a fillet, its tip, and its sense."""


def _rounded(
    loops: Sequence[FloatArray], radii: Sequence[float]
) -> tuple[FloatArray, list[list[int]], tuple[Fillet, ...]]:
    """The points (n, 2) of a profile, the numbers of those of each loop, and the fillets."""
    points: list[FloatArray] = []
    tips: list[FloatArray] = []
    fillets: list[Fillet] = []
    numbers: list[list[int]] = []
    for loop, radius in zip(loops, radii or [0.0] * len(loops), strict=True):
        first = sum(map(len, points))
        if not radius:
            points.append(loop)
        else:
            ahead = np.roll(loop, -1, axis=0) - loop
            ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
            behind = np.roll(ahead, 1, axis=0)
            if np.abs((ahead * behind).sum(axis=1)).max() > RIGHT_ANGLE_COSINE:
                raise ValueError("only corners that are right angles have fillets")
            points.append(np.stack([loop - radius * behind, loop + radius * ahead], axis=1).reshape(-1, 2))
            turns = np.sign(behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]).astype(int).tolist()
            fillets += [(first + 2 * k, first + 2 * k + 1, len(fillets) + k, turn) for k, turn in enumerate(turns)]
            tips.append(loop)
        numbers.append(list(range(first, first + len(points[-1]))))
    n = sum(map(len, points))
    return np.concatenate([*points, *tips]), numbers, tuple((a, b, n + tip, sense) for a, b, tip, sense in fillets)


def _containing(loops: list[list[int]], fillets: Sequence[Fillet]) -> list[list[int]]:
    """The loops with the tip in place of the arc of each fillet that is rounded off."""
    sharp = {a: tip for a, _, tip, sense in fillets if sense == SHAFT}
    left_out = {b for _, b, _, sense in fillets if sense == SHAFT}
    return [[sharp.get(k, k) for k in loop if k not in left_out] for loop in loops]


@lru_cache(maxsize=256)
def _profile_topology(
    loops: tuple[tuple[int, ...], ...], fillets: tuple[Fillet, ...], pieces: tuple[tuple[int, ...], ...]
) -> Topology:
    n = sum(map(len, loops)) + len(fillets)
    below = [np.array(loop) for loop in loops]
    faces = [[loop[::-1] for loop in below], [loop + n for loop in below]]
    sides = [(k, following) for loop in loops for k, following in pairwise([*loop, loop[0]])]
    arcs = [(a, b) for a, b, *_ in fillets]
    flat = [side for side in sides if side not in set(arcs)]
    faces += [[np.array([k, following, following + n, k + n])] for k, following in [*flat, *arcs]]
    corners = [loop for face in faces for loop in face]
    return Topology(
        2 * n,
        np.concatenate(corners),
        np.cumsum([0, *map(len, corners)]),
        np.cumsum([0, *map(len, faces)]),
        pieces=tuple((np.array([*piece, *(n + k for k in piece)]), prism_topology(len(piece))) for piece in pieces),
        fillets=np.array(
            [(2 + len(flat) + k, tip, tip + n, sense) for k, (*_, tip, sense) in enumerate(fillets)], dtype=np.int64
        ).reshape(-1, 4),
    )


def profile_vertices(
    loops: Sequence[FloatArray], first: FloatArray, second: FloatArray, *, radii: Sequence[float] = ()
) -> FloatArray:
    """(..., 2n, 3) vertices of bars with this profile, as in `profile_topology`, from the planes `first` (..., 3) to
    `second`.

    >>> from fabkit.parts import profile_topology, profile_vertices, Section, Solid
    >>> loops = Section.of("rhs 120x60x5").loops
    >>> vertices = profile_vertices(loops, np.array([0.0, 0.0, 0.1]), np.array([1000.0, 0.0, -0.2]))
    >>> round(Solid(vertices, profile_topology(loops)).volume_mm3, 6)
    1700000.0
    """
    points, *_ = _rounded(loops, radii)

    def at(plane: FloatArray) -> FloatArray:
        x = plane[..., :1] + plane[..., 1:] @ points.T
        return np.concatenate([x[..., None], np.broadcast_to(points, (*x.shape, 2))], axis=-1)

    return np.concatenate([at(np.asarray(first)), at(np.asarray(second))], axis=-2)


def round_vertices(
    radii: Sequence[float] | FloatArray,
    first: FloatArray,
    second: FloatArray,
    *,
    at: FloatArray | Sequence[float] = (0.0, 0.0),
) -> FloatArray:
    """(..., 4k, 3) vertices of k rounds with these radii (k,) or (..., k) about one axis along x through (y, z) = at
    (..., 2), from the planes `first` (..., 3) to `second`: for `shaft_topology`, or a bore for `Topology.bored`.

    Raises ValueError where the two planes lean in different planes.

    >>> from fabkit.parts import round_vertices, shaft_topology, Solid
    >>> tube = round_vertices((30.0, 26.0), np.array([0.0, 0.0, 0.1]), np.array([1000.0, 0.0, 0.0]))
    >>> round(Solid(tube, shaft_topology(hollow=True)).volume_mm3 / np.pi, 6)
    224000.0
    """
    first, second, at = (np.asarray(each, dtype=np.float64) for each in (first, second, at))
    slopes = np.broadcast_arrays(first[..., 1:], second[..., 1:])
    steep = np.where((np.abs(slopes[0]).sum(-1) >= np.abs(slopes[1]).sum(-1))[..., None], *slopes)
    size = np.linalg.norm(steep, axis=-1, keepdims=True)
    across = np.where(size > 0, steep / np.where(size > 0, size, 1.0), [0.0, 1.0])
    aside = [slope[..., 0] * across[..., 1] - slope[..., 1] * across[..., 0] for slope in slopes]
    if max(np.abs(each).max(initial=0.0) for each in aside) > SAME_LEAN_SINE:
        raise ValueError("the two ends of a round must lean in one plane: cut one of them square")
    rims = at[..., None, :] + np.asarray(radii, dtype=np.float64)[..., None] * across[..., None, :]
    centres = np.broadcast_to(at[..., None, :], rims.shape)
    across_axis = np.stack([centres, rims], axis=-2)  # (..., k, 2, 2)

    def on(plane: FloatArray) -> FloatArray:
        x = plane[..., None, None, 0] + np.einsum("...kij,...j->...ki", across_axis, plane[..., 1:])
        return np.concatenate([x[..., None], across_axis], axis=-1)

    both = np.concatenate([on(first), on(second)], axis=-2)
    return both.reshape(*both.shape[:-3], both.shape[-3] * both.shape[-2], 3)


def bore_vertices(first: FloatArray, second: FloatArray, radius: FloatArray | float, across: FloatArray) -> FloatArray:
    """(..., 4, 3) first centre, first rim, second centre and second rim of bores, or bars, with ends perpendicular to
    the axis: centres first, second (..., 3), radius (...), and the direction of the rims, `across` (..., 3), of which
    only the part perpendicular to the axis counts.

    >>> from fabkit.parts import bore_vertices
    >>> bore_vertices(np.zeros(3), np.array([0, 0, 9.0]), 2.0, np.array([5.0, 0, 7])).tolist()
    [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 9.0], [2.0, 0.0, 9.0]]
    """
    axis = second - first
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    across = across - (across * axis).sum(axis=-1, keepdims=True) * axis
    rim = np.asarray(radius)[..., None] * across / np.linalg.norm(across, axis=-1, keepdims=True)
    return np.stack(np.broadcast_arrays(first, first + rim, second, second + rim), axis=-2)


# --- convex pieces


def _is_convex(loop: FloatArray) -> bool:
    ahead = np.roll(loop, -1, axis=0) - loop
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    behind = np.roll(ahead, 1, axis=0)
    turns = behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0]
    return bool((turns >= -STRAIGHT_CORNER_SINE).all())


def _convex_pieces(loops: Sequence[FloatArray]) -> tuple[tuple[int, ...], ...]:
    """Points of convex polygons that fill the profile: triangles, joined while the result is convex."""
    points = np.concatenate(loops)
    polygon = shapely.Polygon(loops[0], loops[1:])
    if not polygon.is_valid:
        raise ValueError("the outline or a hole of the profile crosses or touches itself or another one")
    number = {tuple(point): k for k, point in enumerate(points.tolist())}
    triangles = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    pieces = [[number[point] for point in shapely.orient_polygons(one).exterior.coords[:3]] for one in triangles]
    joined = True
    while joined:
        joined = False
        for first, second in ((a, b) for k, a in enumerate(pieces) for b in pieces[:k]):
            union = _joined(first, second)
            if union and _is_convex(points[union]):
                pieces = [piece for piece in pieces if piece is not first and piece is not second] + [union]
                joined = True
                break
    return tuple(sorted(_from_least(piece) for piece in pieces))


def _joined(first: list[int], second: list[int]) -> list[int]:
    """The polygon of two that share an edge, none where they do not."""
    for k in range(len(first)):
        own = first[k + 1 :] + first[: k + 1]
        for m in range(len(second)):
            other = second[m:] + second[:m]
            if (own[0], own[-1]) == (other[0], other[1]):
                return own + other[2:]
    return []


def _from_least(piece: list[int]) -> tuple[int, ...]:
    least = piece.index(min(piece))
    return (*piece[least:], *piece[:least])

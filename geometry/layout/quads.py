"""A quad-dominant mesh laid on a surface along a network of conjugate curves [Pottmann2007, 4.3]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np

from geometry.arrays import BoolArray, ComplexArray, FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import FoldedError, GeometryError, finite_number
from geometry.layout.drafts import Draft, draft
from geometry.layout.quality import LayoutQuality, along_network, layout_quality
from geometry.layout.seams import SeamlessMaps, seamless_maps
from geometry.layout.twists import twist_corrections
from geometry.mesh import Mesh
from geometry.mesh.mesh_polylines import mesh_polylines
from geometry.networks.combed_fields import CombedField
from geometry.networks.conjugate_networks import conjugate_network
from geometry.networks.graded_sizes import graded_sizes
from geometry.networks.networks import Network
from geometry.networks.tangent_frames import TangentFrames
from geometry.surface import Surface
from geometry.surface.surface import check_points

__all__ = [
    "FEWEST_FACES",
    "LARGEST_LENGTH_RATIO",
    "Boundary",
    "LaidMesh",
    "affine_map",
    "boundary_lengths",
    "lay_quads",
]

Boundary = Literal["open", "aligned"]
"""Whether lines end at the boundary ("open") or the boundary consists of lines ("aligned")."""

LARGEST_ALIGNED_ANGLE = np.radians(40.0)
"""Largest angle, in radians, between a boundary edge and a direction of the network for the edge to become part of a
line of the mesh."""

FEWEST_FACES = 4
"""Least number of faces for which lines can be laid on a surface."""

TWIST_CORRECTIONS = 2
"""Largest number of times that the twist of a mesh is measured and the lines laid anew: a third time changes the moves
of planarising by a tenth or less."""

WORTHWHILE_PLANARITY_RATIO = 0.95
"""Mean planarity of a mesh over that before its twist was made good, above which the rest is noise or rim."""

SINGULAR_DETERMINANT = 1e-6
"""Determinant of an affine map over the cube of its size, below which it is not invertible."""


LARGEST_LENGTH_RATIO = 10.0
"""Largest ratio of edge lengths that can be asked for: beyond, faces between long and short edges are distorted."""


@dataclass(frozen=True, eq=False)
class LaidMesh:
    """A mesh with its vertices on the surface and nearly planar faces, which `planarise` makes planar.

    polylines: two families, each the vertices along a polyline of inner edges, see `mesh_polylines`. Most edges of
    the first family are nearer to the first direction of the network than to the second; around singularities of odd
    index the families are exchanged. singularities (k,): vertices; singular_indices (k,): their valence is 4 - index.
    edge_length: the typical one, given or computed from n_faces. network: the directions that the edges follow.

    >>> import numpy as np
    >>> from geometry import Mesh, Surface, lay_quads
    >>> x, y = np.meshgrid(np.linspace(-1, 1, 15), np.linspace(-1.5, 1.5, 22), indexing="ij")
    >>> paraboloid = Mesh.from_grid(np.stack([x, y, -0.3 * x**2 - 0.1 * y**2], axis=2))
    >>> laid = lay_quads(Surface(paraboloid), n_faces=60)
    >>> laid.singularities.tolist(), round(laid.edge_length, 1)  # all inner vertices have valence 4
    ([], 0.3)
    """

    __repr__ = short_repr

    mesh: Mesh
    polylines: tuple[tuple[IntArray, ...], tuple[IntArray, ...]]
    singularities: IntArray
    singular_indices: IntArray
    edge_length: float
    network: Network
    quality: LayoutQuality


def lay_quads(
    surface: Surface,
    *,
    n_faces: int | None = None,
    edge_length: float | None = None,
    affine: Any = None,
    boundary: Boundary | Sequence[Boundary] = "open",
    strokes: Sequence[Any] = (),
    finer_where_curved: float = 1.0,
) -> LaidMesh:
    """Quads of about one size along principal lines, or along other conjugate lines.

    n_faces or edge_length: one of the two gives the size of the quads. affine (3, 3): a map; the lines are the curves
    that become principal lines of the image of the surface. The more it stretches, the smaller their crossing angles.
    boundary: "open", lines end there; or "aligned", it consists of lines, which may add singularities; or a list with
    one of these words for each boundary loop, the longest first, in the order of `boundary_lengths`.
    strokes: polylines (k, 3) near the surface, of any length, whose directions the lines follow.
    finer_where_curved: how many times longer edges may be where the surface is flattest than where it curves most;
    between these, chords are to be equally far from the surface. 1: all edges are to be of one length. Lines that are
    conjugate cannot have any distances: `quality.length_shares` has the lengths that were reached.
    Where the surface is flat or umbilic, directions continue from its surroundings; if it is so everywhere, they follow
    the longest direction of the surface.
    Raises GeometryError for numbers that do not fit the surface, surfaces that cross themselves, curvature that cannot
    be estimated, boundary loops smaller than a face, and FoldedError where the lines cannot be laid without a fold.

    >>> import numpy as np
    >>> from geometry import Mesh, Surface, lay_quads
    >>> x, y = np.meshgrid(np.linspace(-1, 1, 15), np.linspace(-1.5, 1.5, 22), indexing="ij")
    >>> paraboloid = Mesh.from_grid(np.stack([x, y, -0.3 * x**2 - 0.1 * y**2], axis=2))
    >>> laid = lay_quads(Surface(paraboloid), n_faces=60)
    >>> bool(40 < laid.mesh.n_faces < 80), len(laid.singularities), bool(laid.mesh.planarity.max() < 0.05)
    (True, 0, True)
    """
    _check(surface, n_faces, edge_length)
    _check_ratio(finer_where_curved)
    mesh, origin = surface.triangulated.near_zero()
    frames = TangentFrames(mesh)
    align = _aligned_edges(mesh, boundary)
    network, field, undirected = conjugate_network(frames, affine_map(affine), align, _strokes(strokes, origin))
    maps = seamless_maps(mesh.combinatorics, field, _lines(network, align))

    area = float(frames.areas.sum())
    count = float(n_faces) if n_faces is not None else area / float(edge_length or 1) ** 2
    if finer_where_curved > 1:
        network = network.with_sizes(graded_sizes(frames, finer_where_curved, np.sqrt(area / count)))
    final = _corrected_draft(network, field, maps, count)
    indices = np.where(final.vertices >= 0, field.indices[final.vertices], 0)
    singular = np.flatnonzero(indices)
    laid, along = final.mesh, along_network(final.mesh, network)
    return LaidMesh(
        laid.translated(origin),
        _families(laid, along),
        integers(singular),
        integers(indices[singular]),
        final.edge_length,
        network,
        layout_quality(laid, along, Surface(mesh), undirected),
    )


def _corrected_draft(network: Network, field: CombedField, maps: SeamlessMaps, n_faces: float) -> Draft:
    """A mesh of about n_faces faces whose lines make good for the twist measured in meshes before it; the last one
    that is not folded. Raises FoldedError where the first one is."""
    best = draft(network, field, maps, n_faces)
    corrected, wanted = network, n_faces
    for _ in range(TWIST_CORRECTIONS):
        corrected = corrected.corrected(twist_corrections(corrected, best.derivatives, best.mesh, best.edge_length))
        wanted *= n_faces / best.mesh.n_faces  # the rim adds or removes faces
        before = float(best.mesh.planarity.mean())
        try:
            best = draft(corrected, field, maps, wanted)
        except FoldedError:
            break
        if best.mesh.planarity.mean() > WORTHWHILE_PLANARITY_RATIO * before:
            break
    return best


def boundary_lengths(surface: Surface) -> FloatArray:
    """Lengths (k,) of the boundary loops of a surface, longest first.

    >>> from geometry import Surface, boundary_lengths
    >>> from geometry.mesh import shapes
    >>> boundary_lengths(Surface(shapes.grid(2, 3))).tolist()
    [10.0]
    """
    return floats([length for _, length in _loops(surface.triangulated)])


def _check(surface: Surface, n_faces: int | None, edge_length: float | None) -> None:
    if not isinstance(surface, Surface):
        raise GeometryError(f"the surface is a {type(surface).__name__}: wrap the mesh in Surface(mesh)")
    if (n_faces is None) == (edge_length is None):
        raise GeometryError("give either a number of faces or an edge length")
    area = float(np.linalg.norm(surface.triangulated.vector_areas, axis=1).sum())
    given = n_faces if n_faces is not None else edge_length
    if not isinstance(given, (int, float, np.integer, np.floating)) or not 0 < given < np.inf:
        name = "number of faces" if n_faces is not None else "edge length"
        raise GeometryError(f"the {name} is {given!r}: a number above 0 is needed")
    count = given if n_faces is not None else area / given**2
    if count < FEWEST_FACES:
        longest = np.sqrt(area / FEWEST_FACES)
        raise GeometryError(
            f"about {count:.2g} faces would be laid on a surface of area {area:.4g}, at least {FEWEST_FACES} are "
            f"needed: give an edge length of {longest:.3g} or less",
            value=float(count),
            bound=FEWEST_FACES,
        )
    surface.check_embedded()


def _check_ratio(finer_where_curved: float) -> None:
    ratio = finite_number("finer_where_curved", finer_where_curved)
    if not 1 <= ratio <= LARGEST_LENGTH_RATIO:
        raise GeometryError(
            f"finer_where_curved is {ratio:g}: a number from 1, for edges of one length, to "
            f"{LARGEST_LENGTH_RATIO:g} is needed",
            value=ratio,
            bound=1.0 if ratio < 1 else LARGEST_LENGTH_RATIO,
        )


def _loops(mesh: Mesh) -> list[tuple[IntArray, float]]:
    """The vertices of each boundary loop, and its length, longest first."""
    loops = mesh.combinatorics.boundary_loops
    lengths = [np.linalg.norm(np.diff(mesh.vertices[np.append(loop, loop[0])], axis=0), axis=1).sum() for loop in loops]
    order = np.argsort(-np.array(lengths), kind="stable")
    return [(loops[k], float(lengths[k])) for k in order]


def _aligned_edges(mesh: Mesh, boundary: Boundary | Sequence[Boundary]) -> BoolArray:
    """(E,) which are to be lines of the mesh. Raises GeometryError for other words, or a wrong number of them."""
    c = mesh.combinatorics
    is_rim = c.is_boundary_edge
    for word in [boundary] if isinstance(boundary, str) else boundary:
        if word not in get_args(Boundary):
            raise GeometryError(f"the boundary is {word!r}: it is 'open' or 'aligned', or a list of these words")
    if isinstance(boundary, str):
        return is_rim if boundary == "aligned" else np.zeros_like(is_rim)
    loops = _loops(mesh)
    if len(boundary) != len(loops):
        lengths = ", ".join(f"{length:.4g}" for _, length in loops) or "none"
        raise GeometryError(
            f"{len(boundary)} boundaries are given for a surface with {len(loops)} boundary loops (of lengths "
            f"{lengths}): give one word for each loop, longest first, or a single one for all",
            value=float(len(boundary)),
            bound=float(len(loops)),
        )
    is_aligned = np.zeros(c.n_vertices, dtype=bool)
    for (loop, _), word in zip(loops, boundary, strict=True):
        is_aligned[loop] |= word == "aligned"
    return np.asarray(is_rim & is_aligned[c.edges].all(axis=1))


def _strokes(given: Sequence[Any], origin: FloatArray) -> list[FloatArray]:
    """The given polylines (k, 3) minus the origin (3,). Raises GeometryError where one has no direction."""
    strokes = []
    for number, points in enumerate(given):
        stroke = check_points(points)
        if len(stroke) < 2 or not np.ptp(stroke, axis=0).any():
            raise GeometryError(f"stroke {number} has no direction: give at least 2 points, not all in one place")
        strokes.append(stroke - origin)
    return strokes


def affine_map(given: Any) -> FloatArray | None:
    """The given map as a matrix (3, 3); None for the identity. Raises GeometryError where it is not invertible."""
    if given is None:
        return None
    affine = floats(given)
    if (
        affine.shape != (3, 3)
        or not np.isfinite(affine).all()
        or abs(np.linalg.det(affine)) <= SINGULAR_DETERMINANT * (affine**2).sum() ** 1.5
    ):
        raise GeometryError(
            f"the affine map is {affine.tolist()}: an invertible matrix of 3 rows of 3 numbers is needed"
        )
    return affine


def _lines(network: Network, align: BoolArray) -> BoolArray:
    """(C, 2) for each half-edge whether it is on an aligned boundary where u (column 0) or v (column 1) is constant."""
    c = network.frames.combinatorics
    sides = network.frames.sides.ravel()
    triangles = np.arange(c.n_corners) // 3
    angles = np.stack(
        [_line_angles(sides, network.second[triangles]), _line_angles(sides, network.first[triangles])], axis=1
    )
    nearest = angles.argmin(axis=1)
    lines = np.zeros((c.n_corners, 2), dtype=bool)
    aligned = np.flatnonzero((c.twin < 0) & align[c.corner_edge] & (angles.min(axis=1) < LARGEST_ALIGNED_ANGLE))
    lines[aligned, nearest[aligned]] = True
    by_triangle = lines.reshape(-1, 3, 2)
    is_flattened = by_triangle.sum(axis=1) > 1  # u or v would be constant in the whole triangle
    return np.asarray((by_triangle & ~is_flattened[:, None]).reshape(-1, 2))


def _line_angles(a: ComplexArray, b: ComplexArray) -> FloatArray:
    """(n,) angles in radians, at most pi / 2, between lines with directions a (n,) and b (n,)."""
    angles = np.abs(np.angle(a * b.conj()))
    return np.asarray(np.minimum(angles, np.pi - angles))


def _families(mesh: Mesh, along: FloatArray) -> tuple[tuple[IntArray, ...], tuple[IntArray, ...]]:
    """Polylines of the first and of the second family: by the direction of the network to which most of their edges are
    nearer. along (2, n): see `along_network`."""
    lines, line_of_edge = mesh_polylines(mesh.combinatorics)
    votes = np.bincount(line_of_edge[line_of_edge >= 0], np.sign(along[0] - along[1]), minlength=len(lines))
    first = tuple(line for line, vote in zip(lines, votes.tolist(), strict=True) if vote >= 0)
    return first, tuple(line for line, vote in zip(lines, votes.tolist(), strict=True) if vote < 0)

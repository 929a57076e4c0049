"""Which vertices bound which faces of a solid: planar faces with polygonal loops, and round bars, bores and fillets
between them.

A *round* is a cylinder between two planar faces: a *shaft* with the material inside, a *bore* with the material
outside. Its *centres* are the points of its axis in the two faces, its *rims* a point on either edge; both are vertices
of the solid, so whatever moves vertices moves rounds too.

A *fillet* is a quarter of a cylinder in the place of a sharp edge between two planar faces at right angles. It is a
face with four corners, two sides of which are arcs; its *tips* are the ends of the edge that it replaces.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from geometry.arrays import FloatArray, IntArray, integers
from geometry.mesh.ragged_arrays import next_in_row, row_of_entry

__all__ = ["BORE", "SHAFT", "Topology", "prism_topology", "shaft_topology"]

SHAFT, BORE = 1, -1
"""Sense of a round: material inside, material outside."""

Piece = tuple[IntArray, "Topology"]


@dataclass(frozen=True, eq=False)
class Topology:
    """Faces of a solid, each an outer loop and any number of inner ones.

    n_vertices: number of vertices.
    corners (C,): vertex of each corner, loop after loop; outer loops run counter-clockwise seen from outside
        the solid, inner loops clockwise.
    loop_starts (L+1,): loop l has the corners loop_starts[l] .. loop_starts[l+1] - 1.
    face_starts (F+1,): face f has the loops face_starts[f] .. face_starts[f+1] - 1, the outer one first. A face of
        rounds alone has none; its outer loop is then its first shaft, or its first bore if it has no shaft.
    rounds (K, 7): first centre, first rim, second centre, second rim (vertices), first face, second face, and sense:
        `SHAFT` or `BORE`. The line of the rims is parallel to that of the centres, the axis. Where a face is not
        perpendicular to the axis, the edge is an ellipse and the rim an end of its major axis; so two oblique faces
        must lean in one plane. Centres and rims are not corners.
    fillets (Q, 4): face, first tip, second tip, and sense: `SHAFT` where the edge is rounded off, `BORE` where the
        material is outside the arc. The face has one loop of four corners: from the first to the second an arc at the
        first tip, from the third to the fourth an arc at the second one, which meet the faces beside them as tangents.
        Tips are not corners, and two oblique ends must lean in one plane.
    pieces: convex pieces or prisms, each the vertices of the solid that it has and its own topology, that together
        contain the solid; where two solids share volume is found from them. They have no bores and may overlap. Without
        any, the solid itself is convex, or a prism.

    >>> from fabkit.parts import prism_topology
    >>> triangle = prism_topology(3)
    >>> triangle.n_faces, len(triangle.edges), triangle.loops(0)[0].tolist()
    (5, 9, [2, 1, 0])
    >>> drilled = triangle.bored([(0, 1), (2, None)])
    >>> drilled.n_vertices, drilled.n_faces, drilled.rounds[:, 4:].tolist()
    (14, 6, [[0, 1, -1], [2, 5, -1]])
    """

    n_vertices: int
    corners: IntArray
    loop_starts: IntArray
    face_starts: IntArray
    rounds: IntArray = field(default_factory=lambda: np.zeros((0, 7), dtype=np.int64))
    pieces: tuple[Piece, ...] = ()
    fillets: IntArray = field(default_factory=lambda: np.zeros((0, 4), dtype=np.int64))

    def __post_init__(self) -> None:
        for name in ("corners", "loop_starts", "face_starts", "rounds", "fillets"):
            object.__setattr__(self, name, integers(getattr(self, name)))
        tail, head = self.corners, self.corners[self.next_corner]
        forward = np.sort(tail * self.n_vertices + head)
        backward = np.sort(head * self.n_vertices + tail)
        if not np.array_equal(forward, backward) or (np.diff(forward) == 0).any():
            raise ValueError("not a closed solid: each edge must be run along once in each direction")
        ends, faces = self.rounds[:, :4], self.rounds[:, 4:6]
        if len(np.unique(ends)) != ends.size or np.isin(ends, self.corners).any():
            raise ValueError("each round needs two centres and two rims of its own, none of them a corner")
        if ((faces < 0) | (faces >= self.n_faces)).any() or (np.abs(self.rounds[:, 6]) != 1).any():
            raise ValueError("each round must end in two faces of the solid, and be a shaft (1) or a bore (-1)")
        bare = np.setdiff1d(np.arange(self.n_faces), np.concatenate([self.polygonal, faces.ravel()]))
        if len(bare):
            raise ValueError(f"face {bare[0]} (counted from 0) has neither corners nor rounds")
        tips, own = self.fillets[:, 1:3], self.fillets[:, 0]
        if len(np.unique(tips)) != tips.size or np.isin(tips, self.corners).any() or np.isin(tips, ends).any():
            raise ValueError("each fillet needs two tips of its own, none of them a corner")
        if any([len(loop) for loop in self.loops(face)] != [4] for face in own.tolist()):
            raise ValueError("the face of each fillet needs one loop of four corners")

    @property
    def n_faces(self) -> int:
        return len(self.face_starts) - 1

    # --- polygons

    @cached_property
    def next_corner(self) -> IntArray:
        """(C,) the corner after each corner in its loop."""
        return next_in_row(self.loop_starts)

    @cached_property
    def corner_face(self) -> IntArray:
        """(C,) face of each corner."""
        return row_of_entry(self.loop_starts[self.face_starts])

    @cached_property
    def polygonal(self) -> IntArray:
        """(G,) the faces with corners."""
        return integers(np.flatnonzero(np.diff(self.face_starts)))

    @cached_property
    def first_corner(self) -> IntArray:
        """(G,) the first corner of the outer loop of each of the polygonal faces."""
        return integers(self.loop_starts[self.face_starts[self.polygonal]])

    @cached_property
    def own_first_corner(self) -> IntArray:
        """(C,) the first corner of the face of each corner."""
        return integers(self.first_corner[np.searchsorted(self.polygonal, self.corner_face)])

    @cached_property
    def edges(self) -> IntArray:
        """(E, 2) vertices of each straight edge, the lower first."""
        pairs = np.unique(np.sort(np.stack([self.corners, self.corners[self.next_corner]], axis=1), axis=1), axis=0)
        arcs = np.sort(self.fillet_corners.reshape(-1, 2), axis=1) @ [self.n_vertices, 1]
        return integers(pairs[~np.isin(pairs @ [self.n_vertices, 1], arcs)])

    def loops(self, face: int) -> list[IntArray]:
        """Vertices of each loop of a face, the outer one first."""
        first, last = self.face_starts[face : face + 2]
        return [self.corners[self.loop_starts[k] : self.loop_starts[k + 1]] for k in range(first, last)]

    def by_face(self, function: np.ufunc, values: npt.NDArray[Any], *, empty: float) -> FloatArray:
        """(..., F) np.add, np.maximum or np.minimum of values (..., C) over the corners of each face; `empty` where it
        has none."""
        if len(self.polygonal) == self.n_faces:
            every: FloatArray = function.reduceat(values, self.first_corner, axis=-1)
            return every
        found = np.full((*values.shape[:-1], self.n_faces), empty)
        if len(self.polygonal):
            found[..., self.polygonal] = function.reduceat(values, self.first_corner, axis=-1)
        return found

    # --- rounds

    @cached_property
    def outer_round(self) -> IntArray:
        """(F,) the round that is the outer loop of each face, -1 where that is a polygon."""
        outer = np.full(self.n_faces, -1, dtype=np.int64)
        for k in [*np.flatnonzero(self.rounds[:, 6] == BORE)[::-1], *np.flatnonzero(self.rounds[:, 6] == SHAFT)[::-1]]:
            outer[self.rounds[k, 4:6]] = k
        outer[self.polygonal] = -1
        return integers(outer)

    @cached_property
    def face_vertex(self) -> IntArray:
        """(F,) a vertex in each face: its first corner, or the centre of its outer round."""
        found = np.zeros(self.n_faces, dtype=np.int64)
        faces = np.flatnonzero(self.outer_round >= 0)
        rounds = self.rounds[self.outer_round[faces]]
        found[faces] = np.where(rounds[:, 4] == faces, rounds[:, 0], rounds[:, 2])
        found[self.polygonal] = self.corners[self.first_corner]
        return integers(found)

    @cached_property
    def is_convex_shaft(self) -> bool:
        """Whether the solid is one round bar."""
        return len(self.corners) == 0 and len(self.rounds) == 1 and self.rounds[0, 6] == SHAFT

    # --- fillets

    @cached_property
    def fillet_corners(self) -> IntArray:
        """(Q, 4) corners of each fillet: both ends of its first arc, then of its second one."""
        return integers(self.corners[self.loop_starts[self.face_starts[self.fillets[:, 0]]][:, None] + np.arange(4)])

    @cached_property
    def fillet_ends(self) -> IntArray:
        """(Q, 2) the faces in which the first and the second arc of each fillet lie."""
        ends, following = self.fillet_corners, self.corners[self.next_corner]
        found = [
            self.corner_face[(self.corners == b) & (following == a)]
            for arc in (ends[:, :2], ends[:, 2:])
            for a, b in arc.tolist()
        ]
        return integers(np.array(found, dtype=np.int64).reshape(2, -1).T)

    @cached_property
    def sharp(self) -> IntArray:
        """(n,) each vertex, or the tip that it would be if fillets were sharp edges."""
        vertices, ends = np.arange(self.n_vertices), self.fillet_corners
        vertices[ends] = np.repeat(self.fillets[:, 1:3], 2, axis=1)
        return integers(vertices)

    # --- solids made of others

    def bored(self, faces: Sequence[tuple[int, int | None]], *, sense: int = BORE) -> Topology:
        """The same solid with a bore from the first to the second face of each pair; a blind one, whose bottom is a new
        face, where the second is None. With the sense `SHAFT`, round bars that stand on the first faces.

        The first centre, first rim, second centre and second rim of each follow the vertices of the solid.

        >>> from fabkit.parts import prism_topology
        >>> prism_topology(4).bored([(0, 1)]).rounds.tolist()
        [[8, 9, 10, 11, 0, 1, -1]]
        """
        rounds, n_faces = [], self.n_faces
        for k, (first, second) in enumerate(faces):
            n_faces += second is None
            vertices = range(self.n_vertices + 4 * k, self.n_vertices + 4 * k + 4)
            rounds.append([*vertices, first, n_faces - 1 if second is None else second, sense])
        new = np.array(rounds, dtype=np.int64).reshape(-1, 7)
        pieces = self.pieces or ((np.arange(self.n_vertices), self),)
        if sense == SHAFT:
            pieces += tuple((row[:4], shaft_topology()) for row in new)
        return replace(
            self,
            n_vertices=self.n_vertices + 4 * len(new),
            face_starts=np.concatenate([self.face_starts, np.repeat(self.face_starts[-1:], n_faces - self.n_faces)]),
            rounds=np.concatenate([self.rounds, new]),
            pieces=pieces,
        )

    def pierced(self, first: int, second: int, n: int) -> Topology:
        """The same solid with a hole with n corners from the first to the second face, both polygonal, such as a hand
        hole in a wall. Its corners in the first face follow the vertices of the solid, counter-clockwise seen from
        outside that face; then those in the second face, in the same order. Its sides are the last faces.

        >>> from fabkit.parts import prism_topology
        >>> holed = prism_topology(4).pierced(1, 0, 4)
        >>> [loop.tolist() for loop in holed.loops(1)]
        [[4, 5, 6, 7], [11, 10, 9, 8]]
        """
        here = self.n_vertices + np.arange(n)
        there, following = here + n, np.roll(here, -1)
        faces = [self.loops(face) for face in range(self.n_faces)]
        faces[first] = [*faces[first], here[::-1]]
        faces[second] = [*faces[second], there]
        faces += [[side] for side in np.stack([here, following, following + n, there], axis=1)]
        loops = [loop for face in faces for loop in face]
        return replace(
            self,
            n_vertices=self.n_vertices + 2 * n,
            corners=np.concatenate(loops),
            loop_starts=np.cumsum([0, *map(len, loops)]),
            face_starts=np.cumsum([0, *map(len, faces)]),
            pieces=self.pieces or ((np.arange(self.n_vertices), self),),
        )


@lru_cache(maxsize=256)
def prism_topology(n: int) -> Topology:
    """A prism over a polygon with n corners: vertices 0 .. n-1 below, n .. 2n-1 above, each counter-clockwise seen
    from above. Faces: below, above, then the side from corner k to corner k+1 for each k.

    >>> from fabkit.parts import prism_topology
    >>> prism_topology(4).n_vertices, prism_topology(4) is prism_topology(4)
    (8, True)
    """
    below, above = np.arange(n), np.arange(n, 2 * n)
    following = np.roll(below, -1)
    sides = np.stack([below, following, following + n, above], axis=1)
    corners = np.concatenate([below[::-1], above, sides.ravel()])
    loop_starts = np.concatenate([[0, n], 2 * n + 4 * np.arange(n + 1)])
    return Topology(2 * n, corners, loop_starts, np.arange(n + 3))


@lru_cache(maxsize=2)
def shaft_topology(hollow: bool = False) -> Topology:
    """A round bar, or a tube: first centre, first rim, second centre and second rim of its outside, then those of its
    inside. Faces: the first end, the second end.

    >>> from fabkit.parts import shaft_topology
    >>> shaft_topology().n_vertices, shaft_topology(hollow=True).rounds[:, 6].tolist()
    (4, [1, -1])
    """
    nothing = np.zeros(3, dtype=np.int64)
    bar = Topology(4, nothing[:0], nothing[:1], nothing, np.array([[0, 1, 2, 3, 0, 1, SHAFT]]))
    return bar.bored([(0, 1)]) if hollow else bar

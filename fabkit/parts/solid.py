"""Exact solids with planar faces, as arrays.

A *topology* says which vertices bound which faces; parts of one kind share it by reference, so that a writer keeps
one template a topology. A *batch* is solids of one topology as one array, and all that is measured on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers
from geometry.mesh.ragged_arrays import next_in_row, row_of_entry

__all__ = ["Measures", "Solid", "SolidArray", "Topology", "prism_topology", "prism_vertices"]


@dataclass(frozen=True, eq=False)
class Topology:
    """Faces of a solid, each an outer loop and any number of inner ones.

    n_vertices: number of vertices.
    corners (C,): vertex of each corner, loop after loop; outer loops run counter-clockwise seen from outside
        the solid, inner loops clockwise.
    loop_starts (L+1,): loop l has the corners loop_starts[l] .. loop_starts[l+1] - 1.
    face_starts (F+1,): face f has the loops face_starts[f] .. face_starts[f+1] - 1, the outer one first.

    >>> from fabkit.parts import prism_topology
    >>> triangle = prism_topology(3)
    >>> triangle.n_faces, len(triangle.edges), triangle.loops(0)[0].tolist()
    (5, 9, [2, 1, 0])
    """

    n_vertices: int
    corners: IntArray
    loop_starts: IntArray
    face_starts: IntArray

    def __post_init__(self) -> None:
        for name in ("corners", "loop_starts", "face_starts"):
            object.__setattr__(self, name, integers(getattr(self, name)))
        tail, head = self.corners, self.corners[self.next_corner]
        forward = np.sort(tail * self.n_vertices + head)
        backward = np.sort(head * self.n_vertices + tail)
        if not np.array_equal(forward, backward) or (np.diff(forward) == 0).any():
            raise ValueError("not a closed solid: each edge must be run along once in each direction")

    @property
    def n_faces(self) -> int:
        return len(self.face_starts) - 1

    @cached_property
    def next_corner(self) -> IntArray:
        """(C,) the corner after each corner in its loop."""
        return next_in_row(self.loop_starts)

    @cached_property
    def corner_face(self) -> IntArray:
        """(C,) face of each corner."""
        return row_of_entry(self.loop_starts[self.face_starts])

    @cached_property
    def first_corner(self) -> IntArray:
        """(F,) the first corner of each face's outer loop."""
        return integers(self.loop_starts[self.face_starts[:-1]])

    @cached_property
    def edges(self) -> IntArray:
        """(E, 2) vertices of each edge, the lower first."""
        pairs = np.sort(np.stack([self.corners, self.corners[self.next_corner]], axis=1), axis=1)
        return integers(np.unique(pairs, axis=0))

    def loops(self, face: int) -> list[IntArray]:
        """Vertices of each loop of a face, the outer one first."""
        first, last = self.face_starts[face : face + 2]
        return [self.corners[self.loop_starts[k] : self.loop_starts[k + 1]] for k in range(first, last)]


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


def prism_vertices(outlines: FloatArray, bottom: FloatArray | float, top: FloatArray | float) -> FloatArray:
    """(..., 2n, 3) vertices of prisms over polygons (..., n, 2) in the xy-plane, from z = bottom to z = top (...).

    >>> from fabkit.parts import prism_vertices
    >>> prism_vertices(np.array([[0, 0], [4, 0], [0, 3]]), 0.0, 2.0)[-1].tolist()
    [0.0, 3.0, 2.0]
    """

    def at(height: FloatArray | float) -> FloatArray:
        level = np.broadcast_to(np.asarray(height, dtype=np.float64)[..., None], outlines.shape[:-1])
        return np.concatenate([outlines, level[..., None]], axis=-1)

    return np.concatenate([at(bottom), at(top)], axis=-2)


CORNERS_PER_BATCH = 20_000
"""Number of corners of solids that are measured together, so that intermediate results stay in the processor's
cache."""


@dataclass(frozen=True, eq=False)
class SolidArray:
    """Solids of one topology.

    parts (P,): their positions in what they were taken from. vertices (P, n, 3) in mm.

    >>> from fabkit.parts import SolidArray, prism_topology, prism_vertices
    >>> triangle = np.array([[0, 0], [4, 0], [0, 3]])
    >>> wedges = prism_vertices(np.stack([triangle, 2 * triangle]), 0.0, 1.0)
    >>> SolidArray(prism_topology(3), np.arange(2), wedges).volumes.round(9).tolist()
    [6.0, 24.0]
    """

    topology: Topology
    parts: IntArray
    vertices: FloatArray

    def __getitem__(self, chosen: BoolArray | IntArray | slice) -> SolidArray:
        """The solids chosen by a mask, by indices or by a slice."""
        return SolidArray(self.topology, self.parts[chosen], self.vertices[chosen])

    def in_batches(self) -> list[SolidArray]:
        """The same solids in smaller batches, one at least."""
        size = max(1, CORNERS_PER_BATCH // len(self.topology.corners))
        return [self[k : k + size] for k in range(0, max(1, len(self.parts)), size)]

    @cached_property
    def normals(self) -> FloatArray:
        """(P, F, 3) outward unit normals."""
        return np.concatenate([Measures(few.topology, few.vertices).normals for few in self.in_batches()])

    @cached_property
    def volumes(self) -> FloatArray:
        """(P,) in mm3; negative where a solid is inside out."""
        return np.concatenate([Measures(few.topology, few.vertices).volumes for few in self.in_batches()])

    @cached_property
    def centroids(self) -> FloatArray:
        """(P, 3) in mm."""
        return np.concatenate([Measures(few.topology, few.vertices).centroids for few in self.in_batches()])


@dataclass(frozen=True, eq=False)
class Measures:
    """What is measured on solids with vertices (P, n, 3) and one topology: worked out once, from corners about the
    middle of each solid and with coordinates in the first axis, which is fastest.

    >>> from fabkit.parts import Measures, prism_topology, prism_vertices
    >>> wedge = prism_vertices(np.array([[[0, 0], [4, 0], [0, 3]]]), 0.0, 2.0)
    >>> Measures(prism_topology(3), wedge).areas.round(9).tolist()
    [[6.0, 6.0, 8.0, 10.0, 6.0]]
    """

    topology: Topology
    vertices: FloatArray

    @cached_property
    def middles(self) -> FloatArray:
        """(P, 3) mean of the vertices of each solid."""
        middles: FloatArray = self.vertices.mean(axis=1)
        return middles

    @cached_property
    def points(self) -> FloatArray:
        """(3, P, n) the vertices, from the middle of each solid."""
        return np.ascontiguousarray(np.moveaxis(self.vertices - self.middles[:, None], 2, 0))

    @cached_property
    def _apex(self) -> FloatArray:
        """(3, P, C) the first corner of the face of each corner, from the middle of the solid."""
        t = self.topology
        return self.points[:, :, t.corners[t.first_corner[t.corner_face]]]

    @cached_property
    def from_apex(self) -> FloatArray:
        """(3, P, C) each corner, from the first corner of its face."""
        return self.points[:, :, self.topology.corners] - self._apex

    @cached_property
    def _doubles(self) -> FloatArray:
        """(3, P, C) twice the area, times the normal, of the triangle of apex, corner and following corner."""
        here = self.from_apex
        following = here[:, :, self.topology.next_corner]
        return np.stack([here[i - 2] * following[i - 1] - here[i - 1] * following[i - 2] for i in range(3)])

    @cached_property
    def _face_doubles(self) -> FloatArray:
        """(3, P, F) the same of each face, holes taken off."""
        sums: FloatArray = np.add.reduceat(self._doubles, self.topology.first_corner, axis=2)
        return sums

    @cached_property
    def areas(self) -> FloatArray:
        """(P, F) in mm2, of each face."""
        areas: FloatArray = np.sqrt((self._face_doubles * self._face_doubles).sum(axis=0)) / 2
        return areas

    @cached_property
    def normals(self) -> FloatArray:
        """(P, F, 3) outward unit normals."""
        return np.moveaxis(self._face_doubles / (2 * self.areas), 0, 2)

    @cached_property
    def _cones(self) -> FloatArray:
        """(P, C) six-fold volume of the cone from the middle of the solid over each of the triangles."""
        cones: FloatArray = (self._apex * self._doubles).sum(axis=0)
        return cones

    @cached_property
    def volumes(self) -> FloatArray:
        """(P,) in mm3, by the divergence theorem; negative where a solid is inside out."""
        volumes: FloatArray = self._cones.sum(axis=1) / 6
        return volumes

    @cached_property
    def centroids(self) -> FloatArray:
        """(P, 3) in mm."""
        here = self.from_apex
        corner_sums = 3 * self._apex + here + here[:, :, self.topology.next_corner]
        moments = np.einsum("pc,xpc->px", self._cones, corner_sums) / 24
        centroids: FloatArray = self.middles + moments / self.volumes[:, None]
        return centroids


@dataclass(frozen=True, eq=False)
class Solid:
    """One solid: vertices (n, 3) in mm, read-only, in the part's own frame; its topology is shared.

    >>> from fabkit.parts import Solid, prism_topology, prism_vertices
    >>> wedge = Solid(prism_vertices(np.array([[0, 0], [4, 0], [0, 3]]), 0.0, 2.0), prism_topology(3))
    >>> round(wedge.volume_mm3, 9), wedge.centroid.round(9).tolist()
    (12.0, [1.333333333, 1.0, 1.0])
    """

    vertices: FloatArray
    topology: Topology

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices))
        if self.vertices.shape != (self.topology.n_vertices, 3):
            raise ValueError(f"vertices have shape {self.vertices.shape}, need ({self.topology.n_vertices}, 3)")

    @cached_property
    def _measures(self) -> Measures:
        return Measures(self.topology, self.vertices[None])

    @property
    def volume_mm3(self) -> float:
        return float(self._measures.volumes[0])

    @property
    def centroid(self) -> FloatArray:
        """(3,) in mm."""
        return floats(self._measures.centroids[0])

    @property
    def normals(self) -> FloatArray:
        """(F, 3) outward unit normals."""
        return floats(self._measures.normals[0])

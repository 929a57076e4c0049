"""Exact solids with planar faces, as arrays.

A *topology* says which vertices bound which faces; parts of one kind share it by reference, so that a writer keeps
one template a topology. Measures work on stacks of solids with one topology: vertices (..., n, 3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.mesh.ragged_arrays import next_in_run, run_of_place

__all__ = ["Solid", "Topology", "centroids", "face_normals", "prism_topology", "prism_vertices", "volumes"]


@dataclass(frozen=True, eq=False)
class Topology:
    """Faces of a solid, each an outer loop and any number of inner ones.

    n_vertices: number of vertices.
    corners (C,): vertex of each corner, loop after loop; outer loops run counter-clockwise seen from outside
        the solid, inner loops clockwise.
    loop_starts (L+1,): loop l has the corners loop_starts[l] .. loop_starts[l+1] - 1.
    face_starts (F+1,): face f has the loops face_starts[f] .. face_starts[f+1] - 1, the outer one first.
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
        return next_in_run(self.loop_starts)

    @cached_property
    def corner_face(self) -> IntArray:
        """(C,) face of each corner."""
        return run_of_place(self.loop_starts[self.face_starts])

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
    from above. Faces: below, above, then the side from corner k to corner k+1 for each k."""
    below, above = np.arange(n), np.arange(n, 2 * n)
    following = np.roll(below, -1)
    sides = np.stack([below, following, following + n, above], axis=1)
    corners = np.concatenate([below[::-1], above, sides.ravel()])
    loop_starts = np.concatenate([[0, n], 2 * n + 4 * np.arange(n + 1)])
    return Topology(2 * n, corners, loop_starts, np.arange(n + 3))


def prism_vertices(outlines: FloatArray, bottom: FloatArray | float, top: FloatArray | float) -> FloatArray:
    """(..., 2n, 3) vertices of prisms over polygons (..., n, 2) in the xy-plane, from z = bottom to z = top (...)."""

    def at(height: FloatArray | float) -> FloatArray:
        level = np.broadcast_to(np.asarray(height, dtype=np.float64)[..., None], outlines.shape[:-1])
        return np.concatenate([outlines, level[..., None]], axis=-1)

    return np.concatenate([at(bottom), at(top)], axis=-2)


def _vector_areas(vertices: FloatArray, topology: Topology) -> FloatArray:
    """(..., F, 3) area times outward unit normal of each face, holes taken off."""
    here = vertices[..., topology.corners, :]
    first = topology.loop_starts[topology.face_starts[:-1]]
    here = here - here[..., first, :][..., topology.corner_face, :]
    sums: FloatArray = np.add.reduceat(np.cross(here, here[..., topology.next_corner, :]), first, axis=-2)
    return sums / 2


def face_normals(vertices: FloatArray, topology: Topology) -> FloatArray:
    """(..., F, 3) outward unit normals of solids with vertices (..., n, 3)."""
    areas = _vector_areas(vertices, topology)
    lengths: FloatArray = np.linalg.norm(areas, axis=-1, keepdims=True)
    return areas / lengths


def _cones(vertices: FloatArray, topology: Topology) -> tuple[FloatArray, FloatArray, FloatArray]:
    """An inner point (..., 1, 3), and for each triangle (its apex one corner of the face, its base an edge of the
    face) the six-fold volume (..., C) and the sum of the three corners (..., C, 3) of its cone to that point."""
    centre = vertices.mean(axis=-2, keepdims=True)
    here = vertices[..., topology.corners, :] - centre
    following = here[..., topology.next_corner, :]
    first = topology.loop_starts[topology.face_starts[:-1]]
    apex = here[..., first, :][..., topology.corner_face, :]
    six_fold = np.einsum("...k,...k->...", apex, np.cross(here, following))
    return centre, six_fold, apex + here + following


def volumes(vertices: FloatArray, topology: Topology) -> FloatArray:
    """(...) volumes of solids with vertices (..., n, 3), by the divergence theorem."""
    total: FloatArray = _cones(vertices, topology)[1].sum(axis=-1)
    return total / 6


def centroids(vertices: FloatArray, topology: Topology) -> FloatArray:
    """(..., 3) centroids of solids with vertices (..., n, 3)."""
    centre, six_fold, corner_sums = _cones(vertices, topology)
    moments = np.einsum("...c,...ck->...k", six_fold, corner_sums) / 4
    offset: FloatArray = moments / six_fold.sum(axis=-1)[..., None]
    return centre[..., 0, :] + offset


@dataclass(frozen=True, eq=False)
class Solid:
    """One solid: vertices (n, 3) in mm, read-only, in the part's own frame; its topology is shared."""

    vertices: FloatArray
    topology: Topology

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices))
        if self.vertices.shape != (self.topology.n_vertices, 3):
            raise ValueError(f"vertices have shape {self.vertices.shape}, need ({self.topology.n_vertices}, 3)")

    @cached_property
    def volume_mm3(self) -> float:
        return float(volumes(self.vertices, self.topology))

    @cached_property
    def centroid(self) -> FloatArray:
        """(3,) in mm."""
        return floats(centroids(self.vertices, self.topology))

    @cached_property
    def normals(self) -> FloatArray:
        """(F, 3) outward unit normals."""
        return floats(face_normals(self.vertices, self.topology))

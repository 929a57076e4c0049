"""Boxes that meet, and the edges and faces of a mesh that may: by boxes along the coordinate axes while few of them
meet, by trees of oriented boxes otherwise."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.intersections.box_trees import meeting_sets
from geometry.mesh.intersections.face_neighbours import edge_trees, face_trees, local, margin
from geometry.mesh.intersections.flat_faces import heights_over

__all__ = ["meeting_boxes", "near_pairs"]

MANY_BOXES_PER_EDGE = 32
"""Faces per edge whose upright boxes meet, above which oriented boxes are compared instead: on surfaces of even
triangles there are some ten."""

FIRST_EDGES, EDGES_AT_ONCE = 64, 2**12
"""Edges of the first sample, and the most that are compared at once: they bound the memory."""


def meeting_boxes(
    lower: FloatArray, upper: FloatArray, lower_2: FloatArray, upper_2: FloatArray
) -> tuple[IntArray, IntArray]:
    """Pairs of boxes (n, 3) and other boxes (m, 3) that meet, as two arrays (k,) of their numbers.

    >>> import numpy as np
    >>> from geometry.mesh.intersections import meeting_boxes
    >>> low = np.array([[0.0, 0, 0], [3, 0, 0]])
    >>> first, second = meeting_boxes(low, low + 1, low + [0.5, 0, 0], low + 2)
    >>> first.tolist(), second.tolist()
    ([0, 1], [0, 1])
    """
    if not len(lower_2):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    return _BoxIndex(lower_2, upper_2).meeting(lower, upper)


def near_pairs(mesh: Mesh) -> Iterator[tuple[IntArray, IntArray]]:
    """Pairs (k,) of an edge and a face whose boxes meet, part by part, among them all edges and faces that meet."""
    c = mesh.combinatorics
    points = mesh.vertices[c.corners]
    points = points - heights_over(mesh, c.corner_face, points)[:, None] * mesh.face_normals[c.corner_face]
    points, ends, around = local(mesh, points), local(mesh, mesh.vertices[c.edges]), margin(mesh)
    starts = c.face_starts[:-1]
    index = _BoxIndex(np.minimum.reduceat(points, starts) - around, np.maximum.reduceat(points, starts) + around)
    order = np.random.default_rng(0).permutation(c.n_edges)  # so that the first edges are a sample of all
    first, count = 0, FIRST_EDGES
    while first < c.n_edges:
        edges = order[first : first + count]
        found, faces = index.meeting(ends[edges].min(axis=1), ends[edges].max(axis=1))
        if len(faces) > MANY_BOXES_PER_EDGE * len(edges):
            remaining = order[first:]
            for pairs in meeting_sets(edge_trees(mesh, remaining), face_trees(mesh)):
                yield remaining[pairs[0]], pairs[1]
            return
        yield edges[found], faces
        first, count = first + count, min(8 * count, EDGES_AT_ONCE)


class _BoxIndex:
    """Boxes along the coordinate axes, found by their two longest extents, since shapely's tree has two dimensions."""

    def __init__(self, lower: FloatArray, upper: FloatArray) -> None:
        self.axes = np.argsort(np.ptp(lower, axis=0))
        self.lower, self.upper = lower[:, self.axes[0]], upper[:, self.axes[0]]
        self.tree = shapely.STRtree(self._flat(lower, upper))

    def _flat(self, lower: FloatArray, upper: FloatArray) -> np.ndarray:
        _, x, y = self.axes
        return np.asarray(shapely.box(lower[:, x], lower[:, y], upper[:, x], upper[:, y]))

    def meeting(self, lower: FloatArray, upper: FloatArray) -> tuple[IntArray, IntArray]:
        """Pairs of other boxes (n, 3) and of these that meet."""
        first, second = self.tree.query(self._flat(lower, upper))
        z = self.axes[0]
        meet: BoolArray = (lower[first, z] <= self.upper[second]) & (self.lower[second] <= upper[first, z])
        return first[meet], second[meet]

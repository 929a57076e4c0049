"""Which combinatorics are those of Koebe polyhedra: polygons that make a sphere, or a part of one, and meet properly.

The graph of a closed polyhedron is planar, simple and 3-connected (Steinitz): a map on the sphere with at least
three edges at each vertex, where two faces share a vertex, an edge with its ends, or nothing. The same is required of
open ones inside; at the boundary a vertex may have two edges.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import IntArray
from geometry.errors import MeshError
from geometry.mesh import Combinatorics

__all__ = ["double_contact", "refuse_other_than_polyhedra"]


def refuse_other_than_polyhedra(combinatorics: Combinatorics) -> None:
    """Raises MeshError, naming vertices or faces, where no Koebe polyhedron, closed or open, is like this."""
    c = combinatorics
    _refuse_loose_parts(c)
    _refuse_handles(c)
    few = np.flatnonzero((c.vertex_degrees < 3) & ~c.is_boundary_vertex)
    if len(few):
        vertex, degree = int(few[0]), int(c.vertex_degrees[few[0]])
        raise MeshError(
            f"vertex {vertex} has {degree} edges, at least 3 are needed inside: merge its edges into one",
            elements=[vertex],
            value=degree,
            bound=3,
        )
    if contact := double_contact(c):
        (f, g), (v, w) = contact[0].tolist(), contact[1].tolist()
        raise MeshError(
            f"faces {f} and {g} share vertices {v} and {w}, which are not the ends of an edge between them: "
            "removing these two vertices disconnects the graph, so it is not 3-connected",
            elements=[f, g],
        )


def _refuse_loose_parts(c: Combinatorics) -> None:
    unused = np.flatnonzero(~c.is_used)
    if len(unused):
        raise MeshError(f"vertex {unused[0]} belongs to no face: leave it out", elements=unused.tolist())
    apart = np.flatnonzero(c.face_components != c.face_components[0])
    if len(apart):
        raise MeshError(
            f"faces 0 and {apart[0]} are not connected through edges: a polyhedron is connected",
            elements=[0, int(apart[0])],
        )
    starts = c.corners[c.twin < 0]
    twice = np.flatnonzero(np.bincount(starts, minlength=c.n_vertices) > 1)
    if len(twice):
        raise MeshError(
            f"the boundary passes twice through vertex {twice[0]}: give it a vertex for each of its fans of faces",
            elements=twice.tolist(),
        )


def _refuse_handles(c: Combinatorics) -> None:
    sphere = c.euler_characteristic + len(c.boundary_loops)
    if sphere != 2:
        raise MeshError(
            f"V - E + F + boundary loops = {sphere}, of a part of a sphere it is 2: the mesh has handles, or "
            "touches itself in a vertex, and its graph is not planar",
            value=sphere,
            bound=2,
        )


def double_contact(combinatorics: Combinatorics) -> tuple[IntArray, IntArray] | None:
    """Two faces and two vertices of both which are not the ends of an edge between them, where there are such.

    Two common vertices make a cycle of four in the graph of vertices and faces; each inner edge makes one.
    """
    c, n = combinatorics, combinatorics.n_vertices
    cycles = _cycles_of_four(np.stack([c.corners, n + c.corner_face], axis=1))
    vertices, faces = np.where(cycles[0, 0] < n, cycles, cycles[::-1])
    faces = faces - n
    pairs, wanted = _pair_keys(c.edges.T, n), _pair_keys(vertices, n)
    order = np.argsort(pairs)
    found = order[np.minimum(np.searchsorted(pairs[order], wanted), len(order) - 1)]
    between = _pair_keys(c.edge_faces[found].T, c.n_faces) == _pair_keys(faces, c.n_faces)
    wrong = np.flatnonzero(~between | (pairs[found] != wanted))
    return (faces[:, wrong[0]], vertices[:, wrong[0]]) if len(wrong) else None


def _cycles_of_four(edges: IntArray) -> IntArray:
    """(2, 2, k) two opposite nodes and the two others of cycles of four edges (m, 2) of a graph.

    All where two nodes have two common neighbours; where they have more, not every pair of these. A cycle is found at
    its end with most neighbours, so that paths are few whatever the degrees are [ChibaNishizeki1985].
    """
    ends = np.concatenate([edges, edges[:, ::-1]]).T
    degrees = np.bincount(ends[0])
    rank = np.empty(len(degrees), dtype=np.int64)
    rank[np.argsort(degrees, kind="stable")] = np.arange(len(degrees))
    starts, neighbours = np.cumsum(degrees) - degrees, ends[1][np.argsort(ends[0], kind="stable")]
    middle, top = ends[:, rank[ends[0]] < rank[ends[1]]]
    counts = degrees[middle]
    path = np.repeat(np.arange(len(middle)), counts)
    bottom = neighbours[np.arange(len(path)) + np.repeat(starts[middle] - np.cumsum(counts) + counts, counts)]
    lower = rank[bottom] < rank[top[path]]
    middle, top, bottom = middle[path[lower]], top[path[lower]], bottom[lower]
    keys = top * len(degrees) + bottom
    order = np.argsort(keys, kind="stable")
    same = np.flatnonzero(keys[order][1:] == keys[order][:-1])
    first, second = order[same], order[same + 1]
    return np.stack([np.stack([top[first], bottom[first]]), np.stack([middle[first], middle[second]])])


def _pair_keys(pairs: IntArray, n: int) -> IntArray:
    """(k,) a number for each pair (2, k) of indices below n, whatever their order."""
    return np.asarray(pairs.min(axis=0) * n + pairs.max(axis=0))

"""Candidates for a Gauss image with its edges tangent to the unit sphere: a Koebe polyhedron [Pottmann2007, Prop. 3].

The edges at m_i lie on a cone of revolution; s_i is on its axis, at the distance 1 / sin(half angle). Three lines
lie on four cones, so each vertex has up to four candidates, each up to its sign. An edge line of S has one foot: the
point nearest to the origin. It is the same for both ends, which decides which candidates belong together.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree

from geometry.arrays import BoolArray, FloatArray, IntArray, angles_between
from geometry.exact_offsets.edge_cones import best_cones, edge_stars, line_spread
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_sums
from geometry.mesh.spanning_forests import spanning_forest
from geometry.parallel.edge_parallelity import perpendicular_part

__all__ = ["midscribed_candidate"]

LEAST_LINE_SPREAD = 1e-4
"""Sine of the angle between two edges at a vertex, below which they count as one line: coordinates with a planarity of
1e-12 then still determine an axis to 1e-8. Two lines lie on many cones."""

NORMAL_PREFERENCE_COST = 1e-8
"""Cost of a candidate perpendicular to the vertex normal, over the squared distance of two feet: it decides where
several S are exact, as for a box, and has no effect where feet differ by 1e-4."""

POINT_EDGE_COST = 1e-6
"""Cost of an edge of S that is a point: larger than all costs of normals, however few such edges a forest has."""

REVERSED_EDGES_COST = 1e-10
"""Cost of all edges of S together where they run against those of M, shared by the areas of their faces: it decides
where all else is equal, as between the rings of a cone, each of which has two positions."""

POINT_EDGE_LENGTH = 1e-6
"""Length of an edge of S over the distance of its ends from the origin, below which it counts as a point: well above
the square root of rounding."""

LARGEST_FEET_COST = 4.0
"""Squared distance of two opposite feet, the largest that counts. Wide cones have their s far away, and feet without
meaning."""


def midscribed_candidate(mesh: Mesh) -> FloatArray:
    """(N, 3) positions near a midscribed S; exact, up to rounding, at vertices with three different edge lines.

    See `_consistent` for the choice. Most vertices of a component are outside.
    A vertex with less than three edge lines is where its edges' lines, known from their other ends, meet.
    """
    candidates, costs, known = _candidates(mesh)
    edges = np.flatnonzero(known[mesh.combinatorics.edges].all(axis=1))
    s = _outwards(mesh, _consistent(mesh, candidates, costs, edges), edges)
    s[~known] = 0
    return _with_unknown_vertices(mesh, s, known)


def _candidates(mesh: Mesh) -> tuple[FloatArray, FloatArray, BoolArray]:
    """s (N, 4, 3) up to sign, costs (N, 4), and the vertices (N,) that have some."""
    n = mesh.n_vertices
    candidates, costs, known = np.zeros((n, 4, 3)), np.zeros((n, 4)), np.zeros(n, dtype=bool)
    normals = mesh.vertex_normals
    for vertices, directions in edge_stars(mesh, least_valence=3):
        axes, deviations = best_cones(directions)
        sines = np.sin(angles_between(axes[:, :, None], directions[:, None])).mean(axis=2)
        candidates[vertices] = axes / np.maximum(sines, 1e-6)[..., None]
        cosines = np.einsum("nci,ni->nc", axes, normals[vertices])
        costs[vertices] = deviations**2 + NORMAL_PREFERENCE_COST * (1 - cosines**2)
        known[vertices] = line_spread(directions) > LEAST_LINE_SPREAD
    return candidates, costs, known


def _consistent(mesh: Mesh, candidates: FloatArray, costs: FloatArray, edges: IntArray) -> FloatArray:
    """(N, 3) a choice of candidates with signs, of little cost over these edges.

    For each candidate of the roots of a spanning forest, the choice that costs least over the forest, by dynamic
    programming from its leaves; of the four, the one that costs least over all edges.
    """
    ends, along = mesh.combinatorics.edges[edges], mesh.edge_directions[edges]
    feet = perpendicular_part(candidates[ends], along[:, None, None])  # edge, end, candidate
    products = np.einsum("eai,ebi->eab", feet[:, 0], feet[:, 1])
    squares = np.einsum("enci,enci->enc", feet, feet)
    between = np.minimum(squares[:, 0, :, None] + squares[:, 1, None, :] - 2 * np.abs(products), LARGEST_FEET_COST)
    heads = candidates[ends[:, 1]][:, None] * np.where(products < 0, -1.0, 1.0)[..., None]
    between += POINT_EDGE_COST * _is_point(candidates[ends[:, 0]][:, :, None], heads)
    chosen = _most_distinct_forest(
        mesh.n_vertices, ends, between + costs[ends[:, 0], :, None] + costs[ends[:, 1], None, :]
    )
    forest = spanning_forest(mesh.n_vertices, ends[chosen])

    total, best = costs.copy(), np.zeros((mesh.n_vertices, 4), dtype=np.int64)  # for each candidate of the parent
    for level in forest.levels[::-1]:
        forwards = ends[chosen[level.edges], 0] == level.parents
        pairs = between[chosen[level.edges]]
        pairs = np.where(forwards[:, None, None], pairs, pairs.swapaxes(1, 2)) + total[level.children][:, None, :]
        best[level.children] = pairs.argmin(axis=2)
        np.add.at(total, level.parents, pairs.min(axis=2))

    choice = np.tile(np.arange(4), (mesh.n_vertices, 1))  # for each candidate of the root
    sign = np.ones((mesh.n_vertices, 4))
    for level in forest.levels:
        choice[level.children] = np.take_along_axis(best[level.children], choice[level.parents], axis=1)
        tails, heads = ends[chosen[level.edges]].T
        product = products[chosen[level.edges][:, None], choice[tails], choice[heads]]
        sign[level.children] = sign[level.parents] * np.where(product < 0, -1.0, 1.0)
    s = np.take_along_axis(candidates, choice[..., None], axis=1) * sign[..., None]

    gaps = perpendicular_part(s[ends[:, 0]] - s[ends[:, 1]], along[:, None])
    of_edges = np.minimum(np.einsum("eci,eci->ec", gaps, gaps), LARGEST_FEET_COST)
    of_edges += POINT_EDGE_COST * _is_point(s[ends[:, 0]], s[ends[:, 1]])
    of_edges += REVERSED_EDGES_COST * _turned_over(mesh, s, edges)
    total = np.zeros((len(forest.roots), 4))
    np.add.at(total, forest.components, np.take_along_axis(costs, choice, axis=1))
    np.add.at(total, forest.components[ends[:, 0]], of_edges)
    return np.asarray(s[np.arange(mesh.n_vertices), total.argmin(axis=1)[forest.components]])


def _outwards(mesh: Mesh, s: FloatArray, edges: IntArray) -> FloatArray:
    """s (N, 3), turned over in the parts connected by these edges that have most of their vertices inside."""
    parts = spanning_forest(mesh.n_vertices, mesh.combinatorics.edges[edges]).components
    outside = np.bincount(parts, np.sign(np.einsum("ni,ni->n", s, mesh.vertex_normals)))
    return np.asarray(s * np.where(outside < 0, -1.0, 1.0)[parts, None])


def _most_distinct_forest(n_vertices: int, ends: IntArray, pairs: FloatArray) -> IntArray:
    """The edges of the spanning forest whose costs best distinguish which candidates of their ends (E, 2) belong
    together.

    pairs (E, 4, 4): costs. An edge decides nothing where one candidate fits two of the other end, as across the
    edges of a prism: then the second least cost in a row or a column is no more than the least.
    """
    second = np.minimum(np.sort(pairs, axis=1)[:, 1].min(axis=1), np.sort(pairs, axis=2)[:, :, 1].min(axis=1))
    order = np.argsort(-second, kind="stable")
    ranks = np.empty(len(ends))
    ranks[order] = np.arange(1.0, len(ends) + 1)  # an edge of value 0 would be none
    graph = coo_array((ranks, ends.T), shape=(n_vertices, n_vertices))
    return np.asarray(order[minimum_spanning_tree(graph).data.astype(np.int64) - 1])


def _is_point(tails: FloatArray, heads: FloatArray) -> BoolArray:
    """Whether both ends (..., 3) of an edge of S are one: exact too at the boundary, where nothing lies beyond."""
    chords = heads - tails
    both = np.einsum("...k,...k->...", tails, tails) + np.einsum("...k,...k->...", heads, heads)
    return np.asarray(np.einsum("...k,...k->...", chords, chords) < POINT_EDGE_LENGTH**2 * both)


def _turned_over(mesh: Mesh, s: FloatArray, edges: IntArray) -> FloatArray:
    """(n, k) the areas at edges (n,) that run against those of M, if their tails are outside, of k choices s (N, k, 3);
    over the sum of all."""
    c = mesh.combinatorics
    of_corners = np.linalg.norm(mesh.vector_areas, axis=1)[c.corner_face]
    areas = np.bincount(c.corner_edge, of_corners, minlength=c.n_edges)
    tails, heads = c.edges[edges].T
    along = np.einsum("eki,ei->ek", s[heads] - s[tails], mesh.edge_directions[edges])
    outside = np.einsum("eki,ei->ek", s[tails], mesh.vertex_normals[tails])
    return np.where(along * outside < 0, (areas / areas.sum())[edges, None], 0.0)


def _with_unknown_vertices(mesh: Mesh, s: FloatArray, known: BoolArray) -> FloatArray:
    """The unknown vertices, each where the lines of its edges meet, or as near to its normal as they say.

    Line e is where the component of s across the edge is the foot: minimise the squares of the differences.
    """
    c = mesh.combinatorics
    feet, has_foot = _feet(mesh, s, known)
    edges, ends = np.nonzero(has_foot[:, None] & ~known[c.edges])
    vertices, t = c.edges[edges, ends], mesh.edge_directions[edges]
    matrices = np.tile(NORMAL_PREFERENCE_COST * np.eye(3), (mesh.n_vertices, 1, 1))
    np.add.at(matrices, vertices, np.eye(3) - t[:, :, None] * t[:, None, :])
    sums = NORMAL_PREFERENCE_COST * mesh.vertex_normals
    np.add.at(sums, vertices, feet[edges])
    rest = np.flatnonzero(~known)
    s = s.copy()
    s[rest] = np.linalg.solve(matrices[rest], sums[rest][..., None])[..., 0]
    return s


def _feet(mesh: Mesh, s: FloatArray, known: BoolArray) -> tuple[FloatArray, BoolArray]:
    """Feet (E, 3) of the edges, and which (E,) have one: those with a known end, and others of their faces.

    The edges of a face of S touch a circle, in which its plane meets the sphere. So the feet of a face all have the
    same height over its plane, and lie outwards from its centre, or all inwards, unless edges of M are reversed.
    """
    c = mesh.combinatorics
    from_known = np.logical_or(*known[c.edges].T)
    end = np.where(known[c.edges[:, 0]], c.edges[:, 0], c.edges[:, 1])
    feet = perpendicular_part(s[end], mesh.edge_directions)

    normals, edges = mesh.face_normals[c.corner_face], c.corner_edge
    outwards = np.cross(mesh.corner_directions, normals)
    counts = face_sums(c, from_known[edges].astype(float))
    height, side = (
        face_sums(c, np.where(from_known[edges], np.einsum("ci,ci->c", feet[edges], axis), 0.0)) / np.maximum(counts, 1)
        for axis in (normals, outwards)
    )
    radius = np.sqrt(np.maximum(1 - height**2, 0)) * np.where(side < 0, -1.0, 1.0)
    corners = np.flatnonzero(~from_known[edges] & (counts > 0)[c.corner_face])
    faces = c.corner_face[corners]
    feet[edges[corners]] = height[faces, None] * normals[corners] + radius[faces, None] * outwards[corners]
    has_foot = from_known.copy()
    has_foot[edges[corners]] = True
    return feet, has_foot

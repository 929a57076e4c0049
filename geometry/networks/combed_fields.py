"""The singularities of a cross field, and one direction of each cross, chosen consistently except across cuts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, ComplexArray, IntArray, complexes, integers
from geometry.errors import raise_worst
from geometry.mesh import Combinatorics
from geometry.mesh.spanning_forests import spanning_forest
from geometry.networks.tangent_frames import TangentFrames

__all__ = ["CombedField", "comb"]

LARGEST_INDEX_DEVIATION = 1e-6
"""Largest deviation of an index from an integer that rounding can explain."""


@dataclass(frozen=True, eq=False)
class CombedField:
    """first (F,): the first direction of each triangle, a unit vector of its frame; the second is to its left.

    is_cut (E,): edges of the cut graph, which cuts each connected part of the surface into a disc. turns (E,): the
    number of quarter turns from the first direction of the left face to that of the right face; 0 where there is no
    cut.
    indices (N,): quarter turns of the field about each vertex, positive as about an umbilic of an ellipsoid; 0 where
    it is regular, and on the boundary.
    """

    first: ComplexArray
    is_cut: BoolArray
    turns: IntArray
    indices: IntArray


def comb(frames: TangentFrames, field: ComplexArray) -> CombedField:
    """Match neighbouring crosses by the least angle, find singularities, cut and comb."""
    c = frames.combinatorics
    inner, left, right = frames.inner_edges
    turned = field[right] * (field[left] * np.exp(1j * frames.edge_turns[inner])).conj()
    quarters = np.rint(np.angle(turned) / (np.pi / 2)).astype(np.int64)
    residual = np.zeros(c.n_edges)
    residual[inner] = np.angle(turned) - quarters * (np.pi / 2)
    indices = _indices(frames, residual)

    tree = spanning_forest(frames.n_triangles, c.edge_faces[inner])
    combed_quarters = np.zeros(frames.n_triangles, dtype=np.int64)
    is_tree = np.zeros(c.n_edges, dtype=bool)
    for level in tree.levels:
        is_tree[inner[level.edges]] = True
        forward = left[level.edges] == level.parents
        combed_quarters[level.children] = (
            combed_quarters[level.parents] - np.where(forward, 1, -1) * quarters[level.edges]
        )
    turns = np.zeros(c.n_edges, dtype=np.int64)
    turns[inner] = (quarters + combed_quarters[right] - combed_quarters[left]) % 4
    is_cut = pruned(c, ~is_tree & ~c.is_boundary_edge, c.is_boundary_vertex | (indices != 0))
    assert not turns[~is_cut].any()
    return CombedField(complexes(field * 1j**combed_quarters), is_cut, integers(turns), integers(indices))


def _indices(frames: TangentFrames, residual: np.ndarray) -> IntArray:
    """(N,) quarter turns about each vertex, from the angle defects and the angles (E,) by which the field turns between
    the left and the right face, without whole quarters."""
    c = frames.combinatorics
    sides = frames.sides
    angles = np.angle(-np.roll(sides, 1, axis=1) * sides.conj()).ravel()
    defects = 2 * np.pi - np.bincount(c.corners, angles, c.n_vertices)
    tails, heads = c.edges.T
    turns_about_vertices = np.bincount(heads, residual, c.n_vertices) - np.bincount(tails, residual, c.n_vertices)
    quarters = (defects + turns_about_vertices) / (np.pi / 2)
    quarters[c.is_boundary_vertex | ~c.is_used] = 0.0
    indices = np.rint(quarters)
    raise_worst(
        np.abs(quarters - indices),
        "<=",
        LARGEST_INDEX_DEVIATION,
        lambda vertex, _: (
            f"the field turns by {quarters[vertex]:.6f} quarters about vertex {vertex}, not by whole ones: "
            "make triangles with angles near 0 or 180 degrees larger"
        ),
    )
    return integers(indices)


def pruned(c: Combinatorics, is_cut: BoolArray, is_end: BoolArray) -> BoolArray:
    """The cut edges (E,) without dead branches: those that end at a vertex where `is_end` (N,) is false."""
    is_cut = is_cut.copy()
    cut = np.flatnonzero(is_cut)
    degrees = np.bincount(c.edges[cut].ravel(), minlength=c.n_vertices)
    sums = np.bincount(c.edges[cut].ravel(), np.repeat(cut, 2), c.n_vertices).astype(np.int64)
    leaves = np.flatnonzero((degrees == 1) & ~is_end)
    while len(leaves):
        edges = np.unique(sums[leaves])  # the only edge of each leaf
        is_cut[edges] = False
        ends, twice = c.edges[edges].ravel(), np.repeat(edges, 2)
        np.subtract.at(degrees, ends, 1)
        np.subtract.at(sums, ends, twice)
        candidates = np.unique(ends)
        leaves = candidates[(degrees[candidates] == 1) & ~is_end[candidates]]
    return is_cut

"""Distances from a plane for faces with many corners, with numbers in proportion to the corners.

Three corners of a face span a plane; a residual is the distance of another corner from it. Its derivative by these four
corners is exact and sparse: the normal, and minus the normal times the barycentric shares of the three corners. The
three are far apart, so that these shares are small: the first is furthest from the mean, the second from the first, the
third from the line through both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import FloatArray, IntArray
from geometry.functionals.unknowns import coordinates
from geometry.optimise import SparseMatrix

__all__ = ["ReferencePlanes", "far_apart"]


@dataclass(frozen=True, eq=False)
class ReferencePlanes:
    """n faces with k corners each.

    three (n, 3) and others (n, k-3): the corners that span the plane, and the other corners. normals (n, 3); heights
    (n, k-3): distances of the others from the plane; shares (n, k-3, 3): barycentric coordinates of their feet.
    """

    three: IntArray
    others: IntArray
    normals: FloatArray
    heights: FloatArray
    shares: FloatArray

    @classmethod
    def of(cls, corners: FloatArray, three: IntArray) -> ReferencePlanes:
        """corners (n, k, 3), k > 3; three (n, 3) from `far_apart` for these corners or a similar shape."""
        rows = np.arange(len(corners))
        first, second, third = three.T
        here = corners - corners[rows, first][:, None]
        others = np.argsort((np.arange(here.shape[1]) == three[:, :, None]).any(axis=1), axis=1, kind="stable")[:, :-3]
        b, c = here[rows, second], here[rows, third]
        areas = np.cross(b, c)
        squares = np.einsum("ni,ni->n", areas, areas)[:, None]
        squares = np.where(squares > 0, squares, 1.0)  # collinear corners span no plane
        rest = np.take_along_axis(here, others[:, :, None], axis=1)
        normals = areas / np.sqrt(squares)
        share_b = np.einsum("nki,ni->nk", np.cross(rest, c[:, None]), areas) / squares
        share_c = np.einsum("nki,ni->nk", np.cross(b[:, None], rest), areas) / squares
        shares = np.stack([1 - share_b - share_c, share_b, share_c], axis=2)
        return cls(three, others, normals, np.asarray(np.einsum("nki,ni->nk", rest, normals)), shares)

    def rows(self, vertices: IntArray, n_unknowns: int) -> SparseMatrix:
        """The Jacobian (n (k-3), n_unknowns) of all heights, for the vertices (n, k) at the corners."""
        at = np.take_along_axis(vertices, self.others, axis=1)[:, :, None]
        references = np.take_along_axis(vertices, self.three, axis=1)[:, None, :]
        columns = coordinates(np.concatenate([at, np.broadcast_to(references, self.shares.shape)], axis=2))
        weights = np.concatenate([np.ones_like(self.shares[:, :, :1]), -self.shares], axis=2)
        values = weights[..., None] * self.normals[:, None, None, :]
        starts = np.arange(0, values.size + 1, 12)
        return csr_array((values.ravel(), columns.ravel(), starts), shape=(len(starts) - 1, n_unknowns))


def far_apart(corners: FloatArray) -> IntArray:
    """(n, 3) three corners each of faces (n, k, 3): one far from the mean, one far from it, one far from both."""
    here = corners - corners.mean(axis=1, keepdims=True)
    rows = np.arange(len(here))
    first = np.linalg.norm(here, axis=2).argmax(axis=1)
    here = here - here[rows, first][:, None]
    second = np.linalg.norm(here, axis=2).argmax(axis=1)
    third = np.linalg.norm(np.cross(here, here[rows, second][:, None]), axis=2).argmax(axis=1)
    return np.stack([first, second, third], axis=1)

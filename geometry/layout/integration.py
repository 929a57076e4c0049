"""(u, v) whose isolines follow a network and are conjugate: seamless functions by least squares, then integers.

Derivatives of (u, v) along the two directions of the network, times the wanted edge length h, are the matrix
[[p, q], [r, s]] = h [[du(X), du(Y)], [dv(X), dv(Y)]] of a triangle; all triangles are counted by their areas.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.sparse import coo_array, csr_array

from geometry.arrays import FloatArray, IntArray
from geometry.layout.networks import Network, determinants, forms_of_isolines
from geometry.layout.seams import SeamlessMaps
from geometry.optimise import SparseMatrix, apply, factorise

__all__ = ["Integration", "Relaxed"]

LENGTH_WEIGHT = 0.1
"""Weight of the derivatives' sizes, over that of their directions: lengths give way to directions."""

CONJUGACY_WEIGHT = 30.0
"""Weight of II(isoline u, isoline v), over the root mean square of the curvature: repairs what smoothing turned."""

ANCHOR_WEIGHT = 1e-9
"""Weight of (u, v) = 0 at one vertex, over that of a triangle: where a shift of the whole costs nothing."""

FREE_INTEGER_ENERGY = 1e-10
"""Energy of integers, over the largest one, below which they may be any numbers."""

CONJUGACY_STEPS = 2
"""Gauss-Newton steps with the term of conjugacy, after the first one."""

LEAST_DETERMINANT, WANTED_DETERMINANT = 0.15, 0.3
"""Of triangles, below which they are opened, and what is asked of them then."""

OPENING_ROUNDS = 16
"""Rounds in which folded triangles are opened, at most."""

OPENING_WEIGHT = 1.0
"""Weight of the determinant of a folded triangle in the first round; it doubles while the triangle stays folded."""

OPENING_STEP = 0.7
"""Part of each step that is taken while triangles are opened."""

IDENTITY = np.array([1.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Relaxed:
    """The best map with real numbers for all integers, for h = 1. values (m,) of the integers; gram (m, m): energy of
    moving them, the rest following; predicted: area of all triangles in (u, v).
    """

    values: FloatArray
    gram: FloatArray
    predicted: float


@dataclass(frozen=True, eq=False)
class Integration:
    """The least squares problem of a network over seamless maps."""

    network: Network
    maps: SeamlessMaps

    @cached_property
    def _derivatives(self) -> tuple[SparseMatrix, SparseMatrix]:
        """(4F, n), (4F, m): p of all triangles, then q, r, s, for h = 1, of reals and of integers."""
        frames, n = self.network.frames, self.network.frames.n_triangles
        along = (frames.gradients.conj() * self.network.first[:, None]).real
        across = (frames.gradients.conj() * self.network.second[:, None]).real
        rows, columns, values = [], [], []
        corners = np.arange(3 * n).reshape(n, 3)
        for block, (component, weights) in enumerate(((0, along), (0, across), (1, along), (1, across))):
            rows.append(np.repeat(block * n + np.arange(n), 3))
            columns.append((2 * corners + component).ravel())
            values.append(weights.ravel())
        places = (np.concatenate(rows), np.concatenate(columns))
        jacobian = csr_array(coo_array((np.concatenate(values), places), shape=(4 * n, 6 * n)))
        return csr_array(jacobian @ self.maps.reals), csr_array(jacobian @ self.maps.integers)

    def _quadratic(self, at: FloatArray, opening: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(F, 4, 4) and (F, 4): energy g.M g - 2 m.g of the derivatives g of each triangle, linearised at (F, 4)."""
        areas = self.network.frames.areas / self.network.frames.areas.sum()
        weights = np.array([LENGTH_WEIGHT, 1.0, 1.0, LENGTH_WEIGHT])
        matrix = np.tile(np.diag(weights), (len(at), 1, 1))
        right = np.tile(weights * IDENTITY, (len(at), 1))
        value, slope = conjugacy(self.network.forms, at)
        trusted = CONJUGACY_WEIGHT / (1 + opening)  # given up where it folds
        matrix += trusted[:, None, None] * slope[:, :, None] * slope[:, None]
        right += (trusted * value)[:, None] * slope
        p, q, r, s = at.T
        slope = np.stack([s, -r, -q, p], axis=1)
        matrix += opening[:, None, None] * slope[:, :, None] * slope[:, None]
        right += (opening * (WANTED_DETERMINANT + p * s - q * r))[:, None] * slope
        return matrix * areas[:, None, None], right * areas[:, None]

    def _normal(self, matrix: FloatArray) -> tuple[SparseMatrix, SparseMatrix, SparseMatrix]:
        """The sparse matrix (4F, 4F) of blocks (F, 4, 4), times reals and integers, and the grounded one of reals."""
        n = len(matrix)
        f, i, j = np.indices(matrix.shape).reshape(3, -1)
        blocks = csr_array(coo_array((matrix.ravel(), (i * n + f, j * n + f)), shape=(4 * n, 4 * n)))
        reals, integers = self._derivatives
        times_reals, times_integers = csr_array(blocks @ reals), csr_array(blocks @ integers)
        whole = csr_array(reals.T @ times_reals)
        return times_reals, times_integers, csr_array(whole + self._ground * whole.diagonal().mean())

    @cached_property
    def _ground(self) -> SparseMatrix:
        c = self.network.frames.combinatorics
        first = np.unique(c.face_components, return_index=True)[1]
        corners = (3 * first[:, None] + np.arange(3)).ravel()
        diagonal = np.zeros(self.maps.reals.shape[1])
        at = self.maps.reals[np.concatenate([2 * corners, 2 * corners + 1])]
        diagonal[at.indices] = ANCHOR_WEIGHT
        n = len(diagonal)
        return csr_array(coo_array((diagonal, (np.arange(n), np.arange(n))), shape=(n, n)))

    def relaxed(self) -> Relaxed:
        at = np.tile(IDENTITY, (self.network.frames.n_triangles, 1))
        matrix, right = self._quadratic(at, np.zeros(len(at)))
        reals, integers = self._derivatives
        _, times_integers, whole = self._normal(matrix)
        factor = factorise(whole)
        mixed = (reals.T @ times_integers).toarray()
        following = factor.solve(mixed) if mixed.shape[1] else mixed
        gram = (integers.T @ times_integers).toarray() - mixed.T @ following
        side = right.T.ravel()
        free = factor.solve(_back(reals, side))
        values = np.zeros(0)
        if len(gram):
            values = scipy.linalg.lstsq(gram, _back(integers, side) - mixed.T @ free, cond=FREE_INTEGER_ENERGY)[0]
        x = free - following @ values
        areas = determinants(self.at(x, values, 1.0))
        return Relaxed(values, (gram + gram.T) / 2, float(self.network.frames.areas @ areas))

    def at(self, x: FloatArray, t: FloatArray, h: float) -> FloatArray:
        """(F, 4) p, q, r, s."""
        reals, integers = self._derivatives
        return h * (apply(reals, x) + apply(integers, t)).reshape(4, -1).T

    def solved(self, t: IntArray, h: float) -> FloatArray:
        """(n,) the reals for given integers. Triangles that are turned over are opened, as far as they can be."""
        n = self.network.frames.n_triangles
        opening = np.zeros(n)
        at, x = np.tile(IDENTITY, (n, 1)), np.zeros(self.maps.reals.shape[1])
        whole = t.astype(np.float64)
        for _ in range(1 + CONJUGACY_STEPS):
            x = self._step(at, opening, whole, h)
            at = self.at(x, whole, h)
        best, most = x, determinants(at).min()
        for _ in range(OPENING_ROUNDS):
            folded = determinants(at) < LEAST_DETERMINANT
            if not folded.any():
                return x
            opening = np.where(folded, np.maximum(OPENING_WEIGHT, 2 * opening), opening)
            x = x + OPENING_STEP * (self._step(at, opening, whole, h) - x)
            at = self.at(x, whole, h)
            least = determinants(at).min()
            best, most = (x, least) if least > most else (best, most)
        return best

    def _step(self, at: FloatArray, opening: FloatArray, t: FloatArray, h: float) -> FloatArray:
        matrix, right = self._quadratic(at, opening)
        reals, integers = self._derivatives
        times_reals, _, whole = self._normal(matrix)
        pull = _back(reals, right.T.ravel()) - h * _back(times_reals, apply(integers, t))
        return np.asarray(factorise(whole).solve(pull) / h)


def conjugacy(forms: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(F,) II of the isolines' tangents over their area, per h^2, and its derivatives (F, 4); the area as constant."""
    p, q, r, s = at.T
    xx, xy, yy = forms.T
    area = np.maximum(np.abs(determinants(at)), LEAST_DETERMINANT)
    value = forms_of_isolines(forms, at)
    slope = np.stack([xy * s - yy * r, xy * r - xx * s, xy * q - yy * p, xy * p - xx * q], axis=1)
    return value / area, slope / area[:, None]


def _back(matrix: SparseMatrix, values: FloatArray) -> FloatArray:
    return np.asarray(matrix.T @ values)

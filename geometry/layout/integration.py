"""Functions (u, v) whose isolines follow a network and are conjugate: least squares for reals, then for integers.

The derivatives of (u, v) in a triangle along the directions X, Y of the network, times the edge length wanted there,
are the matrix [[p, q], [r, s]] = h size [[du(X), du(Y)], [dv(X), dv(Y)]], with h the typical edge length. All triangles
are weighted by their areas.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.sparse import coo_array, csr_array

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.layout.seams import SeamlessMaps
from geometry.layout.windings import wrongly_wound
from geometry.networks.networks import Network, determinants, forms_of_isolines
from geometry.optimise import SparseMatrix, apply, factorise

__all__ = ["Integration", "RealSolution"]

LENGTH_WEIGHT = 0.1
"""Weight of p = 1 and s = 1, which ask for edge lengths, over that of q = 0 and r = 0, which ask for directions."""

CONJUGACY_WEIGHT = 30.0
"""Weight of the squared II(isoline u, isoline v), over the root mean square of the curvature: it corrects directions
that smoothing has made not conjugate."""

ANCHOR_WEIGHT = 1e-9
"""Weight of (u, v) = 0 in one triangle of each connected part, which makes the solution unique."""

FREE_INTEGER_RATIO = 1e-10
"""Singular value of the energy of the integers, over the largest one, below which it does not determine them."""

CONJUGACY_NEWTON_STEPS = 2
"""Number of Gauss-Newton steps with the term of conjugacy, after the first one."""

LEAST_DETERMINANT, TARGET_DETERMINANT = 0.15, 0.3
"""Determinant p s - q r of a triangle below which it counts as folded, and its target value while it is unfolded."""

MAX_UNFOLDING_ROUNDS = 40
"""Largest number of rounds in which folded triangles are unfolded."""

LENIENT_ROUNDS = 16
"""Number of these rounds after which determinants need only be positive, and triangles at wrongly wound vertices are
turned towards the network."""

UNFOLDING_WEIGHT = 1.0
"""Weight of the determinant of a folded triangle in the first round, and of the directions of a wrongly wound one; it
doubles while the triangle stays so."""

UNFOLDING_STEP = 0.7
"""Share of each Gauss-Newton step that is taken while triangles are unfolded."""

IDENTITY = np.array([1.0, 0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class RealSolution:
    """The best map with real numbers in place of the integers, for h = 1.

    values (m,) of the integers; gram (m, m): the quadratic energy of changing them when the real unknowns adapt;
    predicted: the area of all triangles in (u, v), which is the number of faces.
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
        """(4F, n), (4F, m): p of all triangles, then q, r, s, for h = 1, from the reals and from the integers."""
        frames, n = self.network.frames, self.network.frames.n_triangles
        sizes = self.network.sizes[:, None]
        along = sizes * (frames.gradients.conj() * self.network.first[:, None]).real
        across = sizes * (frames.gradients.conj() * self.network.second[:, None]).real
        rows, columns, values = [], [], []
        corners = np.arange(3 * n).reshape(n, 3)
        for block, (component, weights) in enumerate(((0, along), (0, across), (1, along), (1, across))):
            rows.append(np.repeat(block * n + np.arange(n), 3))
            columns.append((2 * corners + component).ravel())
            values.append(weights.ravel())
        places = (np.concatenate(rows), np.concatenate(columns))
        jacobian = csr_array(coo_array((np.concatenate(values), places), shape=(4 * n, 6 * n)))
        return csr_array(jacobian @ self.maps.reals), csr_array(jacobian @ self.maps.integers)

    def _quadratic(
        self, derivatives: FloatArray, unfolding: FloatArray, directing: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """(F, 4, 4) M and (F, 4) m: the energy g . M g - 2 m . g of the derivatives g of each triangle, linearised at
        the given derivatives (F, 4); unfolding (F,): weights of the determinants, directing (F,): added to those of
        directions and lengths."""
        areas = self.network.frames.areas / self.network.frames.areas.sum()
        weights = np.array([LENGTH_WEIGHT, 1.0, 1.0, LENGTH_WEIGHT]) + directing[:, None]
        matrix = weights[:, :, None] * np.eye(4)
        right = weights * IDENTITY
        value, slope = conjugacy(self.network.forms, derivatives)
        conjugacy_weights = CONJUGACY_WEIGHT / (1 + unfolding)  # less where triangles fold
        matrix += conjugacy_weights[:, None, None] * slope[:, :, None] * slope[:, None]
        right += (conjugacy_weights * value)[:, None] * slope
        p, q, r, s = derivatives.T
        slope = np.stack([s, -r, -q, p], axis=1)
        matrix += unfolding[:, None, None] * slope[:, :, None] * slope[:, None]
        right += (unfolding * (TARGET_DETERMINANT + p * s - q * r))[:, None] * slope
        return matrix * areas[:, None, None], right * areas[:, None]

    def _normal(self, matrix: FloatArray) -> tuple[SparseMatrix, SparseMatrix, SparseMatrix]:
        """The sparse matrix (4F, 4F) of blocks (F, 4, 4) times the derivatives of reals and of integers, and the normal
        matrix of the reals, with the anchors."""
        n = len(matrix)
        f, i, j = np.indices(matrix.shape).reshape(3, -1)
        blocks = csr_array(coo_array((matrix.ravel(), (i * n + f, j * n + f)), shape=(4 * n, 4 * n)))
        reals, integers = self._derivatives
        times_reals, times_integers = csr_array(blocks @ reals), csr_array(blocks @ integers)
        normal = csr_array(reals.T @ times_reals)
        return times_reals, times_integers, csr_array(normal + self._anchors * normal.diagonal().mean())

    @cached_property
    def _anchors(self) -> SparseMatrix:
        """Diagonal matrix of the weights of (u, v) = 0 in the first triangle of each connected part."""
        c = self.network.frames.combinatorics
        first = np.unique(c.face_components, return_index=True)[1]
        corners = (3 * first[:, None] + np.arange(3)).ravel()
        diagonal = np.zeros(self.maps.reals.shape[1])
        anchored = self.maps.reals[np.concatenate([2 * corners, 2 * corners + 1])]
        diagonal[anchored.indices] = ANCHOR_WEIGHT
        n = len(diagonal)
        return csr_array(coo_array((diagonal, (np.arange(n), np.arange(n))), shape=(n, n)))

    def real_solution(self) -> RealSolution:
        derivatives = np.tile(IDENTITY, (self.network.frames.n_triangles, 1))
        matrix, right = self._quadratic(derivatives, *np.zeros((2, len(derivatives))))
        reals, integers = self._derivatives
        _, times_integers, normal = self._normal(matrix)
        factor = factorise(normal)
        mixed = (reals.T @ times_integers).toarray()
        reals_by_integers = factor.solve(mixed) if mixed.shape[1] else mixed
        gram = (integers.T @ times_integers).toarray() - mixed.T @ reals_by_integers
        linear = right.T.ravel()
        x_without_integers = factor.solve(_transposed_times(reals, linear))
        values = np.zeros(0)
        if len(gram):
            values = scipy.linalg.lstsq(
                gram, _transposed_times(integers, linear) - mixed.T @ x_without_integers, cond=FREE_INTEGER_RATIO
            )[0]
        x = x_without_integers - reals_by_integers @ values
        areas = determinants(self.derivatives(x, values, 1.0))
        predicted = float((self.network.frames.areas / self.network.sizes**2) @ areas)
        return RealSolution(values, (gram + gram.T) / 2, predicted)

    def derivatives(self, x: FloatArray, t: FloatArray, h: float) -> FloatArray:
        """(F, 4) p, q, r, s of the triangles, for real unknowns x (n,) and integers t (m,)."""
        reals, integers = self._derivatives
        return h * (apply(reals, x) + apply(integers, t)).reshape(4, -1).T

    def solved(self, t: IntArray, h: float, indices: IntArray) -> FloatArray:
        """(n,) the real unknowns for given integers. Triangles that are turned over, or at vertices that are wrongly
        wound, are unfolded as far as possible. indices (N,): of the field, see `CombedField`."""
        n = self.network.frames.n_triangles
        unfolding, directing = np.zeros((2, n))
        derivatives, x = np.tile(IDENTITY, (n, 1)), np.zeros(self.maps.reals.shape[1])
        t_values = t.astype(np.float64)
        for _ in range(1 + CONJUGACY_NEWTON_STEPS):
            x = self._step(derivatives, unfolding, directing, t_values, h)
            derivatives = self.derivatives(x, t_values, h)
        best, least_folded, best_determinant = x, n + 1, 0.0
        for unfolding_round in range(MAX_UNFOLDING_ROUNDS):
            areas = determinants(derivatives)
            is_wound = self._wrongly_wound(x, t_values, indices)
            n_folded, least = int(((areas <= 0) | is_wound).sum()), float(areas.min())
            if (n_folded, -least) < (least_folded, -best_determinant):
                best, least_folded, best_determinant = x, n_folded, least
            is_lenient = unfolding_round >= LENIENT_ROUNDS
            if n_folded == 0 and (least >= LEAST_DETERMINANT or is_lenient):
                break
            is_flat = areas < LEAST_DETERMINANT
            unfolding = np.where(is_flat, np.maximum(UNFOLDING_WEIGHT, 2 * unfolding), unfolding)
            if is_lenient:
                directing = np.where(is_wound, np.maximum(UNFOLDING_WEIGHT, 2 * directing), directing)
            x = x + UNFOLDING_STEP * (self._step(derivatives, unfolding, directing, t_values, h) - x)
            derivatives = self.derivatives(x, t_values, h)
        return best

    def _wrongly_wound(self, x: FloatArray, t: FloatArray, indices: IntArray) -> BoolArray:
        c = self.network.frames.combinatorics
        return wrongly_wound(c, self.maps.values(x, t).reshape(-1, 3, 2), indices)

    def _step(
        self, derivatives: FloatArray, unfolding: FloatArray, directing: FloatArray, t: FloatArray, h: float
    ) -> FloatArray:
        matrix, right = self._quadratic(derivatives, unfolding, directing)
        reals, integers = self._derivatives
        times_reals, _, normal = self._normal(matrix)
        right_side = _transposed_times(reals, right.T.ravel()) - h * _transposed_times(times_reals, apply(integers, t))
        return np.asarray(factorise(normal).solve(right_side) / h)


def conjugacy(forms: FloatArray, derivatives: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(F,) II of the tangents of the isolines over the area between them, per h^2, and its derivatives (F, 4), with the
    area taken as constant."""
    p, q, r, s = derivatives.T
    xx, xy, yy = forms.T
    area = np.maximum(np.abs(determinants(derivatives)), LEAST_DETERMINANT)
    value = forms_of_isolines(forms, derivatives)
    slope = np.stack([xy * s - yy * r, xy * r - xx * s, xy * q - yy * p, xy * p - xx * q], axis=1)
    return value / area, slope / area[:, None]


def _transposed_times(matrix: SparseMatrix, values: FloatArray) -> FloatArray:
    return np.asarray(matrix.T @ values)

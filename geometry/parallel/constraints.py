"""The objective, the fixed vertices and the bounds of edge factors of a problem in P(M)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csr_array

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.errors import GeometryError, described
from geometry.functionals import coordinates
from geometry.mesh import Mesh
from geometry.optimise import LinearFunctional, SparseMatrix, normal_equations

__all__ = ["FactorBounds", "FixedVertices", "Objective"]


@dataclass(frozen=True, eq=False)
class Objective:
    """x H x / 2 - g x, with all coordinates x (3N,)."""

    H: SparseMatrix
    g: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, quadratic: Iterable[tuple[float, LinearFunctional]], linear: Any) -> Objective:
        """Half of the sum of weight |r(x)|^2 over the terms plus linear . x; linear (3N,) or (N, 3), or None."""
        n = 3 * mesh.n_vertices
        terms = _weighted_terms(quadratic)
        for position, (weight, term) in enumerate(terms):
            _check_term(position, weight, term, n)
        if any(weight > 0 for weight, _ in terms):
            H, g = normal_equations(terms)
        elif linear is None:
            raise GeometryError("there is no objective: give a quadratic term of positive weight, or a linear one")
        else:
            H, g = csr_array((n, n), dtype=np.float64), np.zeros(n)
        return cls(H, g if linear is None else g - _gradient(linear, mesh) / 2)


def _weighted_terms(quadratic: Any) -> list[tuple[float, LinearFunctional]]:
    """The terms as a list. Raises GeometryError for what is no sequence of pairs of a number and a functional."""
    terms = list(quadratic) if isinstance(quadratic, Iterable) else [quadratic]
    for position, term in enumerate(terms):
        if not isinstance(term, (tuple, list)) or len(term) != 2 or not isinstance(term[1], LinearFunctional):
            raise GeometryError(
                f"term {position} of `quadratic` is {described(term)}: pairs of a weight and a linear functional are "
                "needed in a list, such as [(1.0, laplacian(mesh.combinatorics))]",
                elements=[position],
            )
        if np.ndim(term[0]) or not isinstance(term[0], (int, float, np.number)):
            raise GeometryError(
                f"term {position} of `quadratic` has {described(term[0])} for its weight: a number is needed",
                elements=[position],
            )
    return terms


def _check_term(position: int, weight: float, term: LinearFunctional, n: int) -> None:
    if not (np.isfinite(weight) and weight >= 0):
        raise GeometryError(
            f"quadratic term {position} has the weight {weight}: weights are numbers from 0 upwards",
            elements=[position],
            value=weight,
            bound=0.0,
        )
    rows, columns = term.matrix.shape
    if columns != n or term.target.shape != (rows,):
        raise GeometryError(
            f"quadratic term {position} has {columns} unknowns, {rows} residuals and {len(term.target)} targets, but "
            f"the mesh has {n} coordinates: make it for all vertices of this mesh",
            elements=[position],
            value=columns,
            bound=n,
        )
    if not (np.isfinite(term.target).all() and np.isfinite(term.matrix.data).all()):
        raise GeometryError(f"quadratic term {position} has numbers that are not finite", elements=[position])


def _gradient(linear: Any, mesh: Mesh) -> FloatArray:
    gradient = floats(linear)
    if gradient.shape not in ((3 * mesh.n_vertices,), (mesh.n_vertices, 3)):
        raise GeometryError(
            f"the linear term has shape {gradient.shape}, the mesh needs ({mesh.n_vertices}, 3) or "
            f"({3 * mesh.n_vertices},)"
        )
    not_finite = np.flatnonzero(~np.isfinite(gradient.reshape(-1, 3)).all(axis=1))
    if len(not_finite):
        raise GeometryError(f"the linear term is not finite at vertex {not_finite[0]}", elements=not_finite.tolist())
    return gradient.ravel()


@dataclass(frozen=True, eq=False)
class FixedVertices:
    """The fixed vertices (k,) and their positions (k, 3)."""

    vertices: IntArray
    positions: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, fixed: Mapping[int, Any] | None) -> FixedVertices:
        """Raises GeometryError, naming the vertex, where it does not exist or its position is not three numbers."""
        fixed = {} if fixed is None else fixed
        if not isinstance(fixed, Mapping):
            raise GeometryError(
                f"the positions of vertices are {described(fixed)}: a dict from vertices to positions is needed, such "
                "as {0: (0.0, 0.0, 0.0)}, or dict(zip(vertices, mesh.vertices[vertices])) to leave some where they are"
            )
        for vertex, position in fixed.items():
            if not isinstance(vertex, (int, np.integer)):
                raise GeometryError(f"fixed names vertex {vertex}: the number of a vertex is an integer")
            if not 0 <= vertex < mesh.n_vertices:
                raise GeometryError(
                    f"fixed names vertex {vertex}, but there are {mesh.n_vertices} vertices",
                    elements=[vertex],
                    value=vertex,
                    bound=mesh.n_vertices - 1,
                )
            if np.shape(position) != (3,) or not np.isfinite(position).all():
                raise GeometryError(
                    f"fixed has {position} for vertex {vertex}: a position is three finite numbers",
                    elements=[vertex],
                )
        return cls(integers(list(fixed)), floats(np.array(list(fixed.values()), dtype=np.float64).reshape(-1, 3)))

    def rows(self, n_vertices: int) -> SparseMatrix:
        """(3k, 3N) the coordinates of the fixed vertices from those of all vertices."""
        columns = coordinates(self.vertices).ravel()
        places = (np.arange(len(columns)), columns)
        return csr_array(coo_array((np.ones(len(columns)), places), shape=(len(columns), 3 * n_vertices)))

    def distances(self, positions: FloatArray) -> FloatArray:
        """(k,) distances of the fixed vertices from their positions, for vertices at positions (N, 3)."""
        return np.asarray(np.linalg.norm(positions[self.vertices] - self.positions, axis=1))


@dataclass(frozen=True, eq=False)
class FactorBounds:
    """lower and upper (E,) bounds of the edge factors."""

    lower: FloatArray
    upper: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, bounds: tuple[Any, Any]) -> FactorBounds:
        """From two numbers or arrays (E,), which may be infinite. Raises GeometryError where no factor is possible."""
        if not isinstance(bounds, (tuple, list)) or len(bounds) != 2:
            raise GeometryError(f"the bounds are {bounds}: a lower and an upper one are needed")
        lower, upper = (floats(bound) for bound in bounds)
        for name, values in (("lower", lower), ("upper", upper)):
            if values.shape not in ((), (mesh.n_edges,)):
                raise GeometryError(
                    f"the {name} bounds of the edge factors have shape {values.shape}, there are {mesh.n_edges} edges"
                )
        lower, upper = (floats(np.broadcast_to(values, mesh.n_edges)) for values in (lower, upper))
        wrong = np.flatnonzero(~(lower <= upper) | (lower == np.inf) | (upper == -np.inf))
        if len(wrong):
            edge = int(wrong[0])
            raise GeometryError(
                f"the bounds of the factor of {mesh.combinatorics.edge_name(edge)} are {lower[edge]} and "
                f"{upper[edge]}: no number is between them",
                elements=wrong.tolist(),
                value=float(lower[edge]),
                bound=float(upper[edge]),
            )
        return cls(lower, upper)

    def rows(self, mesh: Mesh) -> SparseMatrix:
        """(E, 3N) t . (s_j - s_i), the factor times the length of the edge in M, t its unit direction."""
        t = mesh.edge_directions
        columns = coordinates(mesh.combinatorics.edges).reshape(-1, 6)
        starts = np.arange(0, columns.size + 1, 6)
        values = np.concatenate([-t, t], axis=1).ravel()
        return csr_array((values, columns.ravel(), starts), shape=(mesh.n_edges, 3 * mesh.n_vertices))

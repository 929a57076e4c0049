"""Noise taken out of a design surface, and how far its vertices move by that."""

from __future__ import annotations

from dataclasses import dataclass

import igl
import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from geometry.arrays import FloatArray, IntArray, floats, short_repr
from geometry.errors import GeometryError
from geometry.mesh import Mesh
from geometry.surface.rim_corners import boundary_corners
from geometry.surface.surface import Surface

__all__ = ["SmoothedSurface", "smoothed"]


@dataclass(frozen=True, eq=False)
class SmoothedSurface:
    """surface: of triangles. moves (N,): how far each of its vertices moved.

    >>> from geometry import Surface, smoothed
    >>> from geometry.mesh import shapes
    >>> result = smoothed(Surface(shapes.dome(16, 5)), 0.5)
    >>> result.surface
    Surface(176 vertices, 320 faces, 496 edges)
    >>> bool(result.moves.max() < 0.1)
    True
    """

    __repr__ = short_repr

    surface: Surface
    moves: FloatArray


def smoothed(surface: Surface, wavelength: float) -> SmoothedSurface:
    """Without waves that are much shorter than the wavelength: halved at that, damped with the fourth power below.

    min of the integral of |x - x0|^2 + s^4 |Laplacian x|^2 with s = wavelength / 2 pi, where along the boundary the
    second derivative of the curve stands for the Laplacian; corners of the boundary stay.
    Raises GeometryError for a wavelength that is no positive number.

    >>> import numpy as np
    >>> from geometry import Surface, smoothed
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(12, 12)
    >>> noise = 0.05 * np.random.default_rng(0).standard_normal(grid.n_vertices)
    >>> noisy = grid.with_vertices(grid.vertices + noise[:, None] * [0, 0, 1])
    >>> calm = smoothed(Surface(noisy), 6.0).surface.mesh
    >>> bool(calm.vertices[:, 2].std() < noisy.vertices[:, 2].std() / 2)
    True
    """
    if not 0 < wavelength < np.inf:
        raise GeometryError(f"the wavelength is {wavelength}: a length above 0 is needed", value=wavelength, bound=0.0)
    mesh = surface.triangulated
    c = mesh.combinatorics
    triangles = c.corners.reshape(-1, 3)
    masses = np.bincount(c.corners, np.repeat(np.linalg.norm(mesh.vector_areas, axis=1) / 3, 3), c.n_vertices)
    stiffness = csr_array(igl.cotmatrix(mesh.vertices, triangles))
    inner = np.where(c.is_boundary_vertex, 0.0, 1 / masses)
    bending = diags_array(inner) @ stiffness + _along_boundary(mesh)
    scale = (wavelength / (2 * np.pi)) ** 4
    data = diags_array(masses)
    held = np.where(boundary_corners(mesh), masses.sum(), 0.0)  # as good as fixed
    matrix = data + diags_array(held) + scale * (bending.T @ data @ bending)
    vertices = splu(csc_array(matrix)).solve((masses + held)[:, None] * mesh.vertices)
    moves = np.linalg.norm(vertices - mesh.vertices, axis=1)
    return SmoothedSurface(Surface(mesh.with_vertices(vertices)), floats(moves))


def _boundary_steps(mesh: Mesh) -> tuple[IntArray, IntArray]:
    """(N, 2) vertex before and after each one on the boundary, -1 elsewhere; which is on it (n,)."""
    c = mesh.combinatorics
    halves = np.flatnonzero(c.twin < 0)
    tails, heads = c.corners[halves], c.corners[c.next_corner[halves]]
    around = np.full((c.n_vertices, 2), -1)
    around[heads, 0], around[tails, 1] = tails, heads
    return around, np.flatnonzero(c.is_boundary_vertex)


def _along_boundary(mesh: Mesh) -> csr_array[np.float64, tuple[int, int]]:
    """(N, N) second derivatives along the boundary; rows of other vertices are empty."""
    around, rim = _boundary_steps(mesh)
    before, after = (np.linalg.norm(mesh.vertices[around[rim, k]] - mesh.vertices[rim], axis=1) for k in (0, 1))
    half = (before + after) / 2
    values = np.concatenate([1 / (before * half), 1 / (after * half), -1 / (before * half) - 1 / (after * half)])
    places = (np.tile(rim, 3), np.concatenate([around[rim, 0], around[rim, 1], rim]))
    return csr_array(coo_array((values, places), shape=(mesh.n_vertices, mesh.n_vertices)))

"""Removal of noise from a design surface, and how far its vertices move."""

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
    """The surface without waves that are much shorter than the wavelength.

    Waves of this length are halved, shorter ones damped with the fourth power of their frequency. The result minimises
    the integral of |x - x0|^2 + s^4 |Laplacian x|^2 with s = wavelength / 2 pi; along the boundary the second
    derivative of the curve replaces the Laplacian. Corners of the boundary keep their positions. Raises GeometryError
    for a wavelength that is not a positive number.

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
    corner_weights = np.where(boundary_corners(mesh), masses.sum(), 0.0)  # a weight so large that corners are fixed
    matrix = data + diags_array(corner_weights) + scale * (bending.T @ data @ bending)
    vertices = splu(csc_array(matrix)).solve((masses + corner_weights)[:, None] * mesh.vertices)
    moves = np.linalg.norm(vertices - mesh.vertices, axis=1)
    return SmoothedSurface(Surface(mesh.with_vertices(vertices)), floats(moves))


def _boundary_steps(mesh: Mesh) -> tuple[IntArray, IntArray]:
    """(N, 2) the vertices before and after each vertex of the boundary, -1 elsewhere; and the vertices (n,) of the
    boundary."""
    c = mesh.combinatorics
    halves = np.flatnonzero(c.twin < 0)
    tails, heads = c.corners[halves], c.corners[c.next_corner[halves]]
    boundary_neighbours = np.full((c.n_vertices, 2), -1)
    boundary_neighbours[heads, 0], boundary_neighbours[tails, 1] = tails, heads
    return boundary_neighbours, np.flatnonzero(c.is_boundary_vertex)


def _along_boundary(mesh: Mesh) -> csr_array[np.float64, tuple[int, int]]:
    """(N, N) second derivatives along the boundary; rows of other vertices are empty."""
    boundary_neighbours, rim = _boundary_steps(mesh)
    before, after = (
        np.linalg.norm(mesh.vertices[boundary_neighbours[rim, k]] - mesh.vertices[rim], axis=1) for k in (0, 1)
    )
    half = (before + after) / 2
    values = np.concatenate([1 / (before * half), 1 / (after * half), -1 / (before * half) - 1 / (after * half)])
    places = (np.tile(rim, 3), np.concatenate([boundary_neighbours[rim, 0], boundary_neighbours[rim, 1], rim]))
    return csr_array(coo_array((values, places), shape=(mesh.n_vertices, mesh.n_vertices)))

"""One pass from a network to a mesh on the surface: (u, v), integers, polygons between isolines, a simplified rim."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import FoldedError, GeometryError, listed
from geometry.layout.cells import cells_between_isolines
from geometry.layout.exact_maps import ExactMap
from geometry.layout.integer_lattices import nearest_integers
from geometry.layout.integration import Integration
from geometry.layout.open_rims import Polygons, simplified_rim
from geometry.layout.rim_gaps import rim_gaps
from geometry.layout.seams import SeamlessMaps
from geometry.layout.singular_points import singular_differences
from geometry.mesh import Mesh
from geometry.networks.combed_fields import CombedField
from geometry.networks.networks import Network
from geometry.surface import on_curved_triangles, surface_corners

__all__ = ["Draft", "draft"]

EDGE_LENGTH_FACTORS = (1.0, 0.97, 1.03, 0.94, 1.06)
"""Factors of the edge length, tried one after another while rounding to integers folds triangles."""


@dataclass(frozen=True, eq=False)
class Draft:
    """A mesh on a surface. vertices (N,): the vertex of the surface at each vertex of the mesh, -1 where there is none.
    derivatives (F, 4): of (u, v) in the triangles of the surface, as in `integration`.
    """

    mesh: Mesh
    vertices: IntArray
    derivatives: FloatArray
    edge_length: float


def draft(network: Network, field: CombedField, maps: SeamlessMaps, n_faces: float) -> Draft:
    """A mesh of about n_faces faces. Raises FoldedError where triangles of the surface remain folded in (u, v)."""
    surface = network.frames.mesh
    c = surface.combinatorics
    problem = Integration(network, maps)
    real_solution = problem.real_solution()
    folded = []
    for factor in EDGE_LENGTH_FACTORS:
        h = factor * np.sqrt(real_solution.predicted / n_faces)
        differences = singular_differences(network.frames, field, maps, h)
        t = nearest_integers(
            real_solution.gram, real_solution.values / h, differences, *rim_gaps(network, field, maps, h)
        )
        x = problem.solved(t, h, field.indices)
        exact = ExactMap.of(c, maps, field.turns, x, t)
        folded.append(exact.folded(field.indices))
        if not len(folded[-1]):
            break
    else:
        least = min(folded, key=len)
        raise FoldedError(
            f"{len(least)} triangles of the surface, triangle {least[0]} among them, are folded by "
            f"the lines of a mesh of {n_faces:.0f} faces with {np.count_nonzero(field.indices)} singular points, as "
            "they are for slightly different numbers of faces",
            "lay open lines where a boundary is aligned, ask for more faces, or smooth the surface",
            elements=least.tolist(),
            value=float(len(least)),
            bound=0.0,
        )
    cells = cells_between_isolines(exact)
    positions = on_curved_triangles(surface, surface.vertex_normals, cells.triangles, cells.weights)
    kept = (cells.vertices >= 0) & (surface_corners(surface) | (field.indices != 0))[cells.vertices]
    numbers = integers(np.arange(len(positions)))
    lengths = h * network.sizes[cells.triangles]
    polygons = simplified_rim(Polygons(positions, numbers, lengths, kept, cells.corners, cells.starts))
    mesh = Mesh(polygons.positions, polygons.combinatorics)
    chi = mesh.combinatorics.euler_characteristic
    if chi != c.euler_characteristic or mesh.edge_lengths.min() == 0:
        raise GeometryError(
            f"a hole or connected part of the surface is too small for faces of edge length {h:.3g}: its rim would "
            f"become a point or an edge (the Euler characteristic becomes {chi} instead of {c.euler_characteristic}"
            f"{_short_loops(surface, h)}); fill the hole, align its boundary, or give a shorter edge length",
            value=float(chi),
            bound=float(c.euler_characteristic),
        )
    return Draft(
        mesh,
        cells.vertices[polygons.origins],
        problem.derivatives(x, t.astype(np.float64), h),
        float(h),
    )


def _short_loops(mesh: Mesh, length: float) -> str:
    """The lengths of boundary loops that are shorter than around a face with edges of this length, in words."""
    loops = [mesh.vertices[np.append(loop, loop[:1])] for loop in mesh.combinatorics.boundary_loops]
    lengths = np.array([np.linalg.norm(np.diff(loop, axis=0), axis=1).sum() for loop in loops])
    short = [f"{each:.3g}" for each in np.sort(lengths[lengths < 4 * length])]
    return f"; boundary loops are only {listed(short, len(short))} long" if short else ""

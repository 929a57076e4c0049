"""A quad-dominant mesh laid on a surface along a network of conjugate curves [Pottmann2007, 4.3]."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.errors import GeometryError
from geometry.layout.cells import cells_between_isolines
from geometry.layout.combed_fields import CombedField, comb
from geometry.layout.cross_fields import cross_field, followed_closer
from geometry.layout.exact_maps import ExactMap
from geometry.layout.integer_lattices import nearest_integers
from geometry.layout.integration import Integration
from geometry.layout.networks import Network
from geometry.layout.open_rims import Polygons, tidied_rim
from geometry.layout.seams import seamless_maps
from geometry.layout.tangent_frames import TangentFrames
from geometry.layout.twists import twist_corrections
from geometry.mesh import Mesh
from geometry.surface.curvature import Curvature
from geometry.surface.curved_triangles import on_curved_triangles

__all__ = ["lay"]

FOLLOW = 30.0
"""Weight of the difference of principal curvatures, squared, over that of the field's gradient, squared."""

CLOSER = 300.0

UMBILIC = 0.05
"""Half the difference of the principal curvatures over their size, below which no direction is preferred."""

SURFACE_CORNER = np.radians(35.0)


def lay(mesh: Mesh, n_faces: int, alpha: FloatArray | None = None, log=None):
    import time
    t0 = time.time()
    curvature = Curvature.of(mesh)
    frames = TangentFrames(mesh)
    tensors = curvature.triangle_tensors
    q = frames.traceless(tensors)
    size = np.sqrt((tensors**2).sum(axis=(1, 2)) / 2)
    strength = np.maximum(np.abs(q) ** 2 - (UMBILIC * size) ** 2, 0)
    wanted = np.divide(q, np.abs(q), out=np.ones_like(q), where=np.abs(q) > 0) ** 2
    field = cross_field(frames, wanted, FOLLOW * 4 * strength)
    combed = comb(frames, field)
    first = combed.first
    if CLOSER: first = followed_closer(frames, first, combed.turns, wanted, CLOSER * 4 * strength)
    network = Network.of(frames, frames.in_space(first), frames.in_space(1j * first), tensors)
    maps = seamless_maps(mesh.combinatorics, combed)
    for second in (False, True):
        problem = Integration(network, maps)
        relaxed = problem.relaxed()
        h = np.sqrt(relaxed.predicted / n_faces)
        t = nearest_integers(relaxed.gram, relaxed.values / h, np.zeros((0, 2, len(relaxed.values)), dtype=np.int64))
        x = problem.solved(t, h)
        exact = ExactMap.of(mesh.combinatorics, maps, combed.turns, x, t)
        if len(exact.folded):
            print('FOLDED', len(exact.folded))
        cells = cells_between_isolines(exact)
        positions = on_curved_triangles(mesh, mesh.vertex_normals, cells.triangles, cells.weights)
        poly = Polygons(positions, integers(np.arange(len(positions))), _stays(mesh, combed.indices, cells.vertices), cells.corners, cells.starts)
        poly = tidied_rim(poly, h)
        quad = Mesh(poly.positions, poly.combinatorics)
        if not second:
            corr = twist_corrections(network, problem.at(x, t.astype(float), h), quad, h)
            network = network.corrected(corr)
    return quad, h, combed, network, frames, time.time() - t0


def _stays(mesh: Mesh, indices: IntArray, vertices: IntArray):
    c = mesh.combinatorics
    rim = np.flatnonzero(c.twin < 0)
    after = np.zeros((c.n_vertices, 3)); before = np.zeros((c.n_vertices, 3))
    d = mesh.vertices[c.corners[c.next_corner[rim]]] - mesh.vertices[c.corners[rim]]
    after[c.corners[rim]] = d
    before[c.corners[c.next_corner[rim]]] = d
    turn = np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), (before * after).sum(axis=1))
    special = (turn > SURFACE_CORNER) | (indices != 0)
    return (vertices >= 0) & special[vertices]

"""What is measured of a mesh laid on a surface along a network."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from geometry.arrays import FloatArray, floats
from geometry.layout.networks import Network
from geometry.mesh import Mesh
from geometry.surface import Surface

__all__ = ["LayoutQuality", "corner_angles", "layout_quality"]


@dataclass(frozen=True, eq=False)
class LayoutQuality:
    """Lengths in mean edge lengths of the mesh, angles in radians.

    quad_share: of the faces. valences: of inner vertices other than 4, how many of each. corner_angles (C,).
    edge_lengths (E,). off_network (n,): angles of the edges inside the mesh from the nearer direction of the network.
    planarity (F,): see Mesh. off_surface (F,): distance of the centres of faces, as vertices are on the surface.
    undirected_share: of the area, where the surface is flat or umbilic and any directions are conjugate.
    """

    quad_share: float
    valences: dict[int, int]
    corner_angles: FloatArray
    edge_lengths: FloatArray
    off_network: FloatArray
    planarity: FloatArray
    off_surface: FloatArray
    undirected_share: float


def layout_quality(mesh: Mesh, network: Network, surface: Surface, undirected_share: float) -> LayoutQuality:
    c = mesh.combinatorics
    inside = c.is_used & ~c.is_boundary_vertex
    valences = np.bincount(c.vertex_degrees[inside])
    sums = np.zeros((c.n_faces, 3))
    np.add.at(sums, c.corner_face, mesh.vertices[c.corners])
    centres = sums / c.face_sizes[:, None]
    return LayoutQuality(
        float((c.face_sizes == 4).mean()),
        {int(k): int(valences[k]) for k in np.flatnonzero(valences) if k != 4},
        floats(corner_angles(mesh)),
        floats(mesh.edge_lengths / mesh.mean_edge_length),
        floats(_off_network(mesh, network)),
        mesh.planarity,
        floats(np.linalg.norm(surface.closest(centres)[0] - centres, axis=1) / mesh.mean_edge_length),
        undirected_share,
    )


def corner_angles(mesh: Mesh) -> FloatArray:
    """(C,) between the two edges of each corner, up to pi."""
    c = mesh.combinatorics
    ahead = mesh.vertices[c.corners[c.next_corner]] - mesh.vertices[c.corners]
    back = mesh.vertices[c.corners[c.previous_corner]] - mesh.vertices[c.corners]
    return np.asarray(np.arctan2(np.linalg.norm(np.cross(ahead, back), axis=1), np.einsum("ci,ci->c", ahead, back)))


def _off_network(mesh: Mesh, network: Network) -> FloatArray:
    inner = ~mesh.combinatorics.is_boundary_edge
    middles = mesh.vertices[mesh.combinatorics.edges[inner]].mean(axis=1)
    frames = network.frames
    triangle = KDTree(frames.mesh.vertices[frames.triangles].mean(axis=1)).query(middles)[1]
    along = mesh.edge_directions[inner]
    cosines = [
        np.abs(np.einsum("ei,ei->e", along, frames.in_space(directions)[triangle]))
        for directions in (network.first, network.second)
    ]
    return np.asarray(np.arccos(np.clip(np.maximum(*cosines), 0.0, 1.0)))

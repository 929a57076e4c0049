"""Measures of the quality of a mesh laid on a surface along a network."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, floats
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_centroids
from geometry.networks.networks import Network
from geometry.surface import Surface

__all__ = ["LayoutQuality", "along_network", "layout_quality"]

LENGTH_SHARES = (0.05, 0.5, 0.95)
"""Shares of the edges whose largest length is reported."""


@dataclass(frozen=True, eq=False)
class LayoutQuality:
    """Lengths in mean edge lengths of the mesh, angles in radians.

    quad_share: share of the faces that are quads. valences: numbers of inner vertices by valence, without 4.
    corner_angles (C,). edge_lengths (E,); length_shares (3,): what 5 %, 50 % and 95 % of them do not exceed.
    off_network (n,): angles between the edges inside the mesh and the nearer direction of the network. planarity (F,):
    see `Mesh`. off_surface (F,): distances of the centres of faces from the surface; vertices are on it.
    undirected_share: share of the area where the surface is flat or umbilic, so that any directions are conjugate.
    """

    quad_share: float
    valences: dict[int, int]
    corner_angles: FloatArray
    edge_lengths: FloatArray
    off_network: FloatArray
    planarity: FloatArray
    off_surface: FloatArray
    undirected_share: float

    @property
    def length_shares(self) -> FloatArray:
        return floats(np.quantile(self.edge_lengths, LENGTH_SHARES))


def layout_quality(mesh: Mesh, along: FloatArray, surface: Surface, undirected_share: float) -> LayoutQuality:
    """along (2, n): see `along_network`."""
    c = mesh.combinatorics
    inside = c.is_used & ~c.is_boundary_vertex
    valences = np.bincount(c.vertex_degrees[inside])
    centres = face_centroids(mesh.vertices, c)
    return LayoutQuality(
        float((c.face_sizes == 4).mean()),
        {int(k): int(valences[k]) for k in np.flatnonzero(valences) if k != 4},
        mesh.corner_angles,
        floats(mesh.edge_lengths / mesh.mean_edge_length),
        floats(np.arccos(np.clip(along.max(axis=0), 0.0, 1.0))),
        mesh.planarity,
        floats(np.linalg.norm(surface.closest(centres)[0] - centres, axis=1) / mesh.mean_edge_length),
        undirected_share,
    )


def along_network(mesh: Mesh, network: Network) -> FloatArray:
    """(2, n) cosines of the angles of the edges inside the mesh with the two directions of the network."""
    inner = ~mesh.combinatorics.is_boundary_edge
    triangle = network.frames.nearest(mesh.vertices[mesh.combinatorics.edges[inner]].mean(axis=1))
    along = mesh.edge_directions[inner]
    directions = [network.frames.in_space(each)[triangle] for each in (network.first, network.second)]
    return np.abs([np.einsum("ei,ei->e", along, each) for each in directions])

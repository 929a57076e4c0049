"""Edge offset meshes [Pottmann2007, 3.2, 3.3]: Koebe polyhedra, meshes parallel to them, and what moves both."""

from geometry.edge_offset import patterns
from geometry.edge_offset.boundary_values import open_pattern
from geometry.edge_offset.contradictory_signs import conflicting_edges
from geometry.edge_offset.design import alternating_signs, edge_offset_mesh, guided_signs, saddle_signs
from geometry.edge_offset.koebe import KoebePolyhedron, SphereCircles, koebe
from geometry.edge_offset.laguerre import LaguerreTransformation
from geometry.edge_offset.moebius import MoebiusTransformation
from geometry.edge_offset.planar_patterns import enneper_koebe
from geometry.edge_offset.plane_pattern import PlanePattern
from geometry.edge_offset.rotational import Pattern, rotational_koebe, rows_within
from geometry.edge_offset.tangent_hexagons import TangentMesh, mesh_with_planes, tangent_mesh
from geometry.edge_offset.vertex_cones import VertexCones

__all__ = [
    "KoebePolyhedron",
    "LaguerreTransformation",
    "MoebiusTransformation",
    "Pattern",
    "PlanePattern",
    "SphereCircles",
    "TangentMesh",
    "VertexCones",
    "alternating_signs",
    "conflicting_edges",
    "edge_offset_mesh",
    "enneper_koebe",
    "guided_signs",
    "koebe",
    "mesh_with_planes",
    "open_pattern",
    "patterns",
    "rotational_koebe",
    "rows_within",
    "saddle_signs",
    "tangent_mesh",
]

"""Edge offset meshes [Pottmann2007, 3.2, 3.3]: Koebe polyhedra, and meshes parallel to them by signs or by contact."""

from geometry.edge_offset.contradictory_signs import conflicting_edges
from geometry.edge_offset.covering import SurfaceCover, mean_normal, surface_cover
from geometry.edge_offset.enneper import enneper_koebe
from geometry.edge_offset.koebe_polyhedra import KoebePolyhedron, SphereCircles, koebe
from geometry.edge_offset.rotational import BandTiling, rotational_koebe, rows_within
from geometry.edge_offset.signed_meshes import alternating_signs, edge_offset_mesh, guided_signs, saddle_signs
from geometry.edge_offset.tangent_hexagons import TangentMesh, mesh_with_planes, tangent_mesh

__all__ = [
    "BandTiling",
    "KoebePolyhedron",
    "SphereCircles",
    "SurfaceCover",
    "TangentMesh",
    "alternating_signs",
    "conflicting_edges",
    "edge_offset_mesh",
    "enneper_koebe",
    "guided_signs",
    "koebe",
    "mean_normal",
    "mesh_with_planes",
    "rotational_koebe",
    "rows_within",
    "saddle_signs",
    "surface_cover",
    "tangent_mesh",
]

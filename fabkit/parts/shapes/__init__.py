"""Exact solids: which vertices bound which faces, and what is measured on them."""

from fabkit.parts.shapes.fillets import Fillets
from fabkit.parts.shapes.profiles import bore_vertices, profile_topology, profile_vertices, round_vertices
from fabkit.parts.shapes.solid import Measures, Solid, SolidArray, prism_vertices
from fabkit.parts.shapes.topology import BORE, SHAFT, Topology, prism_topology, shaft_topology

__all__ = [
    "BORE",
    "SHAFT",
    "Fillets",
    "Measures",
    "Solid",
    "SolidArray",
    "Topology",
    "bore_vertices",
    "prism_topology",
    "prism_vertices",
    "profile_topology",
    "profile_vertices",
    "round_vertices",
    "shaft_topology",
]

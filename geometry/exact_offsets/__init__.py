"""Which exact offsets a mesh has, the Gauss images of these, and the mesh at constant distance [Pottmann2007, 3]."""

from geometry.exact_offsets.constant_offset import OffsetKind, OffsetMesh, offset
from geometry.exact_offsets.exact_gauss_image import edge_offset_pair, exact_pairs, face_offset_pair, vertex_offset_pair
from geometry.exact_offsets.exact_or_approximate import exact_or_approximate_pair
from geometry.exact_offsets.offset_conditions import circularity, conicality, edge_axis_twist, edge_cone_deviation
from geometry.exact_offsets.offset_kinds import best_offset_pair, offset_deviations

__all__ = [
    "OffsetKind",
    "OffsetMesh",
    "best_offset_pair",
    "circularity",
    "conicality",
    "edge_axis_twist",
    "edge_cone_deviation",
    "edge_offset_pair",
    "exact_or_approximate_pair",
    "exact_pairs",
    "face_offset_pair",
    "offset",
    "offset_deviations",
    "vertex_offset_pair",
]

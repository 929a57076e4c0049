"""The Gauss image S of a mesh M [Pottmann2007, 2 to 4]: approximate and exact, distances, axes, support structure."""

from geometry.gauss.approximate_gauss_image import gauss_image, refuse_triangle_mesh
from geometry.gauss.axes import node_axes, parallel_from_axes
from geometry.gauss.distances import (
    circularity,
    conicality,
    edge_axis_twist,
    edge_cone_deviation,
    edge_distances,
    face_distances,
    vertex_distances,
)
from geometry.gauss.exact_gauss_image import (
    DISTANCE_TOLERANCE,
    edge_gauss_image,
    exact_gauss_images,
    face_gauss_image,
    vertex_gauss_image,
)
from geometry.gauss.lean import axis_lean
from geometry.gauss.nearest_pair import nearest_parallel_pair
from geometry.gauss.offset_kinds import offset_deviations, offset_gauss_image
from geometry.gauss.rounded_mesh import gauss_image_pair
from geometry.gauss.support_structure import SupportStructure

__all__ = [
    "DISTANCE_TOLERANCE",
    "SupportStructure",
    "axis_lean",
    "circularity",
    "conicality",
    "edge_axis_twist",
    "edge_cone_deviation",
    "edge_distances",
    "edge_gauss_image",
    "exact_gauss_images",
    "face_distances",
    "face_gauss_image",
    "gauss_image",
    "gauss_image_pair",
    "nearest_parallel_pair",
    "node_axes",
    "offset_deviations",
    "offset_gauss_image",
    "parallel_from_axes",
    "refuse_triangle_mesh",
    "vertex_distances",
    "vertex_gauss_image",
]

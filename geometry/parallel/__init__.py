"""Mesh parallelism [Pottmann2007, 2 to 4]: parallel meshes, Gauss images, offsets, node axes, support structures."""

from geometry.parallel.combined import nearest_parallel_pair
from geometry.parallel.exact import (
    DISTANCE_TOLERANCE,
    edge_gauss_image,
    exact_gauss_images,
    face_gauss_image,
    vertex_gauss_image,
)
from geometry.parallel.freer import gauss_image_pair
from geometry.parallel.gauss_image import gauss_image, refuse_triangle_mesh
from geometry.parallel.lean import axis_lean
from geometry.parallel.node_axes import node_axes, parallel_from_axes
from geometry.parallel.offset_images import offset_deviations, offset_gauss_image
from geometry.parallel.offsets import (
    circularity,
    conicality,
    edge_axis_twist,
    edge_cone_deviation,
    edge_distances,
    face_distances,
    vertex_distances,
)
from geometry.parallel.parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from geometry.parallel.spectrum import Spectrum
from geometry.parallel.support import SupportStructure

__all__ = [
    "DISTANCE_TOLERANCE",
    "ParallelSpace",
    "Spectrum",
    "SupportStructure",
    "axis_lean",
    "circularity",
    "conicality",
    "edge_axis_twist",
    "edge_cone_deviation",
    "edge_distances",
    "edge_factors",
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
    "parallelity",
    "refuse_triangle_mesh",
    "vertex_distances",
    "vertex_gauss_image",
]

"""Mesh parallelism [Pottmann2007, 2 to 4]: parallel meshes, Gauss images, offsets, support structures."""

from geometry.parallel.gauss_image import gauss_image, refuse_triangle_mesh
from geometry.parallel.offsets import (
    circularity,
    conicality,
    edge_axis_twist,
    edge_cone_deviation,
    edge_distances,
    face_distances,
    vertex_distances,
)
from geometry.parallel.space import ParallelSpace, Spectrum, edge_factors, parallelity
from geometry.parallel.support import SupportStructure

__all__ = [
    "ParallelSpace",
    "Spectrum",
    "SupportStructure",
    "circularity",
    "conicality",
    "edge_axis_twist",
    "edge_cone_deviation",
    "edge_distances",
    "edge_factors",
    "face_distances",
    "gauss_image",
    "parallelity",
    "refuse_triangle_mesh",
    "vertex_distances",
]

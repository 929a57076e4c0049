"""Curvatures of meshes with planar faces, with respect to a Gauss image, and meshes that have them constant.

[Pottmann2007, 5].
"""

from geometry.curvature.christoffel_duals import ChristoffelDuals, christoffel_dual
from geometry.curvature.constant_mean_curvature import constant_mean
from geometry.curvature.face_curvature import FaceCurvatures, face_curvatures, steiner_area, steiner_areas
from geometry.curvature.revolution import constant_mean_of_revolution, minimal_of_revolution, radii_at_inflections

__all__ = [
    "ChristoffelDuals",
    "FaceCurvatures",
    "christoffel_dual",
    "constant_mean",
    "constant_mean_of_revolution",
    "face_curvatures",
    "minimal_of_revolution",
    "radii_at_inflections",
    "steiner_area",
    "steiner_areas",
]

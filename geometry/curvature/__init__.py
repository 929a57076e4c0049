"""Curvatures of meshes with planar faces, with respect to a Gauss image [Pottmann2007, 5]."""

from geometry.curvature.faces import FaceCurvatures, face_curvatures, steiner_area, steiner_areas

__all__ = ["FaceCurvatures", "face_curvatures", "steiner_area", "steiner_areas"]

"""The design surface and curves on it: nearest points, normals, curvature, smoothing, subdivision."""

from geometry.surface.curvature import Curvature, Umbilics
from geometry.surface.curve import Curve
from geometry.surface.curved_triangles import on_curved_triangles, refined
from geometry.surface.rim_corners import boundary_corners, surface_corners
from geometry.surface.smoothing import SmoothedSurface, smoothed
from geometry.surface.subdivision import subdivided
from geometry.surface.surface import Surface

__all__ = [
    "Curvature",
    "Curve",
    "SmoothedSurface",
    "Surface",
    "Umbilics",
    "boundary_corners",
    "on_curved_triangles",
    "refined",
    "smoothed",
    "subdivided",
    "surface_corners",
]

"""Circle patterns of the plane, from which Koebe polyhedra are lifted: radii, boundary values, layout."""

from geometry.circle_patterns.boundary_values import open_pattern
from geometry.circle_patterns.plane_pattern import PlanePattern, closed_pattern
from geometry.circle_patterns.radii import CirclePattern

__all__ = ["CirclePattern", "PlanePattern", "closed_pattern", "open_pattern"]

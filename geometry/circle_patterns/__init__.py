"""Circle patterns of the plane, from which Koebe polyhedra are lifted: radii, boundary values, layout."""

from geometry.circle_patterns.boundary_values import open_circle_pattern
from geometry.circle_patterns.circle_pattern import CirclePattern, closed_circle_pattern
from geometry.circle_patterns.radii import RadiusProblem

__all__ = ["CirclePattern", "RadiusProblem", "closed_circle_pattern", "open_circle_pattern"]

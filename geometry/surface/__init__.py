"""The design surface, and curves on it: the nearest point, the normal there."""

from geometry.surface.curve import Curve
from geometry.surface.surface import Surface

__all__ = ["Curve", "Surface"]

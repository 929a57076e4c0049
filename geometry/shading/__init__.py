"""Shade on the panels of M by fins along M + d (S + x), for sun positions [Pottmann2007, 4.4, Figs 1, 15]."""

from geometry.shading.fins import Fins
from geometry.shading.panel_shadows import Shading, cast_shadows
from geometry.shading.suns import Suns, suns_at

__all__ = ["Fins", "Shading", "Suns", "cast_shadows", "suns_at"]

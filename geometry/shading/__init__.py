"""Shade on the panels of M by fins along M + d (S + x), for sun positions [Pottmann2007, 4.4, Figs 1, 15]."""

from geometry.shading.fins import Fins
from geometry.shading.panel_shadows import Shading, cast_shadows
from geometry.shading.suns import Suns, suns_at
from geometry.shading.translations import MostShade, most_shade

__all__ = ["Fins", "MostShade", "Shading", "Suns", "cast_shadows", "most_shade", "suns_at"]

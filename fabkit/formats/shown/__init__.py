"""Parts as viewers show them: triangles, colours and placements."""

from fabkit.formats.shown.placed import Placed, Surface, left_out_bars, placed_parts
from fabkit.formats.shown.triangles import facets

__all__ = ["Placed", "Surface", "facets", "left_out_bars", "placed_parts"]

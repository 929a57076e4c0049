"""Panels on stock sheets: rectangles cut from edge to edge, outlines placed close together, and the check of both."""

from fabkit.production.nesting.nests import Nest, Sheet, moved, outline_areas, polygons
from fabkit.production.nesting.sheet_nesting import nest_panels, too_large

__all__ = ["Nest", "Sheet", "moved", "nest_panels", "outline_areas", "polygons", "too_large"]

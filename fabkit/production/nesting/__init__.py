"""Where each panel lies on which stock sheet."""

from fabkit.production.nesting.loose_panels import panels_from_outlines
from fabkit.production.nesting.nests import Nest, Sheet
from fabkit.production.nesting.sheet_nesting import nest_panels, too_large

__all__ = ["Nest", "Sheet", "nest_panels", "panels_from_outlines", "too_large"]

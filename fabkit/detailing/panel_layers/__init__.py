"""Panels in layers at given levels: their shapes, seats and steps, and the parts made of them."""

from fabkit.detailing.panel_layers.panel_shapes import PanelLayer, PanelShapes, bearings, seats, steps
from fabkit.detailing.panel_layers.panels import make_panels

__all__ = ["PanelLayer", "PanelShapes", "bearings", "make_panels", "seats", "steps"]

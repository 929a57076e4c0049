"""Drawings in two dimensions."""

from fabkit.formats.drawings.dxf import shown_text, write_dxf, write_dxfs
from fabkit.formats.drawings.network_page import networks_html
from fabkit.formats.drawings.picture import pair_picture

__all__ = ["networks_html", "pair_picture", "shown_text", "write_dxf", "write_dxfs"]

"""Design surfaces from the exact faces of a CAD kernel."""

from fabkit.formats.surfaces.exact_surfaces import exact_surface
from fabkit.formats.surfaces.shape_files import EXACT_SUFFIXES, read_shape

__all__ = ["EXACT_SUFFIXES", "exact_surface", "read_shape"]

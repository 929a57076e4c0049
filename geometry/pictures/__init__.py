"""Pictures of meshes: `plot`, and the renderer behind it, which knows polygons, light and pixels, and no window."""

from geometry.pictures.plotting import default_view, plot

__all__ = ["default_view", "plot"]

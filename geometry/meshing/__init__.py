"""From a design surface to a mesh that can be built [Pottmann2007, 4.3]: meshes with planar faces."""

from geometry.meshing.planarise import Planarised, planarise

__all__ = ["Planarised", "planarise"]

"""Networks of conjugate curves on a surface, as two directions in each triangle, and their singular points."""

from geometry.networks.networks import Network

__all__ = ["Network"]

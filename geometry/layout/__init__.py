"""Quads laid on a surface along a network of conjugate curves: direction field, functions (u, v), isolines, mesh."""

from geometry.layout.quads import Boundary, LaidMesh, boundary_lengths, lay_quads

__all__ = ["Boundary", "LaidMesh", "boundary_lengths", "lay_quads"]

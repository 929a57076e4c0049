"""Quads laid on a surface along a network of conjugate curves: direction field, functions (u, v), isolines, mesh."""

from geometry.layout.quads import FEWEST_FACES, LARGEST_LENGTH_RATIO, Boundary, LaidMesh, boundary_lengths, lay_quads

__all__ = ["FEWEST_FACES", "LARGEST_LENGTH_RATIO", "Boundary", "LaidMesh", "boundary_lengths", "lay_quads"]

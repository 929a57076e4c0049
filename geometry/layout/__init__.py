"""Quads laid on a surface along a network of conjugate curves: field, integration, extraction."""

from geometry.layout.quads import LaidMesh, lay_quads

__all__ = ["LaidMesh", "lay_quads"]

"""Quads laid on a surface along a network of conjugate curves: field, integration, extraction."""

__all__: list[str] = []

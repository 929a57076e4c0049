"""Solids of bars, and bores and dots in solids that are made already."""

__all__: list[str] = []

"""Solids of bars, and bores in solids that are made already."""

__all__: list[str] = []

"""Sections and solids of bars, bores and stamps in solids, and how far beams stay back from their nodes."""

__all__: list[str] = []

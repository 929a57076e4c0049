"""Panels in layers at given levels: their shapes, seats and steps, and the parts made of them."""

__all__: list[str] = []

"""Errors that come from where a mesh stands, and what to do about them."""

from __future__ import annotations

import numpy as np

from geometry.mesh.mesh import Mesh

__all__ = ["cure_of_place"]

COORDINATE_ROUNDINGS = 4.0
"""Largest error that is put down to the rounding of coordinates, in that of one of them over the mean edge length: two
ends of an edge, in three axes."""


def cure_of_place(mesh: Mesh, value: float) -> str:
    """What to do about an error, a part of the mean edge length, where it comes from the place of the mesh; else ""."""
    away = float(np.abs(mesh.near_zero()[1]).max()) / mesh.mean_edge_length
    if not value <= COORDINATE_ROUNDINGS * np.finfo(float).eps * away:
        return ""
    return (
        f"the mesh lies {away:.0e} mean edge lengths from the origin, where coordinates are coarse: begin "
        "with mesh.near_zero()[0]"
    )

"""Errors that come from the rounding of coordinates far from zero, and the cure that messages advise."""

from __future__ import annotations

import numpy as np

from geometry.mesh.mesh import Mesh

__all__ = ["far_from_zero_cure"]

COORDINATE_ROUNDINGS = 4.0
"""Largest error that is explained by the rounding of coordinates, over the rounding of one coordinate: both ends of an
edge are rounded, in three axes."""


def far_from_zero_cure(mesh: Mesh, value: float) -> str:
    """The cure for an error `value`, over the mean edge length, if the rounding of coordinates explains it; else ""."""
    distance = float(np.abs(mesh.near_zero()[1]).max()) / mesh.mean_edge_length
    if not value <= COORDINATE_ROUNDINGS * np.finfo(float).eps * distance:
        return ""
    return (
        f"the mesh is {distance:.0e} mean edge lengths from the origin, where coordinates are rounded coarsely: begin "
        "with mesh.near_zero()[0]"
    )

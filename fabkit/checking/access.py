"""Room for the tools that tighten bolts."""

from __future__ import annotations

import numpy as np

from fabkit.kinds import BOLT, BoltDetails
from fabkit.parts import Assembly, Parts, SolidArray, prism_topology, prism_vertices
from geometry.arrays import FloatArray

__all__ = ["tool_volumes"]

TOOL_SIDES = 8
"""Number of sides of the prism about a tool: with sides at right angles to the axes of the bolt's frame, in which beams
are cut, it is as wide there as the tool."""


def tool_volumes(assembly: Assembly, first: int) -> SolidArray:
    """The spaces over the heads of all bolts that their tools need, in their order, as parts numbered from `first`."""
    layers = assembly.of_layers(BOLT)
    angles = 2 * np.pi / TOOL_SIDES * (np.arange(TOOL_SIDES) + 0.5)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1) / np.cos(np.pi / TOOL_SIDES)
    vertices = np.concatenate([_placed(bolts, circle) for bolts in layers])
    return SolidArray(prism_topology(TOOL_SIDES), first + np.arange(len(vertices)), vertices)


def _placed(bolts: Parts[BoltDetails], circle: FloatArray) -> FloatArray:
    outlines = bolts.details.tool_radius_mm[:, None, None] * circle
    prisms = prism_vertices(outlines, -bolts.details.tool_length_mm, 0.0)
    own = prisms[..., [2, 0, 1]]  # along the x axis
    return np.asarray(bolts.origins[:, None] + own @ bolts.axes)

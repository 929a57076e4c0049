"""Struts along the node axes, from the top of the block of the inner layer to the bottom of that of the outer one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes
from fabkit.detailing.shapes.bars import bar_solids
from fabkit.kinds import STRUT, StrutDetails
from fabkit.parts import Material, Parts, Section
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["StrutPlaces", "make_struts", "strut_places"]


@dataclass(frozen=True, eq=False)
class StrutPlaces:
    """The axes of all struts. starts (N, 3): points of the axes on the tops of the inner blocks, in mm; lengths (N,):
    from there to the bottoms of the outer ones, NaN where a block is missing. slopes (N, 3): of the tops, vectors
    perpendicular to the axes along which the tops rise by as much as they are long."""

    starts: FloatArray
    lengths: FloatArray
    slopes: FloatArray

    def shortest(self, radius: float) -> FloatArray:
        """(N,) shortest extent along the axes of struts with this radius, in mm."""
        return np.asarray(self.lengths - radius * np.linalg.norm(self.slopes, axis=1))


def strut_places(
    inner: tuple[SupportStructure, Ends, NodeShapes], outer: tuple[SupportStructure, Ends, NodeShapes]
) -> StrutPlaces:
    """The axes between the blocks of two layers, of which the bottoms of the outer ones are square to the axes."""
    (structure, ends, blocks), (above, _, blocks_above) = inner, outer
    axes = structure.axes
    x = np.zeros((structure.mesh.n_vertices, 3))
    first = ends.ring[ends.ring_starts[:-1][np.diff(ends.ring_starts) > 0]]
    x[ends.vertex[first]] = ends.radial[first]
    slopes = blocks.slope[:, :1] * x + blocks.slope[:, 1:] * np.cross(axes, x)
    apart = np.einsum("nk,nk->n", above.mesh.vertices - structure.mesh.vertices, axes)
    starts = structure.mesh.vertices + blocks.top[:, None] * axes
    return StrutPlaces(starts, apart + blocks_above.bottom - blocks.top, slopes)


def make_struts(
    structure: SupportStructure, places: StrutPlaces, vertices: IntArray, section: Section, material: Material
) -> Parts[Any]:
    """Struts at these vertices, in their order."""
    n, x = len(vertices), structure.axes[vertices]
    lengths, slopes = places.lengths[vertices], places.slopes[vertices]
    sizes = np.linalg.norm(slopes, axis=1)
    z = np.where((sizes > 0)[:, None], slopes, np.cross(x, np.eye(3)[np.abs(x).argmin(axis=1)]))
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    first, second = np.zeros((n, 3)), np.zeros((n, 3))
    first[:, 2], second[:, 0] = sizes, lengths
    radius, names = section.width_mm / 2, np.empty(n, dtype=object)
    names[:] = section
    solids = bar_solids(section, first, second)
    return Parts.each_its_own(
        STRUT,
        vertices,
        solids,
        origins=places.starts[vertices] + radius * z,
        axes=np.stack([x, np.cross(z, x), z], axis=1),
        material=material,
        details=StrutDetails(
            section=names,
            length_mm=lengths + radius * sizes,
            cut_angle_deg=np.degrees(np.arctan(sizes)),
        ),
    )

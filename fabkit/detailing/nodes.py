"""Node blocks: prisms along the node axes with a facet for each beam."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.detailing.beams import height_range
from fabkit.detailing.ends import Ends
from fabkit.detailing.setbacks import block_half_width
from fabkit.kinds import NODE, NodeDetails
from fabkit.parts import Material, Parts, Ragged, Solids
from fabkit.rules import DetailingRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["NodeShapes", "axis_misalignments", "make_nodes", "node_shapes"]


HALF_TURN_TOLERANCE = 1e-6
"""Angle in radians by which a gap between beams may exceed half a turn without an extra corner of the block. It is
above rounding at map coordinates, and a block without that corner deviates by a ten-thousandth of a millimetre."""


@dataclass(frozen=True, eq=False)
class NodeShapes:
    """Blocks of all nodes; a node without beams has none.

    corners (K, 2): sections in mm about the axis, x towards the first beam of the ring, node by node and
    counter-clockwise; corner_starts (N+1,): node i has corners[corner_starts[i]:corner_starts[i+1]].
    bottom, top (N,): levels in mm along the axis, NaN where there is no block. top_step, axis_misalignment (N,):
    in mm, see `NodeDetails`.
    """

    corners: FloatArray
    corner_starts: IntArray
    bottom: FloatArray
    top: FloatArray
    top_step: FloatArray
    axis_misalignment: FloatArray


def node_shapes(structure: SupportStructure, ends: Ends, rules: DetailingRules) -> NodeShapes:
    """The smallest blocks that enclose the end faces of the beams.

    Neighbouring facets are joined by straight lines. A gap between beams of more than half a turn gets one more corner
    in its middle, half a beam's width from the axis, so that the block always contains its axis.
    """
    corners, starts = _sections(ends, block_half_width(rules), structure.mesh.n_vertices)
    inner, outer = height_range(rules.beams)
    lows, highs = (
        (ends.setback * np.sin(ends.inclination) + level) / np.cos(ends.inclination) for level in (inner, outer)
    )
    n = structure.mesh.n_vertices
    bottom, _ = _extremes(lows, ends, n)
    lowest_top, top = _extremes(highs, ends, n)
    return NodeShapes(corners, starts, bottom, top, top - lowest_top, axis_misalignments(ends, (inner, outer), n))


def axis_misalignments(ends: Ends, levels: tuple[float, float], n_vertices: int) -> FloatArray:
    """(N,) misalignment of the beams at each node axis, in mm; NaN where there are no beams.

    The centre lines of the inner sides of a node's beams meet its axis in points, and so do those of the outer sides.
    The misalignment is the larger of the two distances between the highest and the lowest of these points. levels: of
    the inner and outer sides above the mesh edges, in mm.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import axis_misalignments, beam_ends
    >>> ends = beam_ends(built.structure, np.ones(30, dtype=bool), built.project.rules)
    >>> axis_misalignments(ends, (-120.0, 0.0), 18).max().round(1).item()
    12.3
    """
    on_axis = [_extremes(level / np.cos(ends.inclination), ends, n_vertices) for level in levels]
    spreads: FloatArray = np.maximum(*(highest - lowest for lowest, highest in on_axis))
    return spreads


def _extremes(values: FloatArray, ends: Ends, n_vertices: int) -> tuple[FloatArray, FloatArray]:
    """(N,) smallest and largest of the values (2E,) at the ends of each node's ring; NaN where there are none."""
    smallest, largest = np.full(n_vertices, np.inf), np.full(n_vertices, -np.inf)
    np.minimum.at(smallest, ends.vertex[ends.ring], values[ends.ring])
    np.maximum.at(largest, ends.vertex[ends.ring], values[ends.ring])
    empty = np.isinf(smallest)
    smallest[empty] = largest[empty] = np.nan
    return smallest, largest


def _sections(ends: Ends, half_width: float, n_vertices: int) -> tuple[FloatArray, IntArray]:
    ring = ends.ring
    azimuth, setback, gap = ends.azimuth[ring], ends.setback[ring], ends.gap[ring]
    half_angle, radius = np.arctan2(half_width, setback), np.hypot(half_width, setback)
    middle = azimuth + gap / 2
    angles = np.stack([azimuth - half_angle, azimuth + half_angle, middle], axis=1)
    radii = np.stack([radius, radius, np.full(len(ring), half_width)], axis=1)
    present = np.stack([np.ones_like(gap), np.ones_like(gap), gap > np.pi + HALF_TURN_TOLERANCE], axis=1).astype(bool)
    counts = np.bincount(ends.vertex[ring], weights=present.sum(axis=1), minlength=n_vertices).astype(np.int64)
    angles, radii = angles[present], radii[present]
    corners = radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return corners, np.concatenate([[0], np.cumsum(counts)])


def make_nodes(
    structure: SupportStructure, ends: Ends, shapes: NodeShapes, vertices: IntArray, material: Material
) -> Parts[NodeDetails]:
    """Node blocks at these vertices, which have at least one beam each, in their order."""
    rings = Ragged(ends.ring, ends.ring_starts)[vertices]
    sections = Ragged(shapes.corners, shapes.corner_starts)[vertices]
    bottom, top = shapes.bottom[vertices], shapes.top[vertices]
    z, x = structure.axes[vertices], ends.radial[rings.values[rings.starts[:-1]]]
    return Parts.each_its_own(
        NODE,
        vertices,
        Solids.prisms(sections, bottom, top),
        origins=structure.mesh.vertices[vertices],
        axes=np.stack([x, np.cross(z, x), z], axis=1),
        material=material,
        details=NodeDetails(
            beams=rings.with_values(rings.values // 2),
            azimuths_deg=rings.with_values(np.degrees(ends.azimuth[rings.values])),
            inclinations_deg=rings.with_values(np.degrees(ends.inclination[rings.values])),
            setbacks_mm=rings.with_values(ends.setback[rings.values]),
            height_mm=top - bottom,
            top_step_mm=shapes.top_step[vertices],
            axis_misalignment_mm=shapes.axis_misalignment[vertices],
        ),
    )

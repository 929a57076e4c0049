"""Node blocks: prisms along the node axes with a facet for each beam."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fabkit.detailing.ends import HALF_TURN_TOLERANCE, Ends
from fabkit.detailing.hubs import circumscribed_sections
from fabkit.detailing.shapes.setbacks import facet_half_widths
from fabkit.kinds import NODE, NodeDetails
from fabkit.parts import Material, Parts, Ragged, Solids
from fabkit.rules import DetailingRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["NodeShapes", "axis_misalignments", "facet_sides", "make_nodes", "node_shapes"]


FLAT_TOPS_SHARE = 1e-6
"""Extent of the tops of a node's beams in one direction over that in the other, squared, below which the top of the
block is level in that direction."""


@dataclass(frozen=True, eq=False)
class NodeShapes:
    """Blocks of all nodes; a node without beams has none.

    corners (K, 2): sections in mm about the axis, x towards the first beam of the ring, node by node and
    counter-clockwise; corner_starts (N+1,): node i has corners[corner_starts[i]:corner_starts[i+1]].
    bottom, top (N,): levels in mm on the axis, NaN where there is no block. slope, bottom_slope (N, 2): of the top and
    the bottom along x and y.
    top_step, axis_misalignment (N,): in mm, see `NodeDetails`.
    """

    corners: FloatArray
    corner_starts: IntArray
    bottom: FloatArray
    top: FloatArray
    slope: FloatArray
    bottom_slope: FloatArray
    top_step: FloatArray
    axis_misalignment: FloatArray


def node_shapes(structure: SupportStructure, ends: Ends, rules: DetailingRules) -> NodeShapes:
    """The smallest blocks that enclose the end faces of the beams, with tops by the rules.

    Neighbouring facets are joined by straight lines. A gap between beams of more than half a turn gets one more corner
    in its middle, half a facet's width from the axis, so that the block always contains its axis.
    """
    n = structure.mesh.n_vertices
    corners, starts = _sections(ends, facet_half_widths(ends.bars, rules), n)
    inner, outer = ends.bars.at_ends
    lows, highs = ends.levels(inner), ends.levels(outer)
    bottom, _ = _extremes(lows, ends, n)
    lowest_top, top = _extremes(highs, ends, n)
    step, slope, bottom_slope = top - lowest_top, np.zeros((n, 2)), np.zeros((n, 2))
    if rules.connection.kind == "hub":
        corners, starts = circumscribed_sections(ends, n)
        flange, cap = np.repeat(ends.bars.flanges, 2), rules.connection.cap_mm
        _, web_top = _extremes(highs - flange / np.cos(ends.inclination), ends, n)
        bottom, top = bottom - cap, web_top + cap
    else:
        if rules.nodes.top == "trimmed":
            top, slope = _tilted_tops(ends, highs, n)
        if rules.nodes.bottom == "trimmed":
            bottom, bottom_slope = (-each for each in _tilted_tops(ends, -lows, n))
    misalignment = axis_misalignments(ends, (inner, outer), n)
    return NodeShapes(corners, starts, bottom, top, slope, bottom_slope, step, misalignment)


def _tilted_tops(ends: Ends, highs: FloatArray, n: int) -> tuple[FloatArray, FloatArray]:
    """Levels on the axis (N,) and slopes (N, 2) of planes that touch the tops of the beams' end faces from above, each
    parallel to the plane with the least sum of squares of distances from both corners of these tops.

    highs (2E,): levels of the tops.
    """
    ring = ends.ring
    node = np.concatenate([ends.vertex[ring]] * 2)
    azimuth = ends.azimuth[ring]
    radial, aside = (np.stack([np.cos(a), np.sin(a)], axis=1) for a in (azimuth, azimuth + np.pi / 2))
    middle, half_width = ends.setback[ring, None] * radial, ends.bars.half_widths[ring, None]
    points = np.concatenate([middle - half_width * aside, middle + half_width * aside])
    levels = np.concatenate([highs[ring]] * 2)

    def sums(values: FloatArray) -> FloatArray:
        return np.asarray(np.bincount(node, weights=values, minlength=n), dtype=np.float64)

    count = np.maximum(sums(np.ones(len(node))), 1)
    x, y, z = (values - (sums(values) / count)[node] for values in (*points.T, levels))
    squares = np.stack([sums(x * x), sums(x * y), sums(x * y), sums(y * y)], axis=1).reshape(-1, 2, 2)
    products = np.stack([sums(x * z), sums(y * z)], axis=1)
    slope = np.einsum("njk,nk->nj", np.linalg.pinv(squares, rcond=FLAT_TOPS_SHARE, hermitian=True), products)
    top = np.full(n, -np.inf)
    np.maximum.at(top, node, levels - np.einsum("kj,kj->k", slope[node], points))
    return np.where(np.isinf(top), np.nan, top), slope


def uncovered_shares(ends: Ends, shapes: NodeShapes) -> FloatArray:
    """(2E,) share of each beam's end face, width times height, that stands above the top of the block; NaN for ends in
    no ring."""
    inner, outer = ends.bars.at_ends
    height = (outer - inner) / np.cos(ends.inclination)
    slope, half = shapes.slope[ends.vertex], ends.bars.half_widths
    along = slope[:, 0] * np.cos(ends.azimuth) + slope[:, 1] * np.sin(ends.azimuth)
    aside = slope[:, 1] * np.cos(ends.azimuth) - slope[:, 0] * np.sin(ends.azimuth)
    middle = ends.levels(outer) - shapes.top[ends.vertex] - ends.setback * along
    with np.errstate(invalid="ignore"):
        above = _mean_above(middle, half * aside) - _mean_above(middle - height, half * aside)
    return above / height


def _mean_above(middle: FloatArray, half: FloatArray) -> FloatArray:
    """Mean over |s| <= 1 of the larger of 0 and middle + half s."""
    half = np.abs(half)
    high = np.maximum(middle + half, 0.0)
    above = np.divide(high, 2 * half, out=np.ones_like(high), where=high < 2 * half)  # the part of the range
    return np.where(high < 2 * half, above * high / 2, np.maximum(middle, 0.0))


def axis_misalignments(
    ends: Ends, levels: tuple[float | FloatArray, float | FloatArray], n_vertices: int
) -> FloatArray:
    """(N,) misalignment of the beams at each node axis, in mm; NaN where there are no beams.

    The centre lines of the inner sides of a node's beams meet its axis in points, and so do those of the outer sides.
    The misalignment is the larger of the two distances between the highest and the lowest of these points. levels: of
    the inner and outer sides above the mesh edges, in mm, of all ends or of each (2E,).

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


def _sections(ends: Ends, half_widths: FloatArray, n_vertices: int) -> tuple[FloatArray, IntArray]:
    ring = ends.ring
    azimuth, setback, gap = ends.azimuth[ring], ends.setback[ring], ends.gap[ring]
    half_width = half_widths[ring]
    half_angle, radius = np.arctan2(half_width, setback), np.hypot(half_width, setback)
    middle = azimuth + gap / 2
    angles = np.stack([azimuth - half_angle, azimuth + half_angle, middle], axis=1)
    radii = np.stack([radius, radius, half_width], axis=1)
    present = np.stack([np.ones_like(gap), np.ones_like(gap), gap > np.pi + HALF_TURN_TOLERANCE], axis=1).astype(bool)
    counts = np.bincount(ends.vertex[ring], weights=present.sum(axis=1), minlength=n_vertices).astype(np.int64)
    angles, radii = angles[present], radii[present]
    corners = radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return corners, np.concatenate([[0], np.cumsum(counts)])


def facet_sides(ends: Ends) -> IntArray:
    """(2E,) face of its node block, a prism, on which each beam ends; -1 for ends in no ring."""
    ring, wide = ends.ring, ends.gap[ends.ring] > np.pi + HALF_TURN_TOLERANCE
    before = np.concatenate([[0], np.cumsum(2 + wide)])
    sides = np.full(len(ends.vertex), -1, dtype=np.int64)
    sides[ring] = 2 + before[:-1] - before[ends.ring_starts[ends.vertex[ring]]]
    return sides


def make_nodes(
    structure: SupportStructure,
    ends: Ends,
    shapes: NodeShapes,
    vertices: IntArray,
    material: Material,
) -> Parts[NodeDetails]:
    """Node blocks at these vertices, which have at least one beam each, in their order."""
    rings = Ragged(ends.ring, ends.ring_starts)[vertices]
    own = rings.values
    sections = Ragged(shapes.corners, shapes.corner_starts)[vertices]
    bottom, top = shapes.bottom[vertices], shapes.top[vertices]
    solids = Solids.prisms(sections, bottom, top)
    rises, falls = (
        np.einsum("kj,kj->k", sections.values, slope[vertices][sections.row])
        for slope in (shapes.slope, shapes.bottom_slope)
    )
    values, is_top = solids.vertices.values.copy(), solids.vertices.place >= sections.sizes[solids.vertices.row]
    values[is_top, 2] += rises
    values[~is_top, 2] += falls
    solids = replace(solids, vertices=solids.vertices.with_values(values))
    z, x = structure.axes[vertices], ends.radial[rings.values[rings.starts[:-1]]]
    return Parts.each_its_own(
        NODE,
        vertices,
        solids,
        origins=structure.mesh.vertices[vertices],
        axes=np.stack([x, np.cross(z, x), z], axis=1),
        material=material,
        details=NodeDetails(
            beams=rings.with_values(own // 2),
            azimuths_deg=rings.with_values(np.degrees(ends.azimuth[own])),
            inclinations_deg=rings.with_values(np.degrees(ends.inclination[own])),
            setbacks_mm=rings.with_values(ends.setback[own]),
            uncovered_percent=rings.with_values(100 * uncovered_shares(ends, shapes)[own]),
            height_mm=top
            + sections.with_values(rises).reduced(np.maximum)
            - (bottom + sections.with_values(falls).reduced(np.minimum)),
            top_step_mm=shapes.top_step[vertices],
            axis_misalignment_mm=shapes.axis_misalignment[vertices],
        ),
    )

"""Solids of bars: a section between two oblique cuts, with hand holes, or with a flange that is cut back.

Vertices are listed so that half a turn about z, which exchanges the ends, reverses their order (see `BeamDetails`).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from fabkit.parts import (
    Section,
    Solids,
    Topology,
    prism_topology,
    profile_topology,
    profile_vertices,
    round_vertices,
    shaft_topology,
)
from geometry.arrays import FloatArray, IntArray

__all__ = ["bar_solids", "cut_planes", "flange_points", "hand_hole_middles", "stepped_tees", "with_hand_holes"]

HAND_HOLE_CHAMFER_MM = 15.0
"""Length in mm by which the corners of a hand hole are cut off, so that no crack begins there."""

HAND_HOLE_START_MM = 30.0
"""Clear distance in mm of a hand hole from the end of its bar, for the weld of the end plate."""

BESIDE_TWO_HAND_HOLES_MM = 180.0
"""Least length in mm between the cuts of a bar with two hand holes, without these: 400 in all with holes of 110; in
shorter ones a hand reaches both ends from the middle."""

HOLE_CORNERS = 8
"""Number of corners of a hand hole, a rectangle whose own corners are cut off."""

RIGHT, LEFT = (5, 9), (3, 7)
"""Outer and inner face of the two sides of a hollow section, as `profile_topology` numbers them, seen from end A."""


def cut_planes(corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(n, 3) planes of both cuts, as in `profile_vertices`, of bars whose side views have corners (n, 4, 2), in the
    order of `BeamShapes`."""
    height = corners[:, 1, 1] - corners[:, 0, 1]

    def plane(inner: FloatArray, outer: FloatArray) -> FloatArray:
        return np.stack([(inner + outer) / 2, np.zeros(len(inner)), (outer - inner) / height], axis=1)

    return plane(corners[:, 0, 0], corners[:, 1, 0]), plane(corners[:, 3, 0], corners[:, 2, 0])


def bar_solids(section: Section, first: FloatArray, second: FloatArray) -> Solids:
    """Bars of one section between planes (n, 3) across the x axis, their z = 0 at the outer side."""
    if section.is_round:
        topology = shaft_topology(hollow=len(section.radii) > 1)
        vertices = round_vertices(section.radii, first, second)
        starts = np.arange(0, topology.n_vertices, 4)
        front = np.stack([starts, starts + 1], axis=1).ravel()
        order = np.concatenate([front, front[::-1] + 2])
    else:
        topology = profile_topology(section.loops, section.corner_radii)
        vertices = profile_vertices(section.loops, first, second, radii=section.corner_radii)
        mirrored = _mirrored(section)
        order = np.concatenate([np.arange(len(mirrored)), len(mirrored) + mirrored[::-1]])
    return Solids.alike(_outer_side_up(vertices[:, order], section), renumbered(topology, order))


def _outer_side_up(vertices: FloatArray, section: Section) -> FloatArray:
    """The vertices of bars whose axes are at half of the height, with z = 0 at the outer side."""
    return np.asarray(vertices - np.array([0.0, 0.0, section.height_mm / 2]))


def _mirrored(section: Section) -> IntArray:
    """(k,) number of the point of the section that lies opposite each of its points in the central plane."""
    flat = np.zeros(3)
    points = profile_vertices(section.loops, flat, flat, radii=section.corner_radii)[:, 1:]
    points = points[: len(points) // 2]
    return np.asarray(np.abs(points[:, None] * [-1.0, 1.0] - points[None]).sum(axis=2).argmin(axis=1))


def renumbered(topology: Topology, order: IntArray) -> Topology:
    """The topology whose vertex k is vertex order[k] of the given one; the same object for equal arguments."""
    return _renumbered(topology, tuple(order.tolist()))


@lru_cache(maxsize=256)
def _renumbered(topology: Topology, order: tuple[int, ...]) -> Topology:
    number = np.empty(len(order), dtype=np.int64)
    number[list(order)] = np.arange(len(order))
    rounds = topology.rounds.copy()
    rounds[:, :4] = number[rounds[:, :4]]
    fillets = topology.fillets.copy()
    fillets[:, 1:3] = number[fillets[:, 1:3]]
    return replace(
        topology,
        corners=number[topology.corners],
        rounds=rounds,
        fillets=fillets,
        pieces=tuple((number[vertices], piece) for vertices, piece in topology.pieces),
    )


# --- hand holes


def with_hand_holes(section: Section, planes: tuple[FloatArray, FloatArray], height: float, length: float) -> Solids:
    """Bars of a rectangular hollow section as in `bar_solids`, with a hand hole of this height and length near each
    end, seen from which it is in the left side; bars that are too short for two have one in the middle."""
    at_ends = hand_hole_middles(section, planes, length)
    reach = _reach(section, planes)
    near, far = planes[0][:, 0] - reach[0] + at_ends[:, 0], planes[1][:, 0] + reach[1] - at_ends[:, 1]
    is_long = ~np.isnan(far)
    rows, batches = [], []
    for chosen, middles in ((is_long, (near, far)), (~is_long, (near,))):
        own = planes[0][chosen], planes[1][chosen]
        vertices, topology = _pierced_bars(section, own, tuple(middle[chosen] for middle in middles), height, length)
        rows.append(np.flatnonzero(chosen))
        batches.append(Solids.alike(_outer_side_up(vertices, section), topology))
    return Solids.gathered(rows, batches)


def hand_hole_middles(section: Section, planes: tuple[FloatArray, FloatArray], length: float) -> FloatArray:
    """(n, 2) distances along the axis in mm of the middle of the hand hole at either end from the long point there;
    where there is only one, NaN at the second end."""
    reach = _reach(section, planes)
    clear = planes[1][:, 0] - reach[1] - planes[0][:, 0] - reach[0]
    at_ends = 2 * reach.T + HAND_HOLE_START_MM + length / 2
    is_short = clear < 2 * length + BESIDE_TWO_HAND_HOLES_MM
    at_ends[is_short] = np.stack([2 * reach[0] + clear / 2, np.full_like(clear, np.nan)], axis=1)[is_short]
    return at_ends


def _reach(section: Section, planes: tuple[FloatArray, FloatArray]) -> FloatArray:
    """(2, n) half of what the cut at each end takes along the axis."""
    reach: FloatArray = section.height_mm / 2 * np.abs(np.stack(planes)[..., 2])
    return reach


def _pierced_bars(
    section: Section,
    planes: tuple[FloatArray, FloatArray],
    middles: tuple[FloatArray, ...],
    height: float,
    length: float,
) -> tuple[FloatArray, Topology]:
    """Vertices and topology of bars with a hole at x = middles[0] (n,) in their left sides, seen along x, and at
    middles[1], if there are two, in their right sides."""
    topology = profile_topology(section.loops, section.corner_radii)
    vertices = profile_vertices(section.loops, *planes, radii=section.corner_radii)
    half, wall, n = section.width_mm / 2, section.sizes[2], topology.n_vertices // 2
    z, x = _hole_outline(height / 2, length / 2)
    blocks = [vertices]
    for middle, (outer, inner), turn in zip(middles, (LEFT, RIGHT), (1.0, -1.0), strict=False):
        topology = _pierced(topology, outer, inner)
        for y in (half, half - wall):
            along = middle[:, None] + turn * x
            blocks.append(np.stack([along, np.full_like(along, turn * y), np.broadcast_to(z, along.shape)], axis=2))
    corners = 2 * n + np.arange(2 * HOLE_CORNERS)
    later = corners[::-1] + 2 * HOLE_CORNERS if len(middles) > 1 else corners[:0]
    order = np.concatenate([np.arange(n), corners, later, n + _mirrored(section)[::-1]])
    return np.concatenate(blocks, axis=1)[:, order], renumbered(topology, order)


@lru_cache(maxsize=16)
def _pierced(topology: Topology, outer: int, inner: int) -> Topology:
    return topology.pierced(outer, inner, HOLE_CORNERS)


def _hole_outline(half_height: float, half_length: float) -> tuple[FloatArray, FloatArray]:
    """z and x (HOLE_CORNERS,) of a rectangle without its corners, counter-clockwise seen against the y axis."""
    cut = min(HAND_HOLE_CHAMFER_MM, half_height / 2, half_length / 2)
    high, far = half_height - cut, half_length - cut
    z = np.array([half_height, half_height, high, -high, -half_height, -half_height, -high, high])
    x = np.array([-far, far, half_length, half_length, far, -far, -half_length, -half_length])
    return z, x


# --- tees


def flange_points(section: Section, side_views: FloatArray, back: FloatArray | None) -> FloatArray:
    """(n, 2) longest and shortest extent along the axis of the flanges of `stepped_tees`, in mm; NaN of other bars,
    without back. side_views (n, 4, 2): as of `cut_planes`."""
    if back is None:
        return np.full((len(side_views), 2), np.nan)
    first, second = cut_planes(side_views)
    levels = section.height_mm / 2 - np.array([section.flange_mm, 0.0])
    tail = first[:, :1] + first[:, 2:] * levels + back[:, :1]
    head = second[:, :1] + second[:, 2:] * levels - back[:, 1:]
    return np.stack([head.max(axis=1) - tail.min(axis=1), head.min(axis=1) - tail.max(axis=1)], axis=1)


def stepped_tees(section: Section, web: tuple[FloatArray, FloatArray], back: FloatArray) -> Solids:
    """Tees as in `bar_solids`, made of a web plate between planes (n, 3), and a flange plate that ends before it by
    back (n, 2) along the axis."""
    along = np.array([1.0, 0.0, 0.0])
    flange = web[0] + back[:, :1] * along, web[1] - back[:, 1:] * along
    top, under = section.height_mm / 2, section.height_mm / 2 - section.sizes[2]
    half_web, half = section.web_mm / 2, section.width_mm / 2
    right = np.array([[half_web, -top], [half_web, under], [half_web, under], [half, under], [half, top]])
    points = np.concatenate([right, right[::-1] * [-1.0, 1.0]])
    of_web = np.isin(np.arange(10), [0, 1, 8, 9])
    ends = []
    for own, others in zip(web, flange, strict=True):
        plane = np.where(of_web[:, None], own[:, None], others[:, None])  # (n, 10, 3)
        x = plane[..., 0] + plane[..., 2] * points[:, 1]
        ends.append(np.concatenate([x[..., None], np.broadcast_to(points, (*x.shape, 2))], axis=2))
    return Solids.alike(_outer_side_up(np.concatenate(ends, axis=1), section), stepped_tee_topology())


@lru_cache(maxsize=1)
def stepped_tee_topology() -> Topology:
    """At each end: lower and upper corner of the web on the right, the point of the flange's end above the latter,
    lower and upper corner of the flange; then the same on the left from above to below."""
    loops = [
        *([0, 9, 8, 1], [10, 11, 18, 19], [3, 2, 7, 6, 5, 4], [13, 14, 15, 16, 17, 12]),  # ends of web and flange
        *([0, 1, 2, 12, 11, 10], [19, 18, 17, 7, 8, 9], [0, 10, 19, 9]),  # sides and lower side of the web
        *([1, 8, 7, 2], [12, 17, 18, 11]),  # the web's upper side before the flange
        *([3, 13, 12, 2], [7, 17, 16, 6], [3, 4, 14, 13], [16, 15, 5, 6], [4, 5, 15, 14]),  # the flange
    ]
    pieces = ([9, 0, 1, 8, 19, 10, 11, 18], [6, 3, 4, 5, 16, 13, 14, 15])
    return Topology(
        20,
        np.concatenate(loops),
        np.cumsum([0, *map(len, loops)]),
        np.arange(len(loops) + 1),
        pieces=tuple((np.array(piece), prism_topology(4)) for piece in pieces),
    )

"""Marks: equal parts share one mark and one solid, so that a workshop makes them from one drawing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from fabkit.parts import Assembly, Details, Measures, Parts, Ragged, SolidArray, Symmetry, Turns, moved
from fabkit.production.equal_shapes import TurnedShapes, equal_shapes, may_have_equals
from geometry.arrays import FloatArray, IntArray

__all__ = ["EQUAL_WITHIN_MM", "compared_points", "share_equal_parts", "turned_parts", "turned_shapes", "turns_of"]

EQUAL_WITHIN_MM = 1e-7
"""Default of the largest difference in mm of each coordinate of corners of parts that count as equal. Smaller than the
permitted deviation of a beam's end from its facet (1e-6 mm), so that shared solids keep their fit; far above rounding
(1e-10 mm for a building of 100 m)."""

D = TypeVar("D", bound=Details)


def share_equal_parts(assembly: Assembly, *, within_mm: float = EQUAL_WITHIN_MM) -> Assembly:
    """The same parts, where equal ones share a mark and the solid of the first of them; all others have their own mark.

    within_mm: largest difference in each coordinate of the corners of parts that count as equal. Parts that share a
    mark may be misplaced by up to this tolerance.

    A part in one of the turns of its kind's symmetry is the same piece: a beam turned end for end, a node or panel
    turned about its normal. A mirrored part is not. The first of equal parts keeps its own frame; the frames of the
    others are turned to match it. Marks are numbered in the order of the mesh elements: B001, N001, P001.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import detail
    >>> from fabkit.production import share_equal_parts
    >>> each = detail(built.structure, built.project.rules, name="roof").assembly
    >>> len(each["beams"].mark_names), len(share_equal_parts(each)["beams"].mark_names)
    (30, 5)
    """
    return replace(assembly, groups=tuple(_share(group, within_mm) for group in assembly.groups))


def _share(parts: Parts[D], within_mm: float) -> Parts[D]:
    """Parts grouped where they are equal. Only parts of the same material, topology and number of turns are
    compared."""
    first, turn = np.arange(len(parts)), np.zeros(len(parts), dtype=np.int64)
    starts, along = np.zeros((len(parts), 2)), np.tile([1.0, 0.0], (len(parts), 1))
    keys = np.stack([parts.solids.topology[parts.shape], _n_turns(parts), parts.material], axis=1)
    comparable = np.unique(keys, axis=0, return_inverse=True)[1]
    for places in np.split(np.argsort(comparable, kind="stable"), np.cumsum(np.bincount(comparable))[:-1]):
        alike = parts.solids.by_topology(parts.shape[places])
        chosen = may_have_equals(compared_points(alike[0]), within_mm) if alike else np.zeros(len(places), dtype=bool)
        places = places[chosen]
        if not len(places):
            continue
        solids, turns = alike[0][chosen], turns_of(parts.take(places), alike[0].vertices[chosen])
        own_first, own_turn = equal_shapes(turned_shapes(turns, compared_points(solids)), within_mm)
        first[places], turn[places] = places[own_first], own_turn
        rows = np.arange(len(places))
        starts[places], along[places] = turns.starts[rows, own_turn], turns.along[rows, own_turn]
    return turned_parts(_marked(parts, first), turn, starts, along)


def _n_turns(parts: Parts[D]) -> IntArray:
    """(n,) number of turns of each part that its kind's symmetry allows."""
    symmetry = parts.kind.symmetry
    if symmetry is None:
        return np.ones(len(parts), dtype=np.int64)
    ring = getattr(parts.details, symmetry.ring_fields[0])
    return ring.sizes if isinstance(ring, Ragged) else np.full(len(parts), ring.shape[1])


def turns_of(parts: Parts[D], corners: FloatArray) -> Turns:
    """The turns that symmetry allows, of comparable parts with corners (n, c, 3) in mm."""
    if parts.kind.symmetry is not None and len(_n_turns(parts)) and _n_turns(parts)[0] > 0:
        return parts.kind.symmetry.turns(parts, corners)
    starts, along = np.zeros((len(parts), 1, 2)), np.tile([1.0, 0.0], (len(parts), 1, 1))
    return Turns(starts, along, lambda parts, turns, chosen: np.broadcast_to(chosen, (len(parts), len(chosen))))


def compared_points(solids: SolidArray) -> FloatArray:
    """(P, n, 3) the vertices in mm, in which equal solids agree. A rim may be anywhere on its circle; it is replaced by
    the point over its centre, outwards, at right angles to the plane of the circle, and as far as the radius."""
    rounds = solids.topology.rounds
    if not len(rounds):
        return solids.vertices
    of, points = Measures(solids.topology, solids.vertices), solids.vertices.copy()
    for end, side in ((0, -1.0), (1, 1.0)):
        rims, squares = of.rims[end], (of.rims[end] * of.rims[end]).sum(axis=0)
        outwards = side * (of.round_axes * squares - rims * of.leans[end]) / np.sqrt(squares)  # as long as the radius
        points[:, rounds[:, 2 * end + 1]] = points[:, rounds[:, 2 * end]] + np.moveaxis(outwards, 0, 2)
    return points


def turned_shapes(turns: Turns, corners: FloatArray) -> TurnedShapes:
    """The shapes with points (n, c, 3) in mm, numbered as their vertices, in each of their turns."""

    def at(parts: IntArray, turn: IntArray, chosen: IntArray) -> FloatArray:
        points = corners[parts[:, None], turns.corners(parts, turn, chosen)]
        return moved(points, turns.starts[parts, turn], turns.along[parts, turn])

    n, n_turns = turns.starts.shape[:2]
    return TurnedShapes(n, n_turns, corners.shape[1], at)


def _marked(parts: Parts[D], first: IntArray) -> Parts[D]:
    """The parts with the marks and solids of the first parts (n,) to which they are equal."""
    firsts, mark = np.unique(first, return_inverse=True)
    width = max(3, len(str(len(firsts))))
    names = tuple(f"{parts.kind.letter}{number:0{width}d}" for number in range(1, len(firsts) + 1))
    return replace(parts, solids=parts.solids.take(parts.shape[firsts]), shape=mark, mark_names=names, mark=mark)


def turned_parts(parts: Parts[D], turn: IntArray, starts: FloatArray, along: FloatArray) -> Parts[D]:
    """The parts with placements and details turned: turn (n,) of each; starts (n, 2) in mm and along (n, 2), origins
    and x axes of the new frames in the frames of the parts."""
    symmetry, rows = parts.kind.symmetry, np.flatnonzero(turn)
    if symmetry is None or not len(rows):
        return parts
    x, y = along[rows].T
    zero, one = np.zeros_like(x), np.ones_like(x)
    turned = np.stack([[x, y, zero], [-y, x, zero], [zero, zero, one]]).transpose(2, 0, 1)
    origins, axes = parts.origins.copy(), parts.axes.copy()
    origins[rows] += (np.pad(starts[rows], ((0, 0), (0, 1)))[:, None] @ axes[rows])[:, 0]
    axes[rows] = turned @ axes[rows]
    return replace(parts, origins=origins, axes=axes, details=_details_turned(parts.details, symmetry, turn))


def _details_turned(details: D, symmetry: Symmetry[Any], turn: IntArray) -> D:
    changes: dict[str, Any] = {}
    for name in symmetry.ring_fields:
        values = getattr(details, name)
        if not isinstance(values, Ragged):
            order = (np.arange(values.shape[1]) + turn[:, None]) % values.shape[1]
            changes[name] = np.take_along_axis(values, order, axis=1)
            continue
        rolled = values.rolled(turn)
        if name in symmetry.azimuth_fields:
            from_first = rolled.values - np.append(rolled.values, 0.0)[rolled.starts[:-1]][rolled.row]
            rolled = rolled.with_values(np.where(turn[rolled.row] > 0, np.mod(from_first, 360.0), rolled.values))
        changes[name] = rolled
    return replace(details, **changes)

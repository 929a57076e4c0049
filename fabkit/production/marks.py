"""Marks: equal parts share one mark and one solid, so that a workshop makes them alike."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from fabkit.parts import Assembly, Details, Parts, Ragged, Symmetry, Turns, moved
from fabkit.production.equal_shapes import TurnedShapes, equal_shapes, may_have_equals
from geometry.arrays import FloatArray, IntArray

__all__ = ["EQUAL_WITHIN_MM", "share_equal_parts", "turned_parts", "turned_shapes", "turns_of"]

EQUAL_WITHIN_MM = 1e-7
"""Parts with all corners within this distance are equal, if nothing else is said. Below what a beam's end may be off
its facet (1e-6 mm), so that sharing solids keeps the fit; far above rounding (1e-10 mm for a building of 100 m)."""

D = TypeVar("D", bound=Details)


def share_equal_parts(assembly: Assembly, *, within_mm: float = EQUAL_WITHIN_MM) -> Assembly:
    """The same parts; equal ones share a mark and the solid of the first of them, others have a mark of their own.

    within_mm: how far each coordinate of corners of parts may differ for these to count as equal. Parts are then
    misplaced by up to this tolerance.

    A part seen in one of the turns of its kind's symmetry is the same piece: a beam turned end for end, a node or panel
    turned about its normal; a mirrored one is not. The first of equal parts keeps its own frame, the frames of the
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
    """Group equal parts. Only parts of one material and one topology, with equally many turns, are compared."""
    first, turn = np.arange(len(parts)), np.zeros(len(parts), dtype=np.int64)
    starts, along = np.zeros((len(parts), 2)), np.tile([1.0, 0.0], (len(parts), 1))
    keys = np.stack([parts.solids.topology[parts.shape], _n_turns(parts), parts.material], axis=1)
    comparable = np.unique(keys, axis=0, return_inverse=True)[1]
    for places in np.split(np.argsort(comparable, kind="stable"), np.cumsum(np.bincount(comparable))[:-1]):
        alike = parts.solids.by_topology(parts.shape[places])
        places = places[may_have_equals(alike[0].vertices, within_mm)] if alike else places
        if not len(places):
            continue
        some = parts.take(places)
        corners = some.solids.by_topology(some.shape)[0].vertices
        turns = turns_of(some, corners)
        own_first, own_turn = equal_shapes(turned_shapes(turns, corners), within_mm)
        first[places], turn[places] = places[own_first], own_turn
        rows = np.arange(len(places))
        starts[places], along[places] = turns.starts[rows, own_turn], turns.along[rows, own_turn]
    return turned_parts(_marked(parts, first), turn, starts, along)


def _n_turns(parts: Parts[D]) -> IntArray:
    """(n,) in how many turns each part may be seen."""
    symmetry = parts.kind.symmetry
    if symmetry is None:
        return np.ones(len(parts), dtype=np.int64)
    ring = getattr(parts.details, symmetry.ring_fields[0])
    return ring.sizes if isinstance(ring, Ragged) else np.full(len(parts), ring.shape[1])


def turns_of(parts: Parts[D], corners: FloatArray) -> Turns:
    """In which turns parts may be seen that are comparable and have corners (n, c, 3)."""
    if parts.kind.symmetry is not None and len(_n_turns(parts)) and _n_turns(parts)[0] > 0:
        return parts.kind.symmetry.turns(parts, corners)
    starts, along = np.zeros((len(parts), 1, 2)), np.tile([1.0, 0.0], (len(parts), 1, 1))
    return Turns(starts, along, lambda parts, turns, chosen: np.broadcast_to(chosen, (len(parts), len(chosen))))


def turned_shapes(turns: Turns, corners: FloatArray) -> TurnedShapes:
    """Where corners (n, c, 3) are in each of the turns."""

    def at(parts: IntArray, turn: IntArray, chosen: IntArray) -> FloatArray:
        points = corners[parts[:, None], turns.corners(parts, turn, chosen)]
        return moved(points, turns.starts[parts, turn], turns.along[parts, turn])

    n, n_turns = turns.starts.shape[:2]
    return TurnedShapes(n, n_turns, corners.shape[1], at)


def _marked(parts: Parts[D], first: IntArray) -> Parts[D]:
    """With marks and solids of the first part (n,) to which each is equal."""
    firsts, mark = np.unique(first, return_inverse=True)
    width = max(3, len(str(len(firsts))))
    names = tuple(f"{parts.kind.letter}{number:0{width}d}" for number in range(1, len(firsts) + 1))
    return replace(parts, solids=parts.solids.take(parts.shape[firsts]), shape=mark, mark_names=names, mark=mark)


def turned_parts(parts: Parts[D], turn: IntArray, starts: FloatArray, along: FloatArray) -> Parts[D]:
    """Placements and details as seen in these turns (n,), from starts with x-axes along (n, 2) in the parts' frames."""
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
            ahead = rolled.values - np.append(rolled.values, 0.0)[rolled.starts[:-1]][rolled.row]
            rolled = rolled.with_values(np.where(turn[rolled.row] > 0, np.mod(ahead, 360.0), rolled.values))
        changes[name] = rolled
    return replace(details, **changes)

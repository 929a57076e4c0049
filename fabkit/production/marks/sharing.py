"""Marks: equal parts share one mark and one solid, so that a workshop makes them from one drawing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from fabkit.errors import DetailingError
from fabkit.parts import Assembly, Details, Parts, Ragged, SolidArray, Symmetry, Turns, moved
from fabkit.production.marks.equal_shapes import (
    MAX_COORDINATES_IN_MEMORY,
    TurnedShapes,
    equal_shapes,
    may_have_equals,
)
from fabkit.production.marks.kept import KeptMarks, compared_points, makes
from fabkit.rules import MarkRules
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["EQUAL_WITHIN_MM", "share_equal_parts", "turned_parts", "turned_shapes", "turns_of"]

EQUAL_WITHIN_MM = 0.5
"""Default of the largest difference in mm of each coordinate of corners of parts that count as equal. Of the order of
what saws and glass cutters keep, so that a workshop could not tell the parts apart."""

D = TypeVar("D", bound=Details)


def share_equal_parts(
    assembly: Assembly,
    *,
    within_mm: float = EQUAL_WITHIN_MM,
    rules: MarkRules | None = None,
    ranks: Mapping[str, IntArray] | None = None,
    kept: Mapping[str, KeptMarks] | None = None,
) -> Assembly:
    """The same parts, where equal ones share a mark and the solid of the first of them; all others have their own mark.

    within_mm: largest difference in each coordinate of the corners of parts that count as equal; rules: what else has
    to agree, and how marks are numbered. ranks: the order of vertices, edges and faces, as `element_ranks` gives it.
    kept: by groups, the marks of an earlier build that parts keep, as `mark_points` gives them.

    A part in one of the turns of its kind's symmetry is the same piece: a beam turned end for end, a node or panel
    turned about its normal, and where the rules say that both faces of panes are equal, a panel turned over. The first
    of equal parts keeps its own frame; the frames of the others are turned to match it. Each part stays where it was,
    so that one that shares a solid may be off by the tolerance, and by twice as much where it keeps an earlier mark;
    `Parts.hidden_mm` says how much. A part in the place of an earlier one keeps its mark unless it has changed by more
    than the tolerance, or differs from another part that has the mark by more than twice that. Raises
    DetailingError where marks of two kinds would be one name.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import detail
    >>> from fabkit.production import share_equal_parts
    >>> each = detail(built.structure, built.project.rules, name="roof").assembly
    >>> len(each["beams"].mark_names), len(share_equal_parts(each)["beams"].mark_names)
    (30, 5)
    """
    sharing = _Sharing(within_mm, rules or MarkRules(), _bar_lengths(assembly))
    groups = []
    for parts in assembly.groups:
        rank = parts.elements if ranks is None else ranks[parts.kind.element][parts.elements]
        own = (kept or {}).get(parts.kind.group, KeptMarks())
        order = np.argsort(rank, kind="stable")
        groups.append(sharing.shared(parts, order, own, own.in_the_place_of(parts.centres_mm + assembly.origin_mm)))
    _check_apart(groups)
    return replace(assembly, groups=tuple(groups))


def _check_apart(groups: Sequence[Parts[Any]]) -> None:
    """Raise DetailingError where two marks are the same name of a file, on systems that do not tell a from A."""
    seen: dict[str, tuple[str, str]] = {}
    for parts in groups:
        for mark in parts.mark_names:
            other, name = seen.setdefault(mark.casefold(), (mark, parts.kind.name))
            if (other, name) != (mark, parts.kind.name):
                raise DetailingError(
                    f"the mark {mark} of a {parts.kind.name} would be the same name of a file as {other} of a {name}: "
                    "take another prefix (marks.prefix), or do not keep these marks (marks.keep)"
                )


def _bar_lengths(assembly: Assembly) -> FloatArray:
    """(E,) length of the longest bar on each edge up to the last that has one."""
    bars = [parts for parts in assembly.groups if parts.kind.form == "bar" and parts.kind.element == "edge"]
    lengths = np.zeros(1 + max((int(parts.elements.max(initial=0)) for parts in bars), default=0))
    for parts in bars:
        along = parts.solids.vertices.with_values(parts.solids.vertices.values[:, 0])
        extents = along.reduced(np.maximum) - along.reduced(np.minimum)
        np.maximum.at(lengths, parts.elements, extents[parts.shape])
    return lengths


@dataclass(frozen=True, eq=False)
class _Alike:
    """Parts of one topology, material and number of turns, in the order in which they are compared.

    solids, turns: of each; reaches (n, t, 3): the far ends of the longest beam along its directions, in mm times
    scale.
    """

    solids: SolidArray
    turns: Turns
    reaches: FloatArray

    def seen(self, points: FloatArray) -> TurnedShapes:
        return turned_shapes(self.turns, points, self.reaches)


@dataclass(frozen=True, eq=False)
class _Sharing:
    within_mm: float
    rules: MarkRules
    bar_lengths_mm: FloatArray

    @property
    def reach(self) -> float:
        """Length of a direction, so that differences at the far end of the longest beam compare as those of corners."""
        return max(1.0, float(self.bar_lengths_mm.max())) * self.within_mm / self.rules.far_end_mm

    def shared(self, parts: Parts[D], order: IntArray, kept: KeptMarks, before: IntArray) -> Parts[D]:
        """Parts grouped where they are equal. order (n,): in which they are visited; before (n,): the earlier pieces in
        their places. Only parts of the same material, finish, topology and number of turns are compared."""
        n = len(parts)
        kept_as = np.full(n, -1, dtype=np.int64)
        first, turn = np.arange(n), np.zeros(n, dtype=np.int64)
        starts, along, over = np.zeros((n, 2)), np.tile([1.0, 0.0], (n, 1)), np.full(n, np.nan)
        hidden = np.zeros((n, 2))
        solids: dict[int, FloatArray] = {}
        made_of = np.unique(makes(parts), return_inverse=True)[1]
        keys = np.stack([parts.solids.topology[parts.shape], _n_turns(parts), parts.material, made_of], axis=1)[order]
        comparable = np.unique(keys, axis=0, return_inverse=True)[1]
        for rows in (
            [] if n == 0 else np.split(np.argsort(comparable, kind="stable"), np.cumsum(np.bincount(comparable))[:-1])
        ):
            places = order[rows]
            alike, numbers, earlier = self._compared(parts, places, kept)
            if alike is None:
                continue
            places = places[alike.solids.parts]
            seen = alike.seen(compared_points(alike.solids))
            own_before = self._own_before(kept, numbers, before[places])
            own_first, own_turn, own_kept = equal_shapes(seen, self.within_mm, earlier, own_before)
            first[places], turn[places] = places[own_first], own_turn
            kept_as[places] = np.append(numbers, -1)[own_kept]
            every = np.arange(len(places))
            starts[places], along[places] = alike.turns.starts[every, own_turn], alike.turns.along[every, own_turn]
            over[places] = alike.turns.over(every, own_turn)
            hidden[places] = self._hidden(parts.take(places), alike, own_first, own_turn)
            for k in np.flatnonzero((own_first == every) & (own_turn > 0)).tolist():
                corners = np.arange(alike.solids.vertices.shape[1])
                solids[int(places[k])] = alike.seen(alike.solids.vertices).at(np.array([k]), own_turn[[k]], corners)[0]
        marked = _marked(parts, first, order, kept_as, kept, self.rules, solids)
        return turned_parts(replace(marked, hidden_mm=hidden, turned_over=~np.isnan(over)), turn, starts, along, over)

    def _compared(
        self, parts: Parts[D], places: IntArray, kept: KeptMarks
    ) -> tuple[_Alike | None, IntArray, FloatArray]:
        """Those of the parts at these places that may have equals, the numbers of the kept marks with as many corners
        and directions, and the corners and reaches of these. None where no part may have equals."""
        solids = parts.solids.by_topology(parts.shape[places])
        n_corners, n_reaches = solids[0].vertices.shape[1], 0
        reaches = np.zeros((len(places), 0, 3))
        if parts.kind.directions is not None:
            reaches = self.reach * parts.kind.directions(parts.take(places)).values.reshape(len(places), -1, 3)
            n_reaches = reaches.shape[1]
        make = makes(parts.take(places[:1]))[0]
        shapes = ((make, n_corners, n_reaches) == each.shape for each in kept.points.values())
        numbers = np.flatnonzero(np.fromiter(shapes, dtype=bool, count=len(kept.points)))
        known = list(kept.points.values())
        earlier = np.zeros((len(numbers), n_corners + n_reaches, 3))
        for row, number in enumerate(numbers.tolist()):
            earlier[row] = np.concatenate([known[number].corners, self.reach * known[number].directions])
        corners = np.concatenate([compared_points(solids[0]), earlier[:, :n_corners]])
        chosen = may_have_equals(corners, (2 if len(earlier) else 1) * self.within_mm)[: len(places)]
        if not chosen.any():
            return None, numbers, earlier
        own = solids[0][chosen]
        return (
            _Alike(
                own, turns_of(parts.take(places[chosen]), own.vertices, over=self.rules.mirrored_panes), reaches[chosen]
            ),
            numbers,
            earlier,
        )

    def _own_before(self, kept: KeptMarks, numbers: IntArray, pieces: IntArray) -> tuple[IntArray, FloatArray]:
        """Which of these kept marks, given by their numbers, the earlier pieces (q,) had, -1 for another; and how far
        they were off the first shape of it."""
        place = {mark: row for row, mark in enumerate(np.array(list(kept.points), dtype=object)[numbers].tolist())}
        marks = np.array([*(place.get(mark, -1) for mark in kept.marks), -1], dtype=np.int64)
        moved = {mark: each.apart_mm(kept.points[mark], self.reach) for mark, each in kept.latest.items()}
        off = (kept.hidden_mm * [1.0, self.within_mm / self.rules.far_end_mm]).max(axis=1)
        off += np.array([moved.get(mark, 0.0) for mark in kept.marks])
        return marks[pieces], np.append(off, 0.0)[pieces]

    def _hidden(self, parts: Parts[D], alike: _Alike, first: IntArray, turn: IntArray) -> FloatArray:
        """(n, 2) for each of the parts, those that were compared, how far its corners and the far ends of its beams are
        from those of the first part to which it is equal."""
        hidden, seen = np.zeros((len(first), 2)), alike.seen(compared_points(alike.solids))
        n_corners, n_turns = alike.solids.vertices.shape[1], seen.n_turns
        lengths = np.zeros((len(first), seen.n_corners - n_corners))
        if parts.kind.directions is not None:
            ring = getattr(parts.details, parts.kind.symmetry.ring_fields[0]) if parts.kind.symmetry else Ragged.of([])
            known = ring.values < len(self.bar_lengths_mm)
            own = np.where(known, self.bar_lengths_mm[np.where(known, ring.values, 0)], 0.0).reshape(lengths.shape)
            place = (np.arange(lengths.shape[1]) + turn[:, None]) % n_turns
            lengths = np.take_along_axis(own, place, axis=1) / self.reach
        shared = np.flatnonzero(first != np.arange(len(first)))
        size, corners = max(1, MAX_COORDINATES_IN_MEMORY // (3 * seen.n_corners)), np.arange(seen.n_corners)
        for some in (shared[start : start + size] for start in range(0, len(shared), size)):
            off = seen.at(some, turn[some], corners) - seen.at(first[some], turn[first[some]], corners)
            off = np.abs(off).max(axis=2)
            hidden[some, 0] = off[:, :n_corners].max(axis=1)
            hidden[some, 1] = (off[:, n_corners:] * lengths[some]).max(axis=1, initial=0.0)
        return hidden


def _n_turns(parts: Parts[D]) -> IntArray:
    """(n,) number of turns of each part that its kind's symmetry allows."""
    symmetry = parts.kind.symmetry
    if symmetry is None:
        return np.ones(len(parts), dtype=np.int64)
    ring = getattr(parts.details, symmetry.ring_fields[0])
    return ring.sizes if isinstance(ring, Ragged) else np.full(len(parts), ring.shape[1])


def turns_of(parts: Parts[D], corners: FloatArray, *, over: bool = False) -> Turns:
    """The turns that symmetry allows, of comparable parts with corners (n, c, 3) in mm; over: also those in which parts
    without an outer side are turned over."""
    symmetry = parts.kind.symmetry
    if symmetry is not None and len(_n_turns(parts)) and _n_turns(parts)[0] > 0:
        turns = symmetry.turns(parts, corners)
        return symmetry.turned_over(parts, turns, corners) if over and symmetry.turned_over else turns
    starts, along = np.zeros((len(parts), 1, 2)), np.tile([1.0, 0.0], (len(parts), 1, 1))
    return Turns(starts, along, lambda parts, turns, chosen: np.broadcast_to(chosen, (len(parts), len(chosen))))


def turned_shapes(turns: Turns, corners: FloatArray, reaches: FloatArray | None = None) -> TurnedShapes:
    """The shapes with points (n, c, 3) in mm, numbered as their vertices, and after them with those of the places of
    their rings, reaches (n, t, 3), in each of their turns."""
    n, n_turns = turns.starts.shape[:2]
    n_corners = corners.shape[1]
    points = corners if reaches is None else np.concatenate([corners, reaches], axis=1)

    def at(parts: IntArray, turn: IntArray, chosen: IntArray) -> FloatArray:
        own = chosen < n_corners
        numbers = np.empty((len(parts), len(chosen)), dtype=np.int64)
        numbers[:, own] = turns.corners(parts, turn, chosen[own])
        numbers[:, ~own] = n_corners + (chosen[~own] - n_corners + turn[:, None]) % n_turns
        frames = turns.starts[parts, turn], turns.along[parts, turn], turns.over(parts, turn)
        return moved(points[parts[:, None], numbers], *frames)

    return TurnedShapes(n, n_turns, points.shape[1], at)


def _marked(
    parts: Parts[D],
    first: IntArray,
    order: IntArray,
    kept_as: IntArray,
    kept: KeptMarks,
    rules: MarkRules,
    turned: Mapping[int, FloatArray],
) -> Parts[D]:
    """The parts with the marks and solids of the first parts (n,) to which they are equal: kept marks come first, new
    ones in their order. turned: the vertices of first parts that are described from another turn than their own."""
    place = np.empty(len(parts), dtype=np.int64)
    place[order] = np.arange(len(parts))
    models = np.unique(first)
    number = np.where(kept_as[models] < 0, len(kept.points) + place[models], kept_as[models])
    models = models[np.argsort(number)]
    mark = np.empty(len(parts), dtype=np.int64)
    mark[models] = np.arange(len(models))
    names = list(kept.points)
    n_kept = int((kept_as[models] >= 0).sum())
    start = max(rules.start, kept.next_number)
    width = max(3, len(str(start + len(models) - n_kept - 1)))
    mark_names = [names[k] for k in kept_as[models[:n_kept]].tolist()]
    mark_names += [f"{rules.prefix}{parts.kind.letter}{start + k:0{width}d}" for k in range(len(models) - n_kept)]
    solids = parts.solids.take(parts.shape[models])
    if turned:
        values = solids.vertices.values.copy()
        for k, vertices in turned.items():
            begin = solids.vertices.starts[mark[k]]
            values[begin : begin + len(vertices)] = vertices
        solids = replace(solids, vertices=solids.vertices.with_values(values))
    mark = mark[first]
    return replace(parts, solids=solids, shape=mark, mark_names=tuple(mark_names), mark=mark, models=models)


def turned_parts(
    parts: Parts[D], turn: IntArray, starts: FloatArray, along: FloatArray, over_mm: FloatArray | None = None
) -> Parts[D]:
    """The parts with placements and details turned: turn (n,) of each; starts (n, 2) in mm and along (n, 2), origins
    and x axes of the new frames in the frames of the parts; over_mm (n,): levels of these origins where parts are
    turned over, NaN where they are not."""
    symmetry, rows = parts.kind.symmetry, np.flatnonzero(turn)
    if symmetry is None or not len(rows):
        return parts
    levels = np.full(len(parts), np.nan) if over_mm is None else over_mm
    side = np.where(np.isnan(levels[rows]), 1.0, -1.0)
    x, y = along[rows].T
    zero = np.zeros_like(x)
    turned = np.stack([[x, y, zero], [-y * side, x * side, zero], [zero, zero, side]]).transpose(2, 0, 1)
    origins, axes = parts.origins.copy(), parts.axes.copy()
    at = np.column_stack([starts[rows], np.nan_to_num(levels[rows])])
    origins[rows] += (at[:, None] @ axes[rows])[:, 0]
    axes[rows] = turned @ axes[rows]
    details = _details_turned(parts.details, symmetry, turn, ~np.isnan(levels))
    return replace(parts, origins=origins, axes=axes, details=details)


def _details_turned(details: D, symmetry: Symmetry[Any], turn: IntArray, over: BoolArray) -> D:
    changes: dict[str, Any] = {}
    for name in symmetry.ring_fields:
        values = getattr(details, name)
        if not isinstance(values, Ragged):
            order = (np.arange(values.shape[1]) + turn[:, None]) % values.shape[1]
            changes[name] = np.take_along_axis(values, order, axis=1)
            continue
        row, sizes = values.row, values.sizes[values.row]
        backwards = turn[row] + int(name in symmetry.corner_fields) - values.place
        place = np.where(over[row], backwards, turn[row] + values.place) % sizes
        rolled = values.with_values(values.values[values.starts[row] + place])
        if name in symmetry.azimuth_fields:
            from_first = rolled.values - np.append(rolled.values, 0.0)[rolled.starts[:-1]][rolled.row]
            rolled = rolled.with_values(np.where(turn[rolled.row] > 0, np.mod(from_first, 360.0), rolled.values))
        changes[name] = rolled
    return replace(details, **changes)

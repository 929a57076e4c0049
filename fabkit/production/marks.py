"""Marks: equal parts share one mark and one solid, so that a workshop makes them alike."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from fabkit.parts import Assembly, Beam, Frame, Node, Panel, Part, Solid, prism_vertices
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["EQUAL_WITHIN_MM", "share_equal_parts"]

EQUAL_WITHIN_MM = 1e-7
"""Parts with all corners within this distance are equal, if nothing else is said. Below what a beam's end may be off
its facet (1e-6 mm), so that sharing solids keeps the fit; far above rounding (1e-10 mm for a building of 100 m)."""

P = TypeVar("P", bound=Part)


def share_equal_parts(assembly: Assembly, *, within_mm: float = EQUAL_WITHIN_MM) -> Assembly:
    """The same parts; equal ones share a mark and the solid of the first of them, others have a mark of their own.

    within_mm: how far each coordinate of corners of parts may differ for these to count as equal. Parts then stand off
    their places by as much.

    A beam turned end for end, a node or panel turned about its normal is the same piece; a mirrored one is not.
    The first of equal parts keeps its own frame, the frames of the others are turned to match it. Marks are
    numbered in the order of the mesh elements: B001, N001, P001.
    """
    return replace(
        assembly,
        beams=_share(assembly.beams, "B", lambda beam: 2, _turn_beam, within_mm),
        nodes=_share(assembly.nodes, "N", lambda node: len(node.beams), _turn_node, within_mm),
        panels=_share(assembly.panels, "P", lambda panel: len(panel.outline), _turn_panel, within_mm),
    )


def _share(
    parts: Sequence[P], letter: str, n_turns: Callable[[P], int], turn: Callable[[P, int], P], within_mm: float
) -> tuple[P, ...]:
    """Group equal parts. Only parts of one material with equally many corners and turns are compared."""
    comparable: dict[tuple[int, int, str], list[int]] = {}
    for place, part in enumerate(parts):
        key = (part.solid.topology.n_vertices, n_turns(part), part.material.name)
        comparable.setdefault(key, []).append(place)
    first_of = np.arange(len(parts))
    turns = np.zeros(len(parts), dtype=np.int64)
    for (_, count, _), group in comparable.items():
        places = np.array(group)[_alike(np.array([parts[place].solid.vertices for place in group]), within_mm)]
        if len(places):
            shapes = [[turn(parts[place], k).solid.vertices.ravel() for k in range(count)] for place in places]
            first, turns[places] = _equal_shapes(np.array(shapes), within_mm)
            first_of[places] = places[first]
    numbers = np.cumsum(first_of == np.arange(len(parts)))
    width = max(3, len(str(numbers[-1]))) if len(parts) else 3
    marks = [f"{letter}{numbers[first]:0{width}d}" for first in first_of.tolist()]
    return tuple(
        replace(turn(part, k), mark=mark, solid=parts[first].solid)
        for part, mark, first, k in zip(parts, marks, first_of.tolist(), turns.tolist(), strict=True)
    )


def _alike(corners: FloatArray, within_mm: float) -> BoolArray:
    """(P,) whether another of the solids with corners (P, n, 3) has them at the same distances from their mean.

    No turn changes these, so only such solids need to be compared in all turns.
    """
    distances = np.sort(np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2), axis=1)
    # corners that are off by the tolerance in each coordinate, and so is their mean
    near = cKDTree(distances).query_ball_point(distances, 2 * np.sqrt(3) * within_mm, p=np.inf, return_length=True)
    alike: BoolArray = near > 1
    return alike


def _equal_shapes(shapes: FloatArray, within_mm: float) -> tuple[IntArray, IntArray]:
    """For shapes (P, T, D), each seen in T turns: the first shape equal to each, and the turn in which it is.

    Of shapes that hang together by equal ones, those near the first are equal to it; the others are looked at again.
    """
    first, turns = np.arange(len(shapes)), np.zeros(len(shapes), dtype=np.int64)
    left = first.copy()
    while len(left):
        found, turns[left], near = _near_first(shapes[left], within_mm)
        first[left] = left[found]
        left = left[~near]
    return first, turns


def _near_first(shapes: FloatArray, within_mm: float) -> tuple[IntArray, IntArray, BoolArray]:
    """The first shape that hangs together with each, the turn in which it is near to that, and whether it is."""
    n_parts, n_turns, size = shapes.shape
    tree = cKDTree(shapes.reshape(-1, size))
    links = cKDTree(shapes[:, 0]).sparse_distance_matrix(tree, within_mm, p=np.inf, output_type="ndarray")
    base, other, turn = links["i"], links["j"] // n_turns, links["j"] % n_turns
    graph = coo_array((np.ones(len(base)), (base, other)), shape=(n_parts, n_parts))
    groups = connected_components(graph, directed=False)[1]
    first = np.unique(groups, return_index=True)[1][groups]
    turns, near = np.zeros(n_parts, dtype=np.int64), np.zeros(n_parts, dtype=bool)
    direct = np.flatnonzero(first[other] == base)
    direct = direct[np.argsort(-turn[direct], kind="stable")]  # the smallest turn, written last, wins
    turns[other[direct]] = turn[direct]
    near[other[direct]] = True
    return first, turns, near


def _turn_beam(beam: Beam, turns: int) -> Beam:
    """The beam seen from its other end, if turned once."""
    if turns == 0:
        return beam
    corners = beam.solid.vertices
    new_start = np.array([corners[2, 0], 0.0, 0.0])
    half_turn = Frame(new_start, np.diag([-1.0, -1.0, 1.0]))
    # half a turn about z exchanges the two ends and the two sides
    order = [7, 6, 5, 4, 3, 2, 1, 0]
    return replace(
        beam,
        solid=Solid(half_turn.to_local(corners)[order], beam.solid.topology),
        placement=beam.placement.place(half_turn),
        nodes=beam.nodes[::-1],
        cut_angles_deg=beam.cut_angles_deg[::-1],
    )


def _turn_node(node: Node, turns: int) -> Node:
    """The node with its x-axis towards another of its beams."""
    if turns == 0:
        return node
    angle = np.radians(node.azimuths_deg[turns])
    x = np.array([np.cos(angle), np.sin(angle), 0.0])
    frame = Frame(np.zeros(3), np.stack([x, np.cross([0.0, 0.0, 1.0], x), [0.0, 0.0, 1.0]]))
    n = node.solid.topology.n_vertices // 2
    corners = frame.to_local(node.solid.vertices)
    middles = (corners[:n, :2] + np.roll(corners[:n, :2], -1, axis=0)) / 2
    first = int(np.linalg.norm(middles - [node.setbacks_mm[turns], 0.0], axis=1).argmin())
    order = (first + np.arange(n)) % n
    azimuths = np.mod(np.roll(node.azimuths_deg, -turns) - node.azimuths_deg[turns], 360.0)
    return replace(
        node,
        solid=Solid(corners[np.concatenate([order, order + n])], node.solid.topology),
        placement=node.placement.place(frame),
        beams=_rolled(node.beams, turns),
        azimuths_deg=tuple(azimuths.tolist()),
        inclinations_deg=_rolled(node.inclinations_deg, turns),
        setbacks_mm=_rolled(node.setbacks_mm, turns),
    )


def _turn_panel(panel: Panel, turns: int) -> Panel:
    """The panel with its x-axis along another of its edges."""
    if turns == 0:
        return panel
    origin = np.array([*panel.outline[turns], 0.0])
    ahead = panel.outline[(turns + 1) % len(panel.outline)] - panel.outline[turns]
    x = np.array([*ahead, 0.0]) / np.linalg.norm(ahead)
    frame = Frame(origin, np.stack([x, np.cross([0.0, 0.0, 1.0], x), [0.0, 0.0, 1.0]]))
    outline = frame.to_local(np.pad(np.roll(panel.outline, -turns, axis=0), ((0, 0), (0, 1))))[:, :2]
    return replace(
        panel,
        solid=Solid(prism_vertices(outline, 0.0, panel.thickness_mm), panel.solid.topology),
        placement=panel.placement.place(frame),
        outline=outline,
        edge_lengths_mm=_rolled(panel.edge_lengths_mm, turns),
        corner_angles_deg=_rolled(panel.corner_angles_deg, turns),
        dihedrals_deg=_rolled(panel.dihedrals_deg, turns),
        beams=_rolled(panel.beams, turns),
        neighbours=_rolled(panel.neighbours, turns),
    )


T = TypeVar("T")


def _rolled(values: tuple[T, ...], turns: int) -> tuple[T, ...]:
    return values[turns:] + values[:turns]

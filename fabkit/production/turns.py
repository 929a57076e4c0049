"""Parts seen from elsewhere: a beam from its other end, a node from another beam, a panel from another edge.

Each kind has one function for the corners of many parts at once, and one for a part with all that is known about it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
from scipy.spatial import cKDTree

from fabkit.parts import Beam, Frame, Node, Panel, Solid, prism_vertices
from fabkit.production.equal_shapes import TurnedShapes
from geometry.arrays import FloatArray, IntArray

__all__ = [
    "turn_beam",
    "turn_node",
    "turn_panel",
    "turned_beams",
    "turned_nodes",
    "turned_panels",
]

OTHER_END = [7, 6, 5, 4, 3, 2, 1, 0]
"""Half a turn about z exchanges the two ends and the two sides of a beam: the corner that takes each one's place."""


def turned_beams(beams: Sequence[Beam]) -> TurnedShapes:
    """Beams alike in their counts: as they are, and from their other ends."""
    corners = np.array([beam.solid.vertices for beam in beams])
    start = np.pad(corners[:, 2, :1], ((0, 0), (0, 2)))[:, None]
    both = np.stack([corners, (corners - start)[:, OTHER_END] * [-1.0, -1.0, 1.0]], axis=1)
    return TurnedShapes(len(beams), 2, 8, lambda parts, turns, chosen: both[parts[:, None], turns[:, None], chosen])


def turned_nodes(nodes: Sequence[Node]) -> TurnedShapes:
    """Nodes alike in their counts, with each of their beams in front."""
    corners = np.array([node.solid.vertices for node in nodes])
    azimuths = np.radians([node.azimuths_deg for node in nodes])
    n, n_turns = corners.shape[1] // 2, azimuths.shape[1]
    forwards = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=2)
    facets = forwards * np.array([node.setbacks_mm for node in nodes])[..., None]
    first = _nearest((corners[:, :n, :2] + np.roll(corners[:, :n, :2], -1, axis=1)) / 2, facets)
    first[:, 0] = 0

    def at(parts: IntArray, turns: IntArray, chosen: IntArray) -> FloatArray:
        place = (first[parts, turns][:, None] + chosen) % n + chosen // n * n
        return _turned_back(corners[parts[:, None], place], forwards[parts, turns])

    return TurnedShapes(len(nodes), n_turns, 2 * n, at)


def turned_panels(panels: Sequence[Panel]) -> TurnedShapes:
    """Panels alike in their counts, on each of their edges; the corners are those of the upper side."""
    outlines = np.array([panel.outline for panel in panels])
    heights = np.array([panel.thickness_mm for panel in panels])
    k = outlines.shape[1]
    sides = np.roll(outlines, -1, axis=1) - outlines
    along = sides / np.linalg.norm(sides, axis=2, keepdims=True)
    along[:, 0], starts = [1.0, 0.0], outlines.copy()
    starts[:, 0] = 0.0

    def at(parts: IntArray, turns: IntArray, chosen: IntArray) -> FloatArray:
        place = (turns[:, None] + chosen) % k
        flat = outlines[parts[:, None], place] - starts[parts, turns][:, None]
        upper = np.broadcast_to(heights[parts, None, None], (*flat.shape[:2], 1))
        return _turned_back(np.concatenate([flat, upper], axis=2), along[parts, turns])

    return TurnedShapes(len(panels), k, k, at)


def _turned_back(points: FloatArray, x: FloatArray) -> FloatArray:
    """Points (q, c, 3) seen with the directions x (q, 2) in front."""
    ahead, aside = x[:, :1], x[:, 1:]
    turned = [points[..., 0] * ahead + points[..., 1] * aside, points[..., 1] * ahead - points[..., 0] * aside]
    return np.stack([*turned, points[..., 2]], axis=2)


def _nearest(points: FloatArray, wanted: FloatArray) -> IntArray:
    """(m, t) which of its own points (m, n, 2) is nearest to each of the points wanted (m, t, 2) of m things."""
    apart = 4 * np.abs(wanted).max(initial=0.0) + 4 * np.abs(points).max(initial=0.0)
    layer = apart * np.arange(len(points), dtype=np.float64)[:, None, None]

    def in_layers(flat: FloatArray) -> FloatArray:
        return np.concatenate([flat, np.broadcast_to(layer, (*flat.shape[:2], 1))], axis=2).reshape(-1, 3)

    found = cKDTree(in_layers(points)).query(in_layers(wanted))[1]
    nearest: IntArray = found.reshape(wanted.shape[:2]) % points.shape[1]
    return nearest


def turn_beam(beam: Beam, turns: int) -> Beam:
    """The beam seen from its other end, if turned once."""
    if turns == 0:
        return beam
    corners = beam.solid.vertices
    new_start = np.array([corners[2, 0], 0.0, 0.0])
    half_turn = Frame(new_start, np.diag([-1.0, -1.0, 1.0]))
    return replace(
        beam,
        solid=Solid(half_turn.to_local(corners)[OTHER_END], beam.solid.topology),
        placement=beam.placement.place(half_turn),
        nodes=beam.nodes[::-1],
        cut_angles_deg=beam.cut_angles_deg[::-1],
    )


def turn_node(node: Node, turns: int) -> Node:
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


def turn_panel(panel: Panel, turns: int) -> Panel:
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

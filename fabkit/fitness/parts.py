"""Criteria of parts in their real sizes: one function for each, which returns None where nothing is unusual."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fabkit.fitness.finding import Finding, Level, named, worst_first
from fabkit.fitness.rules import FitnessRules
from fabkit.fitness.shape import NOTED_PERCENTILE
from fabkit.kinds import BeamDetails, NodeDetails, PanelDetails, smallest_gaps
from fabkit.parts import Parts
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["block_heights", "going_in", "mitres", "mitres_of", "props", "sheets", "slots", "uncovered", "underside"]


def mitres(
    cuts_deg: FloatArray, names: Sequence[str], edges: Sequence[int], rules: FitnessRules, *, layer: str = ""
) -> Finding | None:
    """End cuts of beams. cuts_deg (n, 2): cut angles of the beams with these names on these edges; layer: of beams."""
    if not len(cuts_deg):
        return None
    angles = np.abs(cuts_deg).max(axis=1)
    order = worst_first(angles, angles >= rules.mitres_noted_deg)
    if not len(order):
        return None
    steep = [f"{names[k]} ({angles[k]:.1f})" for k in order.tolist() if angles[k] >= rules.mitres_listed_deg]
    by_name = f"; {rules.mitres_listed_deg:g} degrees or more: {named(list(dict.fromkeys(steep)))}" if steep else ""
    return Finding(
        "mitres",
        "note",
        float(angles[order[0]]),
        rules.mitres_noted_deg,
        "degrees",
        f"{len(order)} of {len(angles)} {f'{layer} beams'.strip()} have an end cut {rules.mitres_noted_deg:g} degrees "
        f"or more off square, at most {angles[order[0]]:.1f} degrees{by_name}",
        "make sure that the saw reaches these angles, or open the angles between edges and node axes there",
        "edge",
        tuple(int(edges[k]) for k in order.tolist()),
        layer,
    )


def mitres_of(beams: Parts[BeamDetails], rules: FitnessRules) -> Finding | None:
    """The same, of all beams of one layer."""
    layer, cuts = beams.kind.layer, beams.details.cut_angles_deg
    return mitres(cuts, beams.marks, beams.elements.tolist(), rules, layer=layer)


def going_in(beams: Parts[BeamDetails], is_closing: BoolArray, gap_mm: float, rules: FitnessRules) -> Finding | None:
    """Beams that come last between two nodes that stand, and go straight in from outside only with a larger gap than
    gap_mm and the one that is noted. is_closing (n,): which come last."""
    gaps, bound = beams.details.going_in_gaps_mm[:, 0], max(gap_mm, rules.going_in_noted_mm)
    order = worst_first(gaps, is_closing & (gaps > bound))
    if not len(order):
        return None
    of_beams = beams.marks
    names = list(dict.fromkeys(f"{of_beams[k]} ({gaps[k]:.1f})" for k in order.tolist()))
    return Finding(
        "going-in",
        "note",
        float(gaps[order[0]]),
        bound,
        "mm",
        f"{len(order)} of {int(is_closing.sum())} {beams.kind.group} that come last between two nodes that stand go "
        f"straight in from inside only, or from outside with a gap of more than {bound:g} mm at each end: "
        f"{named(names)}",
        f"put these beams in from inside, or set {_table('connection', beams.kind.layer)} gap_mm = "
        f"{np.ceil(10 * gaps[order[0]]) / 10:.1f}",
        "edge",
        tuple(beams.elements[order].tolist()),
        beams.kind.layer,
    )


def props(nodes: Parts[NodeDetails], vertices: IntArray) -> Finding | None:
    """Nodes on these vertices, which go up before anything that they could stand on or join."""
    if not len(vertices):
        return None
    marks = dict(zip(nodes.elements.tolist(), nodes.marks, strict=True))
    places = [f"{marks[vertex]} (vertex {vertex}, counted from 0)" for vertex in vertices.tolist()]
    return Finding(
        "props",
        "note",
        float(len(vertices)),
        1.0,
        "nodes",
        f"{len(vertices)} of {len(nodes)} nodes have to be propped, as they go up before anything on which they could "
        f"stand or that they could join: {named(places, at_most=3)}",
        "put zones with supports up first, or choose more nodes under [supports]",
        "vertex",
        tuple(vertices.tolist()),
    )


def block_heights(nodes: Parts[NodeDetails], beam_height_mm: float, rules: FitnessRules) -> Finding | None:
    """Heights of the node blocks, which enclose the ends of their beams, over the height of the beams."""
    heights = nodes.details.height_mm
    sizes = heights / beam_height_mm
    order = worst_first(sizes, sizes >= rules.block_heights_noted)
    if not len(order):
        return None
    worst = nodes[int(order[0])]
    return Finding(
        "block-heights",
        "note",
        float(sizes[order[0]]),
        rules.block_heights_noted,
        "beam heights",
        f"{len(order)} of {len(nodes)} {nodes.kind.named('node blocks')} are at least {rules.block_heights_noted:g} "
        f"times as high as their beams of {beam_height_mm:g} mm: {worst.mark} (vertex {worst.element}, counted from 0) "
        f"is {heights[order[0]]:.0f} mm high",
        f"take narrower beams ({'[second_layer] section' if nodes.kind.layer else '--section, --beam'}) or a smaller "
        f"slot between them ({_table('connection', nodes.kind.layer)} slot_mm), so that they end nearer to the axes, "
        "or make narrow angles between edges wider",
        "vertex",
        tuple(nodes.elements[order].tolist()),
        nodes.kind.layer,
    )


def slots(nodes: Parts[NodeDetails], rules: FitnessRules) -> Finding | None:
    """Angles between beams that are welded to the same node: below 60 degrees a torch reaches the seams badly."""
    angles = smallest_gaps(nodes.details.azimuths_deg)
    order = worst_first(-angles, angles < rules.slots_noted_deg)
    if not len(order):
        return None
    worst = nodes[int(order[0])]
    return Finding(
        "slots",
        "note",
        float(angles[order[0]]),
        rules.slots_noted_deg,
        "degrees",
        f"at {len(order)} of {len(nodes)} {nodes.kind.group} two beams that are welded to it are less than "
        f"{rules.slots_noted_deg:g} degrees apart, the smallest angle is {angles[order[0]]:.1f} degrees at "
        f"{worst.mark} (vertex {worst.element}, counted from 0)",
        "plan these seams with the welder, or make the angles at these vertices wider",
        "vertex",
        tuple(nodes.elements[order].tolist()),
        nodes.kind.layer,
    )


def uncovered(nodes: Parts[NodeDetails], rules: FitnessRules) -> Finding | None:
    """How much of the ends of beams stands above trimmed node blocks."""
    shares = nodes.details.uncovered_percent.reduced(np.maximum, empty=0.0)
    order = worst_first(shares, shares >= rules.uncovered_noted_percent)
    if not len(order):
        return None
    worst = nodes[int(order[0])]
    return Finding(
        "uncovered",
        "note",
        float(shares[order[0]]),
        rules.uncovered_noted_percent,
        "percent",
        f"{len(order)} of {len(nodes)} node blocks are trimmed so low that {rules.uncovered_noted_percent:g} % or more "
        f"of the end of a beam stands above its facet, at most {shares[order[0]]:.1f} % at {worst.mark} (vertex "
        f"{worst.element}, counted from 0)",
        "check these seams, let the blocks enclose their beams ([nodes] top), or give the panels a larger seat",
        "vertex",
        tuple(nodes.elements[order].tolist()),
    )


def underside(
    heights_mm: FloatArray, marks: Mapping[int, str], beam_height_mm: float, rules: FitnessRules
) -> Finding | None:
    """Whether a single node raises all panels. heights_mm (N,): height of each node block above the faces; marks: of
    the nodes that are made, by vertex."""
    vertices = np.array(sorted(marks), dtype=np.int64)
    if not len(vertices):
        return None
    needed = heights_mm[vertices]
    median, percentile = np.percentile(needed, [50, NOTED_PERCENTILE]).tolist()
    worst = int(vertices[needed.argmax()])
    excess = (float(needed.max()) - percentile) / beam_height_mm
    if excess < rules.underside_noted:
        return None
    return Finding(
        "underside",
        "note",
        excess,
        rules.underside_noted,
        "beam heights",
        f"node block {marks[worst]} (vertex {worst}, counted from 0) stands {needed.max():.1f} mm above a face and "
        f"raises all panels; {NOTED_PERCENTILE} % of the nodes need at most {percentile:.1f} mm, the median node "
        f"{median:.1f} mm",
        "move that vertex towards its neighbours' level or make the angles at it wider, take narrower "
        "beams (--section, --beam), or let the blocks follow the tops of their beams (--node-top trimmed)",
        "vertex",
        (worst,),
    )


def _table(name: str, layer: str) -> str:
    """The table of the project file for beams and nodes of a layer."""
    return f"[second_layer.{name}]" if layer else f"[{name}]"


def sheets(reasons: Mapping[int, str], panels: Parts[PanelDetails], level: Level) -> Finding | None:
    """Panels that do not fit on a stock sheet. reasons: a sentence for each of them, by its position."""
    if not reasons:
        return None
    first, *others = reasons
    of_marks = named(list(dict.fromkeys(panels.marks[k] for k in others)))
    does = "does" if len(others) == 1 else "do"
    also = (
        f"; nor {does} {len(others)} more, with the mark{'s' if len(others) > 1 else ''} {of_marks}" if others else ""
    )
    return Finding(
        "sheets",
        level,
        len(reasons),
        0.0,
        "panels",
        f"{reasons[first]}{also}",
        "take larger sheets (--sheet) or a mesh with smaller faces, leave these panels out with --skip-unbuildable, or "
        "turn nesting off (--nest off)",
        "face",
        tuple(dict.fromkeys(panels.elements[list(reasons)].tolist())),
    )

"""What is judged of the parts, which have sizes: a function a criterion, None where all is well."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from fabkit.fitness.finding import Finding, Level, named
from fabkit.fitness.rules import FitnessRules
from fabkit.fitness.shape import MOST
from fabkit.kinds import BeamDetails, NodeDetails
from fabkit.parts import Parts
from geometry.arrays import FloatArray

__all__ = ["blocks", "lift", "mitres", "sheets"]


def mitres(cuts_deg: FloatArray, names: Sequence[str], edges: Sequence[int], rules: FitnessRules) -> Finding | None:
    """How slanted the ends of beams are cut. cuts_deg (n, 2): of the beams with these names on these edges."""
    if not len(cuts_deg):
        return None
    angles = np.abs(cuts_deg).max(axis=1)
    slanted = np.flatnonzero(angles >= rules.mitres_told_deg)
    if not len(slanted):
        return None
    order = slanted[np.argsort(-angles[slanted], kind="stable")]
    steep = [f"{names[k]} ({angles[k]:.1f})" for k in order.tolist() if angles[k] >= rules.mitres_named_deg]
    by_name = f"; from {rules.mitres_named_deg:g} on: {named(list(dict.fromkeys(steep)))}" if steep else ""
    return Finding(
        "mitres",
        "told",
        float(angles[order[0]]),
        rules.mitres_told_deg,
        "degrees",
        f"{len(slanted)} of {len(angles)} beams have an end cut by {rules.mitres_told_deg:g} degrees or more off "
        f"square, at most {angles[order[0]]:.1f}{by_name}",
        "see that the saw turns so far, or open the angles between edges and node axes there",
        "edge",
        tuple(int(edges[k]) for k in order.tolist()),
    )


def mitres_of(beams: Parts[BeamDetails], rules: FitnessRules) -> Finding | None:
    return mitres(beams.details.cut_angles_deg, beams.marks, beams.elements.tolist(), rules)


def blocks(nodes: Parts[NodeDetails], beam_height_mm: float, rules: FitnessRules) -> Finding | None:
    """How much higher than the beams the blocks that enclose their ends are."""
    heights = nodes.details.height_mm
    sizes = heights / beam_height_mm
    high = np.flatnonzero(sizes >= rules.blocks_told)
    if not len(high):
        return None
    order = high[np.argsort(-sizes[high], kind="stable")]
    worst = nodes[int(order[0])]
    return Finding(
        "blocks",
        "told",
        float(sizes[order[0]]),
        rules.blocks_told,
        "beam heights",
        f"{len(high)} of {len(nodes)} node blocks are at least {rules.blocks_told:g} times as high as their beams of "
        f"{beam_height_mm:g} mm: {worst.mark} (vertex {worst.element}, counted from 0) has {heights[order[0]]:.0f} mm",
        "take narrower beams (--beam) or less clearance (--clearance), so that beams end nearer to the axes, or open "
        "narrow angles between edges",
        "vertex",
        tuple(nodes.elements[order].tolist()),
    )


def lift(
    heights_mm: FloatArray, marks: Mapping[int, str], beam_height_mm: float, rules: FitnessRules
) -> Finding | None:
    """Whether one node lifts all panels. heights_mm (N,): what each node asks for; marks: of the nodes that are made,
    by vertex."""
    vertices = np.array(sorted(marks), dtype=np.int64)
    if not len(vertices):
        return None
    asked = heights_mm[vertices]
    median, most = np.percentile(asked, [50, MOST]).tolist()
    worst = int(vertices[asked.argmax()])
    excess = (float(asked.max()) - most) / beam_height_mm
    if excess < rules.lift_told:
        return None
    return Finding(
        "lift",
        "told",
        excess,
        rules.lift_told,
        "beam heights",
        f"node block {marks[worst]} (vertex {worst}, counted from 0) stands {asked.max():.1f} mm above a face and "
        f"lifts all panels; {MOST} % of the nodes ask for {most:.1f} mm at most, the median for {median:.1f}",
        "move that vertex towards its neighbours' level or open the angles at it, or take narrower beams (--beam) or "
        "less clearance (--clearance)",
        "vertex",
        (worst,),
    )


def sheets(reasons: Mapping[int, str], marks: Mapping[int, str], level: Level) -> Finding | None:
    """Panels that fit on no stock sheet: a sentence for each, and its mark, by its face."""
    if not reasons:
        return None
    first, *others = reasons
    of_marks = named(list(dict.fromkeys(marks[face] for face in others)))
    also = f"; so {'is' if len(others) == 1 else 'are'} {len(others)} more, with the mark {of_marks}" if others else ""
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
        tuple(reasons),
    )

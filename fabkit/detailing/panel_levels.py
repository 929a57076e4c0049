"""The levels of the panels above the mesh faces, and panels that cannot be carried or cut there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fabkit.detailing.bar_sections import BarSections
from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes, node_shapes
from fabkit.detailing.panel_underside import heights_of_beams, heights_of_blocks, trimmed
from fabkit.detailing.panels import PanelShapes, bearings, panel_shapes
from fabkit.rules import DetailingRules
from geometry.arrays import BoolArray, FloatArray
from geometry.gauss import SupportStructure

__all__ = ["PanelLevels", "panel_levels", "underside_reason", "unfit_panels"]

BEARING_ROUNDING_MM = 1e-6
"""Difference in mm up to which a panel bears on as much of a beam as it must: above rounding where joint and section
make it exact, far below what anybody can lay."""


@dataclass(frozen=True, eq=False)
class PanelLevels:
    """Blocks, and the panels above them.

    of_blocks, of_beams (C,): heights in mm of what lies under each corner, and edge, of each face with a panel, 0
    elsewhere. needed (N,): largest height of the block at each vertex above these faces. shapes: the panels. depth:
    distance in mm, along S, from the mesh on which the beams stand to the outer faces of the panels, where these are to
    lie on a parallel mesh; 0 where they are not.
    """

    nodes: NodeShapes
    of_blocks: FloatArray
    of_beams: FloatArray
    needed: FloatArray
    shapes: PanelShapes
    depth: float


def panel_levels(
    structure: SupportStructure, ends: Ends, beams: BoolArray, panels: BoolArray, rules: DetailingRules
) -> PanelLevels:
    """The lowest panels that clear beams and blocks by the seat. beams (E,), panels (F,): which ones are made.

    All panels are at one level. Where their outer faces are to lie on a parallel mesh, the level of each follows from
    the distance of that mesh from its face.
    """
    c = structure.mesh.combinatorics
    has_panel = panels[c.corner_face]
    nodes = node_shapes(structure, ends, rules)
    of_beams = np.where(has_panel, heights_of_beams(structure, beams, ends.bars), 0.0)
    if _are_trimmed(rules):
        lowest = _undersides(structure, _by_face(structure, of_beams), panels, rules)[0]
        nodes = trimmed(structure, ends, beams, nodes, panels, lowest - rules.panels.seat_mm)
    of_blocks = np.where(has_panel, heights_of_blocks(structure, ends, beams, nodes), 0.0)
    underside, depth = _undersides(structure, _by_face(structure, np.maximum(of_beams, of_blocks)), panels, rules)
    needed = np.zeros(structure.mesh.n_vertices)
    np.maximum.at(needed, c.corners, of_blocks)
    return PanelLevels(nodes, of_blocks, of_beams, needed, panel_shapes(structure, rules.panels, underside), depth)


def _are_trimmed(rules: DetailingRules) -> bool:
    """Whether blocks are trimmed; the tubes of hubs end square, above the webs of all their beams."""
    return rules.nodes.top == "trimmed" and rules.connection.kind != "hub"


def _by_face(structure: SupportStructure, of_corners: FloatArray) -> FloatArray:
    """(F,) largest value at the corners of each face, at least 0."""
    starts = structure.mesh.combinatorics.face_starts[:-1]
    return np.asarray(np.maximum(np.maximum.reduceat(of_corners, starts), 0.0))


def _undersides(
    structure: SupportStructure, needed: FloatArray, panels: BoolArray, rules: DetailingRules
) -> tuple[FloatArray, float]:
    """(F,) levels of the panels' lower sides above what is needed (F,), and the depth, as in `PanelLevels`."""
    own = rules.panels
    least = needed + own.seat_mm if own.underside_mm is None else np.full(len(needed), own.underside_mm)
    if rules.beams.reference != "glass":
        return np.full(len(least), least[panels].max(initial=least.min())), 0.0
    distances = structure.pair.face_distances
    depth = float(((least + own.thickness_mm) / distances)[panels].max(initial=0.0))
    return depth * distances - own.thickness_mm, depth


def unfit_panels(
    structure: SupportStructure, shapes: PanelShapes, beams: BoolArray, panels: BoolArray, rules: DetailingRules
) -> dict[int, str]:
    """The faces whose panels vanish between their joints, or that lie on too little of a beam, and a reason for each.
    beams (E,), panels (F,): which ones are made."""
    c, own = structure.mesh.combinatorics, rules.panels
    shortest = np.minimum.reduceat(shapes.edge_lengths, c.face_starts[:-1])
    vanishing = np.flatnonzero(panels & ~(shortest >= own.least_edge_mm))
    if len(vanishing):
        return {
            face: f"the panel on face {face} vanishes when cut back by half the joint of {own.joint_mm:g} mm: at "
            f"{shapes.underside[face]:.1f} mm above the mesh its shortest edge is {shortest[face]:.1f} mm, and at "
            f"least {own.least_edge_mm:g} mm are needed (faces counted from 0)"
            for face in vanishing.tolist()
        }
    bearing = bearings(structure, shapes, BarSections.of(structure.mesh, rules.beams).widths)
    lacking = own.least_bearing_mm - bearing
    bare = np.flatnonzero(panels[c.corner_face] & beams[c.corner_edge] & ~(lacking <= BEARING_ROUNDING_MM))
    if not len(bare):
        return {}
    cure = _for_bearing(structure, shapes, float(lacking[bare].max()), rules)
    return {
        int(c.corner_face[corner]): f"the panel on face {c.corner_face[corner]} lies {bearing[corner]:.1f} mm deep on "
        f"the beam on edge {c.corner_edge[corner]}, and at least {own.least_bearing_mm:g} mm are needed (counted from "
        f"0): take {cure}"
        for corner in bare[np.argsort(-bearing[bare], kind="stable")].tolist()
    }


def _for_bearing(structure: SupportStructure, shapes: PanelShapes, lacking: float, rules: DetailingRules) -> str:
    """How wide sections, or how narrow joints, are with which no panel lacks this many mm on its beams any longer, in
    words; in whole mm. A wider section lifts the panels by half as much times the sine of their tilt, and this lift
    moves their rims by the sine again."""
    wider, none = replace(shapes, insets=shapes.insets + 1.0), np.zeros(structure.mesh.n_edges)
    cosine = (bearings(structure, shapes, none) - bearings(structure, wider, none)).min()
    width = np.ceil(rules.beams.profile.width_mm + 2 * lacking / cosine**2 - BEARING_ROUNDING_MM)
    joint = np.floor(rules.panels.joint_mm - 2 * lacking / cosine + BEARING_ROUNDING_MM)
    narrower = f", or a joint of at most {joint:g} mm" if joint >= 0 else ""
    return f"a section at least {width:g} mm wide in place of {rules.beams.profile.name}{narrower}"


def underside_reason(structure: SupportStructure, levels: PanelLevels, rules: DetailingRules) -> str:
    """What determines the level of the panels, in words."""
    if rules.panels.underside_mm is not None:
        return f"given as {rules.panels.underside_mm:g} mm"
    c = structure.mesh.combinatorics
    of_blocks, of_beams = float(levels.of_blocks.max()), float(levels.of_beams.max())
    if max(of_blocks, of_beams) <= 0.0:
        return "no node block and no beam stands above the mesh under the panels"
    if _are_trimmed(rules) or round(of_beams, 1) > round(of_blocks, 1):
        corner = int(levels.of_beams.argmax())
        others = "node blocks are trimmed to that height" if _are_trimmed(rules) else "no node stands higher"
        return (
            f"the beam on edge {c.corner_edge[corner]} stands {of_beams:.1f} mm above face {c.corner_face[corner]} "
            f"(counted from 0); {others}"
        )
    corner = int(levels.of_blocks.argmax())
    return (
        f"the node block at vertex {c.corners[corner]} stands {of_blocks:.1f} mm above face {c.corner_face[corner]} "
        f"(counted from 0); the median node needs {np.median(levels.needed[c.is_used]):.1f} mm"
    )

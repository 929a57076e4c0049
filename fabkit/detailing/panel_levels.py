"""The levels of the layers of panels above the mesh faces, and panels that cannot be carried or cut there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes, node_shapes
from fabkit.detailing.panel_layers.panel_shapes import PanelLayer, bearings, seats
from fabkit.detailing.panel_underside import heights_of_beams, heights_of_blocks, trimmed
from fabkit.detailing.shapes.bar_sections import BarSections
from fabkit.errors import DetailingError
from fabkit.parts import Section
from fabkit.rules import DetailingRules, LayerRules
from geometry.arrays import BoolArray, FloatArray
from geometry.gauss import Pair, SupportStructure
from geometry.mesh import Mesh

__all__ = ["PanelLevels", "on_mesh", "panel_levels", "seats_of", "underside_reason", "unfit_panels"]

LAYERS_APART_MM = 1e-6
"""Depth in mm by which two layers of panels may overlap, or a layer lie below the mesh and still count as lying on the
beams: that of parts which touch."""

BEARING_ROUNDING_MM = 1e-6
"""Difference in mm up to which a panel bears on as much of a beam as it must: above rounding where joint and section
make it exact, far below what anybody can lay."""


@dataclass(frozen=True, eq=False)
class PanelLevels:
    """Blocks, and the layers of panels above and below them.

    of_blocks, of_beams (C,): heights in mm of what lies under each corner, and edge, of each face with a panel, 0
    elsewhere. needed (N,): largest height of the block at each vertex above these faces. layers: of panels; resting:
    number of the one that lies on the beams, None where all are below. depth: distance in mm, along S, from the mesh on
    which the beams stand to the outer faces of the panels, where these are to lie on a parallel mesh; 0 where they are
    not.
    """

    nodes: NodeShapes
    of_blocks: FloatArray
    of_beams: FloatArray
    needed: FloatArray
    layers: tuple[PanelLayer, ...]
    resting: int | None
    depth: float

    @property
    def underside(self) -> FloatArray:
        """(F,) level of the lower sides of the resting layer, or of the outermost one."""
        return self.layers[self.resting or 0].underside


def panel_levels(
    structure: SupportStructure,
    ends: Ends,
    beams: BoolArray,
    panels: BoolArray,
    rules: DetailingRules,
    meshes: Mapping[int, Mesh],
) -> PanelLevels:
    """The layers at their heights; one at the lift is as low as it clears beams and blocks by the seat. beams (E,),
    panels (F,): which ones are made. meshes: the parallel meshes of layers that have their own, by their numbers.

    All panels at the lift are at one level, or each at its own. Where their outer faces are to lie on a parallel mesh,
    the level of each follows from the distance of that mesh from its face. Raises DetailingError where layers cross.
    """
    c = structure.mesh.combinatorics
    has_panel = panels[c.corner_face]
    nodes = node_shapes(structure, ends, rules)
    of_beams = np.where(has_panel, heights_of_beams(structure, beams, ends.bars), 0.0)

    def layers_above(of_corners: FloatArray) -> tuple[list[PanelLayer], int | None, float]:
        return _layers(structure, _by_face(structure, of_corners), panels, rules, meshes)

    if _are_trimmed(rules):
        layers, resting, _ = layers_above(of_beams)
        if resting is not None:
            lowest = layers[resting].underside - layers[resting].rules.seat_mm
            nodes = trimmed(structure, ends, beams, nodes, panels, lowest)
    of_blocks = np.where(has_panel, heights_of_blocks(structure, ends, beams, nodes), 0.0)
    layers, resting, depth = layers_above(np.maximum(of_beams, of_blocks))
    _check_order(layers, panels)
    needed = np.zeros(structure.mesh.n_vertices)
    np.maximum.at(needed, c.corners, of_blocks)
    return PanelLevels(nodes, of_blocks, of_beams, needed, tuple(layers), resting, depth)


def _are_trimmed(rules: DetailingRules) -> bool:
    """Whether blocks are trimmed; the tubes of hubs end square, above the webs of all their beams."""
    return rules.nodes.top == "trimmed" and rules.connection.kind != "hub"


def _by_face(structure: SupportStructure, of_corners: FloatArray) -> FloatArray:
    """(F,) largest value at the corners of each face, at least 0."""
    starts = structure.mesh.combinatorics.face_starts[:-1]
    return np.asarray(np.maximum(np.maximum.reduceat(of_corners, starts), 0.0))


def _layers(
    structure: SupportStructure,
    needed: FloatArray,
    panels: BoolArray,
    rules: DetailingRules,
    meshes: Mapping[int, Mesh],
) -> tuple[list[PanelLayer], int | None, float]:
    """The layers above what is needed (F,), the number of the resting one, and the depth, as in `PanelLevels`."""
    distances, depth, at_lift = structure.pair.face_distances, 0.0, None
    for own in (each for each in rules.layers if each.is_at_lift):
        least = needed + own.seat_mm
        if rules.beams.reference == "glass":
            depth = float(((least + own.total_mm) / distances)[panels].max(initial=0.0))
            at_lift = depth * distances - own.total_mm
        else:
            at_lift = least if own.lift == "each" else np.full(len(least), least[panels].max(initial=least.min()))
    nothing, layers = np.zeros(len(needed)), []
    for number, own in enumerate(rules.layers):
        if own.is_at_lift and at_lift is not None:
            layers.append(PanelLayer(own, structure, nothing, at_lift))
        elif own.distance_mm is not None:
            layers.append(PanelLayer(own, structure, nothing, (depth + own.distance_mm) * distances))
        elif own.z_mm is not None:
            layers.append(PanelLayer(own, structure, nothing, depth * distances + own.z_mm))
        else:
            layers.append(_on_own_mesh(own, structure, meshes[number]))
    return layers, _resting(layers, panels), depth


def _on_own_mesh(rules: LayerRules, structure: SupportStructure, mesh: Mesh) -> PanelLayer:
    """The layer whose lower sides lie in the faces of a mesh, parallel to that on which the beams stand."""
    own = on_mesh(structure, mesh)
    first = mesh.combinatorics.corners[mesh.combinatorics.face_starts[:-1]]
    base = np.einsum("fk,fk->f", mesh.vertices[first] - structure.mesh.vertices[first], structure.mesh.face_normals)
    return PanelLayer(rules, own, base, np.zeros(len(base)))


def on_mesh(structure: SupportStructure, mesh: Mesh) -> SupportStructure:
    """The structure of a mesh parallel to that of another one, with its Gauss image."""
    return SupportStructure(Pair(mesh, structure.gauss_image), structure.distance)


def _resting(layers: list[PanelLayer], panels: BoolArray) -> int | None:
    """The innermost layer that is nowhere below the mesh; that at the lift is."""
    for number in reversed(range(len(layers))):
        low = layers[number].range_mm[0]
        if layers[number].rules.is_at_lift or not (low[panels] < -LAYERS_APART_MM).any():
            return number
    return None


def _check_order(layers: list[PanelLayer], panels: BoolArray) -> None:
    """Raise DetailingError unless the layers lie above each other, the outermost one first."""
    faces = np.flatnonzero(panels)
    for number, (outer, inner) in enumerate(pairwise(layers)):
        low, high = outer.range_mm[0][faces], inner.range_mm[1][faces]
        crossing = np.flatnonzero(low < high - LAYERS_APART_MM)
        if len(crossing):
            worst = int((high - low).argmax())
            raise DetailingError(
                f"layers {number} and {number + 1} cross on {len(crossing)} of {len(faces)} faces: on face "
                f"{faces[worst]} the lower side of layer {number} is at {low[worst]:.1f} mm, and the upper side of "
                f"layer {number + 1} at {high[worst]:.1f} mm (counted from 0, heights above the mesh): name the layers "
                f"from outside to inside, and move them apart by at least {high[worst] - low[worst]:.1f} mm"
            )


def seats_of(
    structure: SupportStructure, levels: PanelLevels, beams: BoolArray, rules: DetailingRules
) -> tuple[FloatArray, FloatArray]:
    """(C,), (C,) least and largest seat in mm at each edge of the resting layer, NaN without one."""
    c = structure.mesh.combinatorics
    if levels.resting is None:
        return np.full(len(c.corners), np.nan), np.full(len(c.corners), np.nan)
    has_block = np.isfinite(levels.nodes.top)[c.corners]
    of_blocks = np.where(has_block, levels.of_blocks, -np.inf)
    layer = levels.layers[levels.resting]
    return seats(layer, BarSections.of(structure.mesh, rules.beams), beams, of_blocks)


def unfit_panels(levels: PanelLevels, beams: BoolArray, panels: BoolArray, rules: DetailingRules) -> dict[int, str]:
    """The faces whose panels vanish between their joints, cannot be mitred, or lie on too little of a beam, with a
    reason for each. beams (E,), panels (F,): which ones are made."""
    for number, layer in enumerate(levels.layers):
        which = f" of layer {number}" if len(levels.layers) > 1 else ""
        if unfit := _vanishing(layer, which, panels) or _not_mitred(layer, which, panels):
            return unfit
    return {} if levels.resting is None else _bare(levels.layers[levels.resting], beams, panels, rules)


def _vanishing(layer: PanelLayer, which: str, panels: BoolArray) -> dict[int, str]:
    c, own = layer.structure.mesh.combinatorics, layer.rules
    lengths = np.min([pane.edge_lengths for pane in layer.panes], axis=0)
    shortest = np.minimum.reduceat(lengths, c.face_starts[:-1])
    return {
        face: f"the panel on face {face}{which} vanishes when cut back by half the joint of {own.joint_mm:g} mm: at "
        f"{layer.range_mm[0][face]:.1f} mm above the mesh its shortest edge is {shortest[face]:.1f} mm, and at "
        f"least {own.least_edge_mm:g} mm are needed (faces counted from 0)"
        for face in np.flatnonzero(panels & ~(shortest >= own.least_edge_mm)).tolist()
    }


def _not_mitred(layer: PanelLayer, which: str, panels: BoolArray) -> dict[int, str]:
    if layer.rules.edges == "square":
        return {}
    concave = np.unique(layer.structure.mesh.combinatorics.corner_face[layer.concave])
    return {
        face: f"the panel on face {face}{which} is not convex, and its edges cannot be mitred (faces counted from 0): "
        "give the layer edges = 'square'"
        for face in concave[panels[concave]].tolist()
    }


def _bare(layer: PanelLayer, beams: BoolArray, panels: BoolArray, rules: DetailingRules) -> dict[int, str]:
    c, own = layer.structure.mesh.combinatorics, layer.rules
    bars = BarSections.of(layer.structure.mesh, rules.beams)
    bearing = bearings(layer, bars.widths)
    lacking = own.least_bearing_mm - bearing
    bare = np.flatnonzero(panels[c.corner_face] & beams[c.corner_edge] & ~(lacking <= BEARING_ROUNDING_MM))
    if not len(bare):
        return {}
    most = np.full(len(bars.sections), -np.inf)
    np.maximum.at(most, bars.of_edge[c.corner_edge[bare]], lacking[bare])
    cure = _for_bearing(layer, most, bars.sections)
    return {
        int(c.corner_face[corner]): f"the panel on face {c.corner_face[corner]} lies {bearing[corner]:.1f} mm deep on "
        f"the beam on edge {c.corner_edge[corner]}, and at least {own.least_bearing_mm:g} mm are needed (counted from "
        f"0): take {cure}"
        for corner in bare[np.argsort(-bearing[bare], kind="stable")].tolist()
    }


def _for_bearing(layer: PanelLayer, lacking: FloatArray, sections: tuple[Section, ...]) -> str:
    """How wide sections, or how narrow joints, are with which no panel lacks this many mm on its beams of each section
    (k,) any longer, in words; in whole mm. A wider section lifts the panels by half as much times the sine of their
    tilt, and this lift moves their rims by the sine again."""
    cosine = layer.across.min()
    wider = []
    for section, own in zip(sections, lacking.tolist(), strict=True):
        width = np.ceil(section.width_mm + 2 * own / cosine**2 - BEARING_ROUNDING_MM)
        if own > -np.inf:
            wider.append(f"a section at least {width:g} mm wide in place of {section.name}")
    joint = np.floor(layer.rules.joint_mm - 2 * lacking.max() / cosine + BEARING_ROUNDING_MM)
    return " and ".join(wider) + (f", or a joint of at most {joint:g} mm" if joint >= 0 else "")


def underside_reason(structure: SupportStructure, levels: PanelLevels, rules: DetailingRules) -> str:
    """What determines the level of the panels, in words."""
    own = levels.layers[levels.resting or 0].rules
    if not own.is_at_lift:
        return "given by its own mesh" if own.parallel else f"given as {own.z_mm or own.distance_mm or 0:g} mm"
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

"""Shapes of the panels: faces cut by the support planes at given levels, layer by layer and pane by pane.

Everything is computed for all corners of all faces at once; corner c also represents the edge of its face that begins
there, as in `Combinatorics`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fabkit.detailing.shapes.bar_sections import BarSections
from fabkit.rules import LayerRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["PanelLayer", "PanelShapes", "bearings", "seats", "steps"]

COLLINEAR_EDGES_SINE = 1e-3
"""Sine of the angle between two edges of a face below which both are cut back by the same distance, since the
intersection of their lines is ill-conditioned."""


@dataclass(frozen=True, eq=False)
class PanelShapes:
    """The panes over all faces, of one layer.

    lower, upper (C, 3): corners in mm of their lower and upper sides; corner c lies between the edge that ends and the
    edge that begins there. underside (F,): level of the lower sides above the faces in mm; thickness: in mm.
    edge_lengths (C,): in mm, of the lower side, or the shorter one of both where they differ, signed along the mesh
    edge, negative where the edge has vanished between its neighbours. insets (C,): distance in mm of each edge of the
    lower side from the mesh edge, in the plane of the panel.
    """

    lower: FloatArray
    upper: FloatArray
    underside: FloatArray
    thickness: float
    edge_lengths: FloatArray
    insets: FloatArray


@dataclass(frozen=True, eq=False)
class PanelLayer:
    """One layer of panels. structure: of the mesh above which the levels are; base (F,): level in mm of its faces above
    those of the mesh on which the beams stand; underside (F,): level of the lower sides of the layer above its
    faces."""

    rules: LayerRules
    structure: SupportStructure
    base: FloatArray
    underside: FloatArray

    @cached_property
    def panes(self) -> tuple[PanelShapes, ...]:
        """The panes, the outermost one first: faces cut by the support planes at their levels, each edge moved inwards
        by half the joint, and at the rim by its step.

        Square edges: of the outlines at the lower and the upper side of the layer, the inner one is taken for all
        panes. Mitred edges are those at the own levels of the pane.
        """
        rules, whole = self.rules, self._insets(self.underside, self.underside + self.rules.total_mm)
        shapes = []
        for level, thickness in rules.panes_mm:
            low, high = self.underside + level, self.underside + level + thickness
            insets = (whole, whole) if rules.edges == "square" else (self._insets(low, low), self._insets(high, high))
            lower, upper = self._corners(insets[0], low), self._corners(insets[1], high)
            c = self.structure.mesh.combinatorics
            sides = (lower,) if rules.edges == "square" else (lower, upper)
            lengths = np.min([np.einsum("ck,ck->c", s[c.next_corner] - s, self._cuts.t) for s in sides], axis=0)
            shapes.append(PanelShapes(lower, upper, low, thickness, lengths, insets[0]))
        return tuple(shapes)

    @property
    def resting(self) -> PanelShapes:
        """The pane that lies on the beams, if any does: the innermost one."""
        return self.panes[-1]

    @property
    def range_mm(self) -> tuple[FloatArray, FloatArray]:
        """(F,), (F,) levels of the lower and the upper side of the layer above the mesh on which the beams stand."""
        low = self.base + self.underside
        return low, low + self.rules.total_mm

    @cached_property
    def rises(self) -> FloatArray:
        """(C,) how the normal of a face rises across the support plane of each of its edges, and (C,) along the height
        of the beam there: components of the normal."""
        c, cuts = self.structure.mesh.combinatorics, self._cuts
        along = np.einsum("ck,ck->c", self.structure.height_directions[c.corner_edge], cuts.n)
        return np.stack([np.einsum("ck,ck->c", cuts.b, cuts.n), along])

    @cached_property
    def across(self) -> FloatArray:
        """(C,) cosine of the angle between each face and the width direction of the beam at each of its edges."""
        return np.asarray(np.einsum("ck,ck->c", self._cuts.b, self._cuts.q))

    @cached_property
    def _cuts(self) -> _Cuts:
        return _cuts(self.structure)

    def _insets(self, low: FloatArray, high: FloatArray) -> FloatArray:
        """(C,) distances of the edges from those of the mesh, in the planes of the panels: the larger ones of those at
        two levels (F,)."""
        c, cuts = self.structure.mesh.combinatorics, self._cuts
        levels = np.stack([low, high], axis=1)[c.corner_face]
        leaning = np.einsum("ck,ck->c", cuts.b, cuts.n)[:, None]
        upright = np.einsum("ck,ck->c", cuts.b, cuts.q)[:, None]
        at_rim = (c.edge_faces[c.corner_edge] < 0).any(axis=1)
        inwards: FloatArray = ((self.rules.joint_mm / 2 - levels * leaning) / upright).max(axis=1)
        return inwards + np.where(at_rim, self.rules.rim_step_mm, 0.0)

    def _corners(self, insets: FloatArray, level: FloatArray) -> FloatArray:
        """(C, 3) corners of the outlines at levels (F,), with these insets (C,)."""
        c, cuts = self.structure.mesh.combinatorics, self._cuts
        before = c.previous_corner
        turn = np.einsum("ck,ck->c", cuts.n, np.cross(cuts.t[before], cuts.t))
        straight = (np.abs(turn) < COLLINEAR_EDGES_SINE) & (np.einsum("ck,ck->c", cuts.t[before], cuts.t) > 0)
        safe = np.where(straight, 1.0, turn)
        meet = (insets[before] / safe)[:, None] * cuts.t - (insets / safe)[:, None] * cuts.t[before]
        alike = np.maximum(insets, insets[before])[:, None] * (cuts.q + cuts.q[before]) / 2
        across: FloatArray = np.where(straight[:, None], alike, meet)
        corners: FloatArray = self.structure.mesh.vertices[c.corners] + across + level[c.corner_face, None] * cuts.n
        return corners

    @cached_property
    def concave(self) -> IntArray:
        """Corners at which a face turns inwards."""
        c, cuts = self.structure.mesh.combinatorics, self._cuts
        turn = np.einsum("ck,ck->c", cuts.n, np.cross(cuts.t[c.previous_corner], cuts.t))
        return np.flatnonzero(turn < 0)


@dataclass(frozen=True, eq=False)
class _Cuts:
    """Per corner: unit direction t of the edge in its face, inward normal q in the face, inward normal b of the
    support plane, and the face normal n; all (C, 3)."""

    t: FloatArray
    q: FloatArray
    b: FloatArray
    n: FloatArray


def _cuts(structure: SupportStructure) -> _Cuts:
    c = structure.mesh.combinatorics
    along = np.where(c.runs_along_edge, 1.0, -1.0)[:, None]
    t = structure.mesh.corner_directions
    n = structure.mesh.face_normals[c.corner_face]
    # t x u points to the right face, so seen from its own face the inside is on the other side
    return _Cuts(t, np.cross(n, t), structure.width_directions[c.corner_edge] * -along, n)


def bearings(layer: PanelLayer, widths: FloatArray) -> FloatArray:
    """(C,) width in mm over which a panel lies above the outer side of the beam at each of its edges, measured across
    the beam. widths (E,): of the beams in mm."""
    return np.asarray(widths[layer.structure.mesh.combinatorics.corner_edge] / 2 - _rims(layer))


def seats(
    layer: PanelLayer, bars: BarSections, beams: BoolArray, of_blocks: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """(C,), (C,) least and largest free height in mm between the resting pane and the beam at each of its edges, where
    it lies above it; the least one also above the blocks at both ends of the edge. NaN where no beam is made, or where
    the pane ends beside it.

    bars: the sections of the beams, and their levels; beams (E,): which ones are made; of_blocks (C,):
    height of the block at each corner, minus infinity without a block.
    """
    c, level = layer.structure.mesh.combinatorics, layer.resting.underside
    rise, upright = layer.rises
    half, rims = bars.widths[c.corner_edge] / 2, _rims(layer)
    # the third place: where the pane is tangent to a round bar, or as near to that as it reaches
    places = np.stack([rims, half, np.where(bars.are_round[c.corner_edge], np.clip(half * rise, rims, half), half)])
    below = np.sqrt(np.maximum(half**2 - places**2, 0.0)) - half
    tops = bars.levels[c.corner_edge, 1] + np.where(bars.are_round[c.corner_edge], below, 0.0)
    free = level[c.corner_face] - places * rise - tops * upright
    lies = beams[c.corner_edge] & (rims < half)
    above_blocks = level[c.corner_face] - np.maximum(of_blocks, of_blocks[c.next_corner])
    least = np.where(lies, np.minimum(free.min(axis=0), above_blocks), np.nan)
    return least, np.where(lies, free.max(axis=0), np.nan)


def steps(layer: PanelLayer, pane: PanelShapes, panels: BoolArray) -> FloatArray:
    """(C,) how far the upper side of the pane across each edge stands above that of the pane of the face, in mm, along
    the height of the beam in its central plane; NaN without a neighbour. panels (F,): which ones are made."""
    c = layer.structure.mesh.combinatorics
    own = (pane.underside + pane.thickness)[c.corner_face] / layer.rises[1]
    own = np.where(panels[c.corner_face], own, np.nan)
    of_sides = np.full((layer.structure.mesh.n_edges, 2), np.nan)
    side = np.where(c.runs_along_edge, 0, 1)
    of_sides[c.corner_edge, side] = own
    across: FloatArray = of_sides[c.corner_edge, 1 - side]
    return across - own


def _rims(layer: PanelLayer) -> FloatArray:
    """(C,) distance in mm of each edge of the resting pane from the support plane."""
    c, cuts, shapes = layer.structure.mesh.combinatorics, layer._cuts, layer.resting
    across, leaning = (np.einsum("ck,ck->c", cuts.b, direction) for direction in (cuts.q, cuts.n))
    rims: FloatArray = shapes.insets * across + shapes.underside[c.corner_face] * leaning
    return rims

"""Beams: straight bars of constant section along the edges, mitred to the node axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.shapes.bars import (
    bar_solids,
    cut_planes,
    flange_points,
    hand_hole_middles,
    stepped_tees,
    with_hand_holes,
)
from fabkit.kinds import BEAM, BeamDetails
from fabkit.parts import Material, Parts, Section, Solids
from fabkit.rules import DetailingRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh import Mesh

__all__ = ["BeamShapes", "beam_shapes", "dihedral_angles", "end_levels", "make_beams"]


@dataclass(frozen=True, eq=False)
class BeamShapes:
    """Side views of all beams: corners (E, 4, 2) in mm, x along the edge from its tail, z above the edge.

    Their order: inner side at the tail, outer side at the tail, outer side at the head, inner side at the head.
    """

    corners: FloatArray

    @property
    def long_point(self) -> FloatArray:
        """(E,) longest extent along the axis, in mm."""
        extent: FloatArray = self.corners[:, 2:, 0].max(axis=1) - self.corners[:, :2, 0].min(axis=1)
        return extent

    @property
    def short_point(self) -> FloatArray:
        """(E,) shortest extent along the axis between the two cuts, in mm; negative where the cuts cross."""
        extent: FloatArray = self.corners[:, 2:, 0].min(axis=1) - self.corners[:, :2, 0].max(axis=1)
        return extent


def beam_shapes(structure: SupportStructure, ends: Ends, levels: tuple[float, float] | FloatArray) -> BeamShapes:
    """Side views of the beams. The cuts are parallel to the node axes, at their distances from them. levels: in mm, of
    the inner and the outer side above the edges, of all beams (2,) or of each (E, 2)."""
    cut = ends.cut.reshape(-1, 2, 1)
    inclination = ends.inclination.reshape(-1, 2, 1)
    levels = np.broadcast_to(np.asarray(levels), (len(cut), 2))
    from_node = (cut + levels[:, None] * np.sin(inclination)) / np.cos(inclination)  # (E, end, level)
    length = structure.mesh.edge_lengths[:, None]
    corners = np.empty((len(length), 4, 2))
    corners[:, :2, 0] = from_node[:, 0]
    corners[:, 2:, 0] = (length - from_node[:, 1])[:, ::-1]
    corners[:, :, 1] = levels[:, [0, 1, 1, 0]]
    return BeamShapes(corners)


def end_levels(ends: Ends) -> FloatArray:
    """(2E,) levels of the middles of the beams' end faces along the node axes, in mm."""
    inner, outer = ends.bars.at_ends
    return ends.levels((inner + outer) / 2)


def dihedral_angles(mesh: Mesh) -> FloatArray:
    """(E,) angle in radians between the normals of the two faces of each edge, positive where the mesh is convex, NaN
    at the boundary."""
    c = mesh.combinatorics
    left, right = mesh.face_normals[c.edge_faces[:, 0]], mesh.face_normals[c.edge_faces[:, 1]]
    sine = np.einsum("ek,ek->e", np.cross(left, right), mesh.edge_vectors) / mesh.edge_lengths
    angles = np.arctan2(sine, np.einsum("ek,ek->e", left, right))
    return np.where(c.is_boundary_edge, np.nan, angles)


def make_beams(
    structure: SupportStructure,
    ends: Ends,
    shapes: BeamShapes,
    edges: IntArray,
    gaps: FloatArray,
    rules: DetailingRules,
    material: Material,
) -> Parts[BeamDetails]:
    """Beams on these edges, in their order. gaps (E, 2): see `going_in_gaps`."""
    back = ((ends.flange_cut - ends.cut) / np.cos(ends.inclination)).reshape(-1, 2)[edges]
    start = shapes.corners[edges, 1] + back[:, :1] * np.array([1.0, 0.0])
    t, u = structure.mesh.edge_directions[edges], structure.height_directions[edges]
    nodes = structure.mesh.combinatorics.edges[edges]
    sections, which = ends.bars.sections, ends.bars.of_edge[edges]
    section, flanges = np.empty(len(edges), dtype=object), np.empty((len(edges), 2))
    backs, holes = np.full_like(back, np.nan), np.full_like(back, np.nan)
    for number, each in enumerate(sections):
        own = which == number
        section[own] = each
        stepped = back[own] if _is_stepped(each, rules) else None
        if stepped is not None:
            backs[own] = stepped
        flanges[own] = flange_points(each, shapes.corners[edges[own]], stepped)
        if rules.connection.kind == "bolted":
            planes = cut_planes(shapes.corners[edges[own]])
            holes[own] = hand_hole_middles(each, planes, rules.connection.hand_hole_length_mm)
    return Parts.each_its_own(
        BEAM,
        edges,
        _solids(shapes.corners[edges] - start[:, None], back, sections, which, rules),
        origins=structure.mesh.vertices[nodes[:, 0]] + start[:, :1] * t + start[:, 1:] * u,
        axes=np.stack([t, np.cross(u, t), u], axis=1),
        material=material,
        details=BeamDetails(
            nodes=nodes,
            section=section,
            cut_angles_deg=-np.degrees(ends.inclination.reshape(-1, 2)[edges]),
            end_gaps_mm=(ends.cut - ends.setback).reshape(-1, 2)[edges],
            long_point_mm=shapes.long_point[edges],
            short_point_mm=shapes.short_point[edges],
            flange_points_mm=flanges,
            flange_backs_mm=backs,
            hand_holes_mm=holes,
            dihedral_deg=np.degrees(dihedral_angles(structure.mesh)[edges]),
            height_deviation_mm=structure.heights[edges] * structure.distance - np.ptp(ends.bars.levels[edges], axis=1),
            twist_deg=np.degrees(structure.twists[edges]),
            going_in_gaps_mm=gaps[edges],
        ),
    )


def _solids(
    side_views: FloatArray, back: FloatArray, sections: tuple[Section, ...], which: IntArray, rules: DetailingRules
) -> Solids:
    """The solids of n beams in their own frames. side_views (n, 4, 2): their corners, as in `BeamShapes`; back (n, 2):
    how much of the flange is cut off at either end, in mm; which (n,): of the sections."""
    if len(sections) == 1:
        return _alike(side_views, back, sections[0], rules)
    rows = [np.flatnonzero(which == number) for number in range(len(sections))]
    return Solids.gathered(
        rows, [_alike(side_views[own], back[own], each, rules) for own, each in zip(rows, sections, strict=True)]
    )


def _alike(side_views: FloatArray, back: FloatArray, section: Section, rules: DetailingRules) -> Solids:
    connection = rules.connection
    planes = cut_planes(side_views)
    if connection.kind == "bolted":
        return with_hand_holes(section, planes, connection.hand_hole_height_mm, connection.hand_hole_length_mm)
    return stepped_tees(section, planes, back) if _is_stepped(section, rules) else bar_solids(section, *planes)


def _is_stepped(section: Section, rules: DetailingRules) -> bool:
    return rules.connection.kind == "hub" and section.shape == "tee"

"""Beams: straight bars of constant section along the edges, mitred to the node axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.kinds import BEAM, BeamDetails
from fabkit.parts import Material, Parts, Solids, prism_topology
from fabkit.rules import BeamRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh import Mesh

__all__ = ["BeamShapes", "beam_shapes", "dihedral_angles", "height_range", "make_beams"]


def height_range(rules: BeamRules) -> tuple[float, float]:
    """Levels in mm of the inner and the outer side of the bar above the mesh edge."""
    height = rules.profile.height_mm
    outer = {"outer": 0.0, "centre": height / 2, "inner": height}[rules.reference]
    return outer - height, outer


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


def beam_shapes(structure: SupportStructure, ends: Ends, rules: BeamRules) -> BeamShapes:
    """Side views of the beams. The cuts are parallel to the node axes, at their distances from them."""
    inner, outer = height_range(rules)
    cut = ends.cut.reshape(-1, 2, 1)
    inclination = ends.inclination.reshape(-1, 2, 1)
    levels = np.array([inner, outer])
    from_node = (cut + levels * np.sin(inclination)) / np.cos(inclination)  # (E, end, level)
    length = structure.mesh.edge_lengths[:, None]
    corners = np.empty((len(length), 4, 2))
    corners[:, :2, 0] = from_node[:, 0]
    corners[:, 2:, 0] = (length - from_node[:, 1])[:, ::-1]
    corners[:, :, 1] = [inner, outer, outer, inner]
    return BeamShapes(corners)


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
    rules: BeamRules,
    material: Material,
) -> Parts[BeamDetails]:
    """Beams on these edges, in their order."""
    start = shapes.corners[edges, 1]
    local = shapes.corners[edges] - start[:, None, :]
    half = np.full(local.shape[:2], rules.profile.width_mm / 2)
    lower = np.stack([local[..., 0], -half, local[..., 1]], axis=-1)
    vertices = np.concatenate([lower, lower * [1, -1, 1]], axis=1)
    t, u = structure.mesh.edge_directions[edges], structure.height_directions[edges]
    nodes = structure.mesh.combinatorics.edges[edges]
    section = np.empty(len(edges), dtype=object)
    section[:] = rules.profile
    return Parts.each_its_own(
        BEAM,
        edges,
        Solids.alike(vertices, prism_topology(4)),
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
            dihedral_deg=np.degrees(dihedral_angles(structure.mesh)[edges]),
            height_deviation_mm=(structure.heights[edges] - 1) * structure.distance,
            twist_deg=np.degrees(structure.twists[edges]),
        ),
    )

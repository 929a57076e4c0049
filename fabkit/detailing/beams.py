"""Beams: straight bars of constant section along the edges, mitred to the node axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.parts import Beam, Frame, Material, Section, Solid, prism_topology
from fabkit.rules import BeamRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh import Mesh

__all__ = ["BeamShapes", "beam_shapes", "dihedral_angles", "height_range", "make_beams"]


def height_range(rules: BeamRules) -> tuple[float, float]:
    """Levels in mm of the inner and the outer side of the bar above the mesh edge."""
    outer = {"outer": 0.0, "centre": rules.height_mm / 2, "inner": rules.height_mm}[rules.reference]
    return outer - rules.height_mm, outer


@dataclass(frozen=True, eq=False)
class BeamShapes:
    """Side views of all beams (E): corners (E, 4, 2) in mm, x along the edge from its tail, z above the edge.

    In order: inner side at the tail, outer side at the tail, outer side at the head, inner side at the head.
    """

    corners: FloatArray

    @property
    def long_point(self) -> FloatArray:
        """(E,) largest extent along the axis."""
        extent: FloatArray = self.corners[:, 2:, 0].max(axis=1) - self.corners[:, :2, 0].min(axis=1)
        return extent

    @property
    def short_point(self) -> FloatArray:
        """(E,) extent along the axis of what lies between the two cuts; negative where the cuts cross."""
        extent: FloatArray = self.corners[:, 2:, 0].min(axis=1) - self.corners[:, :2, 0].max(axis=1)
        return extent


def beam_shapes(structure: SupportStructure, ends: Ends, rules: BeamRules) -> BeamShapes:
    """Where the cuts, parallel to the node axes at their setbacks, meet the inner and the outer side of the bar."""
    inner, outer = height_range(rules)
    setback = ends.setback.reshape(-1, 2, 1)
    inclination = ends.inclination.reshape(-1, 2, 1)
    levels = np.array([inner, outer])
    from_node = (setback + levels * np.sin(inclination)) / np.cos(inclination)  # (E, end, level)
    length = structure.mesh.edge_lengths[:, None]
    corners = np.empty((len(length), 4, 2))
    corners[:, :2, 0] = from_node[:, 0]
    corners[:, 2:, 0] = (length - from_node[:, 1])[:, ::-1]
    corners[:, :, 1] = [inner, outer, outer, inner]
    return BeamShapes(corners)


def dihedral_angles(mesh: Mesh) -> FloatArray:
    """(E,) angle in radians by which the outside turns over each edge, positive where convex, NaN at the boundary."""
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
) -> tuple[Beam, ...]:
    """Beams on these edges, in their order."""
    start = shapes.corners[:, 1]
    local = shapes.corners - start[:, None, :]
    half = np.full(local.shape[:2], rules.width_mm / 2)
    lower = np.stack([local[..., 0], -half, local[..., 1]], axis=-1)
    vertices = np.concatenate([lower, lower * [1, -1, 1]], axis=1)
    t, u = structure.mesh.edge_directions, structure.height_directions
    tails = structure.mesh.vertices[structure.mesh.combinatorics.edges[:, 0]]
    origins = tails + start[:, :1] * t + start[:, 1:] * u
    axes = np.stack([t, np.cross(u, t), u], axis=1)
    cuts = -np.degrees(ends.inclination.reshape(-1, 2))
    dihedrals = np.degrees(dihedral_angles(structure.mesh))
    deviations = (structure.heights - 1) * structure.distance
    twists = np.degrees(structure.twists)
    nodes = structure.mesh.combinatorics.edges
    long_point, short_point = shapes.long_point, shapes.short_point
    section = Section(rules.width_mm, rules.height_mm)
    return tuple(
        Beam(
            mark=f"B{edge}",
            solid=Solid(vertices[edge], prism_topology(4)),
            placement=Frame(origins[edge], axes[edge]),
            material=material,
            element=edge,
            nodes=(int(nodes[edge, 0]), int(nodes[edge, 1])),
            section=section,
            cut_angles_deg=(float(cuts[edge, 0]), float(cuts[edge, 1])),
            long_point_mm=float(long_point[edge]),
            short_point_mm=float(short_point[edge]),
            dihedral_deg=float(dihedrals[edge]),
            height_deviation_mm=float(deviations[edge]),
            twist_deg=float(twists[edge]),
        )
        for edge in edges.tolist()
    )

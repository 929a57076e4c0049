"""Fins: plates along the edges between two meshes M + d (S + x), cut back from the lines in which they would meet.

A fin is made as a flat bar whose height differs from edge to edge: between the lines of its two meshes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.checking import FIT_MM
from fabkit.detailing.beams import BeamShapes, beam_shapes
from fabkit.detailing.ends import Ends, beam_ends
from fabkit.errors import DetailingError
from fabkit.kinds import FIN, FinDetails, PanelDetails
from fabkit.parts import Material, Parts, Ragged, Solids
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, FinRules, NodeRules
from geometry.arrays import BoolArray
from geometry.errors import MeshError
from geometry.gauss import Pair, SupportStructure
from geometry.shading import Fins, MostShade, Suns, most_shade

__all__ = ["FinPlan"]


@dataclass(frozen=True, eq=False)
class FinPlan:
    """What fins are made of. structure: M and S + x, in mm. shade: how x was found, None where it was given. beams:
    structure of M and S."""

    rules: FinRules
    structure: SupportStructure
    shade: MostShade | None
    beams: SupportStructure

    @classmethod
    def of(cls, structure: SupportStructure, rules: FinRules | None) -> FinPlan | None:
        """The one that the rules ask for, if any. Raises MeshError, GeometryError or DetailingError where fins cannot
        be made so."""
        if rules is None:
            return None
        if rules.suns:
            fins, suns = Fins(structure.pair, rules.from_mm, rules.to_mm), Suns(np.array(rules.sun_vectors))
            shade = most_shade(fins, suns, bound=rules.longest_direction)
            pair = shade.after.fins.pair
        else:
            shade, pair = None, structure.pair.tilted(rules.direction)
            _check_outwards(pair)
        low, high = pair.distance_range
        for key, distance in (("from_mm", rules.from_mm), ("to_mm", rules.to_mm)):
            if not low < distance < high:
                raise DetailingError(
                    f"at fins.{key} = {distance:g} some fins have turned inside out: set it between {low:.1f} and "
                    f"{high:.1f}"
                )
        return cls(rules, SupportStructure(pair, rules.to_mm - rules.from_mm), shade, structure)

    def shapes(self, made: BoolArray) -> tuple[Ends, BeamShapes, dict[int, str]]:
        """The ends and side views of the fins on the edges `made` (E,), and the edges where they are too short, with a
        reason for each."""
        own = self.rules
        cuts = DetailingRules(
            beams=BeamRules(width_mm=own.thickness_mm, height_mm=own.to_mm - own.from_mm),
            connection=ConnectionRules(kind="welded", slot_mm=own.gap_mm, ledge_mm=0.0),
            nodes=NodeRules(setbacks="least"),
        )
        ends = beam_ends(self.structure, made, cuts)
        levels = np.multiply.outer(self.structure.heights, [own.from_mm, own.to_mm])
        shapes = beam_shapes(self.structure, ends, levels)
        short = np.flatnonzero(made & ~(shapes.short_point >= own.least_length_mm))
        reasons = {
            int(edge): f"the fin on edge {edge} (counted from 0) is {shapes.short_point[edge]:.1f} mm long between its "
            f"two cuts, and at least {own.least_length_mm:g} mm are needed"
            for edge in short
        }
        return ends, shapes, reasons

    def parts(self, made: BoolArray, ends: Ends, shapes: BeamShapes, material: Material) -> Parts[FinDetails]:
        """The fins on the edges `made` (E,)."""
        edges, structure, thickness = np.flatnonzero(made), self.structure, self.rules.thickness_mm
        angles = -np.degrees(ends.inclination.reshape(-1, 2)[edges])
        turned = angles[:, 1] > angles[:, 0]  # end for end
        corners = shapes.corners[edges][:, [0, 3, 2, 1]]  # inner tail, inner head, outer head, outer tail
        corners = np.where(turned[:, None, None], corners[:, [1, 0, 3, 2]], corners)
        sign = np.where(turned, -1.0, 1.0)[:, None]
        outlines = corners - corners[:, :1]
        outlines[..., 0] *= sign
        nodes = structure.mesh.combinatorics.edges[edges]
        t, u = structure.mesh.edge_directions[edges], structure.height_directions[edges]
        x, z = sign * t, sign * structure.width_directions[edges]
        start = corners[:, 0]
        origins = structure.mesh.vertices[nodes[:, 0]] + start[:, :1] * t + start[:, 1:] * u - thickness / 2 * z
        n, starts = len(edges), 4 * np.arange(len(edges) + 1)
        heights = outlines[:, 2, 1]
        upright = self.beams.height_directions[edges]
        sines, cosines = np.linalg.norm(np.cross(u, upright), axis=1), np.einsum("ek,ek->e", u, upright)
        return Parts.each_its_own(
            FIN,
            edges,
            Solids.prisms(Ragged(outlines.reshape(-1, 2), starts), np.zeros(n), np.full(n, thickness)),
            origins=origins,
            axes=np.stack([x, u, z], axis=1),
            material=material,
            details=FinDetails(
                nodes=np.where(turned[:, None], nodes[:, ::-1], nodes),
                cut_angles_deg=np.where(turned[:, None], angles[:, ::-1], angles),
                thickness_mm=np.full(n, thickness),
                height_mm=heights,
                length_mm=shapes.long_point[edges],
                area_mm2=heights * (shapes.long_point + shapes.short_point)[edges] / 2,
                lean_deg=np.degrees(np.arctan2(sines, cosines)),
            ),
        )

    def check_clear_of(self, panels: Parts[PanelDetails], made: BoolArray) -> None:
        """Raise DetailingError where a fin on the edges `made` (E,) reaches through a panel of the faces at its edge,
        or is nearer to it than the clearance.

        The lines of a fin are parallel to its edge, and so have constant heights above both faces.
        """
        own, mesh, c = self.rules, self.structure.mesh, self.structure.mesh.combinatorics
        corner, panel = c.corners_of(panels.elements)
        corner, panel = corner[made[c.corner_edge[corner]]], panel[made[c.corner_edge[corner]]]
        face, edge = c.corner_face[corner], c.corner_edge[corner]
        normals = mesh.face_normals[face]
        rises = np.einsum("ck,ck->c", normals, self.structure.gauss_image.vertices[c.corners[corner]])
        aside = own.thickness_mm / 2 * np.abs(np.einsum("ck,ck->c", normals, self.structure.width_directions[edge]))
        low, high = own.from_mm * rises - aside, own.to_mm * rises + aside
        bottoms = np.einsum("ck,ck->c", normals, panels.origins[panel] - mesh.vertices[c.corners[corner]])
        tops = bottoms + panels.details.thickness_mm[panel]
        needed = own.clearance_mm - FIT_MM
        wrong = np.flatnonzero(~((low >= tops + needed) | (high <= bottoms - needed)))
        if not len(wrong):
            return
        worst = wrong[int(np.minimum(tops - low, high - bottoms)[wrong].argmax())]
        begin = np.ceil(10 * ((tops + own.clearance_mm + aside) / rises).max()) / 10
        end = np.floor(10 * ((bottoms - own.clearance_mm - aside) / rises).min()) / 10
        raise DetailingError(
            f"the fin on edge {edge[worst]} reaches from {low[worst]:.1f} to {high[worst]:.1f} mm above face "
            f"{face[worst]} (counted from 0), where a panel lies from {bottoms[worst]:.1f} to {tops[worst]:.1f} mm, "
            f"and {own.clearance_mm:g} mm must be clear: set fins.from_mm to {begin:g} or more, or fins.to_mm to "
            f"{end:g} or less" + (", or shorten fins.longest_direction" if self.shade else "")
        )


def _check_outwards(pair: Pair) -> None:
    """Raise MeshError where a Gauss image does not rise above a face at a corner of it."""
    c = pair.mesh.combinatorics
    rises = np.einsum("ck,ck->c", pair.mesh.face_normals[c.corner_face], pair.gauss_image.vertices[c.corners])
    corner = int(rises.argmin())
    if not rises[corner] > 0:
        raise MeshError(
            f"the fins at vertex {c.corners[corner]} would lie behind face {c.corner_face[corner]} (counted from 0): "
            f"with fins.direction the Gauss image rises {rises[corner]:.2f} above it there; take a shorter direction",
            elements=[int(c.corner_face[corner])],
            value=float(rises[corner]),
            bound=0.0,
        )

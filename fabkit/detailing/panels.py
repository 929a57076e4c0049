"""Panels: planar plates over the faces, cut by the support planes, at a height that clears beams and nodes.

Everything is computed for all corners of all faces at once; corner c also represents the edge of its face that begins
there, as in `Combinatorics`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from fabkit.detailing.beams import dihedral_angles
from fabkit.kinds import PANEL, PanelDetails
from fabkit.parts import Material, Parts, Ragged, Solids
from fabkit.rules import PanelRules
from geometry.arrays import FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh.ragged_arrays import rows_by_size

__all__ = ["PanelShapes", "bearings", "make_panels", "panel_shapes"]

COLLINEAR_EDGES_SINE = 1e-3
"""Sine of the angle between two edges of a face below which both are cut back by the same distance, since the
intersection of their lines is ill-conditioned."""


@dataclass(frozen=True, eq=False)
class PanelShapes:
    """Outlines of all panels at the level of their lower sides.

    corners (C, 3): positions in mm; corner c lies between the edge that ends and the edge that begins there.
    underside (F,): level of the lower sides above the faces in mm. edge_lengths (C,): in mm, signed along the mesh
    edge, negative where the edge has vanished between its neighbours. insets (C,): distance in mm of each edge from the
    mesh edge, in the plane of the panel.
    """

    corners: FloatArray
    underside: FloatArray
    edge_lengths: FloatArray
    insets: FloatArray


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


def panel_shapes(structure: SupportStructure, rules: PanelRules, underside: FloatArray) -> PanelShapes:
    """Faces cut by the support planes at the levels `underside` (F,), each edge moved inwards by half the joint.

    The edges of the plate are square: of the outlines at its lower and its upper side, the inner one is taken.
    """
    c = structure.mesh.combinatorics
    cuts = _cuts(structure)
    level = underside[c.corner_face, None]
    levels = np.concatenate([level, level + rules.thickness_mm], axis=1)
    leaning = np.einsum("ck,ck->c", cuts.b, cuts.n)[:, None]
    upright = np.einsum("ck,ck->c", cuts.b, cuts.q)
    inwards = ((rules.joint_mm / 2 - levels * leaning) / upright[:, None]).max(axis=1)
    before = c.previous_corner
    turn = np.einsum("ck,ck->c", cuts.n, np.cross(cuts.t[before], cuts.t))
    straight = (np.abs(turn) < COLLINEAR_EDGES_SINE) & (np.einsum("ck,ck->c", cuts.t[before], cuts.t) > 0)
    safe = np.where(straight, 1.0, turn)
    meet = (inwards[before] / safe)[:, None] * cuts.t - (inwards / safe)[:, None] * cuts.t[before]
    alike = np.maximum(inwards, inwards[before])[:, None] * (cuts.q + cuts.q[before]) / 2
    corners = structure.mesh.vertices[c.corners] + np.where(straight[:, None], alike, meet) + level * cuts.n
    lengths = np.einsum("ck,ck->c", corners[c.next_corner] - corners, cuts.t)
    return PanelShapes(corners, underside, lengths, inwards)


def bearings(structure: SupportStructure, shapes: PanelShapes, widths: FloatArray) -> FloatArray:
    """(C,) width in mm over which a panel lies above the outer side of the beam at each of its edges, measured across
    the beam. widths (E,): of
    the beams."""
    cuts, c = _cuts(structure), structure.mesh.combinatorics
    across, leaning = (np.einsum("ck,ck->c", cuts.b, direction) for direction in (cuts.q, cuts.n))
    rim = shapes.insets * across + shapes.underside[c.corner_face] * leaning
    return np.asarray(widths[c.corner_edge] / 2 - rim)


def make_panels(
    structure: SupportStructure, shapes: PanelShapes, faces: IntArray, rules: PanelRules, material: Material
) -> Parts[PanelDetails]:
    """Panels over these faces, in their order."""
    c = structure.mesh.combinatorics
    every = c.corners_of(faces)[0]
    starts = np.concatenate([[0], np.cumsum(c.face_sizes[faces])])
    corner = np.empty(len(every), dtype=np.int64)
    outlines = np.empty((len(every), 2))
    lengths, angles = np.empty(len(every)), np.empty(len(every))
    origins, axes, areas = np.empty((len(faces), 3)), np.empty((len(faces), 3, 3)), np.empty(len(faces))
    for panels, places in rows_by_size(starts):
        alike = _frames(structure, shapes, faces[panels], every[places])
        corner[places], outlines[places] = alike.corners, alike.outlines
        lengths[places], angles[places] = alike.lengths, alike.angles
        origins[panels], axes[panels], areas[panels] = alike.origins, alike.axes, alike.areas
    left_right = c.edge_faces[c.corner_edge[corner]]
    across = np.where(c.runs_along_edge[corner], left_right[:, 1], left_right[:, 0])
    around = partial(Ragged, starts=starts)
    thickness = np.full(len(faces), rules.thickness_mm)
    return Parts.each_its_own(
        PANEL,
        faces,
        Solids.prisms(around(outlines), np.zeros(len(faces)), thickness),
        origins=origins,
        axes=axes,
        material=material,
        details=PanelDetails(
            layer=np.zeros(len(faces), dtype=np.int64),
            pane=np.zeros(len(faces), dtype=np.int64),
            thickness_mm=thickness,
            underside_mm=shapes.underside[faces],
            area_mm2=areas,
            edge_lengths_mm=around(lengths),
            corner_angles_deg=around(angles),
            dihedrals_deg=around(np.degrees(dihedral_angles(structure.mesh))[c.corner_edge[corner]]),
            beams=around(c.corner_edge[corner]),
            neighbours=around(across),
        ),
    )


@dataclass(frozen=True, eq=False)
class _Frames:
    """n panels with k corners in frames on their longest edges: corners (n, k), of the mesh, from the start of that
    edge; origins (n, 3), axes (n, 3, 3); outlines (n, k, 2); lengths of edges and inner angles in degrees (n, k); areas
    (n,)."""

    corners: IntArray
    origins: FloatArray
    axes: FloatArray
    outlines: FloatArray
    lengths: FloatArray
    angles: FloatArray
    areas: FloatArray


def _frames(structure: SupportStructure, shapes: PanelShapes, faces: IntArray, corners: IntArray) -> _Frames:
    """The frames and outlines of faces with corners (n, k)."""
    rows = np.arange(len(faces))[:, None]
    longest = shapes.edge_lengths[corners].argmax(axis=1)
    size = corners.shape[1]
    order = corners[rows, (longest[:, None] + np.arange(size)) % size]
    points = shapes.corners[order]
    origins = points[:, 0]
    z = structure.mesh.face_normals[faces]
    x = points[:, 1] - origins
    x -= np.einsum("nk,nk->n", x, z)[:, None] * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    axes = np.stack([x, np.cross(z, x), z], axis=1)
    outlines = np.einsum("nck,njk->ncj", points - origins[:, None], axes)[..., :2]
    sides = np.roll(outlines, -1, axis=1) - outlines
    back = -np.roll(sides, 1, axis=1)
    turned = np.arctan2(_cross(sides, back), np.einsum("ncj,ncj->nc", sides, back))
    following = np.roll(outlines, -1, axis=1)
    return _Frames(
        corners=order,
        origins=origins,
        axes=axes,
        outlines=outlines,
        lengths=np.linalg.norm(sides, axis=-1),
        angles=np.degrees(np.mod(turned, 2 * np.pi)),
        areas=_cross(outlines, following).sum(axis=1) / 2,
    )


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """(...) a x b of plane vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

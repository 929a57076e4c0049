"""Panels as parts: the panes of all layers over the faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fabkit.detailing.panel_layers.panel_shapes import PanelLayer, PanelShapes, steps
from fabkit.kinds import PANEL, PanelDetails
from fabkit.parts import Material, Parts, Ragged, Solids
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh.ragged_arrays import rows_by_size

__all__ = ["make_panels"]


def make_panels(
    layers: Sequence[PanelLayer],
    panels: BoolArray,
    materials: Sequence[Sequence[Material]],
    seats: tuple[FloatArray, FloatArray],
    resting: int | None,
    dihedrals_deg: FloatArray,
) -> Parts[PanelDetails]:
    """The panes of all layers, layer by layer, pane by pane, face by face. panels (F,): which faces have them.

    materials: of the panes of each layer. seats (C,), (C,): least and largest seat in mm at each edge of the innermost
    pane of the layer `resting`, if there is such a layer. dihedrals_deg (E,): between the faces at each edge.
    """
    faces, made, of_panes = np.flatnonzero(panels), [], []
    for number, layer in enumerate(layers):
        for place, pane in enumerate(layer.panes):
            rests = number == resting and pane is layer.resting
            made.append(_pane(layer, (number, place), seats if rests else None, panels, dihedrals_deg))
            of_panes.append(materials[number][place])
    known = tuple(dict.fromkeys(of_panes))
    outlines, upper = (Ragged.joined([getattr(each, name) for each in made]) for name in ("outlines", "upper"))
    details = PanelDetails.joined([each.details for each in made])
    found = Parts.each_its_own(
        PANEL,
        np.tile(faces, len(made)),
        Solids.prisms(outlines, np.zeros(len(outlines)), details.thickness_mm, upper.values),
        origins=np.concatenate([each.origins for each in made]),
        axes=np.concatenate([each.axes for each in made]),
        material=known[0],
        details=details,
    )
    which = np.repeat([known.index(material) for material in of_panes], len(faces))
    return replace(found, materials=known, material=which)


@dataclass(frozen=True, eq=False)
class _Pane:
    """The panels of one pane: outlines, upper (k, 2): of the lower and the upper side; origins (n, 3), axes (n, 3,
    3)."""

    outlines: Ragged
    upper: Ragged
    origins: FloatArray
    axes: FloatArray
    details: PanelDetails


def _pane(
    layer: PanelLayer,
    place: tuple[int, int],
    seats: tuple[FloatArray, FloatArray] | None,
    panels: BoolArray,
    dihedrals_deg: FloatArray,
) -> _Pane:
    """place: number of the layer, and of the pane in it. seats (C,), (C,): as of all layers, None without."""
    c, shapes, faces = layer.structure.mesh.combinatorics, layer.panes[place[1]], np.flatnonzero(panels)
    every, n = c.corners_of(faces)[0], len(faces)
    starts = np.concatenate([[0], np.cumsum(c.face_sizes[faces])])
    corner = np.empty(len(every), dtype=np.int64)
    outlines, upper = np.empty((len(every), 2)), np.empty((len(every), 2))
    lengths, angles = np.empty(len(every)), np.empty(len(every))
    origins, axes, areas = np.empty((n, 3)), np.empty((n, 3, 3)), np.empty(n)
    for rows, places in rows_by_size(starts):
        alike = _frames(layer.structure, shapes, faces[rows], every[places])
        corner[places], outlines[places], upper[places] = alike.corners, alike.outlines, alike.upper
        lengths[places], angles[places] = alike.lengths, alike.angles
        origins[rows], axes[rows], areas[rows] = alike.origins, alike.axes, alike.areas
    left_right = c.edge_faces[c.corner_edge[corner]]
    across = np.where(c.runs_along_edge[corner], left_right[:, 1], left_right[:, 0])
    around = partial(Ragged, starts=starts)
    least, largest = seats or (np.full(len(c.corners), np.nan),) * 2
    details = PanelDetails(
        layer=np.full(n, place[0]),
        pane=np.full(n, place[1]),
        finish=np.full(n, layer.rules.finishes[place[1]], dtype=object),
        thickness_mm=np.full(n, shapes.thickness),
        underside_mm=(layer.base + shapes.underside)[faces],
        area_mm2=areas,
        edge_lengths_mm=around(lengths),
        corner_angles_deg=around(angles),
        dihedrals_deg=around(dihedrals_deg[c.corner_edge[corner]]),
        least_seats_mm=around(least[corner]),
        largest_seats_mm=around(largest[corner]),
        steps_mm=around(steps(layer, shapes, panels)[corner]),
        beams=around(c.corner_edge[corner]),
        neighbours=around(across),
    )
    is_square = layer.rules.edges == "square"
    return _Pane(around(outlines), around(outlines if is_square else upper), origins, axes, details)


@dataclass(frozen=True, eq=False)
class _Frames:
    """n panels with k corners in frames on their longest edges: corners (n, k), of the mesh, from the start of that
    edge; origins (n, 3), axes (n, 3, 3); outlines, upper (n, k, 2): of the lower and the upper side; lengths of edges
    and inner angles in degrees (n, k), areas (n,): of the lower side."""

    corners: IntArray
    origins: FloatArray
    axes: FloatArray
    outlines: FloatArray
    upper: FloatArray
    lengths: FloatArray
    angles: FloatArray
    areas: FloatArray


def _frames(structure: SupportStructure, shapes: PanelShapes, faces: IntArray, corners: IntArray) -> _Frames:
    """The frames and outlines of faces with corners (n, k)."""
    rows = np.arange(len(faces))[:, None]
    longest = shapes.edge_lengths[corners].argmax(axis=1)
    size = corners.shape[1]
    order = corners[rows, (longest[:, None] + np.arange(size)) % size]
    points = shapes.lower[order]
    origins = points[:, 0]
    z = structure.mesh.face_normals[faces]
    x = points[:, 1] - origins
    x -= np.einsum("nk,nk->n", x, z)[:, None] * z
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    axes = np.stack([x, np.cross(z, x), z], axis=1)
    outlines = np.einsum("nck,njk->ncj", points - origins[:, None], axes)[..., :2]
    upper = np.einsum("nck,njk->ncj", shapes.upper[order] - origins[:, None], axes)[..., :2]
    sides = np.roll(outlines, -1, axis=1) - outlines
    back = -np.roll(sides, 1, axis=1)
    turned = np.arctan2(_cross(sides, back), np.einsum("ncj,ncj->nc", sides, back))
    following = np.roll(outlines, -1, axis=1)
    return _Frames(
        corners=order,
        origins=origins,
        axes=axes,
        outlines=outlines,
        upper=upper,
        lengths=np.linalg.norm(sides, axis=-1),
        angles=np.degrees(np.mod(turned, 2 * np.pi)),
        areas=_cross(outlines, following).sum(axis=1) / 2,
    )


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """(...) a x b of plane vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]

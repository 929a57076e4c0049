"""Panels: planar plates over the faces, in one layer or several."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.kinds.columns import (
    LEFT_OUT,
    NO_NEIGHBOUR,
    counted,
    each_value,
    files,
    grouped,
    joined,
    marks_and_counts,
    masses,
    materials,
    of_first,
    ranges,
    stock_of_plates,
)
from fabkit.kinds.faces import panel_faces
from fabkit.parts import (
    Column,
    Details,
    Finish,
    Kind,
    Measure,
    Parts,
    Ragged,
    Surroundings,
    Symmetry,
    Turns,
    blanks,
    shifted,
    texts,
)
from geometry.arrays import FloatArray, IntArray

__all__ = ["PANEL", "PanelDetails", "neighbour_names", "panel_outlines", "panel_sides"]


@dataclass(frozen=True, eq=False)
class PanelDetails(Details):
    """Data of n panels.

    Own frame of a panel: outer side up (the plate is a prism between z = 0 and z = thickness), origin at the start of
    the longest edge of the outline, x along it. Each row has a value for each edge of the outline, counter-clockwise,
    edge k from corner k to corner k+1.

    layer (n,): counted from the outermost one, 0. pane (n,): which one of its layer, counted from the outermost one, 0;
    a layer with gaps has several. finish (n,): the `Finish` of each. thickness_mm, area_mm2 (n,): area of the lower
    side. underside_mm (n,): height of the lower side above the mesh face. edge_lengths_mm: of the lower side.
    corner_angles_deg: inner angle at each corner. dihedrals_deg: as for beams. least_seats_mm, largest_seats_mm: free
    height between the panel and what stands highest under it along the edge: a wedge over the width of the beam; NaN
    where it lies on none. steps_mm: how far the upper side of the panel across stands above that of this one, NaN where
    there is none. beams: the mesh edges. neighbours: the faces across, -1 where none.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> panels = built.assembly["panels"].details
    >>> panels.edge_lengths_mm[0].round().tolist(), panels.corner_angles_deg[0].round(1).tolist()
    ([2409.0, 1463.0, 1733.0, 1463.0], [76.7, 76.7, 103.3, 103.3])
    """

    layer: IntArray
    pane: IntArray
    finish: npt.NDArray[np.object_]
    thickness_mm: FloatArray
    underside_mm: FloatArray
    area_mm2: FloatArray
    edge_lengths_mm: Ragged
    corner_angles_deg: Ragged
    dihedrals_deg: Ragged
    least_seats_mm: Ragged
    largest_seats_mm: Ragged
    steps_mm: Ragged
    beams: Ragged
    neighbours: Ragged


def panel_outlines(panels: Parts[Any]) -> Ragged:
    """Corners (k, 2) in mm of the outline from which each panel, or other plate, is cut, in its own frame,
    counter-clockwise: its lower side, or what encloses both sides if its edges are mitred.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.kinds import panel_outlines
    >>> (panel_outlines(built.assembly["panels"])[0].round() + 0.0).tolist()
    [[0.0, 0.0], [2409.0, 0.0], [2071.0, 1423.0], [338.0, 1423.0]]
    """
    return blanks(*panel_sides(panels))


def panel_sides(panels: Parts[PanelDetails]) -> tuple[Ragged, Ragged]:
    """Corners (k, 2) in mm of the lower and of the upper side of each panel, in its own frame, counter-clockwise.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.kinds import panel_sides
    >>> lower, upper = panel_sides(built.assembly["panels"])  # with square edges
    >>> np.array_equal(lower.values, upper.values)
    True
    """
    vertices = panels.solids.vertices
    starts = np.concatenate([[0], np.cumsum(vertices.sizes // 2)])
    below = vertices.place < vertices.sizes[vertices.row] // 2
    lower, upper = (Ragged(vertices.values[side, :2], starts)[panels.shape] for side in (below, ~below))
    return lower, upper


def neighbour_names(panels: Parts[PanelDetails], names: Sequence[str], left_out: str, none: str) -> list[str]:
    """The name of the panel across each edge of all panels, in the same layer and pane. names (n,): of the panels;
    left_out, none: the name where that panel is left out, and at the boundary.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.kinds import neighbour_names
    >>> panels = built.assembly["panels"]
    >>> neighbour_names(panels, panels.marks, "left out", "-")[:4]
    ['-', 'P001', 'P002', 'P001']
    """
    across = panels.details.neighbours
    found = panels.find_alike(across.row, across.values)
    every = [*names, none, left_out]  # the last one has the number -1
    return [every[k] for k in np.where(across.values < 0, len(names), found).tolist()]


def _turns(panels: Parts[PanelDetails], corners: FloatArray) -> Turns:
    """The turns of panels: each of their edges in turn is the first."""
    n = corners.shape[1] // 2
    outlines = corners[:, :n, :2]
    sides = np.roll(outlines, -1, axis=1) - outlines
    along = sides / np.linalg.norm(sides, axis=2, keepdims=True)
    along[:, 0], starts = [1.0, 0.0], outlines.copy()
    starts[:, 0] = 0.0
    return Turns(starts, along, shifted(np.tile(np.arange(n), (len(panels), 1)), n))


def _turned_over(panels: Parts[PanelDetails], turns: Turns, corners: FloatArray) -> Turns:
    """With as many turns more, in which the plate lies on its other face and edge t is in front, run through backwards:
    its mirror image has the same outline then. Without these where the faces of the panels differ."""
    if not all(each.has_equal_faces for each in panels.details.finish.tolist()):
        return turns
    n = corners.shape[1] // 2

    def of_all(parts: IntArray, turn: IntArray, chosen: IntArray) -> IntArray:
        backwards = (turn[:, None] % n + 1 - chosen) % n + np.where(chosen < n, n, 0)
        return np.where(turn[:, None] < n, turns.corners(parts, turn % n, chosen), backwards)

    levels = np.full((len(corners), 2 * n), np.nan)
    levels[:, n:] = corners[:, n:, 2].mean(axis=1, keepdims=True)
    upper = corners[:, n:, :2]
    following = np.roll(upper, -1, axis=1)
    back = (upper - following) / np.linalg.norm(upper - following, axis=2, keepdims=True)
    starts, along = (np.concatenate(both, axis=1) for both in ((turns.starts, following), (turns.along, back)))
    return Turns(starts, along, of_all, levels)


def _columns(panels: Parts[PanelDetails], around: Surroundings) -> list[Column]:
    own, firsts = panels.details, panels.firsts
    area, sheets = own.area_mm2[firsts] * 1e-6, around.sheets.get("panels")
    areas = (panels.counts * own.area_mm2[firsts] * 1e-6).tolist()
    across = joined(neighbour_names(panels, panels.marks, LEFT_OUT, NO_NEIGHBOUR), own.neighbours.starts)
    return [
        *marks_and_counts(panels),
        materials(panels),
        of_first("Thickness (mm)", 2, panels, own.thickness_mm),
        *_finishes(panels),
        *_sizes(panels),
        Column("Area each (m2)", 4, area.tolist()),
        Column("Area (m2)", 4, areas, float(sum(areas))),
        each_value("Edges (mm)", 2, panels, own.edge_lengths_mm),
        each_value("Corners (deg)", 2, panels, own.corner_angles_deg),
        _dihedrals(panels),
        counted("Neighbours", panels, across),
        *masses(panels),
        Column("Sheets", None, [""] * len(firsts) if sheets is None else _sheets(panels, sheets), several=True),
        files(panels, around.panel_file),
    ]


def _finishes(panels: Parts[PanelDetails]) -> list[Column]:
    """Of each mark its build-up, its edge work, and which surface is coated."""
    found: list[Finish] = panels.details.finish[panels.firsts].tolist()
    return [
        Column("Build-up", None, [each.build_up for each in found]),
        Column("Edge work", None, ["" if each.edge_work == "none" else each.edge_work for each in found]),
        Column("Coating", 0, [each.coating or None for each in found]),
        Column("Coated side", None, [each.coated_side for each in found]),
    ]


def _words(panels: Parts[PanelDetails]) -> list[str]:
    return [each.words for each in panels.details.finish.tolist()]


def _sizes(panels: Parts[PanelDetails]) -> list[Column]:
    """Of each mark its extents along edge 1 and across it, and of quads the two diagonals."""
    outlines = panel_outlines(panels)[panels.firsts]
    low, high = (
        np.stack([outlines.with_values(outlines.values[:, k]).reduced(function) for k in range(2)], axis=1)
        for function in (np.minimum, np.maximum)
    )
    diagonals = np.full((len(outlines), 2), np.nan)
    quads = np.flatnonzero(outlines.sizes == 4)
    corners = outlines[quads].values.reshape(-1, 4, 2)
    diagonals[quads] = np.linalg.norm(corners[:, :2] - corners[:, 2:], axis=2)
    columns = [("Width", high[:, 0] - low[:, 0]), ("Height", high[:, 1] - low[:, 1])]
    columns += [(f"Diagonal {k + 1}", diagonals[:, k]) for k in range(2)]
    return [
        Column(f"{name} (mm)", 2, [None if value != value else value for value in values.tolist()])
        for name, values in columns
    ]


def _dihedrals(panels: Parts[PanelDetails]) -> Column:
    """For each edge, over all panels of a mark, the angle or its range."""
    angles = panels.details.dihedrals_deg
    starts = np.concatenate([[0], np.cumsum(angles.sizes[panels.firsts])])
    edge = starts[panels.mark[angles.row]] + angles.place
    found = ranges(angles.values, edge, 2)
    cells = joined([text or NO_NEIGHBOUR for text in texts(found, 2)], starts)
    return Column("Dihedrals (deg)", None, cells, several=True)


def _sheets(panels: Parts[PanelDetails], sheets: IntArray) -> list[str]:
    """The different sheets with panels of each mark. sheets (n,): of each panel, counted from 1."""
    pairs = np.unique(np.stack([panels.mark, sheets], axis=1), axis=0)
    starts = np.concatenate([[0], np.cumsum(np.bincount(pairs[:, 0], minlength=len(panels.mark_names)))])
    return [", ".join(own) for own in grouped([str(sheet) for sheet in pairs[:, 1].tolist()], starts)]


def _measures(panels: Parts[PanelDetails]) -> list[Measure]:
    own, measure = panels.details, partial(Measure, "panels")
    folds = own.dihedrals_deg.with_values(np.abs(own.dihedrals_deg.values))
    return [
        measure("Area", "m²", 3, own.area_mm2 / 1e6),
        measure("Longest edge", "mm", 1, own.edge_lengths_mm.reduced(np.maximum)),
        measure("Smallest corner", "°", 1, own.corner_angles_deg.reduced(np.minimum)),
        measure("Largest dihedral angle", "°", 2, folds.reduced(np.fmax)),
        measure("Mass of a panel", "kg", 1, panels.masses_kg),
    ]


def _labels(panels: Parts[PanelDetails], around: Surroundings) -> list[str]:
    return [
        f"{text}; face {face}" for text, face in zip(stock_of_plates(panels), panels.elements.tolist(), strict=True)
    ]


PANEL = Kind(
    name="panel",
    group="panels",
    element="face",
    letter="P",
    colour=(0.55, 0.75, 0.85),
    form="plate",
    first_edge="the longest",
    one_per_element=False,
    apart_by=("layer", "pane"),
    frame=(
        "Origin at corner 1, x along edge 1, the longest; z outwards; the plate lies between z = 0 and its thickness."
    ),
    empty_details=PanelDetails(
        layer=np.zeros(0, dtype=np.int64),
        pane=np.zeros(0, dtype=np.int64),
        finish=np.zeros(0, dtype=object),
        thickness_mm=np.zeros(0),
        underside_mm=np.zeros(0),
        area_mm2=np.zeros(0),
        edge_lengths_mm=Ragged.of([]),
        corner_angles_deg=Ragged.of([]),
        dihedrals_deg=Ragged.of([]),
        least_seats_mm=Ragged.of([]),
        largest_seats_mm=Ragged.of([]),
        steps_mm=Ragged.of([]),
        beams=Ragged.of([], dtype=np.int64),
        neighbours=Ragged.of([], dtype=np.int64),
    ),
    symmetry=Symmetry(
        (
            "edge_lengths_mm",
            "corner_angles_deg",
            "dihedrals_deg",
            "least_seats_mm",
            "largest_seats_mm",
            "steps_mm",
            "beams",
            "neighbours",
        ),
        (),
        _turns,
        _turned_over,
        ("corner_angles_deg",),
    ),
    columns=_columns,
    measures=_measures,
    labels=_labels,
    faces=panel_faces,
    stock=stock_of_plates,
    finishes=_words,
)

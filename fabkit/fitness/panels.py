"""Criteria of panels as glass is made and handled: one function for each, which returns None where nothing is
unusual."""

from __future__ import annotations

import numpy as np

from fabkit.fitness.finding import Finding, named, worst_first
from fabkit.fitness.rules import FitnessRules
from fabkit.kinds import PanelDetails
from fabkit.parts import Parts
from geometry.arrays import IntArray

__all__ = ["corners", "panel_masses", "short_edges"]


def corners(panels: Parts[PanelDetails], rules: FitnessRules) -> Finding | None:
    """Corners of panels that break, or whose tips are cut off."""
    angles = panels.details.corner_angles_deg.reduced(np.minimum)
    order = worst_first(-angles, angles < rules.corners_noted_deg)
    if not len(order):
        return None
    sharp = [f"{panels[k].mark} ({angles[k]:.1f})" for k in order.tolist() if angles[k] < rules.corners_listed_deg]
    by_mark = (
        f"; below {rules.corners_listed_deg:g} degrees, where tips break off: {named(list(dict.fromkeys(sharp)))}"
        if sharp
        else ""
    )
    return Finding(
        "corners",
        "note",
        float(angles[order[0]]),
        rules.corners_noted_deg,
        "degrees",
        f"{len(order)} of {len(panels)} panels have a corner below {rules.corners_noted_deg:g} degrees, the smallest "
        f"angle is {angles[order[0]]:.1f} degrees at {panels[int(order[0])].mark} (face {panels.elements[order[0]]}, "
        f"counted from 0){by_mark}",
        "agree with the maker of the glass how tips are cut back, or make the angles of these faces wider",
        "face",
        _faces(panels, order),
    )


def short_edges(panels: Parts[PanelDetails], rules: FitnessRules) -> Finding | None:
    """Edges too short for machines that grind edges or make insulating glass."""
    lengths = panels.details.edge_lengths_mm.reduced(np.minimum)
    order = worst_first(-lengths, lengths < rules.short_edges_noted_mm)
    if not len(order):
        return None
    return Finding(
        "short-edges",
        "note",
        float(lengths[order[0]]),
        rules.short_edges_noted_mm,
        "mm",
        f"{len(order)} of {len(panels)} panels have an edge shorter than {rules.short_edges_noted_mm:g} mm, the "
        f"shortest is {lengths[order[0]]:.1f} mm long at {panels[int(order[0])].mark} (face "
        f"{panels.elements[order[0]]}, counted from 0)",
        "ask the maker of the glass for the least size, or collapse short edges of the mesh",
        "face",
        _faces(panels, order),
    )


def panel_masses(panels: Parts[PanelDetails], rules: FitnessRules) -> Finding | None:
    """Masses of panels, those of all panes of a layer together, as they are lifted."""
    if not len(panels):
        return None
    places = np.stack([panels.elements, panels.details.layer], axis=1)
    units, unit = np.unique(places, axis=0, return_inverse=True)
    masses = np.asarray(np.bincount(unit.ravel(), weights=panels.masses_kg), dtype=np.float64)
    order = worst_first(masses, masses >= rules.panel_masses_noted_kg)
    if not len(order):
        return None
    return Finding(
        "panel-masses",
        "note",
        float(masses[order[0]]),
        rules.panel_masses_noted_kg,
        "kg",
        f"{len(order)} of {len(units)} panels have a mass of {rules.panel_masses_noted_kg:g} kg or more, the heaviest "
        f"one has {masses[order[0]]:.0f} kg on face {units[order[0], 0]} (counted from 0)",
        "plan a lifter for these panels, or take thinner glass or smaller faces",
        "face",
        tuple(dict.fromkeys(units[order, 0].tolist())),
    )


def _faces(panels: Parts[PanelDetails], order: IntArray) -> tuple[int, ...]:
    return tuple(dict.fromkeys(panels.elements[order].tolist()))

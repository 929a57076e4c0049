"""Fins: planar plates along the edges, such as those that shade the panels."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from fabkit.kinds.columns import files, marks_and_counts, masses, materials, of_first, over_all, stock_of_plates
from fabkit.parts import Column, Details, Kind, Measure, Parts, Surroundings
from geometry.arrays import FloatArray, IntArray

__all__ = ["FIN", "FinDetails"]


@dataclass(frozen=True, eq=False)
class FinDetails(Details):
    """Data of n fins.

    Own frame of a fin: the plate is a prism between z = 0 and z = thickness over a trapezoid; x along the edge from end
    A to end B, y outwards, the origin at the inner corner of end A. End A is the one at which the outer side is the
    longer one by the larger angle.

    nodes (n, 2): mesh vertices at ends A and B. cut_angles_deg (n, 2): angle of each end from a square one, positive
    where the outer side is the longer one. thickness_mm, height_mm, length_mm, area_mm2 (n,): length from end to end,
    area of one side. lean_deg (n,): angle between the plane of the fin and that of the beam at its edge.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, fins={"from_mm": 80, "to_mm": 300}))
    >>> fins = built.assembly["fins"].details
    >>> fins.nodes[0].tolist(), round(fins.height_mm[0]), bool(fins.lean_deg.max() < 1e-9)
    ([0, 3], 225, True)
    """

    nodes: IntArray
    cut_angles_deg: FloatArray
    thickness_mm: FloatArray
    height_mm: FloatArray
    length_mm: FloatArray
    area_mm2: FloatArray
    lean_deg: FloatArray


def _columns(fins: Parts[FinDetails], around: Surroundings) -> list[Column]:
    own, firsts = fins.details, fins.firsts
    areas = (fins.counts * own.area_mm2[firsts] * 1e-6).tolist()
    return [
        *marks_and_counts(fins),
        materials(fins),
        of_first("Thickness (mm)", 2, fins, own.thickness_mm),
        of_first("Length (mm)", 3, fins, own.length_mm),
        of_first("Height (mm)", 3, fins, own.height_mm),
        of_first("End A (deg)", 3, fins, own.cut_angles_deg[:, 0]),
        of_first("End B (deg)", 3, fins, own.cut_angles_deg[:, 1]),
        Column("Area (m2)", 4, areas, float(sum(areas))),
        *over_all("Lean (deg)", 2, fins, own.lean_deg),
        *masses(fins),
        files(fins, around.panel_file),
    ]


def _measures(fins: Parts[FinDetails]) -> list[Measure]:
    own, measure = fins.details, partial(Measure, "fins")
    return [
        measure("Length of a fin", "mm", 1, own.length_mm),
        measure("Height of a fin", "mm", 1, own.height_mm),
        measure("Lean of a fin", "°", 2, own.lean_deg),
        measure("Mass of a fin", "kg", 2, fins.masses_kg),
    ]


def _labels(fins: Parts[FinDetails], around: Surroundings) -> list[str]:
    return [f"{text}; edge {edge}" for text, edge in zip(stock_of_plates(fins), fins.elements.tolist(), strict=True)]


FIN = Kind(
    name="fin",
    group="fins",
    element="edge",
    letter="F",
    colour=(0.86, 0.67, 0.29),
    form="plate",
    first_edge="the inner one",
    cure="move the fins by fins.from_mm and fins.to_mm, make them thinner, or change their direction",
    frame=(
        "Origin at the inner corner of end A, x along the inner side to end B, y outwards; the plate lies "
        "between z = 0 and its thickness."
    ),
    empty_details=FinDetails(
        nodes=np.zeros((0, 2), dtype=np.int64),
        cut_angles_deg=np.zeros((0, 2)),
        thickness_mm=np.zeros(0),
        height_mm=np.zeros(0),
        length_mm=np.zeros(0),
        area_mm2=np.zeros(0),
        lean_deg=np.zeros(0),
    ),
    columns=_columns,
    measures=_measures,
    labels=_labels,
    stock=stock_of_plates,
)

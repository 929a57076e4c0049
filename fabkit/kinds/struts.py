"""Struts: round bars along the node axes, between the nodes of two layers of beams."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.kinds.columns import counted, files, marks_and_counts, marks_in, masses, materials, of_first
from fabkit.kinds.nodes import NODE
from fabkit.parts import Column, Details, Kind, Measure, Parts, Surroundings
from geometry.arrays import FloatArray

__all__ = ["STRUT", "StrutDetails"]


@dataclass(frozen=True, eq=False)
class StrutDetails(Details):
    """Data of n struts.

    Own frame of a strut: x along the node axis from the inner node, at which end A is, to the outer one. section (n,):
    a `Section` each. length_mm (n,): largest length. cut_angle_deg (n,): angle of end A from a square end; end B is
    square.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> layer = {"distance_mm": -400, "strut": "round 20"}
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, second_layer=layer))
    >>> struts = built.assembly["struts"]
    >>> len(struts), struts.details.section[0].name, bool((struts.details.length_mm < 400).all())
    (18, 'round 20', True)
    """

    section: npt.NDArray[Any]
    length_mm: FloatArray
    cut_angle_deg: FloatArray


def _columns(struts: Parts[StrutDetails], around: Surroundings) -> list[Column]:
    own = struts.details
    ends = [marks_in(around, nodes.kind.group, struts.elements) for nodes in around.assembly.of_layers(NODE)]
    return [
        *marks_and_counts(struts),
        Column("Section", None, [section.name for section in own.section[struts.firsts]]),
        materials(struts),
        of_first("Length (mm)", 3, struts, own.length_mm),
        of_first("End A (deg)", 3, struts, own.cut_angle_deg),
        counted("Nodes", struts, [" ".join(marks) for marks in zip(*ends, strict=True)]),
        *masses(struts),
        files(struts, "parts/{}.step"),
    ]


def _measures(struts: Parts[StrutDetails]) -> list[Measure]:
    measure = partial(Measure, "struts")
    return [
        measure("Length of a strut", "mm", 1, struts.details.length_mm),
        measure("Mass of a strut", "kg", 2, struts.masses_kg),
    ]


def _stock(struts: Parts[StrutDetails]) -> list[str]:
    return [section.name for section in struts.details.section]


def _labels(struts: Parts[StrutDetails], around: Surroundings) -> list[str]:
    names = [each.name for each in struts.materials]
    rows = zip(_stock(struts), struts.material.tolist(), struts.elements.tolist(), strict=True)
    return [f"{section}, {names[material]}; vertex {vertex}" for section, material, vertex in rows]


STRUT = Kind(
    name="strut",
    group="struts",
    element="vertex",
    letter="R",
    colour=(0.42, 0.52, 0.36),
    form="bar",
    cure="take a thinner section for second_layer.strut, or another second_layer.distance_mm",
    frame=(
        "x along the node axis from end A, at the inner node, to end B; its centre line lies at y = 0 and z = "
        "minus half its diameter, and meets end A at x = 0."
    ),
    empty_details=StrutDetails(section=np.zeros(0, dtype=object), length_mm=np.zeros(0), cut_angle_deg=np.zeros(0)),
    columns=_columns,
    measures=_measures,
    labels=_labels,
    stock=_stock,
)

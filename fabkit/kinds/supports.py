"""Supports: base plates, and the stubs between them and the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.kinds.columns import counted, files, marks_and_counts, marks_in, masses, materials, of_first
from fabkit.parts import Column, Details, Kind, Parts, Surroundings
from geometry.arrays import FloatArray

__all__ = ["BASE_PLATE", "STUB", "BasePlateDetails", "StubDetails"]

CURE = "take a longer stub (supports.length_mm), a thinner one (supports.stub) or a smaller plate (supports.plate_mm)"


@dataclass(frozen=True, eq=False)
class BasePlateDetails(Details):
    """Data of n base plates.

    Own frame of a plate: the origin in the middle of its underside, z towards the stub, x along an edge. side_mm,
    thickness_mm (n,); bores (n,): its holes in words. lean_deg (n,): angle between its normal and the node axis.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, supports={"vertices": [2]}))
    >>> plates = built.assembly["base plates"]
    >>> len(plates), plates.details.bores[0], plates.axes[:, 2].round(9).tolist()[0]
    (1, '4 x 18', [0.0, 0.0, 1.0])
    """

    side_mm: FloatArray
    thickness_mm: FloatArray
    bores: npt.NDArray[Any]
    lean_deg: FloatArray


@dataclass(frozen=True, eq=False)
class StubDetails(Details):
    """Data of n stubs.

    Own frame of a stub: x along the node axis from the node, at which end A is, to the plate. section (n,): a `Section`
    each. length_mm (n,): largest length. cut_angle_deg (n,): angle of end B from a square end; end A is square.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> own = {"vertices": [2], "length_mm": 200}
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, supports=own))
    >>> stubs = built.assembly["stubs"]
    >>> len(stubs), stubs.details.section[0].name, bool(stubs.details.length_mm[0] > 200)
    (1, 'chs 48.3x5', True)
    """

    section: npt.NDArray[Any]
    length_mm: FloatArray
    cut_angle_deg: FloatArray


def _nodes(parts: Parts[Any], around: Surroundings) -> Column:
    return counted("Nodes", parts, marks_in(around, "nodes", parts.elements))


def _plate_columns(plates: Parts[BasePlateDetails], around: Surroundings) -> list[Column]:
    own = plates.details
    return [
        *marks_and_counts(plates),
        materials(plates),
        of_first("Side (mm)", 2, plates, own.side_mm),
        of_first("Thickness (mm)", 2, plates, own.thickness_mm),
        Column("Bores", None, own.bores[plates.firsts].tolist()),
        _nodes(plates, around),
        *masses(plates),
        files(plates, "parts/{}.step"),
    ]


def _stub_columns(stubs: Parts[StubDetails], around: Surroundings) -> list[Column]:
    own = stubs.details
    return [
        *marks_and_counts(stubs),
        Column("Section", None, [section.name for section in own.section[stubs.firsts]]),
        materials(stubs),
        of_first("Length (mm)", 3, stubs, own.length_mm),
        of_first("End B (deg)", 3, stubs, own.cut_angle_deg),
        _nodes(stubs, around),
        *masses(stubs),
        files(stubs, "parts/{}.step"),
    ]


BASE_PLATE = Kind(
    name="base plate",
    group="base plates",
    element="vertex",
    letter="A",
    colour=(0.28, 0.33, 0.38),
    form="plate",
    cure=CURE,
    frame="Origin in the middle of the underside, z towards the stub, x along an edge.",
    empty_details=BasePlateDetails(
        side_mm=np.zeros(0), thickness_mm=np.zeros(0), bores=np.zeros(0, dtype=object), lean_deg=np.zeros(0)
    ),
    columns=_plate_columns,
    measures=lambda plates: [],
    labels=lambda plates, around: [f"base plate; vertex {vertex}" for vertex in plates.elements.tolist()],
)

STUB = Kind(
    name="stub",
    group="stubs",
    element="vertex",
    letter="T",
    colour=(0.33, 0.44, 0.52),
    form="bar",
    cure=CURE,
    frame=(
        "x along the node axis from end A, at the node, to end B, at the plate; its centre line lies at y = 0 "
        "and z = minus half its diameter or height, and meets end A at x = 0."
    ),
    empty_details=StubDetails(section=np.zeros(0, dtype=object), length_mm=np.zeros(0), cut_angle_deg=np.zeros(0)),
    columns=_stub_columns,
    measures=lambda stubs: [],
    labels=lambda stubs, around: [f"stub; vertex {vertex}" for vertex in stubs.elements.tolist()],
    stock=lambda stubs: [section.name for section in stubs.details.section],
)

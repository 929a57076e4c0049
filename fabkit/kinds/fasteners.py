"""End plates, and the bolts and dowels that hold them on the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.kinds.columns import counted, files, marks_and_counts, marks_in, masses, materials, of_first
from fabkit.parts import Column, Details, Kind, Parts, Surroundings
from geometry.arrays import FloatArray, IntArray

__all__ = ["BOLT", "DOWEL", "END_PLATE", "BoltDetails", "DowelDetails", "EndPlateDetails"]


@dataclass(frozen=True, eq=False)
class EndPlateDetails(Details):
    """Data of n end plates, two on each beam.

    Own frame of a plate: x along the normal of the facet, away from the node; z along the node axis; the face to the
    node at x = 0. nodes (n,): mesh vertex of each. height_mm, width_mm, thickness_mm (n,). n_bolts (n,): number of
    bores for bolts; bolt_bore_mm (n,): their diameter; bolt_pitch_mm (n,): distance of two, which are as far above the
    middle of the plate as below, NaN for one in the middle. dowel_bore_mm, dowel_depth_mm (n,): diameter of the bore
    for a dowel, and how far it is below the middle; NaN without a dowel.

    >>> from fabkit.kinds import END_PLATE
    >>> END_PLATE.letter, END_PLATE.element
    ('E', 'edge')
    """

    nodes: IntArray
    height_mm: FloatArray
    width_mm: FloatArray
    thickness_mm: FloatArray
    n_bolts: IntArray
    bolt_bore_mm: FloatArray
    bolt_pitch_mm: FloatArray
    dowel_bore_mm: FloatArray
    dowel_depth_mm: FloatArray


@dataclass(frozen=True, eq=False)
class BoltDetails(Details):
    """Data of n bolts.

    Own frame of a bolt: x along it towards the node, from the underside of its head. nodes (n,): mesh vertex of each.
    size (n,): its name, such as M20x40. tool_radius_mm, tool_length_mm (n,): of the space over its head that a socket
    needs.

    >>> from fabkit.kinds import BOLT
    >>> BOLT.letter, BOLT.group
    ('S', 'bolts')
    """

    nodes: IntArray
    size: npt.NDArray[Any]
    tool_radius_mm: FloatArray
    tool_length_mm: FloatArray


@dataclass(frozen=True, eq=False)
class DowelDetails(Details):
    """Data of n dowels, each along the x axis of its own frame towards the node. nodes (n,): mesh vertex of each.
    diameter_mm, length_mm (n,).

    >>> from fabkit.kinds import DOWEL
    >>> DOWEL.letter, DOWEL.group
    ('D', 'dowels')
    """

    nodes: IntArray
    diameter_mm: FloatArray
    length_mm: FloatArray


def _links(parts: Parts[Any], around: Surroundings) -> list[Column]:
    beams = marks_in(around, parts.kind.named("beams"), parts.elements)
    nodes = marks_in(around, parts.kind.named("nodes"), parts.details.nodes)
    return [counted("Beams", parts, beams), counted("Nodes", parts, nodes)]


def _plate_columns(plates: Parts[EndPlateDetails], around: Surroundings) -> list[Column]:
    own = plates.details
    return [
        *marks_and_counts(plates),
        materials(plates),
        of_first("Height (mm)", 2, plates, own.height_mm),
        of_first("Width (mm)", 2, plates, own.width_mm),
        of_first("Thickness (mm)", 2, plates, own.thickness_mm),
        of_first("Bolt bores", 0, plates, own.n_bolts),
        of_first("Bolt bore (mm)", 2, plates, own.bolt_bore_mm),
        of_first("Bolt pitch (mm)", 2, plates, own.bolt_pitch_mm),
        of_first("Dowel bore (mm)", 2, plates, own.dowel_bore_mm),
        of_first("Dowel below middle (mm)", 2, plates, own.dowel_depth_mm),
        *_links(plates, around),
        *masses(plates),
        files(plates, "parts/{}.step"),
    ]


def _bolt_columns(bolts: Parts[BoltDetails], around: Surroundings) -> list[Column]:
    return [
        *marks_and_counts(bolts),
        Column("Size", None, bolts.details.size[bolts.firsts].tolist()),
        materials(bolts),
        *_links(bolts, around),
        *masses(bolts),
        files(bolts, "parts/{}.step"),
    ]


def _dowel_columns(dowels: Parts[DowelDetails], around: Surroundings) -> list[Column]:
    return [
        *marks_and_counts(dowels),
        materials(dowels),
        of_first("Diameter (mm)", 2, dowels, dowels.details.diameter_mm),
        of_first("Length (mm)", 2, dowels, dowels.details.length_mm),
        *_links(dowels, around),
        *masses(dowels),
        files(dowels, "parts/{}.step"),
    ]


def _places(what: list[str], parts: Parts[Any]) -> list[str]:
    rows = zip(what, parts.elements.tolist(), parts.details.nodes.tolist(), strict=True)
    return [f"{each}; edge {edge}, at vertex {vertex}" for each, edge, vertex in rows]


END_PLATE = Kind(
    name="end plate",
    group="end plates",
    element="edge",
    letter="E",
    colour=(0.30, 0.50, 0.62),
    form="plate",
    frame="Origin in the middle of the face to the node, x away from the node, z along the node axis outwards.",
    empty_details=EndPlateDetails(
        nodes=np.zeros(0, dtype=np.int64),
        height_mm=np.zeros(0),
        width_mm=np.zeros(0),
        thickness_mm=np.zeros(0),
        n_bolts=np.zeros(0, dtype=np.int64),
        bolt_bore_mm=np.zeros(0),
        bolt_pitch_mm=np.zeros(0),
        dowel_bore_mm=np.zeros(0),
        dowel_depth_mm=np.zeros(0),
    ),
    one_per_element=False,
    columns=_plate_columns,
    measures=lambda plates: [],
    labels=lambda plates, around: _places(["end plate"] * len(plates), plates),
)

BOLT = Kind(
    name="bolt",
    group="bolts",
    element="edge",
    letter="S",
    colour=(0.75, 0.68, 0.25),
    form="pin",
    frame="Origin under the head, x along the axis towards the node.",
    empty_details=BoltDetails(
        nodes=np.zeros(0, dtype=np.int64),
        size=np.zeros(0, dtype=object),
        tool_radius_mm=np.zeros(0),
        tool_length_mm=np.zeros(0),
    ),
    one_per_element=False,
    columns=_bolt_columns,
    measures=lambda bolts: [],
    labels=lambda bolts, around: _places(bolts.details.size.tolist(), bolts),
)

DOWEL = Kind(
    name="dowel",
    group="dowels",
    element="edge",
    letter="D",
    colour=(0.55, 0.30, 0.55),
    form="pin",
    frame="Origin in the middle of the end away from the node, x along the axis towards the node.",
    empty_details=DowelDetails(
        nodes=np.zeros(0, dtype=np.int64),
        diameter_mm=np.zeros(0),
        length_mm=np.zeros(0),
    ),
    one_per_element=False,
    columns=_dowel_columns,
    measures=lambda dowels: [],
    labels=lambda dowels, around: _places(["dowel"] * len(dowels), dowels),
)

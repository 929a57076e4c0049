"""Caps on the ends of the tubes of hubs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.kinds.columns import counted, files, marks_and_counts, marks_in, masses, materials, of_first
from fabkit.parts import Column, Details, Kind, Parts, Surroundings
from geometry.arrays import FloatArray

__all__ = ["CAP", "CapDetails"]


@dataclass(frozen=True, eq=False)
class CapDetails(Details):
    """Data of n caps, round plates about the z axes of their own frames, two on each hub. diameter_mm, thickness_mm
    (n,).

    >>> from fabkit.kinds import CAP
    >>> CAP.letter, CAP.element
    ('C', 'vertex')
    """

    diameter_mm: FloatArray
    thickness_mm: FloatArray


def _columns(caps: Parts[CapDetails], around: Surroundings) -> list[Column]:
    own = caps.details
    return [
        *marks_and_counts(caps),
        materials(caps),
        of_first("Diameter (mm)", 2, caps, own.diameter_mm),
        of_first("Thickness (mm)", 2, caps, own.thickness_mm),
        counted("Nodes", caps, marks_in(around, caps.kind.named("nodes"), caps.elements)),
        *masses(caps),
        files(caps, "parts/{}.step"),
    ]


CAP = Kind(
    name="cap",
    group="caps",
    element="vertex",
    letter="C",
    colour=(0.85, 0.55, 0.25),
    form="plate",
    frame="Origin in the middle of the inner face, z along the node axis outwards, x towards facet 1.",
    empty_details=CapDetails(diameter_mm=np.zeros(0), thickness_mm=np.zeros(0)),
    one_per_element=False,
    columns=_columns,
    measures=lambda caps: [],
    labels=lambda caps, around: [f"cap; vertex {vertex}" for vertex in caps.elements.tolist()],
)

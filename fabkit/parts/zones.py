"""Zones: which parts of a structure are put up together."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fabkit.parts.parts import Parts
from geometry.arrays import IntArray, integers

__all__ = ["Zones"]


@dataclass(frozen=True, eq=False)
class Zones:
    """The zones of a structure, in the order in which they are put up; by default none.

    of_vertices (N,), of_edges (E,), of_faces (F,): the number of the zone, counted from 0, of each element of the mesh.
    An edge or vertex between several belongs to the first of them.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> zones = [{"name": "West", "faces": [0, 1, 2]}, {"name": "Others"}]
    >>> roof = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, zones=zones)).assembly
    >>> roof.zones.names, roof.zones.of_faces.tolist()[:5], roof.zones.named(roof["panels"])[2:4]
    (('West', 'Others'), [0, 0, 0, 1, 1], ['West', 'Others'])
    """

    names: tuple[str, ...] = ()
    of_vertices: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    of_edges: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    of_faces: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        for name in ("of_vertices", "of_edges", "of_faces"):
            object.__setattr__(self, name, integers(getattr(self, name)))

    def of(self, parts: Parts[Any]) -> IntArray:
        """(n,) the number of the zone of each part, 0 where there are no zones."""
        if not self.names:
            return np.zeros(len(parts), dtype=np.int64)
        elements = {"vertex": self.of_vertices, "edge": self.of_edges, "face": self.of_faces}[parts.kind.element]
        return np.asarray(elements[parts.elements])

    def named(self, parts: Parts[Any]) -> list[str]:
        """The name of the zone of each part, empty where there are no zones."""
        names = self.names or ("",)
        return [names[number] for number in self.of(parts).tolist()]

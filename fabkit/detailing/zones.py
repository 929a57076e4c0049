"""Which zone each element of the mesh belongs to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabkit.errors import DetailingError
from fabkit.parts import Zones
from fabkit.rules import ZoneRules
from geometry.arrays import IntArray
from geometry.mesh import Mesh

__all__ = ["zones_of_mesh"]


def zones_of_mesh(mesh: Mesh, rules: Sequence[ZoneRules]) -> Zones:
    """The zones that the rules choose, below_mm at the coordinates of this mesh. Raises DetailingError for a face that
    the mesh does not have or that is in no zone, and for a zone without a face."""
    if not rules:
        return Zones()
    of_faces = _of_faces(mesh, rules)
    c, none = mesh.combinatorics, len(rules)
    of_vertices, of_edges = np.full(c.n_vertices, none), np.full(c.n_edges, none)
    np.minimum.at(of_vertices, c.corners, of_faces[c.corner_face])
    np.minimum.at(of_edges, c.corner_edge, of_faces[c.corner_face])
    return Zones(tuple(zone.name for zone in rules), of_vertices % none, of_edges, of_faces)


def _of_faces(mesh: Mesh, rules: Sequence[ZoneRules]) -> IntArray:
    c = mesh.combinatorics
    of_faces = np.full(c.n_faces, -1)
    for number, zone in enumerate(rules):
        largest = max(zone.faces or (), default=0)
        if largest >= c.n_faces:
            raise DetailingError(
                f"zone {zone.name!r} has face {largest}, which the mesh does not have: faces are counted from 0 "
                f"to {c.n_faces - 1}"
            )
        of_faces[list(zone.faces or ())] = number
    heights = np.bincount(c.corner_face, weights=mesh.vertices[c.corners, 2], minlength=c.n_faces) / c.face_sizes
    for number, zone in enumerate(rules):
        if zone.below_mm is not None:
            left = of_faces < 0
            of_faces[left & (heights < zone.below_mm)] = number
            if left.any() and not (of_faces == number).any():
                raise DetailingError(
                    f"zone {zone.name!r} has no face: the lowest middle of those that no other zone has is "
                    f"{heights[left].min() - zone.below_mm:.1f} mm above its below_mm; raise it by more"
                )
    others = [number for number, zone in enumerate(rules) if not zone.chooses]
    of_faces[of_faces < 0] = others[0] if others else -1
    if len(without := np.flatnonzero(of_faces < 0)):
        raise DetailingError(
            f"{len(without)} of {c.n_faces} faces are in no zone, the first of them face {without[0]} (counted from "
            "0): add them to one, or add a zone with a name alone, which has all others"
        )
    counts = np.bincount(of_faces, minlength=len(rules))
    if len(empty := np.flatnonzero(counts == 0)):
        raise DetailingError(
            f"zone {rules[empty[0]].name!r} has no face, as none is left for it: give it faces, or take it out"
        )
    return of_faces

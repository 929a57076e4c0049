"""Marks of an earlier build: by what they are recognised, and which numbers were taken."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from fabkit.kinds.look_alikes import dot_vertices
from fabkit.parts import Measures, Parts, Ragged, SolidArray
from geometry.arrays import FloatArray, IntArray

__all__ = ["MARK_POINTS", "KeptMarks", "MarkPoints", "compared_points", "makes", "mark_points"]

MARK_POINTS = ("corner", "direction", "first corner", "first direction")
"""What the points are that are listed of a mark: of its shape, and of that under which a kept one was first given,
where it is another one."""


@dataclass(frozen=True, eq=False)
class MarkPoints:
    """By what a mark is recognised.

    material: its name, stock and finish if there are any. corners (c, 3): of its solid in mm, in its own frame, as
    `compared_points` gives them. directions (t, 3): unit vectors along the beams that stand on it.

    >>> from fabkit.production.marks import MarkPoints
    >>> MarkPoints("steel", np.zeros((8, 3)), np.eye(3)).shape
    ('steel', 8, 3)
    """

    material: str
    corners: FloatArray
    directions: FloatArray

    @property
    def shape(self) -> tuple[str, int, int]:
        """Material with its finish, and numbers of corners and directions."""
        return self.material, len(self.corners), len(self.directions)

    def apart_mm(self, other: MarkPoints, reach: float) -> float:
        """Largest difference of a coordinate from those of the same shape, of directions at this distance in mm."""
        off = np.concatenate([self.corners - other.corners, reach * (self.directions - other.directions)])
        return float(np.abs(off).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class KeptMarks:
    """The marks that a kind had in an earlier build, by their names, and its pieces.

    points: of the shape under which each mark was first given, so that a mark that is kept from build to build does
    not drift; latest: of that which it had last, where it is another one. marks: of each piece. centres_mm (n, 3):
    their centres of mass at the coordinates of the mesh file. hidden_mm (n, 2): how far each was from the shape of
    its mark, as in `Parts`.

    >>> from fabkit.production.marks import KeptMarks
    >>> KeptMarks({"NO1-B009": None, "B011": None}).next_number, KeptMarks().next_number
    (12, 1)
    """

    points: dict[str, MarkPoints] = field(default_factory=dict)
    latest: dict[str, MarkPoints] = field(default_factory=dict)
    marks: tuple[str, ...] = ()
    centres_mm: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    hidden_mm: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))

    @property
    def next_number(self) -> int:
        """The first number that none of them has, nor any larger one."""
        ends = (re.search(r"\d+$", name) for name in self.points)
        return 1 + max((int(end.group()) for end in ends if end), default=0)

    def in_the_place_of(self, centres_mm: FloatArray) -> IntArray:
        """(q,) the earlier piece in whose place there is now one with this centre (q, 3): of both, the other one is the
        nearest; -1 for none."""
        if not len(self.centres_mm) or not len(centres_mm):
            return np.full(len(centres_mm), -1, dtype=np.int64)
        nearest, back = (
            np.asarray(cKDTree(near).query(points)[1], dtype=np.int64)
            for near, points in ((self.centres_mm, centres_mm), (centres_mm, self.centres_mm))
        )
        return np.where(back[nearest] == np.arange(len(centres_mm)), nearest, -1)


def compared_points(solids: SolidArray) -> FloatArray:
    """(P, n, 3) the vertices in mm, in which equal solids agree. A rim may be anywhere on its circle; it is replaced by
    the point over its centre, outwards, at right angles to the plane of the circle, and as far as the radius."""
    rounds = solids.topology.rounds
    if not len(rounds):
        return solids.vertices
    of, points = Measures(solids.topology, solids.vertices), solids.vertices.copy()
    for end, side in ((0, -1.0), (1, 1.0)):
        rims, squares = of.rims[end], (of.rims[end] * of.rims[end]).sum(axis=0)
        outwards = side * (of.round_axes * squares - rims * of.leans[end]) / np.sqrt(squares)  # as long as the radius
        points[:, rounds[:, 2 * end + 1]] = points[:, rounds[:, 2 * end]] + np.moveaxis(outwards, 0, 2)
    return points


def makes(parts: Parts[Any]) -> list[str]:
    """The material of each part, its stock and its finish if it has any, in words."""
    words: list[Sequence[str]] = [[parts.materials[k].name for k in parts.material.tolist()]]
    words += [of(parts) for of in (parts.kind.stock, parts.kind.finishes) if of is not None]
    return [", ".join(filter(None, each)) for each in zip(*words, strict=True)]


def mark_points(parts: Parts[Any], origin_mm: FloatArray | None = None) -> KeptMarks:
    """By what the marks of these parts are recognised in a later build. origin_mm (3,): that of their assembly.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production.marks import mark_points
    >>> points = mark_points(built.assembly["nodes"]).points["N001"]
    >>> points.material, points.corners.shape[1], points.directions.shape
    ('S355', 3, (3, 3))
    """
    models = parts.firsts
    directions = Ragged.of([[]] * len(models), shape=(3,))
    if parts.kind.directions is not None:
        directions = parts.kind.directions(parts)[models]
    found: dict[int, MarkPoints] = {}
    made_of = makes(parts.take(models))
    for batch in parts.solids.by_topology(parts.shape[models]):
        points = compared_points(batch)
        if parts.kind.directions is not None:  # dots are drilled when marks are known
            points = np.delete(points, dot_vertices(batch.topology), axis=1)
        for mark, corners in zip(batch.parts.tolist(), points, strict=True):
            found[mark] = MarkPoints(made_of[mark], corners, directions[mark])
    centres = parts.centres_mm if origin_mm is None else parts.centres_mm + origin_mm
    by_name = {parts.mark_names[mark]: found[mark] for mark in sorted(found)}
    return KeptMarks(by_name, {}, tuple(parts.marks), centres, parts.hidden_mm)

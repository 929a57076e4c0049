"""Whether the geometry of a part file holds together: lines, planes, volume and area; from its text alone.

Part files of one topology are alike but for their numbers, so how they refer is read once for all of them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np

from fabkit.errors import FolderError
from geometry.arrays import FloatArray, IntArray, integers

__all__ = ["REFERENCE", "PartSolid", "measured"]

VOLUME_TOLERANCE, FACE_TOLERANCE_MM = 1e-9, 1e-6
"""Largest relative difference of a stated volume or area, and largest distance in mm of a corner from its face, that
is put down to rounding."""
_NUMBER = re.compile(r"(?<=[(,])(-?\d+\.\d*(?:E-?\d+)?)")
REFERENCE = re.compile(r"#(\d+)")


@dataclass(frozen=True)
class PartSolid:
    """What a part file says of its solid, in mm. mass_kg: of the stated volume and density; centre (3,): of mass, as
    stated; corners (V, 3); edges (E, 2, 3): the straight ones; normals (F, 3): of planar faces; rounds (C, 7): a point
    and the direction of each axis, and the radius; centres
    (n, 3): of circles and ellipses."""

    mass_kg: float
    centre: FloatArray
    corners: FloatArray
    edges: FloatArray
    normals: FloatArray
    rounds: FloatArray
    centres: FloatArray

    @cached_property
    def outline(self) -> FloatArray:
        """(k, 2) the corners at z = 0, in their order."""
        return self.corners[self.corners[:, 2] == 0.0, :2]

    @cached_property
    def upper(self) -> FloatArray:
        """(k, 2) of a plate those of its other side, else the same."""
        found = self.corners[self.corners[:, 2] == self.corners[:, 2].max(initial=0.0), :2]
        return found if len(self.corners) == 2 * len(found) == 2 * len(self.outline) else self.outline


def measured(name: str, data: str) -> PartSolid:
    """The solid of a part file, after comparing volume, area, lines and planes. data: entities, one a line. Raises
    FolderError with what is wrong."""
    texts = _NUMBER.split(data)
    numbers, of = np.array(list(map(float, texts[1::2]))), _reading("~".join(texts[::2]))
    if not of.is_whole:
        raise FolderError(f"{name} is no complete STEP file")
    if of.missing:
        raise FolderError(f"{name} refers to #{min(of.missing)}, which it does not have")
    points = numbers[of.points[:, None] + np.arange(3)]
    _check_lines(name, of, numbers)
    planes, normals = (numbers[of.planes[:, k, None] + np.arange(3)] for k in (0, 1))
    face = of.corner_face
    off = np.abs(np.einsum("ci,ci->c", points - planes[face], normals[face]))
    off = np.append(off, np.abs(np.einsum("fi,fi->f", normals, normals) - 1) / VOLUME_TOLERANCE * FACE_TOLERANCE_MM)
    if off.max(initial=0.0) > FACE_TOLERANCE_MM:
        raise FolderError(f"{name}: a face is {off.max():.3g} mm off its plane")
    stated = {key: float(numbers[place]) for key, place in of.stated}
    if of.is_plane:
        vectors = np.zeros_like(planes)
        np.add.at(vectors, face, np.cross(points, points[of.next_corner]) / 2)
        areas = np.einsum("fi,fi->f", vectors, normals)
        heights = np.einsum("fi,fi->f", planes, normals)
        for key, found in (("volume measure", heights @ areas / 3), ("surface area measure", areas.sum())):
            if abs(found - stated[key]) > VOLUME_TOLERANCE * abs(stated[key]):
                raise FolderError(f"{name} states a {key} of {stated[key]:.6g}, its faces have {found:.6g}")
    triples = np.arange(3)
    corners, every = numbers[of.vertices[:, None] + triples], numbers[of.planes[:, 1, None] + triples]
    rounds = np.concatenate(
        [numbers[of.rounds[:, k, None] + triples[:size]] for k, size in enumerate((3, 3, 1))], axis=1
    )
    edges = numbers[of.lines[:, :2, None] + triples]
    mass = stated["volume measure"] * stated["density measure"] * 1e-6
    return PartSolid(
        mass, numbers[of.centre + triples], corners, edges, every, rounds, numbers[of.centres[:, None] + triples]
    )


def _check_lines(name: str, of: _Reading, numbers: FloatArray) -> None:
    start, end, through, unit = (numbers[of.lines[:, k, None] + np.arange(3)] for k in range(4))
    off = np.abs(np.cross(end - start, unit)).max(axis=1, initial=0.0)
    if (through != start).any() or off.max(initial=0.0) > FACE_TOLERANCE_MM:
        raise FolderError(f"{name}: an edge is off its line")
    length = np.einsum("ei,ei->e", unit, unit)
    if (numbers[of.lines[:, 4]] != 1.0).any() or np.abs(length - 1).max(initial=0.0) > VOLUME_TOLERANCE:
        raise FolderError(f"{name}: the direction of an edge is no unit vector")


@dataclass(frozen=True)
class _Reading:
    """Where the numbers of a part file are, counted from its first. lines (E, 5): of the start, the end, the point and
    the direction of each straight edge, and of the length of the direction. points (C,): of the corners of the planar
    faces with straight edges only, loop after loop; corner_face (C,); planes (F, 2): of their points and normals.
    stated: of the measures; vertices: of all points of corners; rounds (C, 3): of points and directions of the axes of
    cylinders, and of their radii; centres: of circles; centre: of the centre of mass. is_whole: whether each line is an
    entity of its own number; missing: references to entities that are not there."""

    is_whole: bool
    missing: frozenset[int]

    lines: IntArray = field(default_factory=lambda: integers([]))
    points: IntArray = field(default_factory=lambda: integers([]))
    next_corner: IntArray = field(default_factory=lambda: integers([]))
    corner_face: IntArray = field(default_factory=lambda: integers([]))
    planes: IntArray = field(default_factory=lambda: integers([]))
    stated: tuple[tuple[str, int], ...] = ()
    vertices: IntArray = field(default_factory=lambda: integers([]))
    rounds: IntArray = field(default_factory=lambda: integers([]))
    centres: IntArray = field(default_factory=lambda: integers([]))
    centre: int = 0
    is_plane: bool = False


@lru_cache(maxsize=256)
def _reading(data: str) -> _Reading:
    entities, places, at = {}, {}, 0
    for line in data.splitlines():
        label, _, entity = line.partition("=")
        if label.startswith("#"):
            entities[int(label[1:])], places[int(label[1:])] = entity, at
        at += line.count("~")

    known = data.splitlines()
    is_whole = len(entities) == len(known) and all(line.endswith(";") for line in known)
    missing = frozenset(map(int, REFERENCE.findall(data))) - entities.keys()
    if missing or not is_whole:
        return _Reading(is_whole, missing)

    def refs(number: int) -> list[int]:
        return [int(found) for found in REFERENCE.findall(entities[number])]

    def named(*names: str) -> list[int]:
        return [number for number, entity in entities.items() if entity.startswith(names)]

    def straight(edge: int) -> bool:
        return entities[refs(edge)[2]].startswith("LINE")

    lines = []
    for curve in filter(straight, named("EDGE_CURVE")):
        start, end, through_line = refs(curve)
        through, pointing = refs(through_line)
        found = refs(start)[0], refs(end)[0], through, refs(pointing)[0], pointing
        lines.append([places[each] for each in found])
    points: list[int] = []
    following: list[int] = []
    faces: list[int] = []
    planes: list[list[int]] = []
    for face in named("ADVANCED_FACE"):
        *bounds, surface = refs(face)
        loops = [refs(refs(bound)[0]) for bound in bounds]
        edges = [refs(oriented)[0] for loop in loops for oriented in loop]
        if not entities[surface].startswith("PLANE") or not all(map(straight, edges)):
            continue
        point, axis, _ = refs(refs(surface)[0])
        for loop in loops:
            first = len(points)
            for oriented in loop:
                start, end, _ = refs(refs(oriented)[0])
                tail = start if entities[oriented].endswith(".T.);") else end
                points.append(places[refs(tail)[0]])
            following += [*range(first + 1, len(points)), first]
            faces += [len(planes)] * len(loop)
        planes.append([places[point], places[axis]])
    rounds = []
    for surface in named("CYLINDRICAL_SURFACE"):
        point, axis, _ = refs(refs(surface)[0])
        rounds.append([places[point], places[axis], places[surface]])
    stated = tuple((entities[each].split("'")[1], places[each]) for each in named("MEASURE_REPRESENTATION_ITEM"))
    return _Reading(
        is_whole,
        missing,
        np.array(lines, dtype=np.int64).reshape(-1, 5),
        np.array(points, dtype=np.int64),
        np.array(following, dtype=np.int64),
        np.array(faces, dtype=np.int64),
        np.array(planes, dtype=np.int64).reshape(-1, 2),
        stated,
        np.array([places[refs(each)[0]] for each in named("VERTEX_POINT")], dtype=np.int64),
        np.array(rounds, dtype=np.int64).reshape(-1, 3),
        np.array([places[refs(refs(each)[0])[0]] for each in named("CIRCLE", "ELLIPSE")], dtype=np.int64),
        places[named("CARTESIAN_POINT('centre point'")[0]],
        not rounds,
    )

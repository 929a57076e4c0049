"""Whether the geometry of a part file holds together: lines, planes, volume and area; from its text alone.

Part files of one topology are alike but for their numbers, so how they refer is read once for all of them.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from fabkit.errors import FolderError
from geometry.arrays import FloatArray, IntArray, integers

__all__ = ["NUMBER", "REFERENCE", "measured"]

VOLUME_TOLERANCE, FACE_TOLERANCE_MM = 1e-9, 1e-6
"""Largest relative difference of a stated volume or area, and largest distance in mm of a corner from its face, that
is put down to rounding."""
NUMBER = re.compile(r"-?\d+\.\d*(?:E-?\d+)?")
REFERENCE = re.compile(r"#(\d+)")


def measured(name: str, data: str) -> tuple[float, FloatArray, FloatArray]:
    """Mass in kg from the stated volume and density, the outline: (k, 2) corners at z = 0, and of a plate that of its
    upper side; after comparing volume,
    area, lines and planes. data: entities, one a line. Raises FolderError with what is wrong."""
    numbers = np.array([float(found) for found in NUMBER.findall(data)])
    of = _reading(NUMBER.sub("~", data))
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
    vertices = numbers[of.vertices[:, None] + np.arange(3)]
    mass = stated["volume measure"] * stated["density measure"] * 1e-6
    lower, upper = (vertices[vertices[:, 2] == level, :2] for level in (0.0, vertices[:, 2].max(initial=0.0)))
    is_plate = len(vertices) == 2 * len(lower) == 2 * len(upper)
    return mass, lower, upper if is_plate else lower


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
    stated: of the measures; vertices: of all points of corners. is_whole: whether each line is an entity of its own
    number; missing: references to entities that are not there."""

    is_whole: bool
    missing: frozenset[int]

    lines: IntArray = field(default_factory=lambda: integers([]))
    points: IntArray = field(default_factory=lambda: integers([]))
    next_corner: IntArray = field(default_factory=lambda: integers([]))
    corner_face: IntArray = field(default_factory=lambda: integers([]))
    planes: IntArray = field(default_factory=lambda: integers([]))
    stated: tuple[tuple[str, int], ...] = ()
    vertices: IntArray = field(default_factory=lambda: integers([]))
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
        not named("CYLINDRICAL_SURFACE"),
    )

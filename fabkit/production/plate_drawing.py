"""Drawings of plates other than panels for cutting machines: the outline and the holes of their larger side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import shapely

from fabkit.kinds import PANEL
from fabkit.parts import BORE, Assembly, Curves, Measures, Parts, SolidArray
from fabkit.production.drawing import CUT, MARK, Drawing, middle_labels
from geometry.arrays import FloatArray

__all__ = ["plate_drawings"]

EQUAL_AREAS = 1e-9
"""Difference of the areas of two sides of a plate, over the area, up to which neither is the larger: rounding."""

UPRIGHT_COSINE = 0.9
"""Cosine of the angle between the z axis of a plate and the normal of its side from which on its y axis is upwards in
the drawing, and not its z axis."""

CORNERS_OF_CIRCLES = 32
"""Number of corners of the circles between which a mark is placed."""

NOTES = (
    "Contours are nominal, without allowance for the kerf.",
    "Millimetres. Layers: CUT contour and holes through the plate, MARK open strokes and holes that end in the plate, "
    "TITLE text.",
)


def plate_drawings(assembly: Assembly, *, labels: bool = True, title: str = "") -> tuple[Drawing, ...]:
    """One drawing for each mark of all plates but panels, named like the mark: the outline of the larger side, seen
    from outside, with z upwards in its own frame, or y where that is towards the eye. Holes through the plate are
    circles on CUT, or curves where they have corners; those that end in it are on MARK.

    labels: whether the mark is engraved, where most room is; title: first words below each drawing.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> bolted = {"section": "rhs 120x60x5"}, {"kind": "bolted"}
    >>> project = Project(mesh=dome(12, 3), mean_edge_mm=2000, beams=bolted[0], connection=bolted[1])
    >>> from fabkit.production import CUT, plate_drawings
    >>> drawing = plate_drawings(design(project).assembly)[0]
    >>> drawing.name, len(drawing.layers[CUT]), drawing.circles[CUT][:, 2].tolist()
    ('E001', 1, [11.0, 5.0])
    """
    groups = [group for group in assembly.groups if group.kind.form == "plate" and group.kind is not PANEL]
    return tuple(drawing for group in groups for drawing in _of_group(group, labels, title))


def _of_group(parts: Parts[Any], labels: bool, title: str) -> Iterator[Drawing]:
    sides: dict[int, _Side] = {}
    for batch in parts.solids.by_topology(parts.shape[parts.firsts]):
        of = Measures(batch.topology, batch.vertices)
        sides |= {number: _side(batch, of, row) for row, number in enumerate(batch.parts.tolist())}
    ordered = [sides[number] for number in range(len(parts.mark_names))]
    strokes = _labels(parts.mark_names, ordered) if labels and ordered else [Curves.of([])] * len(ordered)
    made_of = [parts.materials[k].name for k in parts.material[parts.firsts].tolist()]
    for mark, material, (curves, circles, thickness), own in zip(
        parts.mark_names, made_of, ordered, strokes, strict=True
    ):
        words = (title, f"{thickness:.6g} mm {material}, {parts.kind.name} {mark}")
        layers = {CUT: curves[CUT], MARK: Curves.joined([curves[MARK], own])}
        yield Drawing(mark, layers, NOTES, words if title else (), circles)


_Side = tuple[dict[str, Curves], dict[str, FloatArray], float]
"""Closed curves and circles of the larger side of a plate by layer, and the thickness of the plate there."""


def _side(batch: SolidArray, of: Measures, row: int) -> _Side:
    t, vertices = batch.topology, batch.vertices[row]
    face, opposite = _larger_side(of, row)
    normal = of.normals[row, face]
    up = np.array([0.0, 1, 0] if abs(normal[2]) > UPRIGHT_COSINE else [0.0, 0, 1])
    x = np.cross(up, normal)
    x /= np.linalg.norm(x)
    flat = vertices @ np.stack([x, np.cross(normal, x)], axis=1)
    levels = vertices @ normal
    curves: dict[str, list[FloatArray]] = {CUT: [], MARK: []}
    circles: dict[str, list[list[float]]] = {CUT: [], MARK: []}
    for loop in t.loops(face):
        curves[CUT].append(np.concatenate([flat[loop], flat[loop[:1]]]))
    for k, (*centres, first, second, sense) in enumerate(t.rounds[:, [0, 2, 4, 5, 6]].tolist()):
        if face in (first, second):
            centre = flat[centres[0] if first == face else centres[1]]
            is_cut = sense != BORE or {first, second} == {face, opposite}
            circles[CUT if is_cut else MARK].append([*centre.tolist(), float(of.radii[row, k])])
    thickness = float(levels[t.face_vertex[face]] - levels[t.face_vertex[opposite]])
    rings = {layer: np.array(own, dtype=np.float64).reshape(-1, 3) for layer, own in circles.items()}
    return {layer: Curves.of(own) for layer, own in curves.items()}, rings, thickness


def _larger_side(of: Measures, row: int) -> tuple[int, int]:
    """The side with the larger outline, of equal ones that with more holes, and of these the second; and the other."""
    t = of.topology
    first = int(of.areas[row].argmax())
    second = int((of.normals[row] @ of.normals[row, first]).argmin())
    sizes, holes = [], []
    for face in sorted((first, second)):
        ends = [k for k in range(len(t.rounds)) if face in t.rounds[k, 4:6]]
        loops = t.loops(face)
        holes.append(len(ends) + len(loops))
        normal = of.normals[row, face]
        points = of.points[:, row].T[loops[0]] if loops else np.zeros((0, 3))
        polygon = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0) @ normal / 2
        sizes.append(polygon if loops else np.pi * of.radii[row, t.outer_round[face]] ** 2)
    if abs(sizes[0] - sizes[1]) > EQUAL_AREAS * max(sizes):
        second_is_larger = sizes[1] > sizes[0]
    else:
        second_is_larger = holes[1] >= holes[0]
    low, high = sorted((first, second))
    return (high, low) if second_is_larger else (low, high)


def _labels(marks: Sequence[str], sides: Sequence[_Side]) -> list[Curves]:
    """The marks, each in the middle of the largest circle that has neither the outline nor a hole in it."""
    angles = 2 * np.pi * np.arange(CORNERS_OF_CIRCLES) / CORNERS_OF_CIRCLES
    unit = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    shapes = []
    for curves, circles, _ in sides:
        rings = [*curves[CUT], *(ring[:2] + ring[2] * unit for own in circles.values() for ring in own)]
        outer = int(np.argmax([np.ptp(ring, axis=0).prod() for ring in rings]))
        shapes.append(shapely.Polygon(rings[outer], [ring for k, ring in enumerate(rings) if k != outer]))
    found = shapely.get_coordinates(shapely.maximum_inscribed_circle(shapes)).reshape(-1, 2, 2)
    strokes, plate = middle_labels(marks, found[:, 0], np.linalg.norm(found[:, 1] - found[:, 0], axis=1)).strokes()
    return strokes.grouped(plate, len(sides))

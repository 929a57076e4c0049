"""What the text of a STEP file says of each part where it stands: corners, cylinders, mass; without fabkit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from geometry.arrays import FloatArray
from tests.fabkit.part21 import StepText, coordinates

__all__ = ["Cylinder", "PlacedPart", "across", "apart", "hull_volume", "placed_parts"]


@dataclass(frozen=True)
class Cylinder:
    """A round face. ends (2, 3): the centres of its edges; is_bore: whether material is outside."""

    ends: FloatArray
    radius: float
    is_bore: bool

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    @property
    def axis(self) -> FloatArray:
        return np.asarray((self.ends[1] - self.ends[0]) / self.length)

    @property
    def volume(self) -> float:
        return float(np.pi * self.radius**2 * self.length)

    def rims(self, n: int = 360) -> FloatArray:
        """(2, n, 3) points of both edges."""
        x = np.cross(self.axis, np.eye(3)[np.abs(self.axis).argmin()])
        x /= np.linalg.norm(x)
        turns = 2 * np.pi * np.arange(n)[:, None] / n
        circle = self.radius * (np.cos(turns) * x + np.sin(turns) * np.cross(self.axis, x))
        return np.asarray(self.ends[:, None] + circle)

    def distances(self, points: FloatArray) -> FloatArray:
        """(m,) of points (m, 3) outside the solid cylinder from it."""
        from_end = points - self.ends[0]
        along = from_end @ self.axis
        beside = np.linalg.norm(from_end - along[:, None] * self.axis, axis=1) - self.radius
        beyond = np.maximum(-along, along - self.length)
        return np.asarray(np.hypot(np.maximum(beside, 0), np.maximum(beyond, 0)))


@dataclass(frozen=True)
class PlacedPart:
    """corners (n, 3) of its straight edges where it stands, own (n, 3) in its own frame; cylinders where it stands;
    outlines: corners (m, 3) of the first polygon of each planar face; density: in kg/m3."""

    corners: FloatArray
    own: FloatArray
    cylinders: list[Cylinder]
    outlines: list[FloatArray]
    density: float
    stated_volume: float


def placed_parts(file: StepText) -> dict[str, PlacedPart]:
    """By the names of the instances."""
    found, shapes = {}, {}
    stated = dict(_stated(file))
    for link in file.all("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
        leaves = dict(file[link.values[0]].values)
        usage = file[file[link.values[1]].values[2]]
        child, product = leaves["REPRESENTATION_RELATIONSHIP"][2], int(usage.values[4])
        end = file[leaves["REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"][0]].values[3]
        origin, z, x = (coordinates(file, each) for each in file[end].values[1:])
        frame = np.stack([x, np.cross(z, x), z])
        if child not in shapes:
            shapes[child] = _Shape(file, child)
        own = shapes[child]
        if not own.faces:
            continue  # of a group
        found[usage.values[1]] = PlacedPart(
            origin + own.corners @ frame,
            own.corners,
            [Cylinder(origin + each.ends @ frame, each.radius, each.is_bore) for each in own.cylinders],
            [origin + outline @ frame for outline in own.outlines],
            *stated[product],
        )
    return found


def _stated(file: StepText) -> Iterator[tuple[int, tuple[float, float]]]:
    """Density in kg/m3 and volume in mm3 by product definition."""
    shape_of = {n: int(each.values[2]) for n, each in file.instances.items() if each.kind == "PRODUCT_DEFINITION_SHAPE"}
    density, volume = {}, {}
    for link in file.all("PROPERTY_DEFINITION_REPRESENTATION"):
        name, what, of = file[link.values[0]].values
        items = file[link.values[1]].values[1]
        if what == "density":
            density[int(of)] = 1000 * float(file[items[0]].values[1])
        elif name == "geometric validation property":
            volume[shape_of[of]] = float(file[items[0]].values[1])
    yield from ((product, (density[product], volume[product])) for product in volume)


class _Shape:
    """Of one representation in its own frame."""

    def __init__(self, file: StepText, representation: int) -> None:
        self.file, self.faces = file, [n for n in set(_below(file, representation)) if file[n].kind == "ADVANCED_FACE"]
        corners, self.cylinders, self.outlines = {}, [], []
        for face in sorted(self.faces):
            bounds, surface, same_sense = file[face].values[1:]
            lines = [self._edges(bound) for bound in bounds]
            for start, end, curve in (edge for loop in lines for edge in loop):
                if file[curve].kind == "LINE" and file[file[face].values[2]].kind == "PLANE":
                    corners |= {n: coordinates(file, file[n].values[1]) for n in (start, end)}
            if file[surface].kind == "PLANE":
                loop = [edge for edge in lines[0] if file[edge[2]].kind == "LINE"]
                if loop:
                    self.outlines.append(np.array([corners[start] for start, _, _ in loop]))
            else:
                circles = [curve for loop in lines for _, _, curve in loop if file[curve].kind == "CIRCLE"]
                centres = np.array([coordinates(file, file[file[each].values[1]].values[1]) for each in circles])
                ends = centres[[0, int(np.linalg.norm(centres - centres[0], axis=1).argmax())]]
                self.cylinders.append(Cylinder(ends, float(file[surface].values[2]), not same_sense))
        self.corners = np.array(list(corners.values())).reshape(-1, 3)

    def _edges(self, bound: int) -> list[tuple[int, int, int]]:
        """First and last vertex, and curve, of the edges of a loop, as the loop runs."""
        found = []
        for oriented in self.file[self.file[bound].values[1]].values[1]:
            edge, forwards = self.file[oriented].values[3:]
            start, end, curve = self.file[edge].values[1:4]
            found.append((start, end, curve) if forwards else (end, start, curve))
        return found


def _below(file: StepText, at: int) -> Iterator[int]:
    """All ids that an instance refers to, and those to which they refer."""
    seen, todo = set(), [at]
    while todo:
        one = todo.pop()
        if one not in seen:
            seen.add(one)
            yield one
            todo += file.references(file[one].values)


def apart(one: Cylinder, other: Cylinder) -> float:
    """Least distance between the solids of two cylinders, from points of their edges and sides."""
    shares = np.linspace(0, 1, 41)[:, None, None]
    points = [(c.rims()[0] * (1 - shares) + c.rims()[1] * shares).reshape(-1, 3) for c in (one, other)]
    return float(min(other.distances(points[0]).min(), one.distances(points[1]).min()))


def across(axis: FloatArray) -> FloatArray:
    """(3, 2) the view along an axis."""
    x = np.cross(axis, [0.3, 0.5, -0.8])
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x)], axis=1)


def hull_volume(points: FloatArray) -> float:
    return float(ConvexHull(points).volume)

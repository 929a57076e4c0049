"""Curves of a network traced on a surface itself, evenly spaced, to take away as polylines."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import GeometryError
from geometry.layout.quads import affine_map
from geometry.surface import Surface, on_curved_triangles
from geometry.traced_curves.even_spacing import OPPOSITE_SIDE_SHARE, SEED_DISTANCE, Coverage, SampledCurve
from geometry.traced_curves.line_fields import LineField
from geometry.traced_curves.walks import Walks, walk

__all__ = ["CurveKind", "TracedCurves", "trace_curves"]

CurveKind = Literal["principal", "asymptotic"]
"""Lines of curvature, of the surface or of an affine image of it; or lines without normal curvature."""

FIRST_SEEDS = 12
"""Seeds of the curves of which the longest is crossed by the first curves of the other family."""

LONGEST_CURVE = 4.0
"""Largest length of a curve from its seed, over the extent of the surface: curves that wind about it end there, and
others continue."""

MOST_SQUARES = 200_000
"""Squares of the spacing that fit into the area of the surface, at most: more would take minutes."""

SAME_POINT_SHARE = 1e-9
"""Distance of two points that follow each other over the spacing of curves, up to which they are one but for rounding:
a curve that begins on a side of a triangle, or passes a vertex, has several there."""

LEAST_GAP_SHARE = 0.5
"""Distance over the spacing of curves, within which no second curve is begun in a gap where one was too short."""


@dataclass(frozen=True, eq=False)
class TracedCurves:
    """Polylines (k, 3) on a surface; families (n,): 0 or 1; lengths (n,); is_closed (n,): whether the last point of a
    curve is its first one.

    Principal curves of family 0 have the larger normal curvature, with its sign, those of family 1 the smaller one.
    Asymptotic curves of family 0 run to the left of the direction of larger curvature.

    >>> from geometry import Surface, trace_curves
    >>> from geometry.mesh import shapes
    >>> barrel = Surface(shapes.rotational_mesh([[2, 0.3 * k] for k in range(10)], 60, closed=False))
    >>> curves = trace_curves(barrel, spacing=0.5)
    >>> round(float(curves.lengths[curves.families == 0].max()), 1)  # rulings; circles bend the other way
    2.7
    """

    __repr__ = short_repr

    polylines: tuple[FloatArray, ...]
    families: IntArray
    is_closed: BoolArray

    @cached_property
    def lengths(self) -> FloatArray:
        return floats([np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in self.polylines])

    @property
    def by_family(self) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
        """The polylines of the two families."""
        first, second = (
            tuple(line for line, each in zip(self.polylines, self.families.tolist(), strict=True) if each == family)
            for family in (0, 1)
        )
        return first, second


def trace_curves(
    surface: Surface, *, spacing: float, kind: CurveKind = "principal", affine: Any = None
) -> TracedCurves:
    """Two families of curves on a surface, each some `spacing` from the next one of its family.

    kind: "principal", lines of curvature, or, with affine (3, 3), the conjugate curves that become lines of curvature
    of the image of the surface; or "asymptotic", along which the surface does not bend, where it is saddle-shaped.
    Curves end at the boundary, where they come nearer to another one than 0.6 times the spacing, and where their
    direction is not determined: near umbilics, on flat parts, asymptotic ones at the edge of saddle-shaped parts. One
    that comes back to its beginning within a tenth of the spacing is closed.

    The error of a curve falls with the square of the edge length of the triangles; the points are on the smooth surface
    through their vertices, or on the exact surface.

    Raises GeometryError where the surface has no such curves, for an invalid spacing or map, and where the spacing is
    so small that there would be very many curves.

    >>> import numpy as np
    >>> from geometry import Mesh, Surface, trace_curves
    >>> turn, across = np.meshgrid(np.linspace(0, 3, 31), np.linspace(-1, 1, 15), indexing="ij")
    >>> helicoid = Mesh.from_grid(np.stack([across * np.cos(turn), across * np.sin(turn), turn], axis=2))
    >>> curves = trace_curves(Surface(helicoid), spacing=0.25, kind="asymptotic")
    >>> rulings, helices = curves.by_family
    >>> len(rulings) > 5, len(helices) > 5
    (True, True)
    >>> bool(max(np.ptp(line[:, 2]) for line in rulings) < 0.1)  # they are level, up to the size of the quads
    True
    """
    if not isinstance(surface, Surface):
        raise GeometryError(f"the surface is a {type(surface).__name__}: wrap the mesh in Surface(mesh)")
    if kind not in get_args(CurveKind):
        raise GeometryError(f"the kind of curves is {kind!r}: it is 'principal' or 'asymptotic'")
    if kind == "asymptotic" and affine is not None:
        raise GeometryError("asymptotic curves are the same under all affine maps: leave out the map")
    mesh, origin = surface.triangulated.near_zero()
    _check_spacing(spacing, float(np.linalg.norm(mesh.vector_areas, axis=1).sum()))
    field = LineField.of(mesh, affine_map(affine), is_asymptotic=kind == "asymptotic")
    found = _Tracer(Surface(mesh), field, float(spacing)).evenly_spaced()
    if not found:
        raise GeometryError(_none_found(field, spacing))
    normals = mesh.vertex_normals
    ends = np.cumsum([len(curve.triangles) for curve in found])[:-1]
    at, weights = (np.concatenate([getattr(curve, name) for curve in found]) for name in ("triangles", "weights"))
    points = on_curved_triangles(mesh, normals, at, weights) + origin
    if surface.is_exact:
        points = surface.closest(points)[0]
    return TracedCurves(
        tuple(_without_repeats(line, SAME_POINT_SHARE * spacing) for line in np.split(points, ends)),
        integers([curve.family for curve in found]),
        np.array([curve.is_closed for curve in found]),
    )


def _without_repeats(line: FloatArray, least: float) -> FloatArray:
    """The points (k, 3) of a curve without inner ones that coincide with a neighbour."""
    apart = np.asarray(np.linalg.norm(np.diff(line, axis=0), axis=1) > least)
    kept = np.concatenate([[True], apart[:-1], [True]])
    kept[1:-1][-1:] &= apart[-1]
    return floats(line[kept])


def _check_spacing(spacing: object, area: float) -> None:
    if not isinstance(spacing, (int, float, np.integer, np.floating)) or not 0 < spacing < np.inf:
        raise GeometryError(f"the spacing of curves is {spacing!r}: a number above 0 is needed")
    squares = area / float(spacing) ** 2
    if not 1 <= squares <= MOST_SQUARES:
        raise GeometryError(
            f"the spacing of curves is {spacing:.4g} on a surface of area {area:.4g}: give one between "
            f"{np.sqrt(area / MOST_SQUARES):.3g} and {np.sqrt(area):.3g}",
            value=float(spacing),
        )


def _none_found(field: LineField, spacing: float) -> str:
    n = field.frames.n_triangles
    middle = np.full((n, 3), 1 / 3)
    exists = field.directions(np.arange(n), middle, np.zeros(n, dtype=np.int64))[1]
    if exists.any():
        return f"no curve is longer than the spacing of {spacing:.4g}: give a smaller one"
    if field.is_asymptotic:
        return "the surface is nowhere saddle-shaped, so that it has no asymptotic curves: trace principal ones"
    return "the surface is plane or spherical, so that all its lines are principal: any curves will do"


@dataclass(frozen=True, eq=False)
class _Curve:
    """A curve of a family: its points by triangles (k,) and barycentric weights (k, 3)."""

    triangles: IntArray
    weights: FloatArray
    family: int
    is_closed: bool


@dataclass(frozen=True, eq=False)
class _Seeds:
    """Points (n, 3) by triangles (n,) and weights (n, 3), with normals (n, 3), where curves of families (n,) begin."""

    points: FloatArray
    normals: FloatArray
    triangles: IntArray
    weights: FloatArray
    families: IntArray

    def take(self, chosen: Any) -> _Seeds:
        return _Seeds(
            *(each[chosen] for each in (self.points, self.normals, self.triangles, self.weights, self.families))
        )


@dataclass(frozen=True, eq=False)
class _Tracer:
    """Takes in curves round after round: beside those of the round before, and where there is none, in gaps."""

    surface: Surface
    field: LineField
    spacing: float

    def evenly_spaced(self) -> list[_Curve]:
        coverages = (Coverage(self.spacing), Coverage(self.spacing))
        is_tried = np.zeros((2, self.field.frames.n_triangles), dtype=bool)
        found: list[_Curve] = []
        seeds = self._across_the_longest(self._gaps(coverages, is_tried))
        while len(seeds.families):
            added = self._accepted(seeds, coverages)
            found += added
            seeds = self._beside(added, coverages) if added else self._gaps(coverages, is_tried)
            if added and not len(seeds.families):
                seeds = self._gaps(coverages, is_tried)
        return found

    def _accepted(self, seeds: _Seeds, coverages: tuple[Coverage, Coverage]) -> list[_Curve]:
        """The curves through the seeds, as far as there is room for them."""
        walks = self._walks(seeds)
        accepted = []
        for family in (0, 1):
            numbers = np.flatnonzero(seeds.families == family).tolist()
            numbers = [k for k in numbers if walks.starts[k + 1] - walks.starts[k] > 1]
            sampled = [self._sampled(walks, k, seeds.points[k]) for k in numbers]
            for which, low, high in coverages[family].accept(sampled):
                k, arc = numbers[which], sampled[which].arc
                kept = walks.starts[k] + np.flatnonzero((arc >= low) & (arc <= high))
                whole = low <= 0 and high >= arc[-1]
                if len(kept) > 1:
                    is_closed = bool(walks.is_closed[k]) and whole
                    accepted.append(_Curve(walks.triangles[kept], walks.weights[kept], family, is_closed))
        return accepted

    def _walks(self, seeds: _Seeds) -> Walks:
        extent = float(np.linalg.norm(np.ptp(self.surface.mesh.vertices, axis=0)))
        longest = LONGEST_CURVE * extent
        return walk(self.field, seeds.triangles, seeds.weights, seeds.families, spacing=self.spacing, longest=longest)

    def _sampled(self, walks: Walks, number: int, seed: FloatArray) -> SampledCurve:
        own = slice(int(walks.starts[number]), int(walks.starts[number + 1]))
        points, normals = self._placed(walks.triangles[own], walks.weights[own])
        nearest = int(np.linalg.norm(points - seed, axis=1).argmin())
        return SampledCurve.of(points, normals, nearest, bool(walks.is_closed[number]), self.spacing)

    def _placed(self, triangles: IntArray, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points and unit normals (n, 3)."""
        corners, mesh = self.field.frames.triangles[triangles], self.surface.mesh
        points, normals = (
            np.einsum("nk,nki->ni", weights, each[corners]) for each in (mesh.vertices, mesh.vertex_normals)
        )
        return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)

    # --- where curves begin

    def _at(self, points: FloatArray, families: IntArray, within: float) -> _Seeds:
        """Those of the points (n, 3) that are nearer to the surface than `within`, on it."""
        feet, triangles, normals, weights = self.surface.locate(points)
        near = np.linalg.norm(feet - points, axis=1) < within
        return _Seeds(feet, normals, triangles, weights, families).take(near)

    def _free(self, seeds: _Seeds, coverages: tuple[Coverage, Coverage]) -> BoolArray:
        """(n,) whether seeds are far enough from the curves so far."""
        six = np.concatenate([seeds.points, OPPOSITE_SIDE_SHARE * self.spacing * seeds.normals], axis=1)
        distances = np.choose(seeds.families, [coverage.distances(six) for coverage in coverages])
        return np.asarray(distances >= SEED_DISTANCE * self.spacing)

    def _beside(self, curves: list[_Curve], coverages: tuple[Coverage, Coverage]) -> _Seeds:
        """Points at the spacing from the curves, on both sides, as far as they are free; one in each cube."""
        places, families = [], []
        for curve in curves:
            points, along, normals = self._every_spacing(*self._placed(curve.triangles, curve.weights))
            across = self.spacing * np.cross(normals, along)
            places += [points + across, points - across]
            families.append(np.full(2 * len(points), curve.family))
        seeds = self._at(np.concatenate(places), np.concatenate(families), self.spacing / 2)
        seeds = seeds.take(self._free(seeds, coverages))
        cubes = np.floor(seeds.points / (1.5 * self.spacing)).astype(np.int64)
        keys = np.concatenate([cubes, seeds.families[:, None]], axis=1)
        return seeds.take(np.sort(np.unique(keys, axis=0, return_index=True)[1]))

    def _every_spacing(self, points: FloatArray, normals: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points, unit tangents and normals (m, 3) of a curve (k, 3) at distances of the spacing along it."""
        steps = np.diff(points, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        arc = np.concatenate([[0.0], np.cumsum(lengths)])
        count = max(round(arc[-1] / self.spacing), 1)
        places = (np.arange(count) + 0.5) / count * arc[-1]
        part = np.searchsorted(arc, places, side="right").clip(1, len(steps)) - 1
        along = steps[part] / lengths[part, None]
        return points[part] + (places - arc[part])[:, None] * along, along, normals[part]

    def _gaps(self, coverages: tuple[Coverage, Coverage], is_tried: BoolArray) -> _Seeds:
        """Centres of triangles far from all curves so far and from each other; they are marked as tried."""
        n, centres = self.field.frames.n_triangles, self.field.frames.centres
        chosen = []
        for family in (0, 1):
            families = np.full(n, family)
            seeds = _Seeds(centres, self.surface.mesh.face_normals, np.arange(n), np.full((n, 3), 1 / 3), families)
            exists = self.field.directions(seeds.triangles, seeds.weights, families)[1]
            free = np.flatnonzero(exists & ~is_tried[family] & self._free(seeds, coverages))
            far = np.full(len(free), np.inf)
            for _ in range(min(FIRST_SEEDS, len(free))):
                place = int(far.argmax())
                if far[place] < 2 * self.spacing:
                    break
                distances = np.linalg.norm(centres[free] - centres[free[place]], axis=1)
                far = np.minimum(far, distances)
                is_tried[family, free[distances <= LEAST_GAP_SHARE * self.spacing]] = True
                chosen.append(seeds.take(free[place : place + 1]))
        return _joined(chosen)

    def _across_the_longest(self, seeds: _Seeds) -> _Seeds:
        """Points at the spacing along the longest curve of each family, where curves of the other family begin."""
        curves = self._accepted(seeds, (Coverage(self.spacing), Coverage(self.spacing)))
        chosen = []
        for family in (0, 1):
            own = [self._placed(curve.triangles, curve.weights) for curve in curves if curve.family == family]
            if own:
                points, normals = max(own, key=lambda each: np.linalg.norm(np.diff(each[0], axis=0), axis=1).sum())
                places, _, _ = self._every_spacing(points, normals)
                chosen.append(self._at(places, np.full(len(places), 1 - family), self.spacing))
        return _joined(chosen) if chosen else seeds


def _joined(parts: list[_Seeds]) -> _Seeds:
    if not parts:
        none = np.zeros((0, 3))
        return _Seeds(none, none, np.zeros(0, dtype=np.int64), none, np.zeros(0, dtype=np.int64))
    names = ("points", "normals", "triangles", "weights", "families")
    return _Seeds(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

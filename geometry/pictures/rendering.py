"""Polygons in space to pixels: a depth buffer, light, shadow, and outlines that belong to their faces.

Every pixel is sampled `OVERSAMPLING` times in each direction. A sample first finds its nearest triangle; colour,
outline and shadow are looked up only then. Translucent polygons are peeled off layer by layer.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.colours import ColourScale

__all__ = ["Camera", "Polygons", "View", "fit", "render"]

OVERSAMPLING = 2
"""Samples of a pixel in each direction."""

TRANSLUCENT_LAYERS = 8
"""Translucent polygons that are seen behind each other, at most."""

LIGHT = np.array([-0.45, 0.55, 0.8])
"""Where the light comes from: right, up and towards the viewer."""

AMBIENT_LIGHT = 0.65
"""Light from all sides, as a part of the light that leaves colours as they are."""

SKY_LIGHT = 0.11
"""More of it where a side faces upwards, less where it faces downwards."""

SUN_LIGHT = 0.36
"""Light from one side, which casts shadows."""

SHADOW_STRENGTH = 0.8
"""Part of the light from one side that a shadow takes."""

LARGEST_SHADOW = 800
"""Pixels along a side of the picture that the light sees, at most: shadows are soft."""

SAMPLES_IN_MEMORY = 2_000_000
"""Samples of triangles that are computed together, which bounds the memory."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """n polygons with k corners (n, k, 3), as near to convex as a fan of triangles needs.

    normals (n, k, 3) at the corners; colour and back (n, k, 3) there of the side they point to and of the other one.
    outline (n, k): widths in pixels of the lines along the edges that start at the corners; ink (n, k, 3): their
    colours. scale: where it is given, colour and back are values (n, k, 1), of which it makes colours pixel by pixel.
    """

    corners: FloatArray
    normals: FloatArray
    colour: FloatArray
    back: FloatArray
    outline: FloatArray
    ink: FloatArray
    opacity: float = 1.0
    scale: ColourScale | None = None

    @property
    def triangles(self) -> FloatArray:
        """(n (k - 2), 3, 3), polygon after polygon."""
        return self.at_triangles(self.corners)

    def at_triangles(self, values: FloatArray) -> FloatArray:
        """(n (k - 2), 3, c) values (n, k, c) of corners at those of the triangles."""
        k = values.shape[1]
        rank = np.stack([np.zeros(k - 2, dtype=int), np.arange(1, k - 1), np.arange(2, k)], axis=1)
        return values[:, rank].reshape(-1, 3, values.shape[2])


@dataclass(frozen=True)
class View:
    """From where one looks: degrees about z, degrees above the horizon; distance of the eye over the picture's size."""

    azimuth: float
    elevation: float
    distance: float = 6.0

    @property
    def axes(self) -> FloatArray:
        """(3, 3) rows: right, up, towards the viewer."""
        a, e = np.radians([self.azimuth, self.elevation])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        back = np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])
        return np.stack([right, np.cross(back, right), back])


@dataclass(frozen=True, eq=False)
class Camera:
    """Points in space to (column, row, depth) in pixels, depth towards the viewer; planes stay planes."""

    axes: FloatArray
    centre: FloatArray
    scale: float
    middle: FloatArray
    eye: float

    def project(self, points: FloatArray) -> FloatArray:
        local = (points - self.centre) @ self.axes.T * self.scale
        local = local / (1 - local[..., 2:] / self.eye)
        return local * [1, -1, 1] + self.middle

    def unproject(self, pixels: FloatArray) -> FloatArray:
        local = (pixels - self.middle) * [1, -1, 1]
        local = local / (1 + local[..., 2:] / self.eye)
        points: FloatArray = local / self.scale @ self.axes + self.centre
        return points

    def finer(self) -> Camera:
        return replace(
            self, scale=self.scale * OVERSAMPLING, middle=self.middle * OVERSAMPLING, eye=self.eye * OVERSAMPLING
        )


def fit(view: View, points: FloatArray, width: float, height: float, scale: float | None = None) -> Camera:
    """The camera that shows the points (n, 3) in the middle of width x height pixels, as large as fits or to scale."""
    local = points @ view.axes.T
    centre = (local.min(axis=0) + local.max(axis=0)) / 2 @ view.axes
    size = float(np.ptp(local, axis=0).max())
    unit = Camera(view.axes, centre, 1.0, np.zeros(3), view.distance * size)
    flat = unit.project(points)[:, :2]
    low, high = flat.min(axis=0), flat.max(axis=0)
    scale = scale or float((np.array([width, height]) / (high - low)).min())
    middle = np.append(np.array([width, height]) / 2 - scale * (low + high) / 2, 0.0)
    return Camera(view.axes, centre, scale, middle, view.distance * size * scale)


def render(shapes: Sequence[Polygons], camera: Camera, width: int, height: int, *, shadows: bool = True) -> FloatArray:
    """(height, width, 4) colours, premultiplied by their opacity; whether shapes cast shadows on each other."""
    fine = camera.finer()
    rows, columns = height * OVERSAMPLING, width * OVERSAMPLING
    triangles = fine.project(np.concatenate([shape.triangles for shape in shapes]))
    shadow_size = min(max(rows, columns), LARGEST_SHADOW * OVERSAMPLING)
    shadow = _Shadow.of(shapes, fine, shadow_size) if shadows else None
    image = np.zeros((rows * columns, 4))
    transparency, depth = np.ones(rows * columns), np.full(rows * columns, np.inf)
    for _ in range(TRANSLUCENT_LAYERS):
        depth, nearest = _nearest(triangles, rows, columns, np.where(transparency > 0.01, depth, -np.inf))
        first, is_translucent = 0, False
        for shape in shapes:
            count = shape.corners.shape[0] * (shape.corners.shape[1] - 2)
            places = np.flatnonzero((nearest >= first) & (nearest < first + count))
            if len(places):
                samples = np.stack([places % columns + 0.5, places // columns + 0.5, depth[places]], axis=1)
                colour, opacity = _shade(shape, nearest[places] - first, samples, fine, shadow)
                image[places] += (
                    np.column_stack([colour, np.ones(len(places))]) * (transparency[places] * opacity)[:, None]
                )
                transparency[places] *= 1 - opacity
                is_translucent |= shape.opacity < 1
            first += count
        if not is_translucent:
            break
    return np.asarray(image.reshape(height, OVERSAMPLING, width, OVERSAMPLING, 4).mean(axis=(1, 3)))


# --- which triangle is nearest


def _nearest(triangles: FloatArray, rows: int, columns: int, limit: FloatArray) -> tuple[FloatArray, IntArray]:
    """Depth and triangle (rows * columns,) seen at each sample, -1 for none; only what lies behind the limit counts."""
    depth, nearest = np.full(rows * columns, -np.inf), np.full(rows * columns, -1)
    for triangle, sample, here in _fragments(triangles, rows, columns):
        counts = here < limit[sample]
        triangle, sample, here = triangle[counts], sample[counts], here[counts]
        np.maximum.at(depth, sample, here)
        wins = here == depth[sample]
        nearest[sample[wins]] = triangle[wins]
    return depth, nearest


def _fragments(triangles: FloatArray, rows: int, columns: int) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
    """Triangle, sample and depth of everything covered, some of it at a time: spans of rows first, then samples."""
    x, y, z = np.moveaxis(triangles, 2, 0)
    twice = (x[:, 1] - x[:, 0]) * (y[:, 2] - y[:, 0]) - (x[:, 2] - x[:, 0]) * (y[:, 1] - y[:, 0])
    top = np.clip(np.ceil(y.min(axis=1) - 0.5), 0, rows).astype(int)
    bottom = np.clip(np.ceil(y.max(axis=1) - 0.5), 0, rows).astype(int)
    bottom[np.abs(twice) < 1e-9] = 0
    triangle, step = _expand(np.maximum(bottom - top, 0))
    row = top[triangle] + step
    left, right = _span(x[triangle], y[triangle], row + 0.5)
    left, right = (np.clip(np.ceil(end - 0.5), 0, columns).astype(int) for end in (left, right))
    lengths = np.maximum(right - left, 0)
    slope_x, slope_y = _slopes(x, y, z, np.where(np.abs(twice) < 1e-9, 1.0, twice))
    start = z[:, 0] - slope_x * x[:, 0] - slope_y * y[:, 0]
    base = start[triangle] + slope_y[triangle] * (row + 0.5)
    parts = np.searchsorted(
        np.cumsum(lengths), np.arange(SAMPLES_IN_MEMORY, lengths.sum() + SAMPLES_IN_MEMORY, SAMPLES_IN_MEMORY)
    )
    for part in np.split(np.arange(len(lengths)), np.unique(parts)):
        span, step = _expand(lengths[part])
        span = part[span]
        column = left[span] + step
        yield triangle[span], row[span] * columns + column, base[span] + slope_x[triangle[span]] * (column + 0.5)


def _span(x: FloatArray, y: FloatArray, at: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where the triangles (n, 3) begin and end on the horizontal lines y = at (n,)."""
    x1, y1 = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    crosses = (y <= at[:, None]) != (y1 <= at[:, None])
    where = x + (at[:, None] - y) / np.where(crosses, y1 - y, 1.0) * (x1 - x)
    return np.where(crosses, where, np.inf).min(axis=1), np.where(crosses, where, -np.inf).max(axis=1)


def _slopes(x: FloatArray, y: FloatArray, z: FloatArray, twice: FloatArray) -> tuple[FloatArray, FloatArray]:
    a, b = z[:, 1] - z[:, 0], z[:, 2] - z[:, 0]
    along_x = (a * (y[:, 2] - y[:, 0]) - b * (y[:, 1] - y[:, 0])) / twice
    along_y = (b * (x[:, 1] - x[:, 0]) - a * (x[:, 2] - x[:, 0])) / twice
    return along_x, along_y


def _expand(counts: IntArray) -> tuple[IntArray, IntArray]:
    """0 0 0 1 1 ... and 0 1 2 0 1 ... for counts 3, 2, ..."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - (np.cumsum(counts) - counts)[owner]


# --- what it looks like


def _shade(
    shape: Polygons, triangle: IntArray, samples: FloatArray, camera: Camera, shadow: _Shadow | None
) -> tuple[FloatArray, FloatArray]:
    """Colours (n, 3) and opacities (n,) of a shape at samples (n, 3) that lie in the given of its triangles."""
    polygon = triangle // (shape.corners.shape[1] - 2)
    weights = _barycentric(camera.project(shape.triangles)[triangle], samples)

    def interpolated(values: FloatArray) -> FloatArray:
        return np.asarray(np.einsum("nc,nci->ni", weights, shape.at_triangles(values)[triangle]))

    normal = interpolated(shape.normals) @ camera.axes.T
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    front = normal[:, 2] > 0
    normal *= np.where(front, 1, -1)[:, None]
    sun = np.maximum(normal @ (LIGHT / np.linalg.norm(LIGHT)), 0)
    if shadow is not None and shape.opacity == 1:
        sun *= 1 - SHADOW_STRENGTH * shadow.at(camera.unproject(samples))
    light = AMBIENT_LIGHT + SKY_LIGHT * normal[:, 1] + SUN_LIGHT * sun
    colour = np.where(front[:, None], interpolated(shape.colour), interpolated(shape.back))
    if shape.scale is not None:
        colour = shape.scale.colours(colour[:, 0])
    colour = colour * light[:, None]
    share, ink = _outlined(camera.project(shape.corners), shape, polygon, samples)
    colour += share[:, None] * (ink - colour)
    return np.clip(colour, 0, 1), shape.opacity + (1 - shape.opacity) * share


def _barycentric(triangles: FloatArray, samples: FloatArray) -> FloatArray:
    (ax, ay, _), (bx, by, _), (cx, cy, _) = (triangles[:, corner].T for corner in range(3))
    x, y = samples[:, 0], samples[:, 1]
    twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice
    third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice
    return np.stack([1 - second - third, second, third], axis=1)


def _outlined(
    corners: FloatArray, shape: Polygons, polygon: IntArray, samples: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """0 to 1 (n,): how much of each sample the outline of its polygon covers; and the colour (n, 3) of that outline."""
    share, ink = np.zeros(len(samples)), np.zeros((len(samples), 3))
    for start in np.flatnonzero(shape.outline.any(axis=0)):
        tail = corners[:, start, :2]
        along = (np.roll(corners, -1, axis=1)[:, start, :2] - tail)[polygon]
        from_tail = samples[:, :2] - tail[polygon]
        squared = np.maximum(np.einsum("ni,ni->n", along, along), 1e-12)
        place = np.clip(np.einsum("ni,ni->n", along, from_tail) / squared, 0, 1)
        distance = np.linalg.norm(from_tail - place[:, None] * along, axis=1)
        width = shape.outline[polygon, start] * OVERSAMPLING
        covered = np.where(width > 0, np.clip(width - distance + 0.5, 0, 1), 0)
        nearer = covered > share
        share[nearer], ink[nearer] = covered[nearer], shape.ink[polygon[nearer], start]
    return share, ink


@dataclass(frozen=True, eq=False)
class _Shadow:
    """What the light sees: depth (SIZE, SIZE) towards the light."""

    camera: Camera
    depth: FloatArray
    bias: float
    softness: float

    @classmethod
    def of(cls, shapes: Sequence[Polygons], camera: Camera, size: int) -> _Shadow:
        points = np.concatenate([shape.triangles for shape in shapes if shape.opacity == 1])
        towards = LIGHT / np.linalg.norm(LIGHT) @ camera.axes
        right = np.cross(camera.axes[1], towards)
        right /= np.linalg.norm(right)
        axes = np.stack([right, np.cross(towards, right), towards])
        local = points.reshape(-1, 3) @ axes.T
        centre = (local.min(axis=0) + local.max(axis=0)) / 2 @ axes
        scale = size / float(np.ptp(local[:, :2], axis=0).max()) * 0.99
        light = Camera(axes, centre, scale, np.array([size / 2, size / 2, 0.0]), np.inf)
        depth, _ = _nearest(light.project(points), size, size, np.full(size * size, np.inf))
        return cls(light, depth.reshape(size, size), 0.004 * size, 0.0025 * size)

    def at(self, points: FloatArray) -> FloatArray:
        """(n,) share of the light that does not reach the points (n, 3)."""
        here = self.camera.project(points)
        size, taps = len(self.depth), 7
        hidden = np.zeros(len(points))
        for tap in range(taps):
            angle, radius = 2.4 * tap, self.softness * np.sqrt((tap + 0.5) / taps)
            place = (here[:, :2] + radius * np.array([np.cos(angle), np.sin(angle)])).astype(int).clip(0, size - 1)
            hidden += self.depth[place[:, 1], place[:, 0]] > here[:, 2] + self.bias
        return hidden / taps

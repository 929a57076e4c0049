"""Polygons in space to pixels: a depth buffer, light, shadow, and outlines that belong to their faces.

Every pixel is sampled `FINE` times in each direction. A sample first finds its nearest triangle; colour, outline and
shadow are looked up only then. Translucent polygons are peeled off layer by layer.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import FloatArray, IntArray

__all__ = ["Polygons", "View", "render"]

FINE = 2
LAYERS = 8
LIGHT = np.array([-0.45, 0.55, 0.8])
"""Where the light comes from: right, up and towards the viewer."""

AMBIENT, SKY, SUN = 0.65, 0.11, 0.36
"""Light from all sides, more of it where a side faces upwards, and light from one side, which casts shadows."""

SHADE = 0.8
"""What a shadow takes off the light from one side."""


@dataclass(frozen=True, eq=False)
class Polygons:
    """n polygons with k corners (n, k, 3), as near to convex as a fan of triangles needs.

    normals (n, k, 3) at the corners; colour and back (n, 3) of the side they point to and of the other one.
    outline (n, k): widths in pixels of the lines along the edges that start at the corners.
    """

    corners: FloatArray
    normals: FloatArray
    colour: FloatArray
    back: FloatArray
    outline: FloatArray
    ink: FloatArray
    opacity: float = 1.0

    @property
    def triangles(self) -> FloatArray:
        """(n (k - 2), 3, 3), polygon after polygon."""
        return self._fan(self.corners)

    @property
    def triangle_normals(self) -> FloatArray:
        return self._fan(self.normals)

    def _fan(self, values: FloatArray) -> FloatArray:
        k = values.shape[1]
        rank = np.stack([np.zeros(k - 2, dtype=int), np.arange(1, k - 1), np.arange(2, k)], axis=1)
        return values[:, rank].reshape(-1, 3, 3)


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
        return replace(self, scale=self.scale * FINE, middle=self.middle * FINE, eye=self.eye * FINE)


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


def render(shapes: Sequence[Polygons], camera: Camera, width: int, height: int) -> FloatArray:
    """(height, width, 4) colours, premultiplied by their opacity."""
    fine = camera.finer()
    rows, columns = height * FINE, width * FINE
    triangles = fine.project(np.concatenate([shape.triangles for shape in shapes]))
    shadow = _Shadow.of(shapes, fine)
    image = np.zeros((rows * columns, 4))
    clear, depth = np.ones(rows * columns), np.full(rows * columns, np.inf)
    for _ in range(LAYERS):
        depth, nearest = _nearest(triangles, rows, columns, np.where(clear > 0.01, depth, -np.inf))
        first, seen_through = 0, False
        for shape in shapes:
            count = shape.corners.shape[0] * (shape.corners.shape[1] - 2)
            places = np.flatnonzero((nearest >= first) & (nearest < first + count))
            if len(places):
                samples = np.stack([places % columns + 0.5, places // columns + 0.5, depth[places]], axis=1)
                colour, opacity = _shade(shape, nearest[places] - first, samples, fine, shadow)
                image[places] += np.column_stack([colour, np.ones(len(places))]) * (clear[places] * opacity)[:, None]
                clear[places] *= 1 - opacity
                seen_through |= shape.opacity < 1
            first += count
        if not seen_through:
            break
    return np.asarray(image.reshape(height, FINE, width, FINE, 4).mean(axis=(1, 3)))


# --- which triangle is nearest


def _nearest(triangles: FloatArray, rows: int, columns: int, beyond: FloatArray) -> tuple[FloatArray, IntArray]:
    """Depth and triangle (rows * columns,) seen at each sample, -1 for none; only what lies behind `beyond` counts."""
    depth, nearest = np.full(rows * columns, -np.inf), np.full(rows * columns, -1)
    for triangle, sample, here in _fragments(triangles, rows, columns):
        counts = here < beyond[sample]
        triangle, sample, here = triangle[counts], sample[counts], here[counts]
        np.maximum.at(depth, sample, here)
        wins = here == depth[sample]
        nearest[sample[wins]] = triangle[wins]
    return depth, nearest


def _fragments(
    triangles: FloatArray, rows: int, columns: int, at_once: int = 2_000_000
) -> Iterator[tuple[IntArray, IntArray, FloatArray]]:
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
    parts = np.searchsorted(np.cumsum(lengths), np.arange(at_once, lengths.sum() + at_once, at_once))
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
    shape: Polygons, triangle: IntArray, samples: FloatArray, camera: Camera, shadow: _Shadow
) -> tuple[FloatArray, FloatArray]:
    """Colours (n, 3) and opacities (n,) of a shape at samples (n, 3) that lie in the given of its triangles."""
    polygon = triangle // (shape.corners.shape[1] - 2)
    weights = _barycentric(camera.project(shape.triangles)[triangle], samples)
    normal = np.einsum("nc,nci->ni", weights, shape.triangle_normals[triangle]) @ camera.axes.T
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    front = normal[:, 2] > 0
    normal *= np.where(front, 1, -1)[:, None]
    sun = np.maximum(normal @ (LIGHT / np.linalg.norm(LIGHT)), 0)
    if shape.opacity == 1:
        sun *= 1 - SHADE * shadow.at(camera.unproject(samples))
    light = AMBIENT + SKY * normal[:, 1] + SUN * sun
    paint = np.where(front[:, None], shape.colour[polygon], shape.back[polygon]) * light[:, None]
    inked = _inked(camera.project(shape.corners), shape.outline, polygon, samples)
    paint += inked[:, None] * (shape.ink - paint)
    return np.clip(paint, 0, 1), shape.opacity + (1 - shape.opacity) * inked


def _barycentric(triangles: FloatArray, samples: FloatArray) -> FloatArray:
    (ax, ay, _), (bx, by, _), (cx, cy, _) = (triangles[:, corner].T for corner in range(3))
    x, y = samples[:, 0], samples[:, 1]
    twice = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / twice
    third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / twice
    return np.stack([1 - second - third, second, third], axis=1)


def _inked(corners: FloatArray, widths: FloatArray, polygon: IntArray, samples: FloatArray) -> FloatArray:
    """(n,) 0 to 1: how much of a sample the outline of its polygon covers."""
    inked = np.zeros(len(samples))
    for start in np.flatnonzero(widths.any(axis=0)):
        tail = corners[:, start, :2]
        ahead = np.roll(corners, -1, axis=1)[:, start, :2] - tail
        ahead_here, from_tail = ahead[polygon], samples[:, :2] - tail[polygon]
        squared = np.maximum(np.einsum("ni,ni->n", ahead_here, ahead_here), 1e-12)
        share = np.clip(np.einsum("ni,ni->n", ahead_here, from_tail) / squared, 0, 1)
        away = np.linalg.norm(from_tail - share[:, None] * ahead_here, axis=1)
        width = widths[polygon, start] * FINE
        inked = np.maximum(inked, np.where(width > 0, np.clip(width - away + 0.5, 0, 1), 0))
    return inked


@dataclass(frozen=True, eq=False)
class _Shadow:
    """What the light sees: depth (SIZE, SIZE) towards the light."""

    camera: Camera
    depth: FloatArray
    bias: float
    softness: float

    @classmethod
    def of(cls, shapes: Sequence[Polygons], camera: Camera) -> _Shadow:
        size = 800 * FINE
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

"""The model of a page as arrays: each shape once, placed many times, in a text that its script reads (model.js).

All numbers have four bytes, the lower ones first. For each layer follow on each other: positions of the parts in metres
(n, 3), turns as quaternions x, y, z, w (n, 4), shape and colour of each (n,) as whole numbers. Then, for all layers:
points in metres (p, 3), the first point of each shape and its cut (s, 2), and for each cut the triangles (t, 3) and the
edges that are drawn (e, 2), whose points are counted from the first one of a shape.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.formats.shown import Placed, Surface, facets
from fabkit.formats.shown.triangles import Facets
from fabkit.parts import Solids
from geometry.arrays import FloatArray, IntArray

__all__ = ["model_data"]

SMOOTH_COSINE = 0.9
"""Cosine of the angle between the normals of two faces at an edge above which the edge lies on a round, and is not
drawn: strips of a round have one normal there."""


def model_data(layers: Sequence[tuple[str, Placed]]) -> tuple[dict[str, Any], str]:
    """What the layers hold, for JSON, and their arrays in base64; about the middle of the whole, middle_mm.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.report.model import model_data
    >>> from fabkit.formats.shown import placed_parts
    >>> head, arrays = model_data([("beams", placed_parts(built.assembly["beams"]))])
    >>> [(layer["name"], layer["count"]) for layer in head["layers"]], head["shapes"]
    ([('beams', 30)], 5)
    """
    shapes, layers = _Shapes(), [layer for layer in layers if layer[1].names]
    heads, arrays = [], []
    origins = np.concatenate([np.zeros((0, 3)), *(placed.translations + _middles(placed) for _, placed in layers)])
    middle = (origins.min(axis=0) + origins.max(axis=0)) / 2 if len(origins) else np.zeros(3)
    for name, placed in layers:
        used, example, shape = np.unique(placed.shape, return_index=True, return_inverse=True)
        colours = [_screen_colour(surface) for surface in placed.surfaces]
        heads.append({"name": name, "count": len(placed.names), "colours": colours})
        first = shapes.add(placed.solids.take(used), [placed.names[n] for n in example.tolist()])
        arrays += [
            _reals((placed.translations - middle) / 1000),
            _reals(placed.rotations),
            _whole(first + shape),
            _whole(placed.surface),
        ]
    sizes, cuts = np.array(shapes.sizes, dtype=np.int64), np.array(shapes.cuts, dtype=np.int64)
    arrays += [_reals(points) for points in shapes.points]
    arrays.append(_whole(np.stack([np.cumsum(sizes) - sizes, cuts], axis=1)))
    arrays += [_whole(each) for cut in shapes.found for each in cut]
    head = {
        "layers": heads,
        "middle_mm": middle.tolist(),
        "points": int(sizes.sum()),
        "shapes": len(shapes.cuts),
        "cuts": [[len(triangles), len(edges)] for triangles, edges in shapes.found],
    }
    return head, base64.b64encode(b"".join(arrays)).decode()


def _middles(placed: Placed) -> FloatArray:
    """(n, 3) of the points of each, turned as it is placed."""
    vertices = placed.solids.vertices
    means = np.add.reduceat(vertices.values, vertices.starts[:-1]) / vertices.sizes[:, None]
    points, turns = means[placed.shape], placed.rotations
    across = 2 * np.cross(turns[:, :3], points)
    turned: FloatArray = points + turns[:, 3:] * across + np.cross(turns[:, :3], across)
    return turned


def _screen_colour(surface: Surface) -> list[int]:
    return [round(255 * part) for part in (*surface.colour, surface.opacity)]


def _reals(values: FloatArray) -> bytes:
    return values.astype("<f4").tobytes()


def _whole(values: npt.NDArray[np.int64]) -> bytes:
    return values.astype("<u4").tobytes()


class _Shapes:
    """Points of each shape, their number, and which of the different cuts into triangles it has."""

    def __init__(self) -> None:
        self.points: list[FloatArray] = []
        self.sizes: list[int] = []
        self.cuts: list[int] = []
        self.found: list[tuple[IntArray, IntArray]] = []
        self.numbers: dict[bytes, int] = {}

    def add(self, solids: Solids, names: Sequence[str]) -> int:
        """Adds solids with these names; returns the number of the first."""
        first = len(self.cuts)
        sizes, cuts = np.zeros((2, len(solids)), dtype=np.int64)
        batches = facets(solids, names)
        for batch in batches:
            edges = _drawn_edges(batch)
            sizes[batch.solids] = batch.flat.vertices.shape[1]
            cuts[batch.solids] = [self._cut(each, edges) for each in batch.flat.topology.corners[batch.triangles]]
        points, starts = np.empty((sizes.sum(), 3)), np.cumsum(sizes) - sizes
        for batch in batches:
            places = starts[batch.solids, None] + np.arange(batch.flat.vertices.shape[1])
            points[places] = batch.flat.vertices / 1000
        self.points.append(points)
        self.sizes += sizes.tolist()
        self.cuts += cuts.tolist()
        return first

    def _cut(self, triangles: IntArray, edges: IntArray) -> int:
        key = triangles.tobytes() + edges.tobytes()
        if key not in self.numbers:
            self.numbers[key] = len(self.found)
            self.found.append((triangles, edges))
        return self.numbers[key]


def _drawn_edges(batch: Facets) -> IntArray:
    """(e, 2) the edges between faces, without those on rounds."""
    t = batch.flat.topology
    tail, head = t.corners, t.corners[t.next_corner]
    n = t.n_vertices
    backward = np.argsort(head * n + tail)
    other = backward[np.searchsorted((head * n + tail)[backward], tail * n + head)]  # corner where the twin starts
    of = batch.normals[0]
    cosines = np.einsum("ci,ci->c", of, of[t.next_corner[other]])
    chosen = (tail < head) & (cosines < SMOOTH_COSINE)
    edges: IntArray = np.stack([tail[chosen], head[chosen]], axis=1)
    return edges

"""Shadows of fins on panels, as exact polygons.

Everything is projected along the light, sun by sun: the projections of a shadow and of the fin that casts it
are the same, on any plane. Of each fin the part above the plane of a panel shades it; where the shadows of several fins
overlap they count once. Panels are glass: they let light through, and cast no shadow.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray, floats
from geometry.errors import GeometryError
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_centroids, perpendicular_pair
from geometry.shading.covered_areas import covered_areas
from geometry.shading.fins import Fins
from geometry.shading.suns import Suns

__all__ = ["GRAZING_COSINE", "Shading", "cast_shadows", "check_some_sun", "face_suns", "shadow_areas"]

GRAZING_COSINE = 1e-4
"""Least cosine between the normal of a panel and a sun that it faces: less light than this counts as none."""

MAX_PANELS_AND_FINS = 2**14
"""Most panels or fins, each under each sun, treated at once, which bounds the memory."""

IN_PLANE_TOLERANCE = 1e-9
"""Distance of corners of fins from the plane of a panel, over the mean edge length, up to which they count as lying in
it."""


@dataclass(frozen=True, eq=False)
class Shading:
    """What shade fins cast on panels under some suns.

    shadow_areas (k, F): area of the shadow, in the plane of each panel, for each sun; zero where `facing` is false.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import grid
    >>> flat = grid(1, 1)
    >>> upright = Pair(flat, flat.with_vertices(0 * flat.vertices + [0, 0, 1]))
    >>> shading = cast_shadows(Fins(upright, 0.0, 0.5), Suns([[1, 0, 1], [0, 0, 1]], weights=[1, 3]))
    >>> shading.shares.round(6).tolist(), round(shading.share, 6)
    ([[0.5], [0.0]], 0.125)
    >>> shading.table.round(6).tolist()
    [[0.0, 0.0, 1.0, 0.5, 0.5], [1.0, 0.0, 1.0, 0.0, 0.0]]
    """

    fins: Fins
    suns: Suns
    shadow_areas: FloatArray

    @cached_property
    def facing(self) -> BoolArray:
        """(k, F) whether a panel faces a sun; others are not counted."""
        return face_suns(self.fins.mesh, self.suns.directions)

    @cached_property
    def panel_areas(self) -> FloatArray:
        """(F,)"""
        return floats(np.linalg.norm(self.fins.mesh.vector_areas, axis=1))

    @cached_property
    def shares(self) -> FloatArray:
        """(k, F) part of each panel that is in the shade under each sun, from 0 to 1; NaN where it faces away."""
        return floats(np.where(self.facing, self.shadow_areas / self.panel_areas, np.nan))

    @property
    def table(self) -> FloatArray:
        """(r, 5) a row for each sun and each panel that faces it: numbers of the sun and of the panel, counted from 0,
        areas of the panel and of its shadow, and the share of it that is in the shade."""
        sun, panel = np.nonzero(self.facing)
        columns = (sun, panel, self.panel_areas[panel], self.shadow_areas[sun, panel], self.shares[sun, panel])
        return floats(np.column_stack(columns))

    @property
    def total(self) -> float:
        """Area of shadow on all panels, a weighted mean over the suns."""
        return float(np.average(self.shadow_areas.sum(axis=1), weights=self.suns.weights))

    @property
    def share(self) -> float:
        """Part of the area of panels that face a sun that is in the shade, over all suns by weight."""
        w = self.suns.weights
        return float(w @ self.shadow_areas.sum(axis=1) / (w @ (self.facing @ self.panel_areas)))

    @property
    def blocked_light(self) -> float:
        """Part of the direct light on the panels that is kept off: shadow counts by the cosine of the incidence."""
        light = np.maximum(self.suns.directions @ self.fins.mesh.face_normals.T, 0) * self.suns.weights[:, None]
        return float((light * self.shadow_areas).sum() / (light * self.facing * self.panel_areas).sum())

    @property
    def shadow_per_fin_area(self) -> float:
        """`total` over the area of all fins, one side: the shadow per material."""
        return self.total / float(self.fins.areas.sum())


def cast_shadows(fins: Fins, suns: Suns) -> Shading:
    """The shade that fins cast on their panels. Raises GeometryError where no panel faces any sun.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import grid
    >>> flat = grid(1, 1)
    >>> upright = Pair(flat, flat.with_vertices(0 * flat.vertices + [0, 0, 1]))
    >>> round(cast_shadows(Fins(upright, 0.0, 0.5), Suns([[1, 0, 1]])).total, 6)
    0.5
    """
    check_some_sun(fins.mesh, suns)
    faces = np.arange(fins.mesh.n_faces)
    return Shading(fins, suns, floats(shadow_areas(fins.mesh, faces, fins.quads, suns.directions)))


def check_some_sun(mesh: Mesh, suns: Suns) -> None:
    """Raise GeometryError where no panel faces any sun."""
    cosines = suns.directions @ mesh.face_normals.T
    if not (cosines > GRAZING_COSINE).any():
        raise GeometryError(
            f"no panel faces any of the {len(suns.directions)} suns: the largest cosine between a normal and a sun is "
            f"{cosines.max():.1e}, it must be above {GRAZING_COSINE:.0e}; give other suns, or reverse the mesh if its "
            f"normals "
            "point inwards",
            value=float(cosines.max()),
            bound=GRAZING_COSINE,
        )


def face_suns(mesh: Mesh, directions: FloatArray) -> BoolArray:
    """(k, F) whether the outer side of each panel faces the suns in unit directions (k, 3)."""
    return np.asarray(directions @ mesh.face_normals.T > GRAZING_COSINE)


def shadow_areas(mesh: Mesh, faces: IntArray, quads: FloatArray, directions: FloatArray) -> FloatArray:
    """(k, f) areas of shadow on faces (f,) of a mesh, from convex quads (m, 4, 3), for suns in directions (k, 3)."""
    pieces = min(len(directions), 1 + len(directions) * max(len(faces), len(quads)) // MAX_PANELS_AND_FINS)
    parts = [_areas_under(mesh, faces, quads, some) for some in np.array_split(directions, pieces)]
    return np.concatenate(parts)


def _areas_under(mesh: Mesh, faces: IntArray, quads: FloatArray, directions: FloatArray) -> FloatArray:
    """The same, for all suns at once."""
    areas = np.zeros((len(directions), len(faces)))
    sun, face = np.nonzero(face_suns(mesh, directions)[:, faces])
    across = perpendicular_pair(directions).swapaxes(1, 2)
    panels = np.einsum("skc,sci->ski", _corners(mesh, faces)[face], across[sun])
    outlines = quads @ across[:, None]
    panel, fin_sun, fin = _boxes_that_meet(panels, sun, outlines)
    normals = mesh.face_normals[faces]
    levels = np.einsum("fk,fk->f", normals, face_centroids(mesh.vertices, mesh.combinatorics)[faces])
    own = face[panel]
    heights = np.einsum("pk,pqk->pq", normals[own], quads[fin]) - levels[own][:, None]
    heights[np.abs(heights) < IN_PLANE_TOLERANCE * mesh.mean_edge_length] = 0.0
    some = (heights > 0).any(axis=1)
    parts = _parts_above(outlines[fin_sun[some], fin[some]], heights[some])
    cosines = np.einsum("sk,sk->s", normals[face], directions[sun])
    areas[sun, face] = covered_areas(panels, parts, panel[some]) / cosines
    return areas


def _boxes_that_meet(panels: FloatArray, sun: IntArray, outlines: FloatArray) -> tuple[IntArray, IntArray, IntArray]:
    """Panels (p,), and suns and fins (p,), whose boxes along the axes meet under the same sun.

    panels (s, c, 2), seen from the suns (s,); outlines of fins (k, m, 4, 2) from all suns.
    """
    k, m = outlines.shape[:2]
    low = min(panels[..., 0].min(initial=0.0), outlines[..., 0].min())
    width = max(panels[..., 0].max(initial=0.0), outlines[..., 0].max()) - low
    beside = np.stack([2 * width * np.arange(k), np.zeros(k)], axis=1)  # one sun beside the other, in one tree
    found = []
    for corners, own in ((panels, sun), (outlines.reshape(-1, 4, 2), np.repeat(np.arange(k), m))):
        found.append(shapely.box(*(corners.min(axis=1) + beside[own]).T, *(corners.max(axis=1) + beside[own]).T))
    fin, panel = shapely.STRtree(found[0]).query(found[1])
    return panel, fin // m, fin % m


def _corners(mesh: Mesh, faces: IntArray) -> FloatArray:
    """(f, k, 3) corners of faces (f,), the last one repeated where a face has less than most have."""
    c = mesh.combinatorics
    places = np.minimum(np.arange(c.face_sizes.max()), c.face_sizes[faces][:, None] - 1)
    return np.asarray(mesh.vertices[c.corners[c.face_starts[faces][:, None] + places]])


def _parts_above(outlines: FloatArray, heights: FloatArray) -> FloatArray:
    """(p, 5, 2) convex quads (p, 4, 2) without what is below zero of heights (p, 4), the last corner repeated."""
    following = np.roll(heights, -1, axis=1)
    crossing = np.sign(heights) * np.sign(following) < 0
    parts = heights / np.where(crossing, heights - following, 1.0)
    crossings = outlines + parts[..., None] * (np.roll(outlines, -1, axis=1) - outlines)
    kept = np.stack([heights >= 0, crossing], axis=2).reshape(-1, 8)
    corners = np.stack([outlines, crossings], axis=2).reshape(-1, 8, 2)
    first = np.argsort(~kept, axis=1, kind="stable")[:, :5]
    first = np.take_along_axis(first, np.minimum(np.arange(5), kept.sum(axis=1)[:, None] - 1), axis=1)
    return np.take_along_axis(corners, first[..., None], axis=1)

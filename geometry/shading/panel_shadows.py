"""Shadows of fins on panels, as exact polygons.

Everything is projected along the light, sun by sun: the projections of a shadow and of the fin that casts it
are the same, on any plane. Of each fin the part above the plane of a panel shades it; where the shadows of several fins
overlap they count once. Panels let light through, and cast no shadow; opaque ones do, and then fins count only for what
they shade of the area that other panels leave in the sun.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers
from geometry.errors import GeometryError
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_centroids, perpendicular_pair
from geometry.mesh.triangulation import triangulated
from geometry.shading.covered_areas import covered_areas
from geometry.shading.fins import Fins
from geometry.shading.suns import Suns

__all__ = ["Blinds", "Shading", "cast_shadows", "check_some_sun", "face_suns", "shadow_areas"]

GRAZING_COSINE = 1e-4
"""Least cosine between the normal of a panel and a sun that it faces: less light than this counts as none."""

MAX_PANELS_AND_FINS = 2**14
"""Most panels or fins, each under each sun, treated at once, which bounds the memory."""

IN_PLANE_TOLERANCE = 1e-9
"""Distance of corners of fins from the plane of a panel, over the mean edge length, up to which they count as lying in
it."""


LEAST_SUNLIT_SHARE = 1e-6
"""Part of a panel that opaque panels leave in the sun, below which it counts as none: well above the rounding of
areas."""


@dataclass(frozen=True, eq=False)
class Blinds:
    """What casts shadows: convex quads (m, 4, 3), triangles with the last corner repeated; and the panels (m,) that
    they are parts of, which they do not shade, -1 for fins."""

    quads: FloatArray
    panels: IntArray

    @classmethod
    def of(cls, mesh: Mesh, fins: FloatArray, *, opaque: bool) -> Blinds:
        """The fins (m, 4, 3), and all panels if they are opaque."""
        triangles, panels = triangulated(mesh) if opaque else (np.zeros((0, 3), dtype=np.int64), np.zeros(0, np.int64))
        quads = np.concatenate([fins, mesh.vertices[triangles[:, [0, 1, 2, 2]]]])
        return cls(floats(quads), integers(np.concatenate([np.full(len(fins), -1), panels])))


@dataclass(frozen=True, eq=False)
class Shading:
    """What shade fins cast on panels under some suns.

    shadow_areas (k, F): area of the shadow of fins, in the plane of each panel, for each sun; zero where `facing` is
    false. panel_shadows (k, F): area in the shadow of other panels, without fins; zero unless panels are opaque. Areas
    shaded by both count as the latter.

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
    panel_shadows: FloatArray

    @cached_property
    def facing(self) -> BoolArray:
        """(k, F) whether a panel faces a sun; others are not counted."""
        return face_suns(self.fins.mesh, self.suns.directions)

    @cached_property
    def panel_areas(self) -> FloatArray:
        """(F,)"""
        return floats(np.linalg.norm(self.fins.mesh.vector_areas, axis=1))

    @cached_property
    def sunlit_areas(self) -> FloatArray:
        """(k, F) area of each panel that each sun would reach without fins; zero where it faces away, and below
        `LEAST_SUNLIT_SHARE` of the panel."""
        areas = np.where(self.facing, self.panel_areas - self.panel_shadows, 0.0)
        return floats(np.where(areas > LEAST_SUNLIT_SHARE * self.panel_areas, areas, 0.0))

    @cached_property
    def shares(self) -> FloatArray:
        """(k, F) part of the sunlit area of each panel that fins shade under each sun, from 0 to 1; NaN where no sun
        reaches the panel."""
        sunlit = self.sunlit_areas > 0
        shares = np.divide(self.shadow_areas, self.sunlit_areas, out=np.full(sunlit.shape, np.nan), where=sunlit)
        return floats(np.minimum(shares, 1.0))

    @property
    def table(self) -> FloatArray:
        """(r, 5) a row for each sun and each panel that it reaches: numbers of the sun and of the panel, counted from
        0, sunlit area of the panel, area that fins shade, and the share of it."""
        sun, panel = np.nonzero(self.sunlit_areas)
        columns = (sun, panel, self.sunlit_areas[sun, panel], self.shadow_areas[sun, panel], self.shares[sun, panel])
        return floats(np.column_stack(columns))

    @property
    def total(self) -> float:
        """Area that fins shade on all panels, a weighted mean over the suns."""
        return float(np.average(self.shadow_areas.sum(axis=1), weights=self.suns.weights))

    @property
    def share(self) -> float:
        """Part of the sunlit area of all panels that fins shade, over all suns by weight."""
        w = self.suns.weights
        return float(w @ self.shadow_areas.sum(axis=1) / (w @ self.sunlit_areas.sum(axis=1)))

    @property
    def blocked_light(self) -> float:
        """Part of the direct light on the panels that fins keep off: shadow counts by the cosine of the incidence."""
        light = np.maximum(self.suns.directions @ self.fins.mesh.face_normals.T, 0) * self.suns.weights[:, None]
        return float((light * self.shadow_areas).sum() / (light * self.sunlit_areas).sum())

    @property
    def shadow_per_fin_area(self) -> float:
        """`total` over the area of all fins, one side: the shadow per material."""
        return self.total / float(self.fins.areas.sum())


def cast_shadows(fins: Fins, suns: Suns, *, opaque: bool = False) -> Shading:
    """The shade that fins cast on their panels.

    opaque: panels shade panels, and fins count only where they shade what is left in the sun; by default light passes
    panels, as it does glass. Raises GeometryError where no sun reaches any panel.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import grid
    >>> flat = grid(1, 1)
    >>> upright = Pair(flat, flat.with_vertices(0 * flat.vertices + [0, 0, 1]))
    >>> round(cast_shadows(Fins(upright, 0.0, 0.5), Suns([[1, 0, 1]])).total, 6)
    0.5
    """
    check_some_sun(fins.mesh, suns)
    mesh, faces = fins.mesh, integers(np.arange(fins.mesh.n_faces))
    panels = shadow_areas(mesh, faces, Blinds.of(mesh, fins.quads[:0], opaque=opaque), suns.directions)
    both = shadow_areas(mesh, faces, Blinds.of(mesh, fins.quads, opaque=opaque), suns.directions)
    return Shading(fins, suns, floats(np.maximum(both - panels, 0.0)), floats(panels))


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


def shadow_areas(mesh: Mesh, faces: IntArray, blinds: Blinds, directions: FloatArray) -> FloatArray:
    """(k, f) areas of shadow on faces (f,) of a mesh, for suns in directions (k, 3)."""
    pieces = min(len(directions), 1 + len(directions) * max(len(faces), len(blinds.quads)) // MAX_PANELS_AND_FINS)
    return np.concatenate([_areas_under(mesh, faces, blinds, some) for some in np.array_split(directions, pieces)])


def _areas_under(mesh: Mesh, faces: IntArray, blinds: Blinds, directions: FloatArray) -> FloatArray:
    """The same, for all suns at once."""
    areas = np.zeros((len(directions), len(faces)))
    quads = blinds.quads
    if not len(quads):
        return areas
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
    some = (heights > 0).any(axis=1) & (blinds.panels[fin] != faces[own])
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

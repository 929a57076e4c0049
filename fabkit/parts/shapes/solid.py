"""Exact solids with planar faces, round bars, bores and fillets, as arrays.

A *topology* says which vertices bound which faces; parts of one kind share it by reference, so that a writer keeps
one template a topology. A *batch* is solids of one topology as one array, and all that is measured on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fabkit.parts.shapes.fillets import Fillets
from fabkit.parts.shapes.topology import Topology
from geometry.arrays import BoolArray, FloatArray, IntArray, floats

__all__ = ["Measures", "Solid", "SolidArray", "prism_vertices"]


def prism_vertices(outlines: FloatArray, bottom: FloatArray | float, top: FloatArray | float) -> FloatArray:
    """(..., 2n, 3) vertices of prisms over polygons (..., n, 2) in the xy-plane, from z = bottom to z = top (...).

    >>> from fabkit.parts import prism_vertices
    >>> prism_vertices(np.array([[0, 0], [4, 0], [0, 3]]), 0.0, 2.0)[-1].tolist()
    [0.0, 3.0, 2.0]
    """

    def at(height: FloatArray | float) -> FloatArray:
        level = np.broadcast_to(np.asarray(height, dtype=np.float64)[..., None], outlines.shape[:-1])
        return np.concatenate([outlines, level[..., None]], axis=-1)

    return np.concatenate([at(bottom), at(top)], axis=-2)


CORNERS_PER_BATCH = 20_000
"""Number of corners of solids that are measured together, so that intermediate results stay in the processor's
cache."""


@dataclass(frozen=True, eq=False)
class SolidArray:
    """Solids of one topology.

    parts (P,): their positions in what they were taken from. vertices (P, n, 3) in mm.

    >>> from fabkit.parts import SolidArray, prism_topology, prism_vertices
    >>> triangle = np.array([[0, 0], [4, 0], [0, 3]])
    >>> wedges = prism_vertices(np.stack([triangle, 2 * triangle]), 0.0, 1.0)
    >>> SolidArray(prism_topology(3), np.arange(2), wedges).volumes.round(9).tolist()
    [6.0, 24.0]
    """

    topology: Topology
    parts: IntArray
    vertices: FloatArray

    def __getitem__(self, chosen: BoolArray | IntArray | slice) -> SolidArray:
        """The solids chosen by a mask, by indices or by a slice."""
        return SolidArray(self.topology, self.parts[chosen], self.vertices[chosen])

    def in_batches(self) -> list[SolidArray]:
        """The same solids in smaller batches, one at least."""
        size = max(1, CORNERS_PER_BATCH // (len(self.topology.corners) + len(self.topology.rounds)))
        return [self[k : k + size] for k in range(0, max(1, len(self.parts)), size)]

    @cached_property
    def normals(self) -> FloatArray:
        """(P, F, 3) outward unit normals."""
        return np.concatenate([Measures(few.topology, few.vertices).normals for few in self.in_batches()])

    @cached_property
    def volumes(self) -> FloatArray:
        """(P,) in mm3; negative where a solid is inside out."""
        return np.concatenate([Measures(few.topology, few.vertices).volumes for few in self.in_batches()])

    @cached_property
    def centroids(self) -> FloatArray:
        """(P, 3) in mm."""
        return np.concatenate([Measures(few.topology, few.vertices).centroids for few in self.in_batches()])


@dataclass(frozen=True, eq=False)
class Measures:
    """What is measured on solids with vertices (P, n, 3) and one topology: worked out once, from corners about the
    middle of each solid and with coordinates in the first axis, which is fastest. All of it is exact, rounds too.

    >>> from fabkit.parts import Measures, prism_topology, prism_vertices
    >>> wedge = prism_vertices(np.array([[[0, 0], [4, 0], [0, 3]]]), 0.0, 2.0)
    >>> Measures(prism_topology(3), wedge).areas.round(9).tolist()
    [[6.0, 6.0, 8.0, 10.0, 6.0]]
    """

    topology: Topology
    vertices: FloatArray

    @cached_property
    def middles(self) -> FloatArray:
        """(P, 3) mean of the vertices of each solid."""
        middles: FloatArray = self.vertices.mean(axis=1)
        return middles

    @cached_property
    def points(self) -> FloatArray:
        """(3, P, n) the vertices, from the middle of each solid."""
        return np.ascontiguousarray(np.moveaxis(self.vertices - self.middles[:, None], 2, 0))

    # --- planar faces

    @cached_property
    def _apex(self) -> FloatArray:
        """(3, P, C) the first corner of the face of each corner, from the middle of the solid."""
        t = self.topology
        return self.points[:, :, t.corners[t.own_first_corner]]

    @cached_property
    def from_apex(self) -> FloatArray:
        """(3, P, C) each corner, from the first corner of its face."""
        return self.points[:, :, self.topology.corners] - self._apex

    @cached_property
    def _doubles(self) -> FloatArray:
        """(3, P, C) twice the area, times the normal, of the triangle of apex, corner and following corner."""
        here = self.from_apex
        following = here[:, :, self.topology.next_corner]
        return np.stack([here[i - 2] * following[i - 1] - here[i - 1] * following[i - 2] for i in range(3)])

    @cached_property
    def _face_doubles(self) -> FloatArray:
        """(3, P, F) the same of each face, holes taken off."""
        sums = self.topology.by_face(np.add, self._doubles, empty=0.0)
        for k, (first, second) in enumerate(self.topology.rounds[:, 4:6].tolist()):
            sums[:, :, first] += 2 * self._end_areas[0, ..., k]
            sums[:, :, second] += 2 * self._end_areas[1, ..., k]
        for q, (first, second) in enumerate(self.topology.fillet_ends.tolist()):
            sums[:, :, first] += 2 * self.fillets.end_areas[0, ..., q]
            sums[:, :, second] += 2 * self.fillets.end_areas[1, ..., q]
        return sums

    @cached_property
    def areas(self) -> FloatArray:
        """(P, F) in mm2, of each planar face; of a fillet, of the plane through its sides."""
        areas: FloatArray = np.sqrt((self._face_doubles * self._face_doubles).sum(axis=0)) / 2
        return areas

    @cached_property
    def normals(self) -> FloatArray:
        """(P, F, 3) outward unit normals of the planar faces."""
        return np.moveaxis(self._face_doubles / (2 * self.areas), 0, 2)

    @cached_property
    def _cones(self) -> FloatArray:
        """(P, C) six-fold volume of the cone from the middle of the solid over each of the triangles."""
        cones: FloatArray = (self._apex * self._doubles).sum(axis=0)
        return cones

    @cached_property
    def fillets(self) -> Fillets:
        """What is measured on the fillets."""
        return Fillets(self.topology, self.points)

    @cached_property
    def fillet_misfits(self) -> FloatArray:
        """(P, Q) in mm, largest distance of each fillet from a quarter of a cylinder, and of its tips from the planes
        of the faces at its ends."""
        t = self.topology
        faces, normals = t.fillet_ends, np.moveaxis(self.normals, 2, 0)
        away = self.points[:, :, t.fillets[:, 1:3]] - self.points[:, :, t.face_vertex[faces]]
        off = np.abs((away * normals[:, :, faces]).sum(axis=0))
        return np.asarray(np.maximum(self.fillets.misfits, off.max(axis=2)))

    # --- rounds

    @cached_property
    def lengths(self) -> FloatArray:
        """(P, K) in mm, of each round along its axis."""
        centres = self.points[:, :, self.topology.rounds[:, :3:2]]
        along = centres[..., 1] - centres[..., 0]
        lengths: FloatArray = np.sqrt((along * along).sum(axis=0))
        return lengths

    @cached_property
    def round_axes(self) -> FloatArray:
        """(3, P, K) unit vector of each round from its first to its second centre."""
        centres = self.points[:, :, self.topology.rounds[:, :3:2]]
        axes: FloatArray = (centres[..., 1] - centres[..., 0]) / self.lengths
        return axes

    @cached_property
    def rims(self) -> FloatArray:
        """(2, 3, P, K) from the centre of each end of each round to its rim: half the major axis of its edge."""
        vertices = self.topology.rounds[:, :4]
        ends = self.points[..., vertices[:, 1::2]] - self.points[..., vertices[:, ::2]]
        return np.moveaxis(ends, 3, 0)

    @cached_property
    def leans(self) -> FloatArray:
        """(2, P, K) distance of each rim beyond its centre, along the axis."""
        leans: FloatArray = (self.rims * self.round_axes).sum(axis=1)
        return leans

    @cached_property
    def _across(self) -> FloatArray:
        """(3, P, K) from the axis of each round to the first rim, perpendicular to it: as long as the radius."""
        across: FloatArray = self.rims[0] - self.leans[0] * self.round_axes
        return across

    @cached_property
    def radii(self) -> FloatArray:
        """(P, K) in mm, of each round."""
        radii: FloatArray = np.sqrt((self._across * self._across).sum(axis=0))
        return radii

    @cached_property
    def round_across(self) -> FloatArray:
        """(3, P, K) unit vector of each round perpendicular to its axis, towards its rims."""
        across: FloatArray = self._across / self.radii
        return across

    @cached_property
    def shortest_sides(self) -> FloatArray:
        """(P, K) in mm, shortest line on each round along its axis; not positive where its ends cross."""
        shortest: FloatArray = self.lengths - np.abs(self.leans[1] - self.leans[0])
        return shortest

    @cached_property
    def _end_areas(self) -> FloatArray:
        """(2, 3, P, K) area, times the normal of its face, that each end of each round adds to its face."""
        squares = (self.rims * self.rims).sum(axis=1)
        areas = np.pi * (self.round_axes * squares[:, None] - self.rims * self.leans[:, None])
        outwards = self.topology.rounds[:, 6]
        return np.stack([-outwards * areas[0], outwards * areas[1]])

    @cached_property
    def round_misfits(self) -> FloatArray:
        """(P, K) in mm, largest distance of the edges of each round from the planes of their faces, and of the one rim
        from the line through the other along the axis."""
        t = self.topology
        first, second = self.rims - self.leans[:, None] * self.round_axes
        misfits: FloatArray = np.sqrt(((first - second) ** 2).sum(axis=0))
        anchors, normals = self.points[:, :, t.face_vertex], np.moveaxis(self.normals, 2, 0)
        minor = [self.round_axes[i - 2] * first[i - 1] - self.round_axes[i - 1] * first[i - 2] for i in range(3)]
        for end in (0, 1):
            faces, centres = t.rounds[:, 4 + end], self.points[:, :, t.rounds[:, 2 * end]]
            off = np.abs(((centres - anchors[:, :, faces]) * normals[:, :, faces]).sum(axis=0))
            for half_axis in (self.rims[end], np.stack(minor)):
                misfits = np.maximum(misfits, off + np.abs((half_axis * normals[:, :, faces]).sum(axis=0)))
        return misfits

    @cached_property
    def round_areas(self) -> FloatArray:
        """(P, K) in mm2, of each round without its ends."""
        areas: FloatArray = 2 * np.pi * self.radii * self.lengths
        return areas

    @cached_property
    def surface_areas(self) -> FloatArray:
        """(P,) in mm2, of each solid."""
        areas: FloatArray = self.areas.sum(axis=1)
        if len(self.topology.rounds):
            areas += self.round_areas.sum(axis=1)
        if len(self.topology.fillets):
            areas += (self.fillets.areas - self.areas[:, self.topology.fillets[:, 0]]).sum(axis=1)
        return areas

    # --- solids

    @cached_property
    def volumes(self) -> FloatArray:
        """(P,) in mm3, by the divergence theorem; negative where a solid is inside out."""
        volumes: FloatArray = self._cones.sum(axis=1) / 6
        if len(self.topology.rounds):
            volumes += np.pi * (self.topology.rounds[:, 6] * self.radii**2 * self.lengths).sum(axis=1)
        if len(self.topology.fillets):
            volumes += self.fillets.volumes.sum(axis=1)
        return volumes

    @cached_property
    def centroids(self) -> FloatArray:
        """(P, 3) in mm."""
        here = self.from_apex
        corner_sums = 3 * self._apex + here + here[:, :, self.topology.next_corner]
        moments = np.einsum("pc,xpc->px", self._cones, corner_sums) / 24
        if len(self.topology.rounds):
            moments += self._round_moments
        if len(self.topology.fillets):
            moments += self.fillets.moments
        centroids: FloatArray = self.middles + moments / self.volumes[:, None]
        return centroids

    @property
    def _round_moments(self) -> FloatArray:
        """(P, 3) integral of the positions in all rounds. At a point x across from the axis (in units of the radius), a
        round reaches from lean[0] * x to length + lean[1] * x along the axis; that is integrated over the circle."""
        first, second = self.leans
        centres = self.points[:, :, self.topology.rounds[:, :3:2]].sum(axis=3) / 2
        moments = (
            self.lengths * centres
            + self._across * (second - first) / 4
            + self.round_axes * (second - first) * (second + first) / 8
        )
        weights = np.pi * self.topology.rounds[:, 6] * self.radii**2
        sums: FloatArray = np.einsum("xpk,pk->px", moments, weights)
        return sums


@dataclass(frozen=True, eq=False)
class Solid:
    """One solid: vertices (n, 3) in mm, read-only, in the part's own frame; its topology is shared.

    >>> from fabkit.parts import Solid, prism_topology, prism_vertices
    >>> wedge = Solid(prism_vertices(np.array([[0, 0], [4, 0], [0, 3]]), 0.0, 2.0), prism_topology(3))
    >>> round(wedge.volume_mm3, 9), wedge.centroid.round(9).tolist()
    (12.0, [1.333333333, 1.0, 1.0])
    """

    vertices: FloatArray
    topology: Topology

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", floats(self.vertices))
        if self.vertices.shape != (self.topology.n_vertices, 3):
            raise ValueError(f"vertices have shape {self.vertices.shape}, need ({self.topology.n_vertices}, 3)")

    @cached_property
    def _measures(self) -> Measures:
        return Measures(self.topology, self.vertices[None])

    @property
    def volume_mm3(self) -> float:
        return float(self._measures.volumes[0])

    @property
    def centroid(self) -> FloatArray:
        """(3,) in mm."""
        return floats(self._measures.centroids[0])

    @property
    def normals(self) -> FloatArray:
        """(F, 3) outward unit normals."""
        return floats(self._measures.normals[0])

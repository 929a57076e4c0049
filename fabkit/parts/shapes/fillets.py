"""What is measured on the fillets of solids: quarters of cylinders in the place of sharp edges.

All of it is exact, also between oblique faces: seen from the axis, the arc in either face is u p + v q with u^2 + v^2 =
1, where p and q lead from the centre to both ends of the arc.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fabkit.parts.shapes.topology import Topology
from geometry.arrays import FloatArray

__all__ = ["Fillets"]

LEAST_LEAN = 1e-11
"""Slope of the end of a fillet from which on it counts as oblique: far above rounding, and a fillet of 1 m leans by
1e-8 mm."""

_SEGMENT = np.pi / 4 - 1 / 2
"""Area of a quarter of the unit circle without the triangle of its centre and ends."""
_FIRST, _SQUARED, _MIXED = 1 / 6, np.pi / 16 - 1 / 12, 1 / 12
"""Integrals of u, of u^2 and of u v over that segment."""


@dataclass(frozen=True, eq=False)
class Fillets:
    """Measures of Q fillets, of P solids with points (3, P, n).

    >>> import numpy as np
    >>> from fabkit.parts import Measures, Section, profile_topology, profile_vertices
    >>> section = Section.of("rhs 120x60x5 r10")
    >>> ends, radii = (np.zeros((1, 3)), np.array([[900.0, 0.0, 0.2]])), section.corner_radii
    >>> bar = profile_vertices(section.loops, *ends, radii=radii)
    >>> Measures(profile_topology(section.loops, radii), bar).fillets.radii.round(9).tolist()
    [[10.0, 10.0, 10.0, 10.0, 5.0, 5.0, 5.0, 5.0]]
    """

    topology: Topology
    points: FloatArray

    @cached_property
    def _ends(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """(2, 3, P, Q) of both ends: first and last point of the arc as the fillet sees it, tip, and centre."""
        t = self.topology
        corners, tips = t.fillet_corners, t.fillets[:, 1:3]
        first, last, tip = (self.points[:, :, each] for each in (corners[:, [0, 3]], corners[:, [1, 2]], tips))
        return tuple(np.moveaxis(each, 3, 0) for each in (first, last, tip, first + last - tip))  # type: ignore[return-value]

    @property
    def centres(self) -> FloatArray:
        """(2, 3, P, Q) points of the axes in the faces at both ends."""
        return self._ends[3]

    @cached_property
    def _half_axes(self) -> tuple[FloatArray, FloatArray]:
        """p and q, (2, 3, P, Q) each."""
        first, last, tip, _ = self._ends
        return tip - last, tip - first

    @cached_property
    def axes(self) -> FloatArray:
        """(3, P, Q) unit vectors from the first to the second end."""
        along = self._ends[0][1] - self._ends[0][0]
        axes: FloatArray = along / np.sqrt((along * along).sum(axis=0))
        return axes

    def _across(self, vectors: FloatArray) -> FloatArray:
        """The parts of vectors (..., 3, P, Q) perpendicular to the axes."""
        across: FloatArray = vectors - (vectors * self.axes).sum(axis=-3)[..., None, :, :] * self.axes
        return across

    @cached_property
    def radii(self) -> FloatArray:
        """(P, Q) in mm."""
        across = self._across(self._half_axes[0][0])
        radii: FloatArray = np.sqrt((across * across).sum(axis=0))
        return radii

    @cached_property
    def _lengths(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(P, Q) length along the axis, at its centre, and by how much it grows with u and with v."""
        first, last, _, centre = (((each[1] - each[0]) * self.axes).sum(axis=0) for each in self._ends)
        return centre, first - centre, last - centre

    @cached_property
    def areas(self) -> FloatArray:
        """(P, Q) in mm2, of the fillets themselves."""
        length, by_u, by_v = self._lengths
        areas: FloatArray = self.radii * (np.pi / 2 * length + by_u + by_v)
        return areas

    @cached_property
    def end_areas(self) -> FloatArray:
        """(2, 3, P, Q) area, times the normal of the face, of what each end of each fillet adds to its face."""
        p, q = self._half_axes
        segments = _SEGMENT * np.stack(
            [p[:, i - 2] * q[:, i - 1] - p[:, i - 1] * q[:, i - 2] for i in range(3)], axis=1
        )
        return np.stack([-segments[0], segments[1]])

    @cached_property
    def volumes(self) -> FloatArray:
        """(P, Q) in mm3, of what each fillet adds to the solid with a flat face in its place."""
        length, by_u, by_v = self._lengths
        each = self.radii**2 * (_SEGMENT * length + _FIRST * (by_u + by_v))
        volumes: FloatArray = self.topology.fillets[:, 3] * each
        return volumes

    @cached_property
    def moments(self) -> FloatArray:
        """(P, 3) integral of the positions in what the fillets add."""
        (length, by_u, by_v), (p, q) = self._lengths, (each[0] for each in self._half_axes)
        weights = (
            _SEGMENT * length + _FIRST * (by_u + by_v),
            _FIRST * length + _SQUARED * by_u + _MIXED * by_v,
            _FIRST * length + _MIXED * by_u + _SQUARED * by_v,
        )
        along = length * weights[0] + by_u * weights[1] + by_v * weights[2]
        each = weights[0] * self.centres[0] + weights[1] * p + weights[2] * q + along / 2 * self.axes
        moments: FloatArray = np.einsum("xpq,pq->px", each, self.topology.fillets[:, 3] * self.radii**2)
        return moments

    @cached_property
    def _normals(self) -> FloatArray:
        """(2, 3, P, Q) vectors perpendicular to the arcs, as long as twice the areas of their triangles."""
        p, q = self._half_axes
        normals: FloatArray = np.cross(p, q, axis=1)
        return normals

    @cached_property
    def leans(self) -> FloatArray:
        """(2, P, Q) in mm, how far the major half axis of each arc reaches along the axis: zero where it is a
        circle."""
        upright = np.abs((self._normals * self.axes).sum(axis=1))
        across = self._across(self._normals)
        leans: FloatArray = self.radii * np.sqrt((across * across).sum(axis=1)) / upright
        return leans

    @cached_property
    def reference(self) -> FloatArray:
        """(3, P, Q) unit vectors perpendicular to the axes and away from the fillets; towards the major half axes of
        the arcs where an end is oblique."""
        first, last = self._half_axes
        middle = self._across(first[0] + last[0])
        oblique = np.where((self.leans[0] >= self.leans[1])[None], *self._across(self._normals))
        across = np.where((self.leans.max(axis=0) > LEAST_LEAN * self.radii)[None], oblique, middle)
        away = np.where((across * middle).sum(axis=0) > 0, -1.0, 1.0)
        reference: FloatArray = across * (away / np.sqrt((across * across).sum(axis=0)))
        return reference

    @cached_property
    def misfits(self) -> FloatArray:
        """(P, Q) in mm, largest distance of each fillet from a quarter of a cylinder, of its sides from parallels to
        its axis, and of an oblique end from the plane in which the other one leans."""
        p, q = (self._across(each) for each in self._half_axes)
        sizes = np.sqrt((p * p).sum(axis=1)), np.sqrt((q * q).sum(axis=1))
        off = [np.abs(sizes[0] - sizes[1]).max(axis=0), np.abs((p * q).sum(axis=1)).max(axis=0) / self.radii]
        off += [np.sqrt(((each[0] - each[1]) ** 2).sum(axis=0)) for each in (p, q)]
        minor = np.cross(self.axes, self.reference, axis=0)
        aside = np.abs((self._normals * minor).sum(axis=1)) / np.abs((self._normals * self.axes).sum(axis=1))
        is_lean = self.leans.max(axis=0) > LEAST_LEAN * self.radii
        misfits: FloatArray = np.max([*off, np.where(is_lean, self.radii * aside.max(axis=0), 0.0)], axis=0)
        return misfits

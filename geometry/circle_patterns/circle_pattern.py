"""The circle pattern of a Koebe polyhedron in the plane, before it is lifted to the sphere [BobenkoSpringborn2004].

For a closed polyhedron the point of tangency of one edge is at infinity. The circles of its two vertices and two faces
are then four lines around a rectangle, which the kites of all other circles fill. The kites of an open polyhedron
fill a disc, or a disc with holes; they go once around every centre but those of vertices at the boundary.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import ComplexArray, FloatArray, IntArray, floats, short_repr
from geometry.circle_patterns.circle_centres import circle_centres
from geometry.circle_patterns.radii import KiteAngles, RadiusProblem
from geometry.mesh import Combinatorics

__all__ = ["CirclePattern", "all_kites", "closed_circle_pattern", "laid_out"]


@dataclass(frozen=True, eq=False)
class CirclePattern:
    """Circles of the vertices and faces of a combinatorics; its faces run counter-clockwise in the plane.

    centres (N + F,), complex numbers, and radii (N + F,): of vertices, then of faces. The four circles of
    `edge_at_infinity`, where there is one, are lines: their radii are infinite, their centres are not numbers.

    >>> from geometry.circle_patterns import open_circle_pattern
    >>> from geometry.mesh.tilings import quad_patch
    >>> pattern = open_circle_pattern(quad_patch(3, 3))
    >>> pattern.vertex_radii.shape, pattern.face_radii.shape, pattern.tangency_points.shape
    ((16,), (9,), (24,))
    """

    __repr__ = short_repr

    combinatorics: Combinatorics
    centres: ComplexArray
    radii: FloatArray
    edge_at_infinity: int | None = None

    def __post_init__(self) -> None:
        centres = np.array(self.centres, dtype=np.complex128)
        centres.flags.writeable = False
        object.__setattr__(self, "centres", centres)
        object.__setattr__(self, "radii", floats(self.radii))

    @property
    def vertex_radii(self) -> FloatArray:
        """(N,)"""
        return self.radii[: self.combinatorics.n_vertices]

    @property
    def face_radii(self) -> FloatArray:
        """(F,)"""
        return self.radii[self.combinatorics.n_vertices :]

    @cached_property
    def vertex_angles(self) -> FloatArray:
        """(N,) angle that the kites fill about the centre of each vertex: 2 pi inside; meaningless for a line."""
        c = self.combinatorics
        halves = KiteAngles(all_kites(c), self.radii).at_first
        return floats(np.bincount(c.corners, 2 * halves, minlength=c.n_vertices))

    @cached_property
    def tangency_points(self) -> ComplexArray:
        """(E,) where the circles of the two ends of each edge touch; not finite for the edge at infinity.

        The direction from the centre of a vertex to the point of an edge is that to the centre of a face beside the
        edge, turned by half the angle of their kite.
        """
        c = self.combinatorics
        left, right = c.edge_corners.T
        next_right = np.where(right >= 0, c.next_corner[right], -1)
        z, n = self.centres, c.n_vertices
        points = np.full(c.n_edges, complex(np.inf, np.inf))
        for corners, side in ((left, -1), (c.next_corner[left], 1), (right, -1), (next_right, 1)):
            v, f = c.corners[corners], n + c.corner_face[corners]
            r_v, r_f = self.radii[v], self.radii[f]
            here = np.flatnonzero((corners >= 0) & np.isfinite(r_v + r_f) & np.isinf(points.real))
            v, f, r_v, r_f = v[here], f[here], r_v[here], r_f[here]
            points[here] = z[v] + (z[f] - z[v]) * (r_v * (r_v + side * 1j * r_f) / (r_v**2 + r_f**2))
        points.flags.writeable = False
        return points


def closed_circle_pattern(combinatorics: Combinatorics) -> CirclePattern:
    """Of a closed polyhedron. Infinity is at the edge with most neighbours, whose large circles are lines then.

    >>> import numpy as np
    >>> from geometry.mesh.solids import cube
    >>> pattern = closed_circle_pattern(cube().combinatorics)
    >>> np.isinf(pattern.radii).sum().item()  # the circles at the edge at infinity are lines
    4
    """
    c = combinatorics
    n = c.n_vertices
    left, right = c.edge_faces.T
    edge = int(np.argmax(c.vertex_degrees[c.edges].sum(axis=1) + c.face_sizes[left] + c.face_sizes[right]))
    is_line = np.zeros(n + c.n_faces, dtype=bool)
    is_line[c.edges[edge]] = is_line[n + c.edge_faces[edge]] = True
    kites = all_kites(c)
    lines = is_line[kites]
    angles = np.full(n + c.n_faces, 2 * np.pi)
    for end in (0, 1):  # the line of a neighbour takes half of a circle
        angles -= np.pi * np.bincount(kites[lines[:, 1 - end], end], minlength=n + c.n_faces)
    unknowns = np.where(is_line, -1, np.cumsum(~is_line) - 1)
    pattern = RadiusProblem(n, kites[~lines.any(axis=1)], unknowns, np.where(is_line, np.inf, 1.0), angles[~is_line])
    return laid_out(c, pattern, edge_at_infinity=edge)[0]


def laid_out(
    combinatorics: Combinatorics, pattern: RadiusProblem, *, edge_at_infinity: int | None = None
) -> tuple[CirclePattern, float]:
    """The pattern with its centres, and the largest gap of a kite over the distance of its centres.

    Without holes the gap is rounding; around a hole a pattern need not close.
    """
    radii = pattern.radii()
    finite = np.isfinite(radii)
    corners = np.flatnonzero(finite[all_kites(combinatorics)].all(axis=1))
    z, off = circle_centres(combinatorics, corners, pattern.kites, radii)
    centres = np.where(finite, z, complex(np.nan, np.nan))
    return CirclePattern(combinatorics, centres, radii, edge_at_infinity), off


def all_kites(c: Combinatorics) -> IntArray:
    """(C, 2) the circles of vertex and face of each corner."""
    return np.stack([c.corners, c.n_vertices + c.corner_face], axis=1)

"""Circle patterns of open polyhedra: one value is free at each vertex of the boundary, its radius or its angle.

The *angle* of a vertex is the sum of the angles of its kites at the centre of its circle. Where neither is given,
radii are equal all along the boundary. Of all patterns, the logarithms of the radii then vary least, in the mean square
of the differences between neighbours: exactly so in the limit of fine meshes, where it is Chebyshev's principle of
least distortion [SpringbornSchroederPinkall2008].
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, floats
from geometry.circle_patterns.circle_pattern import CirclePattern, all_kites, laid_out
from geometry.circle_patterns.hole_closure import outer_radii
from geometry.circle_patterns.planar_graphs import double_contact
from geometry.circle_patterns.radii import RadiusProblem
from geometry.errors import GeometryError
from geometry.mesh import Combinatorics

__all__ = ["open_circle_pattern"]

KITE_TOLERANCE = 1e-6
"""Gap of a kite over the distance of its centres, up to which the pattern closes around holes: rounding leaves 1e-9
where radii differ by a factor of a million."""

ANGLE_SUM_TOLERANCE = 1e-9
"""Deviation in radians of the sum of given angles along a boundary loop from what it must be: ten digits are
enough."""


@dataclass(frozen=True, eq=False)
class _Boundary:
    """radii and angles (N,), NaN where not given; loops: vertices of each boundary loop, the outer one first."""

    radii: FloatArray
    angles: FloatArray
    loops: list[IntArray]

    def is_free(self, loop: int) -> bool:
        vertices = self.loops[loop]
        return bool((np.isnan(self.radii[vertices]) & np.isnan(self.angles[vertices])).all())

    def free_holes(self, c: Combinatorics) -> list[IntArray]:
        """The loops but the outer one that have no values and are not filled in c."""
        holes = [vertices for loop, vertices in enumerate(self.loops) if loop and self.is_free(loop)]
        return [vertices for vertices in holes if c.is_boundary_vertex[vertices[0]]]

    def sized_holes(self, c: Combinatorics) -> list[IntArray]:
        """The loops but the outer one that are not filled in c and have no angles: their radii are given, or equal."""
        holes = [vertices for vertices in self.loops[1:] if np.isnan(self.angles[vertices]).all()]
        return [vertices for vertices in holes if c.is_boundary_vertex[vertices[0]]]

    def with_outer(self, radii: FloatArray) -> _Boundary:
        """With radii (k,) along the outer loop."""
        given = self.radii.copy()
        given[self.loops[0]] = radii
        return replace(self, radii=given)

    def angle_sum(self, loop: int) -> float:
        """The sum of the angles along a loop: the outer boundary turns once to the left, that of a hole to the
        right."""
        return (len(self.loops[loop]) + (2 if loop else -2)) * np.pi


def open_circle_pattern(
    combinatorics: Combinatorics, *, radii: Any = None, angles: Any = None, outer: int | None = None
) -> CirclePattern:
    """The circle pattern of an open polyhedron, a disc or a disc with holes.

    radii (N,): of the circles of boundary vertices, NaN elsewhere and where free. angles (N,): in the same way. Along
    a boundary loop every vertex has one of the two, or none has. outer: a vertex of the outer boundary loop, by
    default the longest one.

    The pattern has the given radii in the plane; along each further loop up to a common factor, which is determined
    since the pattern closes around the hole. Closing takes two more free numbers for each hole. So where radii are
    given around holes and the outer boundary is free, the radii of the outer boundary are not equal but nearly so, see
    `outer_radii`.

    A hole without values is temporarily filled with a face, if all vertices around it have three edges or more, which
    makes the pattern close. Otherwise its radii are equal; where the pattern does not close in this way, as few do
    without rotational symmetry, the hole is temporarily filled with triangles around a vertex.

    Raises GeometryError for values at inner vertices, missing or doubly given values, radii that are not positive,
    angles that are out of range or have an impossible sum, values for which no pattern exists, and patterns that do
    not close around a hole whose values are given.

    >>> import numpy as np
    >>> from geometry.mesh.tilings import hexagon_patch
    >>> pattern = open_circle_pattern(hexagon_patch(3, 3))
    >>> radii = pattern.vertex_radii[pattern.combinatorics.is_boundary_vertex]
    >>> bool(np.ptp(radii) < 1e-9)  # all equal, as none were given
    True
    """
    c = combinatorics
    boundary = _checked(c, radii, angles, outer)
    filled = c
    for hole in boundary.free_holes(filled):
        if (c.vertex_degrees[hole] >= 3).all():
            filled = _filled(filled, _with_face(filled, hole[::-1]))
    pattern, off = laid_out(filled, _pattern(filled, boundary))
    if off > KITE_TOLERANCE:
        for hole in boundary.free_holes(filled):
            filled = _filled(filled, _with_triangles(filled, hole[::-1]))
        pattern, off = laid_out(filled, _pattern(filled, boundary))
    holes = boundary.sized_holes(filled)
    if holes and boundary.is_free(0):  # also where it nearly closes by itself
        outer_loop = boundary.loops[0]
        of_outer = outer_radii(lambda given: _pattern(filled, boundary.with_outer(given)), outer_loop, holes)
        pattern, off = laid_out(filled, _pattern(filled, boundary.with_outer(of_outer)))
    if off > KITE_TOLERANCE and len(filled.boundary_loops) > 1:
        raise GeometryError(
            f"the circle pattern does not close around a hole: its kites are apart by {off:.1e} of their size, "
            f"allowed {KITE_TOLERANCE:.0e}; leave the values along the hole free, "
            "or give radii there and leave those of the outer boundary free",
            value=off,
            bound=KITE_TOLERANCE,
        )
    kept = np.concatenate([np.arange(c.n_vertices), filled.n_vertices + np.arange(c.n_faces)])
    return CirclePattern(c, pattern.centres[kept], pattern.radii[kept])


def _pattern(c: Combinatorics, boundary: _Boundary) -> RadiusProblem:
    n = c.n_vertices
    totals = np.full(n + c.n_faces, 2 * np.pi)
    factors = np.ones(n + c.n_faces)
    labels = np.arange(n + c.n_faces)  # circles of the same label share an unknown; -1: none
    held = False
    for loop, vertices in enumerate(boundary.loops):
        if not c.is_boundary_vertex[vertices[0]]:  # filled
            continue
        totals[vertices] = boundary.angles[vertices]
        sized = vertices[np.isnan(boundary.angles[vertices])]
        if not len(sized):
            continue
        factors[sized] = np.nan_to_num(boundary.radii[sized], nan=1.0)
        labels[sized] = sized[0] if held else -1
        totals[sized[0]] = boundary.angle_sum(loop) - np.nansum(boundary.angles[vertices])
        held = True
    kept, unknowns = np.unique(labels, return_inverse=True)
    shift = int(kept[0] < 0)
    return RadiusProblem(n, all_kites(c), unknowns - shift, factors, totals[kept[shift:]])


def _with_face(c: Combinatorics, vertices: IntArray) -> Combinatorics:
    corners = np.concatenate([c.corners, vertices])
    return Combinatorics(c.n_vertices, corners, np.append(c.face_starts, len(corners)))


def _with_triangles(c: Combinatorics, vertices: IntArray) -> Combinatorics:
    """A new vertex, joined to all of these by triangles."""
    fan = np.stack([vertices, np.roll(vertices, -1), np.full(len(vertices), c.n_vertices)], axis=1)
    starts = np.concatenate([c.face_starts, c.face_starts[-1] + 3 * np.arange(1, len(fan) + 1)])
    return Combinatorics(c.n_vertices + 1, np.concatenate([c.corners, fan.ravel()]), starts)


def _filled(c: Combinatorics, candidate: Combinatorics) -> Combinatorics:
    """The candidate, if it is still that of a polyhedron."""
    return c if double_contact(candidate) else candidate


# --- what is given


def _checked(c: Combinatorics, radii: Any, angles: Any, outer: int | None) -> _Boundary:
    r, a = (_given(c, values, name) for values, name in ((radii, "radii"), (angles, "angles")))
    _refuse_at(~np.isnan(r) & ~np.isnan(a), "vertex {} is given a radius and an angle: give one of them", r)
    _refuse_at(r <= 0, "vertex {} is given the radius {:.6g}: a number above 0 is needed", r)
    most = np.pi * np.bincount(c.corners, minlength=c.n_vertices)
    wrong = "vertex {} is given the angle {:.6g}: it must be above 0 and less than pi for each of its faces"
    _refuse_at((a <= 0) | (a >= most), wrong, a)
    loops = sorted(c.boundary_loops, key=len, reverse=True)
    if outer is not None:
        of_outer = [loop for loop in loops if outer in loop]
        if not of_outer:
            raise GeometryError(f"vertex {outer} is not on the boundary, so it is on no outer loop", elements=[outer])
        loops = of_outer + [loop for loop in loops if outer not in loop]
    boundary = _Boundary(r, a, loops)
    for loop in range(len(loops)):
        _check_loop(boundary, loop)
    return boundary


def _given(c: Combinatorics, values: Any, name: str) -> FloatArray:
    if values is None:
        return np.full(c.n_vertices, np.nan)
    given = floats(values)
    if given.shape != (c.n_vertices,):
        raise GeometryError(f"{name} have shape {given.shape}, one for each of {c.n_vertices} vertices is needed")
    _refuse_at(np.isinf(given), f"vertex {{}} is given {name} of {{}}: finite numbers are needed, or NaN", given)
    inside = ~np.isnan(given) & ~c.is_boundary_vertex
    _refuse_at(inside, f"vertex {{}} is inside and is given {name}: only the boundary is free, write NaN", given)
    return given


def _refuse_at(wrong: BoolArray, message: str, values: FloatArray) -> None:
    vertices = np.flatnonzero(wrong)
    if len(vertices):
        value = float(values[vertices[0]])
        raise GeometryError(message.format(vertices[0], value), elements=vertices.tolist(), value=value)


def _check_loop(boundary: _Boundary, loop: int) -> None:
    if boundary.is_free(loop):
        return
    vertices, angles = boundary.loops[loop], boundary.angles[boundary.loops[loop]]
    missing = vertices[np.isnan(angles) & np.isnan(boundary.radii[vertices])]
    if len(missing):
        raise GeometryError(
            f"vertex {missing[0]} is given neither a radius nor an angle, but others of its boundary loop are: give "
            "one of them to all of the loop, or none",
            elements=missing.tolist(),
        )
    total, wanted = float(np.nansum(angles)), boundary.angle_sum(loop)
    if np.isnan(angles).any():
        wrong, relation = total >= wanted, "less than"
    else:
        wrong, relation = abs(total - wanted) > ANGLE_SUM_TOLERANCE, "exactly"
    if wrong:
        raise GeometryError(
            f"the angles along the {'hole' if loop else 'outer boundary'} through vertex {vertices[0]} sum to "
            f"{total:.10g}; for its {len(vertices)} vertices it must be {relation} {wanted:.10g}, as the loop "
            "makes one full turn",
            elements=vertices.tolist(),
            value=total,
            bound=wanted,
        )

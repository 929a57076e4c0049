"""Curves that follow a field of directions over the triangles of a surface, all of them a triangle further at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import BoolArray, ComplexArray, FloatArray, IntArray, floats, integers
from geometry.traced_curves.line_fields import LineField

__all__ = ["Walks", "walk"]

CORNER_CLEARANCE = 1e-6
"""Barycentric coordinate by which a point on a side stays away from its ends, so that it is never in a corner."""

LARGEST_TURN = np.radians(60.0)
"""Largest angle in radians between directions in neighbouring triangles, above which a curve ends: next to a singular
point the field is not steady."""

CLOSING_SHARE = 0.1
"""Distance of a curve from its beginning, over the spacing of curves, within which it is closed."""

LEAST_LOOP = 3.0
"""Length over the spacing of curves, from which on a curve may be closed."""


@dataclass(frozen=True, eq=False)
class Walks:
    """Points of n curves, one curve after another: starts (n+1,), triangles (P,), weights (P, 3) barycentric;
    is_closed (n,): whether the curve ends where it began."""

    starts: IntArray
    triangles: IntArray
    weights: FloatArray
    is_closed: BoolArray


def walk(
    field: LineField, triangles: IntArray, weights: FloatArray, families: IntArray, *, spacing: float, longest: float
) -> Walks:
    """Curves through seeds (n,) in both directions, to the boundary, to where there is no direction, or to their own
    beginning; at most `longest` each way.

    In each triangle a curve is straight, in the direction of the field halfway across [midpoint rule].
    """
    both = _half_walks(
        field,
        np.repeat(triangles, 2),
        np.repeat(weights, 2, axis=0),
        np.repeat(families, 2),
        np.tile([1.0, -1.0], len(triangles)),
        spacing,
        longest,
    )
    walker, at, here, closed = both
    order = np.argsort(walker, kind="stable")
    walker, at, here = walker[order], at[order], here[order]
    is_back, is_closed = walker % 2 == 1, closed[::2]
    kept = ~(
        is_back & (is_closed[walker // 2] | (np.diff(walker, prepend=-1) > 0))
    )  # a closed curve is run through once
    walker, at, here = walker[kept], at[kept], here[kept]
    step = np.where(walker % 2 == 1, -1, 1) * np.arange(len(walker))
    order = np.lexsort((step, walker % 2 == 0, walker // 2))  # backwards, then forwards
    starts = np.searchsorted(walker[order] // 2, np.arange(len(triangles) + 1))
    return Walks(integers(starts), integers(at[order]), floats(here[order]), is_closed)


def _half_walks(
    field: LineField,
    triangles: IntArray,
    weights: FloatArray,
    families: IntArray,
    signs: FloatArray,
    spacing: float,
    longest: float,
) -> tuple[IntArray, IntArray, FloatArray, BoolArray]:
    """Walker (P,), triangle (P,) and weights (P, 3) of each point, in the order of steps; closed (n,)."""
    c, sides = field.frames.combinatorics, field.frames.sides
    closed = np.zeros(len(triangles), dtype=bool)
    z, exists = field.directions(triangles, weights, families)
    alive = np.flatnonzero(exists)
    at, here, heading = triangles[alive], weights[alive], z[alive] * signs[alive]
    entry = np.full(len(alive), -1)
    begin, begin_heading = _points(field, at, here), _in_space(field, at, heading)
    length = np.zeros(len(alive))
    record = [(alive, at, here)]
    while len(alive):
        step, new, exit_side, goes_on = _across(field, at, here, heading, entry, families[alive])
        alive, at = alive[goes_on], at[goes_on]
        here, begin, begin_heading, length = (each[goes_on] for each in (here, begin, begin_heading, length))
        step, new, exit_side = step[goes_on], new[goes_on], exit_side[goes_on]
        length = length + np.abs(step)
        returns = _returns(field, at, here, new, step, begin, begin_heading, length, spacing)
        closed[alive[returns]] = True
        first = np.searchsorted(record[0][0], alive[returns])
        new[returns], at[returns] = record[0][2][first], record[0][1][first]
        record.append((alive, at, new))
        corner = 3 * at + exit_side
        twin = c.twin[corner]
        on = ~returns & (twin >= 0) & (length < longest)
        alive, at, corner, twin = (each[on] for each in (alive, at, corner, twin))
        new, begin, begin_heading, length = (each[on] for each in (new, begin, begin_heading, length))
        step = step[on]
        carried = -sides.ravel()[twin] / sides.ravel()[corner]
        heading = step * carried / np.abs(step * carried)
        rows = np.arange(len(alive))
        here = np.zeros((len(alive), 3))
        tail = new[rows, corner % 3]
        here[rows, (twin + 1) % 3], here[rows, twin % 3] = tail, 1 - tail
        at, entry = twin // 3, twin % 3
    walker, triangle, point = (np.concatenate(each) for each in zip(*record, strict=True))
    return walker, triangle, point, closed


def _across(
    field: LineField,
    at: IntArray,
    here: FloatArray,
    heading: ComplexArray,
    entry: IntArray,
    families: IntArray,
) -> tuple[ComplexArray, FloatArray, IntArray, BoolArray]:
    """The steps (n,) across triangles (n,) from points (n, 3), headed for (n,) and entered by a side (n,), -1 inside;
    the points (n, 3) where they leave, the sides (n,) there, and whether they do (n,)."""
    gradients = field.frames.gradients[at]
    first, goes_on = _aligned(field, at, here, families, heading)
    first = _inwards(field, at, entry, first)[0]
    share, _ = _leaving(gradients, here, first)
    middle = here + share[:, None] / 2 * (gradients.conj() * first[:, None]).real
    second, exists = _aligned(field, at, middle.clip(0, 1), families, first)
    second, enters = _inwards(field, at, entry, second)
    share, corner = _leaving(gradients, here, second)
    new = here + share[:, None] * (gradients.conj() * second[:, None]).real
    rows = np.arange(len(at))
    new[rows, corner] = 0.0
    others = np.stack([(corner + 1) % 3, (corner + 2) % 3], axis=1)
    ends = new[rows[:, None], others].clip(CORNER_CLEARANCE, None)
    new[rows[:, None], others] = ends / ends.sum(axis=1, keepdims=True)
    return share * second, new, (corner + 1) % 3, goes_on & exists & enters & (share > 0)


def _aligned(
    field: LineField, at: IntArray, here: FloatArray, families: IntArray, heading: ComplexArray
) -> tuple[ComplexArray, BoolArray]:
    """(n,) directions at points, nearest to those headed for (n,); and whether they are near enough."""
    z, exists = field.directions(at, here, families)
    along = (z * heading.conj()).real
    z = np.where(along < 0, -z, z)
    return z, exists & (np.abs(along) > np.cos(LARGEST_TURN))


def _inwards(field: LineField, at: IntArray, entry: IntArray, z: ComplexArray) -> tuple[ComplexArray, BoolArray]:
    """Directions (n,), along the side by which a curve has just come where they would lead out of it again; and
    whether they are near enough to it."""
    inside = entry < 0
    side = field.frames.sides[at, np.maximum(entry, 0)]
    side = side / np.abs(side)
    turned = z * side.conj()  # inwards is to the left of the side
    outwards = ~inside & (turned.imag <= 0)
    along = np.where(turned.real < 0, -side, side)
    return np.where(outwards, along, z), ~outwards | (np.abs(turned.real) > np.cos(LARGEST_TURN))


def _leaving(gradients: ComplexArray, here: FloatArray, z: ComplexArray) -> tuple[FloatArray, IntArray]:
    """(n,) how far it is from points (n, 3) along directions (n,) to the border of the triangle, and the corner (n,)
    opposite to the side that is met."""
    rates = (gradients.conj() * z[:, None]).real
    least = 1e-12 * np.abs(gradients).max(axis=1, keepdims=True)
    shares = np.divide(here, -rates, out=np.full_like(here, np.inf), where=rates < -least)
    corner = shares.argmin(axis=1)
    return np.asarray(shares[np.arange(len(z)), corner]), np.asarray(corner)


def _points(field: LineField, at: IntArray, here: FloatArray) -> FloatArray:
    """(n, 3) points in space."""
    return np.asarray(np.einsum("nk,nki->ni", here, field.frames.mesh.vertices[field.frames.triangles[at]]))


def _in_space(field: LineField, at: IntArray, z: ComplexArray) -> FloatArray:
    """(n, 3) vectors (n,) of the frames of triangles (n,)."""
    return np.asarray(np.einsum("an,nai->ni", [z.real, z.imag], field.frames.axes[at]))


def _returns(
    field: LineField,
    at: IntArray,
    here: FloatArray,
    new: FloatArray,
    step: ComplexArray,
    begin: FloatArray,
    begin_heading: FloatArray,
    length: FloatArray,
    spacing: float,
) -> BoolArray:
    """(n,) whether the last step passes the beginning of the curve, in the same direction."""
    tails, heads = _points(field, at, here), _points(field, at, new)
    along = heads - tails
    offsets = begin - tails
    share = np.einsum("ni,ni->n", offsets, along) / np.maximum(np.einsum("ni,ni->n", along, along), 1e-300)
    off = np.linalg.norm(offsets - share.clip(0, 1)[:, None] * along, axis=1)
    same = np.einsum("ni,ni->n", along, begin_heading) > 0.5 * np.abs(step)
    return np.asarray(
        (length > LEAST_LOOP * spacing) & same & (share >= 0) & (share <= 1) & (off < CLOSING_SHARE * spacing)
    )

"""Solids as convex pieces: those that they bring with them, or their own.

Two pieces are compared by each face of the one with each corner of the other, and a large plate has many neighbours. So
prisms over outlines with many corners are cut into triangular prisms even if they are convex.
"""

from __future__ import annotations

import numpy as np
import shapely

from fabkit.checking.convex_pieces import MAX_CORNERS_UNCUT, triangles
from fabkit.checking.separation import Pieces, distinct, shafts
from fabkit.parts import Measures, SolidArray, Topology, prism_topology
from geometry.arrays import BoolArray, FloatArray

__all__ = ["convex_pieces", "is_splittable"]

CONVEXITY_TOLERANCE_MM = 1e-6
"""Largest height of a corner above a face plane of its solid, up to which the solid counts as convex, in mm."""


def convex_pieces(batch: SolidArray) -> list[Pieces]:
    """Solids with pieces as those; round bars and convex solids with few corners as they are; all others, which must be
    splittable, as triangular prisms."""
    if batch.topology.pieces:
        return [pieces for own in _own_pieces(batch) for pieces in convex_pieces(own)]
    if batch.topology.is_convex_shaft:
        centres = batch.vertices[:, batch.topology.rounds[0, :3:2]]
        return [shafts(batch.parts, centres, batch.normals, Measures(batch.topology, batch.vertices).radii[:, 0])]
    uncut = _is_uncut(batch)
    if uncut.all():
        return [_pieces(batch)]
    return [_pieces(part) for part in (batch[uncut], _triangular_prisms(batch[~uncut])) if len(part.parts)]


def _own_pieces(batch: SolidArray) -> list[SolidArray]:
    """The pieces of the solids, those of one topology together."""
    found: dict[Topology, list[FloatArray]] = {}
    for numbers, topology in batch.topology.pieces:
        found.setdefault(topology, []).append(batch.vertices[:, numbers])
    return [
        SolidArray(topology, np.tile(batch.parts, len(vertices)), np.concatenate(vertices))
        for topology, vertices in found.items()
    ]


def is_splittable(batch: SolidArray) -> BoolArray:
    """(P,) whether `convex_pieces` can take each solid: it has pieces that it can take, or is a round bar, convex, or a
    right or oblique prism over a simple polygon."""
    if batch.topology.pieces:
        every = np.ones(len(batch.parts), dtype=bool)
        for numbers, topology in batch.topology.pieces:
            every &= is_splittable(SolidArray(topology, batch.parts, batch.vertices[:, numbers]))
        return every
    if batch.topology.is_convex_shaft:
        return np.asarray(Measures(batch.topology, batch.vertices).shortest_sides[:, 0] > 0)
    result = _is_uncut(batch)
    others = np.flatnonzero(~result)
    n = batch.topology.n_vertices // 2
    if len(others) and _is_prism(batch.topology):
        vertices = batch.vertices[others]
        outlines, axes, _ = _along_axes(vertices)
        generators = vertices[:, n:] - vertices[:, :n]
        deviations = np.linalg.norm(np.cross(generators, axes[:, None, :]), axis=-1).max(axis=1)
        result[others] = (deviations <= CONVEXITY_TOLERANCE_MM) & shapely.is_valid(shapely.polygons(outlines))
    return result


def _is_uncut(batch: SolidArray) -> BoolArray:
    """(P,) whether each solid is convex and not a prism over an outline with many corners."""
    t = batch.topology
    if len(t.rounds) or len(t.fillets) or (t.n_vertices > 2 * MAX_CORNERS_UNCUT and _is_prism(t)):
        return np.zeros(len(batch.parts), dtype=bool)
    is_convex = np.empty(len(batch.parts), dtype=bool)
    done = 0
    for few in batch.in_batches():
        normals = batch.normals[done : done + len(few.parts)]
        levels = np.einsum("pfk,pfk->pf", normals, few.vertices[:, t.face_vertex])
        heights = normals @ few.vertices.transpose(0, 2, 1) - levels[..., None]
        is_convex[done : done + len(few.parts)] = heights.max(axis=(1, 2), initial=-np.inf) <= CONVEXITY_TOLERANCE_MM
        done += len(few.parts)
    return is_convex


def _is_prism(topology: Topology) -> bool:
    n, odd = divmod(topology.n_vertices, 2)
    if odd or n < 3:
        return False
    prism = prism_topology(n)
    names = ("corners", "loop_starts", "face_starts", "rounds", "fillets")
    return all(np.array_equal(getattr(topology, name), getattr(prism, name)) for name in names)


def _along_axes(vertices: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Prisms with vertices (P, 2n, 3) projected along their axes, with their first corners as origins: outlines (P, n,
    2), counter-clockwise; unit axes (P, 3); two unit vectors perpendicular to each, the columns of (P, 3, 2)."""
    n = vertices.shape[1] // 2
    axes = vertices[:, n] - vertices[:, 0]
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    x = np.cross(np.eye(3)[np.abs(axes).argmin(axis=1)], axes)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    plane = np.stack([x, np.cross(axes, x)], axis=-1)
    return (vertices[:, :n] - vertices[:, :1]) @ plane, axes, plane


def _triangular_prisms(batch: SolidArray) -> SolidArray:
    if not len(batch.parts):
        return batch
    outlines, axes, plane = _along_axes(batch.vertices)
    corners, owner = triangles(outlines)
    points = np.einsum("tck,tjk->tcj", corners, plane[owner])
    normals = batch.normals
    ends = []
    for face, first in ((0, 0), (1, batch.topology.n_vertices // 2)):  # both ends are planar, but need not be square
        slope = normals[:, face] / np.einsum("pk,pk->p", normals[:, face], axes)[:, None]
        rise = -np.einsum("tcj,tj->tc", points, slope[owner])
        ends.append(batch.vertices[owner, None, first] + points + rise[..., None] * axes[owner, None])
    return SolidArray(prism_topology(3), batch.parts[owner], np.concatenate(ends, axis=1))


def _pieces(batch: SolidArray) -> Pieces:
    return Pieces(batch.parts, batch.vertices, distinct(batch.normals), batch.topology.edges)

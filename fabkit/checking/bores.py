"""Round bars and polyhedra in bores: what is in a bore of another part shares no volume with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fabkit.checking.separation import Pieces, shafts
from fabkit.parts import BORE, Measures, SolidArray
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["PlacedBores", "are_in_bores", "outside_bores"]


@dataclass(frozen=True, eq=False)
class PlacedBores:
    """All bores, in the order of their parts (B,). centres (B, 2, 3); normals (B, 2, 3): unit normals of the planes at
    their ends, along the axes; radii (B,) in mm."""

    parts: IntArray
    centres: FloatArray
    normals: FloatArray
    radii: FloatArray

    @classmethod
    def of(cls, batches: Sequence[SolidArray]) -> PlacedBores:
        found = [cls(np.zeros(0, dtype=np.int64), np.zeros((0, 2, 3)), np.zeros((0, 2, 3)), np.zeros(0))]
        for batch in batches:
            rounds = batch.topology.rounds
            own = np.flatnonzero(rounds[:, 6] == BORE)
            if not len(own):
                continue
            measures = Measures(batch.topology, batch.vertices)
            normals = measures.normals[:, rounds[own, 4:6]]
            along = np.einsum("pbek,kpb->pbe", normals, measures.round_axes[:, :, own])
            found.append(
                cls(
                    np.repeat(batch.parts, len(own)),
                    batch.vertices[:, rounds[own][:, [0, 2]]].reshape(-1, 2, 3),
                    (normals * np.sign(along)[..., None]).reshape(-1, 2, 3),
                    measures.radii[:, own].ravel(),
                )
            )
        order = np.argsort(np.concatenate([each.parts for each in found]), kind="stable")
        parts, centres, normals, radii = (
            np.concatenate([getattr(each, name) for each in found])[order]
            for name in ("parts", "centres", "normals", "radii")
        )
        return cls(parts, centres, normals, radii)


def outside_bores(
    bars: Pieces, parts: IntArray, bores: PlacedBores, *, touching_mm: float
) -> tuple[Pieces, IntArray, IntArray]:
    """Round bars, each (Q,) compared with another part (Q,), without what is in bores of that part; (R,) which of the
    bars each of the rest is of; (m,) the bars that are in a bore somewhere. A bar is in a bore where its axis is, as a
    whole, as far from the bore's wall as its radius."""
    radii = np.linalg.norm(bars.half_axes[:, 0, 1], axis=1)  # type: ignore[index]
    bar, bore = _inside_walls(bars, radii, parts, bores, touching_mm)
    # where the axis of the bar crosses the ends of the bore
    direction = bars.directions[bar, 0]
    along = np.einsum("kej,kj->ke", bores.normals[bore], direction)
    to_ends = bores.centres[bore] - bars.vertices[bar, :1]
    levels = np.einsum("kej,kej->ke", to_ends, bores.normals[bore]) / along
    turned = along[:, 0] < 0
    levels, normals = (
        np.where(turned.reshape(-1, *[1] * (each.ndim - 1)), each[:, ::-1], each)
        for each in (levels, bores.normals[bore])
    )
    return _rest(bars, radii, bar, levels, normals, touching_mm)


def are_in_bores(pieces: Pieces, others: Pieces, bores: PlacedBores, *, touching_mm: float) -> BoolArray:
    """(Q,) whether each polyhedron lies as a whole in a bore of the part of the other piece in its row: all its corners
    are within the wall of the bore, and at either end of it the polyhedron or that piece ends too."""
    inside = np.zeros(len(pieces.parts), dtype=bool)
    row, bore = _inside_walls(pieces, np.zeros(len(inside)), others.parts, bores, touching_mm)
    ends_there = np.ones(len(row), dtype=bool)
    for end, outwards in ((0, -1.0), (1, 1.0)):
        normals, centres = outwards * bores.normals[bore, end : end + 1], bores.centres[bore, end : end + 1]
        reach = [each.taken(row).extents(normals, centres)[1][:, 0] for each in (pieces, others)]
        ends_there &= np.minimum(*reach) <= touching_mm
    inside[row[ends_there]] = True
    return inside


def _inside_walls(
    pieces: Pieces, radii: FloatArray, parts: IntArray, bores: PlacedBores, touching_mm: float
) -> tuple[IntArray, IntArray]:
    """Rows of pieces (Q,), and bores of the part (Q,) in that row, whose axis is as far from all vertices of the piece
    as its wall is, without the radius (Q,) of the piece, or nearer; however long the bore is."""
    first, last = np.searchsorted(bores.parts, parts), np.searchsorted(bores.parts, parts, side="right")
    row = np.repeat(np.arange(len(parts)), last - first)
    bore = np.arange(len(row)) - np.repeat(np.cumsum(last - first) - last, last - first)
    axis = bores.centres[bore, 1] - bores.centres[bore, 0]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    away = pieces.vertices[row] - bores.centres[bore, :1]
    away -= np.einsum("kej,kj->ke", away, axis)[..., None] * axis[:, None]
    inside = np.linalg.norm(away, axis=2).max(axis=1, initial=0.0) + radii[row] <= bores.radii[bore] + touching_mm
    return row[inside], bore[inside]


def _rest(
    bars: Pieces, radii: FloatArray, bar: IntArray, levels: FloatArray, normals: FloatArray, touching_mm: float
) -> tuple[Pieces, IntArray, IntArray]:
    """The bars without the intervals levels (k, 2) of these bars (k,), at the ends of which are planes with these
    normals (k, 2, 3)."""
    concerned = np.unique(bar)
    lengths = np.linalg.norm(bars.vertices[concerned, 1] - bars.vertices[concerned, 0], axis=1)
    # before the first interval and after the last one the bar has its own ends
    owner = np.concatenate([concerned, bar, concerned])
    starts = np.concatenate([np.full(len(concerned), -np.inf), levels[:, 0], lengths])
    stops = np.concatenate([np.zeros(len(concerned)), levels[:, 1], np.full(len(concerned), np.inf)])
    own = bars.normals[concerned]
    faces = np.concatenate([np.stack([own[:, 0]] * 2, axis=1), normals, np.stack([own[:, 1]] * 2, axis=1)])
    order = np.lexsort((starts, owner))
    owner, starts, stops, faces = owner[order], starts[order], stops[order], faces[order]
    gap = np.flatnonzero((owner[1:] == owner[:-1]) & (starts[1:] - stops[:-1] > touching_mm))
    owner = owner[gap]
    ends = np.stack([stops[gap], starts[gap + 1]], axis=1)
    centres = bars.vertices[owner, :1] + ends[..., None] * bars.directions[owner]
    rest = shafts(bars.parts[owner], centres, np.stack([faces[gap, 1], faces[gap + 1, 0]], axis=1), radii[owner])
    return rest, owner, concerned

"""Drawings of bars and blocks of a finished folder: their lines against the solids, their words against the tables."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fabkit.formats.finished.dxf_checks import are_texts
from fabkit.formats.finished.dxf_files import DxfFile
from fabkit.formats.finished.part_geometry import PartSolid
from fabkit.production import HIDDEN, LABEL, VISIBLE
from fabkit.production.part_drawing import LABEL_MM, SAME_LINE_MM, VIEW_GAP_MM
from fabkit.production.part_views import CHORDS
from geometry.arrays import BoolArray, FloatArray

__all__ = ["check_views"]

LINE_TOLERANCE_MM = 1e-6
"""Largest distance in mm of a point of a drawing from where the solid has it; 9 decimals are written."""
LEAST_LINE_MM = 2e-3
"""Length in mm of an edge as it is seen, from which on it must be drawn: shorter ones are points there."""


def check_views(name: str, file: DxfFile, solid: PartSolid, texts: tuple[str, ...]) -> Iterator[str]:
    """Each line is an edge of the solid as it is seen, and each edge is drawn, visible or hidden; rounds are arcs.
    texts: ends or facets, which are labelled in their order."""
    others = (file.curves.keys() | file.circles.keys()) - {VISIBLE, HIDDEN, LABEL}
    if others or any(is_closed for own in file.curves.values() for is_closed, _ in own):
        yield f"{name} has a closed line, or layers {', '.join(sorted(others))}"
    drawn = [points for layer in (VISIBLE, HIDDEN) for _, points in file.curves.get(layer, [])]
    lines = np.array([points for points in drawn if len(points) == 2]).reshape(-1, 2, 2)
    seen = np.concatenate([_seen(solid.edges, solid, 2), _seen(solid.edges, solid, 1)])
    known = _ordered(lines)[:, None] - _ordered(seen)
    near = np.abs(known).reshape(*known.shape[:2], 4).max(axis=2) <= LINE_TOLERANCE_MM
    free = lines[~near.any(axis=1)]
    if not _are_outlines(free, solid):
        at = ", ".join(f"{value:.3f}" for value in free[0, 0])
        yield f"{name} has a line from ({at}) that is not an edge of the solid"
    long = np.linalg.norm(seen[:, 1] - seen[:, 0], axis=1) > LEAST_LINE_MM
    if not len(solid.rounds) and (long & ~_are_drawn(seen, lines)).any():
        yield f"{name} lacks an edge of the solid"
    if len(np.unique(np.round(_ordered(lines).reshape(-1, 4), 6), axis=0)) != len(lines):
        yield f"{name} has a line twice"
    if not all(map(_is_arc, (points for points in drawn if len(points) != 2))):
        yield f"{name} has a curve that is no arc"
    rings = np.array([ring for own in file.circles.values() for ring in own]).reshape(-1, 3)
    if not len(rings) or len(solid.rounds):
        off = np.minimum(*(_off_axes(rings, solid, up) for up in (2, 1)))
    else:
        off = np.full(1, np.inf)
    if off.max(initial=0.0) > LINE_TOLERANCE_MM:
        yield f"{name} has a circle that is not a hole of the solid"
    labels = [points for _, points in file.curves.get(LABEL, [])]
    if not are_texts(labels, [[text] for text in texts], LABEL_MM):
        yield f"{name} does not have the labels {', '.join(texts)}"


def _seen(points: FloatArray, solid: PartSolid, up: int) -> FloatArray:
    """(..., 2) points seen from the side (up: 2), or from outside (1) below that view."""
    reach = np.concatenate([solid.corners, solid.centres])
    down = 0.0 if up == 2 else reach[:, 2].min() - VIEW_GAP_MM - reach[:, 1].max()
    found: FloatArray = points[..., [0, up]] + [0.0, down]
    return found


def _are_drawn(edges: FloatArray, lines: FloatArray) -> BoolArray:
    """(n,) whether each edge (n, 2, 2) is among the lines, from either end, or so near to one that both are one."""
    apart = [
        np.abs(lines[:, None, ::step] - edges).reshape(len(lines), -1, 4).max(axis=2).min(axis=0, initial=np.inf)
        for step in (1, -1)
    ]
    return np.asarray(np.minimum(*apart) <= SAME_LINE_MM + LINE_TOLERANCE_MM)


def _off_axes(rings: FloatArray, solid: PartSolid, up: int) -> FloatArray:
    """(n,) how far circles (n, 3), centre and radius, are from the nearest round of the solid, anywhere along its axis,
    which may be seen a little obliquely."""
    along = solid.rounds[:, [3, 3 + up]]
    sizes = np.linalg.norm(along, axis=1)
    units = along / np.where(sizes > 0, sizes, 1.0)[:, None]
    away = rings[:, None, :2] - _seen(solid.rounds[:, :3], solid, up)
    limit = sizes * np.ptp(solid.corners, axis=0).max()
    away -= np.clip(np.einsum("nrk,rk->nr", away, units), -limit, limit)[..., None] * units
    off = np.maximum(np.abs(away).max(axis=2), np.abs(rings[:, None, 2] - solid.rounds[:, 6]))
    return np.asarray(off.min(axis=1, initial=np.inf))


def _ordered(lines: FloatArray) -> FloatArray:
    """Lines (n, 2, 2) with their left ends first, of upright ones the lower."""
    x, y = np.round(lines[:, 1] - lines[:, 0], 6).T
    turned = (x < 0) | ((x == 0) & (y < 0))
    return np.where(turned[:, None, None], lines[:, ::-1], lines)


def _are_outlines(lines: FloatArray, solid: PartSolid) -> bool:
    """Whether each line is the outline of a round: as far from its axis as its radius."""
    if not len(lines):
        return True
    if not len(solid.rounds):
        return False
    fits = np.zeros(len(lines), dtype=bool)
    for up in (2, 1):
        start = _seen(solid.rounds[:, :3], solid, up)
        along = solid.rounds[:, [3, 3 + up]]
        sizes = np.linalg.norm(along, axis=1)
        across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.where(sizes > 0, sizes, 1.0)[:, None]
        off = np.abs(np.einsum("lerk,rk->ler", lines[:, :, None] - start, across)) - solid.rounds[:, 6]
        fits |= (np.abs(off).max(axis=1) <= LINE_TOLERANCE_MM).any(axis=1)
    return bool(fits.all())


def _is_arc(points: FloatArray) -> bool:
    """Whether the points are those of an arc that is seen at any angle, in equal steps: p[k-1] + p[k+1] - 2 cos p[k] is
    the same for all."""
    found = points[:-2] + points[2:] - 2 * np.cos(np.pi / CHORDS) * points[1:-1]
    return len(points) > 3 and bool(np.abs(found - found.mean(axis=0)).max() <= LINE_TOLERANCE_MM)

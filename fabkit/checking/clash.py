"""Clash detection: parts that share volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fabkit.checking.bores import PlacedBores, are_in_bores, outside_bores
from fabkit.checking.convex import convex_pieces, is_splittable
from fabkit.checking.positions import Positions
from fabkit.checking.separation import Pieces, depths
from fabkit.errors import DetailingError
from fabkit.parts import Assembly, Part, SolidArray
from geometry.arrays import FloatArray, IntArray

__all__ = ["clashes", "clashing_pairs"]

TOUCHING_MM = 1e-6
"""Depth of overlap in mm up to which two parts only touch. Rounding gives faces that meet exactly a depth of 1e-9
mm."""


def clashes(assembly: Assembly, *, depth_mm: float = TOUCHING_MM) -> list[tuple[Part, Part, float]]:
    """All pairs of parts that overlap by more than `depth_mm`, with the depth of the overlap in mm.

    The depth is the shortest displacement that separates the two parts; where a part is not convex, the largest such
    depth over its convex pieces; of a round bar it may be too large. A round bar in a bore, such as a bolt, shares no
    volume with the part that is bored, nor does a part with planar faces that is in a bore as a whole, such as a plate
    inside a tube. The solids must be valid (`violations` reports those that are not). Pairs are in
    the order of `assembly.parts()`. Raises DetailingError where a solid has no convex pieces and is neither convex nor
    a prism over a simple polygon.

    >>> import numpy as np
    >>> from dataclasses import replace
    >>> from fabkit import Project, design
    >>> from fabkit.checking import clashes
    >>> from geometry.mesh.shapes import dome
    >>> roof = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly
    >>> lowered = replace(roof["panels"], origins=roof["panels"].origins - np.array([0, 0, 30]))
    >>> len(clashes(roof)), len(clashes(roof.with_group(lowered))) > 0
    (0, True)
    """
    positions = Positions(assembly)
    batches = positions.placed()
    for batch in batches:
        for position in batch.parts[~is_splittable(batch)].tolist():
            part = positions[position]
            raise DetailingError(
                f"{part.kind.name} {part.mark} ({part.kind.element} {part.element}, counted from 0) is neither "
                "convex nor a prism over a simple polygon, so its clashes cannot be found; build it as a prism, or "
                "give its topology convex pieces"
            )
    pairs, found = clashing_pairs(batches, depth_mm=depth_mm)
    return [(positions[i], positions[j], d) for (i, j), d in zip(pairs.tolist(), found.tolist(), strict=True)]


def clashing_pairs(batches: Sequence[SolidArray], *, depth_mm: float = TOUCHING_MM) -> tuple[IntArray, FloatArray]:
    """(K, 2) positions of all pairs of parts that overlap by more than `depth_mm`, sorted, the lower position first;
    (K,) depths of the overlaps in mm. All solids must have convex pieces or be convex or prisms, see `is_splittable`.
    What is in a bore shares no volume with the part that is bored, see `clashes`.

    >>> import numpy as np
    >>> from fabkit.checking import clashing_pairs
    >>> from fabkit.parts import SolidArray, prism_topology, prism_vertices
    >>> square = np.array([[0, 0], [10, 0], [10, 10], [0, 10]])
    >>> boxes = prism_vertices(np.stack([square, square + 8, square + 20]), 0.0, 5.0)
    >>> pairs, depths = clashing_pairs([SolidArray(prism_topology(4), np.arange(3), boxes)])
    >>> pairs.tolist(), depths.round(6).tolist()
    ([[0, 1]], [2.0])
    """
    shapes = [pieces for batch in batches for pieces in convex_pieces(batch)]
    if not shapes:
        return np.empty((0, 2), dtype=np.int64), np.empty(0)
    candidates, bores = _candidates(shapes), PlacedBores.of(batches)
    counts = [len(pieces.parts) for pieces in shapes]
    shape = np.repeat(np.arange(len(shapes)), counts)
    row = np.concatenate([np.arange(count) for count in counts])
    found = np.empty(len(candidates))
    group = shape[candidates] @ np.array([len(shapes), 1])
    for number in np.unique(group).tolist():
        members = np.flatnonzero(group == number)
        first, second = divmod(number, len(shapes))
        pairs = row[candidates[members]]
        found[members] = depths(shapes[first], shapes[second], pairs, touching_mm=depth_mm)
        for one, other, order in ((first, second, [0, 1]), (second, first, [1, 0])):
            deep: IntArray = members[found[members] > depth_mm]
            rows = row[candidates[deep]][:, order]
            found[deep] = _outside_bores(shapes[one], shapes[other], rows, found[deep], bores, depth_mm)
    clashing = found > depth_mm
    parts = np.concatenate([pieces.parts for pieces in shapes])
    return _deepest(np.sort(parts[candidates[clashing]], axis=1), found[clashing])


def _outside_bores(
    pieces: Pieces, others: Pieces, pairs: IntArray, found: FloatArray, bores: PlacedBores, depth_mm: float
) -> FloatArray:
    """(K,) depths found of pairs (K, 2) of a piece and a piece of another part, without what is in bores of that part:
    of round bars whatever is, of polyhedra those that are as a whole."""
    one = pieces.taken(pairs[:, 0])
    if one.half_axes is None:
        return np.where(are_in_bores(one, others.taken(pairs[:, 1]), bores, touching_mm=depth_mm), 0.0, found)
    rest, of, concerned = outside_bores(one, others.parts[pairs[:, 1]], bores, touching_mm=depth_mm)
    left = found.copy()
    left[concerned] = 0.0
    rows = np.stack([np.arange(len(of)), pairs[of, 1]], axis=1)
    np.maximum.at(left, of, depths(rest, others, rows, touching_mm=depth_mm))
    return left


def _candidates(shapes: Sequence[Pieces]) -> IntArray:
    """(K, 2) pieces of different parts whose axis-aligned boxes meet; pieces are numbered through all shapes."""
    parts = np.concatenate([pieces.parts for pieces in shapes])
    lower, upper = (np.concatenate(corners) for corners in zip(*(pieces.boxes for pieces in shapes), strict=True))
    z, x, y = np.argsort(np.ptp(lower, axis=0))  # the tree is two-dimensional, in the plane of the two longest extents
    boxes = shapely.box(lower[:, x], lower[:, y], upper[:, x], upper[:, y])
    first, second = shapely.STRtree(boxes).query(boxes)
    meet = (first < second) & (parts[first] != parts[second])
    first, second = first[meet], second[meet]
    meet = (lower[first, z] <= upper[second, z]) & (lower[second, z] <= upper[first, z])
    pairs: IntArray = np.stack([first[meet], second[meet]], axis=1)
    return pairs


def _deepest(pairs: IntArray, found: FloatArray) -> tuple[IntArray, FloatArray]:
    """Each pair of parts once, sorted, with the largest depth over its pieces."""
    order = np.lexsort((-found, pairs[:, 1], pairs[:, 0]))
    pairs, found = pairs[order], found[order]
    first = np.ones(len(pairs), dtype=bool)
    first[1:] = (pairs[1:] != pairs[:-1]).any(axis=1)
    return pairs[first], found[first]

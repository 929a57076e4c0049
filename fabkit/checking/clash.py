"""Which parts share volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely

from fabkit.checking.convex import Pieces, convex_pieces, depths, is_splittable
from fabkit.checking.positions import Positions
from fabkit.errors import DetailingError
from fabkit.parts import Assembly, Part, SolidArray
from geometry.arrays import FloatArray, IntArray

__all__ = ["clashes", "clashing_pairs"]

TOUCHING_MM = 1e-6
"""Depth of overlap up to which two parts only touch, in mm. Rounding makes 1e-9 mm of faces that meet exactly."""


def clashes(assembly: Assembly, *, depth_mm: float = TOUCHING_MM) -> list[tuple[Part, Part, float]]:
    """Every two parts that reach into each other by more than `depth_mm`, and by how much, in mm.

    The depth is the shortest way to move the two apart; where a part is not convex, the largest such depth over
    its convex pieces. The solids must be sound (`check.violations` says which are not). In the order of
    `assembly.parts()`. Raises DetailingError where a solid is neither convex nor a prism over a simple polygon.

    >>> import numpy as np
    >>> from dataclasses import replace
    >>> from fabkit import Project, design
    >>> from fabkit.checking import clashes
    >>> from geometry.mesh.shapes import dome
    >>> roof = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly
    >>> lowered = replace(roof["panels"], origins=roof["panels"].origins - np.array([0, 0, 8]))
    >>> len(clashes(roof)), len(clashes(roof.with_group(lowered))) > 0
    (0, True)
    """
    positions = Positions(assembly)
    batches = positions.placed()
    for batch in batches:
        for position in batch.parts[~is_splittable(batch)].tolist():
            part = positions[position]
            raise DetailingError(
                f"{part.kind.name} {part.mark}, element {part.element}, is neither convex nor a prism over a simple "
                "polygon, so what it shares with others cannot be found; build it as a prism"
            )
    pairs, found = clashing_pairs(batches, depth_mm=depth_mm)
    return [(positions[i], positions[j], d) for (i, j), d in zip(pairs.tolist(), found.tolist(), strict=True)]


def clashing_pairs(batches: Sequence[SolidArray], *, depth_mm: float = TOUCHING_MM) -> tuple[IntArray, FloatArray]:
    """(K, 2) positions of every two parts, the lower first, that reach into each other by more than `depth_mm`;
    (K,) by how much. All solids must be splittable; sorted.

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
    candidates = _candidates(shapes)
    counts = [len(pieces.parts) for pieces in shapes]
    shape = np.repeat(np.arange(len(shapes)), counts)
    row = np.concatenate([np.arange(count) for count in counts])
    found = np.empty(len(candidates))
    group = shape[candidates] @ np.array([len(shapes), 1])
    for alike in np.unique(group).tolist():
        members = np.flatnonzero(group == alike)
        first, second = divmod(alike, len(shapes))
        pairs = row[candidates[members]]
        found[members] = depths(shapes[first], shapes[second], pairs, touching_mm=depth_mm)
    deep = found > depth_mm
    parts = np.concatenate([pieces.parts for pieces in shapes])
    return _deepest(np.sort(parts[candidates[deep]], axis=1), found[deep])


def _candidates(shapes: Sequence[Pieces]) -> IntArray:
    """(K, 2) pieces, counted through all shapes, of different parts whose axis-aligned boxes meet."""
    parts = np.concatenate([pieces.parts for pieces in shapes])
    lower = np.concatenate([pieces.vertices.min(axis=1) for pieces in shapes])
    upper = np.concatenate([pieces.vertices.max(axis=1) for pieces in shapes])
    z, x, y = np.argsort(np.ptp(lower, axis=0))  # the tree is flat: its plane is that of the two longest extents
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

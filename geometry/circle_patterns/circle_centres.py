"""Centres of the circles of a pattern whose radii are known.

Kite by kite along short paths; then all together by least squares, which distributes the rounding of a path.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import ComplexArray, FloatArray, IntArray
from geometry.circle_patterns.radii import KiteAngles
from geometry.mesh import Combinatorics
from geometry.mesh.spanning_forests import spanning_forest
from geometry.optimise import GroundedLaplacian

__all__ = ["circle_centres"]

CENTRES_ACCURACY = 1e-3
"""Relative accuracy of the least squares correction of the centres, which is small."""


def circle_centres(
    combinatorics: Combinatorics, corners: IntArray, kites: IntArray, radii: FloatArray
) -> tuple[ComplexArray, float]:
    """Centres (n,) as complex numbers, and the largest gap of a kite over the distance of its centres.

    corners (K,): those of the combinatorics that have a kite; kites (K, 2): the circles of its vertex and its face;
    radii (n,). Faces run counter-clockwise. A circle without kite lies at 0.
    """
    lengths = np.hypot(*radii[kites.T])
    n = len(radii)
    start = int(kites[0, 0])
    root = int(spanning_forest(n, kites, start=start).levels[-1].children[0])
    first = int(np.flatnonzero((kites == root).any(axis=1))[0])
    steps = lengths * np.exp(1j * _directions(combinatorics, corners, KiteAngles(kites, radii), first))
    centres = _along_paths(n, kites, steps, root)
    laplacian = GroundedLaplacian(n, kites, lengths**-2.0)
    centres = centres + _correction(laplacian, kites, lengths, steps - (centres[kites[:, 1]] - centres[kites[:, 0]]))
    missing = steps - (centres[kites[:, 1]] - centres[kites[:, 0]])
    return centres, float((np.abs(missing) / lengths).max())


def _directions(combinatorics: Combinatorics, corners: IntArray, kites: KiteAngles, first: int) -> FloatArray:
    """(K,) angle of the direction from the vertex to the face of each kite; 0 for the kite `first`."""
    c = combinatorics
    place = np.full(c.n_corners, -1, dtype=np.int64)
    place[corners] = np.arange(len(corners))
    at_face = place[c.next_corner[corners]]
    left = c.twin[c.previous_corner[corners]]  # the next corner at the vertex, counter-clockwise
    at_vertex = np.where(left >= 0, place[left], -1)
    pairs, turns = [], []
    for following, halves in ((at_face, kites.at_second), (at_vertex, kites.at_first)):
        here = np.flatnonzero(following >= 0)
        pairs.append(np.stack([here, following[here]], axis=1))
        turns.append(halves[here] + halves[following[here]])
    edges, turn = np.concatenate(pairs), np.concatenate(turns)
    angles = np.zeros(len(corners))
    for level in spanning_forest(len(corners), edges, start=first).levels:
        forwards = edges[level.edges, 0] == level.parents
        signed = np.where(forwards, turn[level.edges], -turn[level.edges])
        angles[level.children] = np.remainder(angles[level.parents] + signed, 2 * np.pi)
    return angles


def _along_paths(n: int, kites: IntArray, steps: ComplexArray, root: int) -> ComplexArray:
    centres = np.zeros(n, dtype=np.complex128)
    for level in spanning_forest(n, kites, start=root).levels:
        forwards = kites[level.edges, 0] == level.parents
        centres[level.children] = centres[level.parents] + np.where(forwards, 1, -1) * steps[level.edges]
    return centres


def _correction(
    laplacian: GroundedLaplacian, kites: IntArray, lengths: FloatArray, missing: ComplexArray
) -> ComplexArray:
    """(n,) moves of the centres, which minimise the gaps of the kites over their lengths."""
    weighted = missing / lengths**2
    right = np.zeros(laplacian.n_nodes, dtype=np.complex128)
    np.add.at(right, kites[:, 1], weighted)
    np.add.at(right, kites[:, 0], -weighted)
    moves = laplacian.solve(np.stack([right.real, right.imag], axis=1), accuracy=CENTRES_ACCURACY)
    moved: ComplexArray = moves[:, 0] + 1j * moves[:, 1]
    return moved

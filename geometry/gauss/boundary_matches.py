"""Motions that bring a boundary loop of one pair M, S to that of another.

Two pairs match where a boundary loop of one is that of the other, run through in the other direction: M after a motion,
S after its rotation. All vertices from which the loop can begin are compared at once.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.gauss.pair import Pair

__all__ = ["BoundaryLoop", "Motion", "boundary_loops", "gaps_in_place", "matches"]


@dataclass(frozen=True, eq=False)
class BoundaryLoop:
    """piece: its number; vertices (n,): in order; mesh, image (n, 3): their positions in M and in S."""

    piece: int
    vertices: IntArray
    mesh: FloatArray
    image: FloatArray

    @cached_property
    def edge_length(self) -> float:
        """The mean edge length in M."""
        return float(np.linalg.norm(np.roll(self.mesh, -1, axis=0) - self.mesh, axis=1).mean())

    @cached_property
    def size(self) -> float:
        """Root mean square of distances in M from their mean."""
        return float(np.sqrt(np.square(self.mesh - self.mesh.mean(axis=0)).sum(axis=1).mean()))

    def turned(self) -> IntArray:
        """(n, n): the places of the loop run through in the other direction, beginning with each in turn."""
        n = len(self.vertices)
        return np.asarray((np.arange(n)[:, None] - np.arange(n)) % n)


@dataclass(frozen=True, eq=False)
class Motion:
    """p -> scale rotation p + shift of points of M; S is only turned."""

    rotation: FloatArray
    scale: float
    shift: FloatArray

    def moved(self, pair: Pair) -> tuple[FloatArray, FloatArray]:
        """(N, 3) positions in M and in S."""
        turned = pair.mesh.vertices @ self.rotation.T
        return self.scale * turned + self.shift, pair.gauss_image.vertices @ self.rotation.T


def boundary_loops(piece: int, pair: Pair) -> list[BoundaryLoop]:
    """The loops of a pair that pass each of their vertices once."""
    mesh, image = pair.mesh.vertices, pair.gauss_image.vertices
    loops = [loop for loop in pair.mesh.combinatorics.boundary_loops if len(np.unique(loop)) == len(loop)]
    return [BoundaryLoop(piece, loop, mesh[loop], image[loop]) for loop in loops]


def matches(fixed: BoundaryLoop, moving: BoundaryLoop, *, scaled: bool) -> tuple[list[Motion], IntArray, FloatArray]:
    """For each vertex where a loop of as many vertices can begin: the motion, the places (n, n) of `moving` beside
    those of `fixed`, and the gaps (n, 2): of M in mean edge lengths of `fixed`, of S."""
    places = moving.turned()
    centre, middle = fixed.mesh.mean(axis=0), moving.mesh.mean(axis=0)
    scale = fixed.size / moving.size if scaled else 1.0
    target = np.concatenate([(fixed.mesh - centre) / fixed.size, fixed.image])
    points = np.concatenate([(moving.mesh - middle)[places] / moving.size, moving.image[places]], axis=1)
    u, _, v = np.linalg.svd(np.einsum("ki,nkj->nij", target, points))  # the nearest rotations
    signs = np.ones((len(places), 3))
    signs[:, 2] = np.linalg.det(u @ v)
    rotations = (u * signs[:, None]) @ v
    shifts = centre - scale * rotations @ middle
    moved = scale * np.einsum("nij,nkj->nki", rotations, moving.mesh[places]) + shifts[:, None]
    turned = np.einsum("nij,nkj->nki", rotations, moving.image[places])
    motions = [Motion(rotation, scale, shift) for rotation, shift in zip(rotations, shifts, strict=True)]
    return motions, places, _gaps(fixed, moved, turned)


def gaps_in_place(fixed: BoundaryLoop, other: BoundaryLoop) -> tuple[IntArray, FloatArray]:
    """Places (n, n) and gaps (n, 2) as in `matches`, without a motion."""
    places = other.turned()
    return places, _gaps(fixed, other.mesh[places], other.image[places])


def _gaps(fixed: BoundaryLoop, mesh: FloatArray, image: FloatArray) -> FloatArray:
    of_mesh = np.linalg.norm(mesh - fixed.mesh, axis=2).max(axis=1) / fixed.edge_length
    return np.stack([of_mesh, np.linalg.norm(image - fixed.image, axis=2).max(axis=1)], axis=1)

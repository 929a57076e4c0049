"""Motions that bring a boundary loop of one pair M, S to that of another.

Two pairs match where a boundary loop of one is that of the other, run through in the other direction: M after a motion,
S after its rotation. For each vertex from which the loop can begin, the best rotation follows from the correlation of
both loops; all of them are one convolution.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.gauss.pair import Pair

__all__ = ["BoundaryLoop", "Fits", "Motion", "boundary_loops"]


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

    def beside(self, other: BoundaryLoop) -> IntArray:
        """(n,) the places of this loop, run through in the other direction, that lie beside those of another one."""
        first = int(np.square(self.mesh - other.mesh[0]).sum(axis=1).argmin())
        return np.asarray((first - np.arange(len(self.vertices))) % len(self.vertices))

    def gaps(self, other: BoundaryLoop) -> FloatArray:
        """(2,) the largest distance between such places: of M in mean edge lengths of the other loop, of S."""
        places = self.beside(other)
        of_mesh = np.linalg.norm(self.mesh[places] - other.mesh, axis=1).max() / other.edge_length
        return np.array([of_mesh, np.linalg.norm(self.image[places] - other.image, axis=1).max()])

    def moved(self, motion: Motion) -> BoundaryLoop:
        return BoundaryLoop(self.piece, self.vertices, *motion.applied(self.mesh, self.image))


@dataclass(frozen=True, eq=False)
class Motion:
    """p -> scale rotation p + shift of points of M; S is only turned."""

    rotation: FloatArray
    scale: float
    shift: FloatArray

    def applied(self, mesh: FloatArray, image: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Positions (N, 3) in M and in S."""
        return self.scale * mesh @ self.rotation.T + self.shift, image @ self.rotation.T


def boundary_loops(piece: int, pair: Pair) -> list[BoundaryLoop]:
    """The loops of a pair that pass each of their vertices once."""
    mesh, image = pair.mesh.vertices, pair.gauss_image.vertices
    loops = [loop for loop in pair.mesh.combinatorics.boundary_loops if len(np.unique(loop)) == len(loop)]
    return [BoundaryLoop(piece, loop, mesh[loop], image[loop]) for loop in loops]


@dataclass(frozen=True, eq=False)
class Fits:
    """The motions of the loop `moving` to a loop with as many vertices, one for each vertex where it can begin."""

    fixed: BoundaryLoop
    moving: BoundaryLoop
    scaled: bool

    @property
    def scale(self) -> float:
        return self.fixed.size / self.moving.size if self.scaled else 1.0

    @cached_property
    def _correlation(self) -> tuple[FloatArray, FloatArray]:
        """The nearest rotations (n, 3, 3), and the sums of the singular values (n,)."""
        target, points = (_normalised(loop) for loop in (self.fixed, self.moving))
        u, values, v = np.linalg.svd(_sums(target, points))
        signs = np.ones_like(values)
        signs[:, 2] = np.linalg.det(u @ v)
        return (u * signs[:, None]) @ v, (signs * values).sum(axis=1)

    @cached_property
    def deviations(self) -> FloatArray:
        """(n,) root mean square distances of both loops after the motion: of M over its size, and of S."""
        target, points = (_normalised(loop) for loop in (self.fixed, self.moving))
        squares = np.square(target).sum() + np.square(points).sum() - 2 * self._correlation[1]
        return np.asarray(np.sqrt(np.maximum(squares, 0.0) / len(self.fixed.vertices)))

    @cached_property
    def moves(self) -> FloatArray:
        """(n,) how far the loop moves, over its size: its centre and, by the rotation, a point of it."""
        shifts = self.fixed.mesh.mean(axis=0) - self.moving.mesh.mean(axis=0)
        turns = np.linalg.norm(self._correlation[0] - np.eye(3), axis=(1, 2))
        return np.asarray(turns + np.linalg.norm(shifts) / self.fixed.size)

    def motion(self, start: int) -> Motion:
        rotation = self._correlation[0][start]
        shift = self.fixed.mesh.mean(axis=0) - self.scale * rotation @ self.moving.mesh.mean(axis=0)
        return Motion(rotation, self.scale, shift)


def _normalised(loop: BoundaryLoop) -> FloatArray:
    """(2, n, 3): of M about its centre and over its size, of S."""
    return np.stack([(loop.mesh - loop.mesh.mean(axis=0)) / loop.size, loop.image])


def _sums(target: FloatArray, points: FloatArray) -> FloatArray:
    """(n, 3, 3): for each k, the sum over j of target_j times points_(k-j), of M and S, by the Fourier transform."""
    n = target.shape[1]
    products = np.einsum("smi,smj->mij", np.fft.rfft(target, axis=1), np.fft.rfft(points, axis=1))
    return np.fft.irfft(products, n, axis=0)

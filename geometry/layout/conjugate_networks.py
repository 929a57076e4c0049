"""The network of a surface: principal lines, or those of an affine image, smoothed where they are not determined."""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, ComplexArray, FloatArray, complexes
from geometry.layout.combed_fields import CombedField, comb
from geometry.layout.cross_fields import cross_field, followed_closer
from geometry.layout.networks import Network
from geometry.layout.tangent_frames import TangentFrames
from geometry.surface import Curvature

__all__ = ["conjugate_network"]

FOLLOW, FOLLOW_CLOSER = 30.0, 300.0
"""Weights of the difference of principal curvatures, squared, over that of the field's gradient, squared: where
singularities are decided, and then with these as they are."""

UMBILIC = 0.05
"""Half the difference of the principal curvatures over their size, below which no direction is preferred."""

FLAT = 1e-6
"""Curvature times the size of the surface, below which it is plane."""

ALIGN = 20.0
"""Weight of the boundary's direction in a triangle there, over that of its neighbours."""


def conjugate_network(
    frames: TangentFrames, affine: FloatArray | None, align: BoolArray
) -> tuple[Network, CombedField, float]:
    """The network, the combed field it stems from, and the share of the area where no direction is preferred.

    affine (3, 3): principal lines are those of the image of the surface; as conjugacy is kept by affine maps, their
    originals are conjugate [Pottmann2007, 4.3]. align (E,): boundary edges that the network is to follow.
    """
    curvature = Curvature.of(frames.mesh)
    if affine is None:
        image, tensors = frames, curvature.triangle_tensors
    else:
        image = TangentFrames(frames.mesh.with_vertices(frames.mesh.vertices @ affine.T))
        tensors = Curvature.of(image.mesh).triangle_tensors
    traceless = image.traceless(tensors)
    sizes = np.sqrt((tensors**2).sum(axis=(1, 2)) / 2)
    strength = 4 * np.maximum(np.abs(traceless) ** 2 - (UMBILIC * sizes) ** 2, 0.0)
    strength[sizes * np.sqrt(image.areas.sum()) < FLAT] = 0.0
    wanted = np.divide(traceless, np.abs(traceless), out=np.ones_like(traceless), where=np.abs(traceless) > 0) ** 2
    combed = comb(image, cross_field(image, *_with_boundary(image, align, wanted, FOLLOW * strength)))
    first = followed_closer(
        image, combed.first, combed.turns, *_with_boundary(image, align, wanted, FOLLOW_CLOSER * strength)
    )
    directions = image.in_space(first), image.in_space(1j * first)
    if affine is not None:
        directions = _solved(affine, directions[0]), _solved(affine, directions[1])
    network = Network.of(frames, *directions, curvature.triangle_tensors)
    undirected = float(frames.areas[strength == 0].sum() / frames.areas.sum())
    return network, combed, undirected


def _solved(affine: FloatArray, vectors: FloatArray) -> FloatArray:
    """The vectors (n, 3) whose images these are."""
    return np.asarray(np.linalg.solve(affine, vectors.T).T)


def _with_boundary(
    frames: TangentFrames, align: BoolArray, wanted: ComplexArray, weights: FloatArray
) -> tuple[ComplexArray, FloatArray]:
    """Crosses wanted and their weights, where triangles at the boundary are to follow it."""
    c = frames.combinatorics
    halves = np.flatnonzero((c.twin < 0) & align[c.corner_edge])
    sides = frames.sides.ravel()[halves]
    pull = np.bincount(halves // 3, minlength=c.n_faces) * ALIGN / frames.areas
    source = weights * wanted
    np.add.at(source, halves // 3, (sides / np.abs(sides)) ** 4 * (ALIGN / frames.areas)[halves // 3])
    total = weights + pull
    return complexes(np.divide(source, total, out=wanted.copy(), where=total > 0)), np.asarray(total)

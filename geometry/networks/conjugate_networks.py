"""The network of a surface: principal lines of the surface or of an affine image, smoothed where they are not
unique."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from geometry.arrays import BoolArray, ComplexArray, FloatArray, IntArray, complexes
from geometry.networks.combed_fields import CombedField, comb
from geometry.networks.cross_fields import aligned_directions, cross_field
from geometry.networks.networks import Network
from geometry.networks.tangent_frames import TangentFrames
from geometry.surface import Curvature

__all__ = ["conjugate_network"]

CURVATURE_WEIGHT, FINAL_CURVATURE_WEIGHT = 30.0, 300.0
"""Weights of the squared difference of principal curvatures, over that of the squared gradient of the field: while the
singularities are determined, and afterwards, when they are fixed."""

UMBILIC_RATIO = 0.05
"""Half the difference of the principal curvatures over their size, below which no direction is preferred."""

FLAT_CURVATURE = 1e-6
"""Curvature times the size of the surface, below which the surface counts as plane."""

ALIGNMENT_WEIGHT = 20.0
"""Weight of the direction of a boundary edge or stroke in its triangle, over that of the smoothness of the field."""

STROKE_SAMPLES_PER_EDGE = 4.0
"""Sample points of a stroke in a mean edge length of the surface: enough to miss only triangles of which the stroke
crosses a small corner."""


def conjugate_network(
    frames: TangentFrames, affine: FloatArray | None, align: BoolArray, strokes: Sequence[FloatArray] = ()
) -> tuple[Network, CombedField, float]:
    """The network, the combed field that it is made from, and the share of the area where no direction is preferred.

    affine (3, 3): a map; the network consists of the curves that become principal lines of the image of the surface.
    These are conjugate, since affine maps preserve conjugacy [Pottmann2007, 4.3]. align (E,): boundary edges that the
    network is to follow. strokes: polylines (k, 3) near the surface that it is to follow as well.
    """
    curvature = Curvature.of(frames.mesh)
    if affine is None:
        image, tensors = frames, curvature.triangle_tensors
    else:
        image = TangentFrames(frames.mesh.with_vertices(frames.mesh.vertices @ affine.T))
        tensors = Curvature.of(image.mesh).triangle_tensors
    boundary = _boundary_attraction(image, align)
    attraction = boundary if not strokes else boundary + _stroke_attraction(frames, image, affine, strokes)
    traceless = image.traceless(tensors)
    sizes = np.sqrt((tensors**2).sum(axis=(1, 2)) / 2)
    strength = 4 * np.maximum(np.abs(traceless) ** 2 - (UMBILIC_RATIO * sizes) ** 2, 0.0)
    strength[sizes * np.sqrt(image.areas.sum()) < FLAT_CURVATURE] = 0.0
    target = np.divide(traceless, np.abs(traceless), out=np.ones_like(traceless), where=np.abs(traceless) > 0) ** 2
    combed = comb(image, cross_field(image, *_attracted(attraction, target, CURVATURE_WEIGHT * strength)))
    first = aligned_directions(
        image, combed.first, combed.turns, *_attracted(attraction, target, FINAL_CURVATURE_WEIGHT * strength)
    )
    directions = image.in_space(first), image.in_space(1j * first)
    if affine is not None:
        directions = _originals(affine, directions[0]), _originals(affine, directions[1])
    network = Network.of(frames, *directions, curvature.triangle_tensors)
    undirected = float(frames.areas[strength == 0].sum() / frames.areas.sum())
    return network, combed, undirected


def _originals(affine: FloatArray, vectors: FloatArray) -> FloatArray:
    """The vectors (n, 3) that the affine map takes to the given ones."""
    return np.asarray(np.linalg.solve(affine, vectors.T).T)


def _attracted(attraction: ComplexArray, target: ComplexArray, weights: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """Target crosses (F,) and their weights (F,), after those of boundaries and strokes (2, F) have been added."""
    source, added = attraction[0], attraction[1].real
    total = weights + added
    return complexes(np.divide(weights * target + source, total, out=target.copy(), where=total > 0)), np.asarray(total)


def _boundary_attraction(frames: TangentFrames, align: BoolArray) -> ComplexArray:
    """(2, F) crosses along boundary edges times their weights, and the weights."""
    c = frames.combinatorics
    halves = np.flatnonzero((c.twin < 0) & align[c.corner_edge])
    return _summed(frames, halves // 3, frames.sides.ravel()[halves], np.ones(len(halves)))


def _stroke_attraction(
    frames: TangentFrames, image: TangentFrames, affine: FloatArray | None, strokes: Sequence[FloatArray]
) -> ComplexArray:
    """(2, F) crosses along strokes times their weights, and the weights. frames: of the surface; image: of its image
    under the affine map, to which the crosses belong."""
    spacing = frames.mesh.mean_edge_length / STROKE_SAMPLES_PER_EDGE
    points, vectors, shares = [], [], []
    for stroke in strokes:
        steps = np.diff(stroke, axis=0)
        lengths = np.linalg.norm(steps, axis=1)
        counts = np.maximum(np.ceil(lengths / spacing), 1).astype(np.int64)
        part = np.repeat(np.arange(len(steps)), counts)
        nth = np.arange(len(part)) - np.repeat(np.cumsum(counts) - counts, counts)
        points.append(stroke[part] + ((nth + 0.5) / counts[part])[:, None] * steps[part])
        vectors.append(steps[part])
        shares.append((lengths / counts)[part] / frames.mesh.mean_edge_length)
    triangles = frames.nearest(np.concatenate(points))
    along = np.concatenate(vectors)
    mapped = along if affine is None else along @ affine.T
    flat = np.einsum("ni,nai->na", mapped, image.axes[triangles])
    return _summed(image, triangles, flat[:, 0] + 1j * flat[:, 1], np.concatenate(shares))


def _summed(frames: TangentFrames, triangles: IntArray, along: ComplexArray, shares: FloatArray) -> ComplexArray:
    """(2, F) sums over vectors (n,) in triangles (n,): their crosses times their weights, and the weights."""
    weights = shares * (ALIGNMENT_WEIGHT / frames.areas)[triangles]
    sizes = np.abs(along)
    directions = np.divide(along, sizes, out=np.ones_like(along), where=sizes > 0)
    summed = np.zeros((2, frames.n_triangles), dtype=np.complex128)
    np.add.at(summed[0], triangles, directions**4 * weights)
    np.add.at(summed[1], triangles, np.where(sizes > 0, weights, 0.0))
    return summed

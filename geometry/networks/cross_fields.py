"""Cross fields: in each triangle four directions, 90 degrees apart, that follow given ones and vary little.

A cross is the fourth power z of its unit vectors, as a complex number in the triangle's frame.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csc_array, csr_array, diags_array
from scipy.sparse.linalg import splu

from geometry.arrays import ComplexArray, FloatArray, IntArray
from geometry.networks.tangent_frames import TangentFrames
from geometry.optimise import factorise

__all__ = ["aligned_directions", "cross_field"]

DIFFUSION_STEPS = 20
"""Steps of diffusion, each followed by making all directions of unit length."""

DIFFUSION_TIME = 4.0
"""Time of a step of diffusion, in mean areas of triangles."""

ANGLE_STEPS = 5
"""Newton steps on the angles of the field."""

LARGEST_DIRECTION_TURN = 0.3
"""Largest turn of a direction in one of these steps, in radians."""

TIE_BREAKING_WEIGHT = 1e-6
"""Weight of the longest direction of the surface, over its area: it determines the field where nothing else does."""


def cross_field(frames: TangentFrames, target: ComplexArray, weights: FloatArray) -> ComplexArray:
    """(F,) unit vectors, one of the four of each cross.

    target (F,): crosses to follow, as fourth powers of unit length; weights (F,): their weights per area. First the
    integral of |grad z|^2 + weight |z - target|^2 is minimised; then z is alternately scaled to unit length and
    diffused [KnoeppelCranePinkallSchroeder2013].
    """
    (inner, left, right), stiffness = frames.inner_edges, frames.stiffness
    carried = stiffness * np.exp(4j * frames.edge_turns[inner])
    n = frames.n_triangles
    diagonal = np.bincount(left, stiffness, n) + np.bincount(right, stiffness, n)
    rows, columns = np.concatenate([right, left]), np.concatenate([left, right])
    coupling = coo_array((np.concatenate([carried, carried.conj()]), (rows, columns)), shape=(n, n))
    area_weights = frames.areas * weights
    source = area_weights * target
    tie_breaking = TIE_BREAKING_WEIGHT * frames.areas / frames.areas.sum()
    source = source + tie_breaking * longest_direction(frames) ** 4
    smooth = diags_array(diagonal + area_weights + tie_breaking) - coupling
    z = splu(csc_array(smooth)).solve(source)
    step = frames.areas / (DIFFUSION_TIME * frames.areas.mean())
    factor = splu(csc_array(smooth + diags_array(step)))
    for _ in range(DIFFUSION_STEPS):
        z = factor.solve(source + step * _unit(z))
    return np.asarray(_unit(z) ** 0.25)


def longest_direction(frames: TangentFrames) -> ComplexArray:
    """(F,) the direction in which the surface is longest, projected to the triangles, of unit length; 1 where it is
    perpendicular to the triangle."""
    points = frames.centres
    weights = frames.areas / frames.areas.sum()
    offsets = points - weights @ points
    longest = np.linalg.eigh(np.einsum("f,fi,fj->ij", weights, offsets, offsets))[1][:, -1]
    return _unit(frames.flat(np.broadcast_to(longest, points.shape)))


def _unit(z: ComplexArray) -> ComplexArray:
    sizes = np.abs(z)
    return np.divide(z, sizes, out=np.ones_like(z), where=sizes > 0)


def aligned_directions(
    frames: TangentFrames, first: ComplexArray, turns: IntArray, target: ComplexArray, weights: FloatArray
) -> ComplexArray:
    """(F,) the first directions of a combed field, turned towards the target crosses without a change of singularities.

    Angles instead of fourth powers: min of the integral of |grad angle|^2 + weight sin^2(4 (angle - target)) / 16,
    where neighbours remain matched by the given quarter turns (E,).
    """
    (inner, left, right), stiffness = frames.inner_edges, frames.stiffness
    n, m = frames.n_triangles, len(inner)
    rows = np.tile(np.arange(m), 2)
    signs = np.repeat([1.0, -1.0], m)
    difference = csr_array(coo_array((signs, (rows, np.concatenate([right, left]))), shape=(m, n)))
    smooth = difference.T @ diags_array(stiffness) @ difference
    area_weights = frames.areas * weights
    tie_breaking = TIE_BREAKING_WEIGHT * frames.areas / frames.areas.sum()
    factor = factorise(csr_array(smooth + diags_array(area_weights + tie_breaking)))
    for _ in range(ANGLE_STEPS):
        carried = first[left] * np.exp(1j * frames.edge_turns[inner]) * 1j ** (turns[inner] % 4)
        residual = np.angle(first[right] * carried.conj())
        angles_to_target = np.angle(target * first.conj() ** 4)
        step = factor.solve(-(difference.T @ (stiffness * residual)) + area_weights * np.sin(angles_to_target) / 4)
        first = first * np.exp(1j * step.clip(-LARGEST_DIRECTION_TURN, LARGEST_DIRECTION_TURN))
    return first

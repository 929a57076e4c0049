"""Radii of the outer boundary for which a circle pattern with given radii around its holes closes.

The circles of the vertices around a hole touch each other one after the other: their centres are the corners of a
polygon, whose sides are sums of two radii, given up to a common factor, and whose angles come out of the pattern. That
it closes is two equations for each hole. Their derivatives by the logarithms of the outer radii are those of a harmonic
function: one system of equations with the Laplacian of the kites for each of the two.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from geometry.arrays import ComplexArray, FloatArray, IntArray
from geometry.circle_patterns.radii import KiteAngles, RadiusProblem
from geometry.optimise import GroundedLaplacian

__all__ = ["outer_radii"]

MAX_CLOSURE_STEPS = 50
"""Steps towards radii for which the pattern closes; five to ten do."""

CLOSURE_TOLERANCE = 1e-12
"""Gap of the polygon around a hole over its length, at which the steps end."""

LONGEST_CLOSURE_STEP = 0.5
"""Change of the logarithm of a radius in one step, at most: the gap is far from linear beyond."""

ADJOINT_ACCURACY = 1e-10
"""Accuracy of the systems of equations for derivatives: further steps correct the error."""


def outer_radii(
    problem_of: Callable[[FloatArray], RadiusProblem], outer: IntArray, holes: Sequence[IntArray]
) -> FloatArray:
    """(k,) radii of the vertices of the outer loop (k,) for which the pattern closes around the holes.

    problem_of: the problem with given outer radii (k,). holes: the vertices of each loop, the mesh to the left, radii
    given up to a factor. Found from equal radii by Newton steps that change the logarithms by the least sum of squares.
    Where the pattern does not close after all, the last radii are returned: the caller checks the pattern.
    """
    logs = np.zeros(len(outer))
    for _ in range(MAX_CLOSURE_STEPS):
        problem = problem_of(np.exp(logs))
        radii = problem.radii()
        rows = [_gap(problem, radii, outer, hole) for hole in holes]
        gaps = np.concatenate([[gap.real, gap.imag] for gap, _ in rows])
        J = np.concatenate([np.stack([gradient.real, gradient.imag]) for _, gradient in rows])
        step = -np.linalg.lstsq(J, gaps, rcond=None)[0]
        if np.abs(gaps).max() <= CLOSURE_TOLERANCE:
            break
        longest = float(np.abs(step).max())
        logs = logs + step * min(1.0, LONGEST_CLOSURE_STEP / max(longest, CLOSURE_TOLERANCE))
    return np.asarray(np.exp(logs))


def _gap(problem: RadiusProblem, radii: FloatArray, outer: IntArray, hole: IntArray) -> tuple[complex, ComplexArray]:
    """The gap of the polygon around a hole over its length, and its derivatives (k,) by logarithms of outer radii."""
    kites = problem.kites
    angles = np.bincount(kites[:, 0], 2 * KiteAngles(kites, radii).at_first, minlength=len(radii))[hole]
    lengths = radii[hole] + radii[np.roll(hole, -1)]
    directions = np.cumsum(np.append(0.0, np.pi - angles[1:]))
    sides = lengths / lengths.sum() * np.exp(1j * directions)
    to_end = np.cumsum(sides[::-1])[::-1]
    weights_of_angles = -1j * to_end
    weights_of_angles[0] = 0.0  # it turns the polygon as a whole
    first, second = radii[kites.T]
    w = 2 / (first / second + second / first)
    at_hole = np.zeros(len(radii), dtype=np.complex128)
    at_hole[hole] = weights_of_angles
    flux = w * at_hole[kites[:, 0]]
    right = np.zeros((problem.n_unknowns + 1, 2))  # the last: circles of given radius
    for end, sign in ((0, -1.0), (1, 1.0)):
        np.add.at(right, problem.links[:, end], sign * np.stack([flux.real, flux.imag], axis=1))
    laplacian = GroundedLaplacian(problem.n_unknowns, problem.links, w)
    solved = np.append(laplacian.solve(right[:-1], accuracy=ADJOINT_ACCURACY), np.zeros((1, 2)), axis=0)
    harmonic = solved[:, 0] + 1j * solved[:, 1]
    gradient = np.zeros(len(radii), dtype=np.complex128)
    np.add.at(gradient, kites[:, 0], w * harmonic[problem.links[:, 1]])
    return complex(sides.sum()), gradient[outer]

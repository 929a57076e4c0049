"""Radii of orthogonal circle patterns in the plane, by minimising a convex function [BobenkoSpringborn2004].

Circles of vertices touch each other, circles of faces touch each other, and a circle of a vertex meets that of
a face at right angles. A *kite* is a pair of them that meet: its corners are the two centres and the two points where
the circles meet. With r_v, r_f its radii, the kite fills the angle 2 atan(r_f / r_v) at the centre of v. The unknowns
are the logarithms of the radii; the gradient of the convex function is the missing angle about each centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.errors import GeometryError
from geometry.optimise import ConvergenceError, GroundedLaplacian, Reason, Solution, max_norm

__all__ = ["KiteAngles", "RadiusProblem"]

ANGLE_TOLERANCE = 1e-12
"""Deviation in radians of the sum of the kite angles about a centre from its total: rounding of the sum of hundreds of
angles."""

ANGLE_ROUNDING = 2e-14
"""Deviation in radians of the angles about centres with some ten kites that is rounding alone: no step reduces it."""

MAX_RADIUS_STEPS = 100
"""Most Newton steps; about 8 are enough, with hundreds of thousands of circles too."""

LARGEST_LOG_RATIO = 60.0
"""Logarithm of the ratio of two radii, above which rounding leaves no correct digit."""

LOOSEST_STEP_ACCURACY = 1e-2
"""Relative accuracy of a Newton step far from the minimum, where a better one has no effect."""

SHOWN_CIRCLES = 5
"""Vertices or faces that an error names, of many."""


@dataclass(frozen=True, eq=False)
class KiteAngles:
    """kites (K, 2) and radii; at_first, at_second (K,): half the angle that each kite fills at its two centres."""

    kites: IntArray
    radii: FloatArray

    @property
    def at_first(self) -> FloatArray:
        first, second = self.radii[self.kites.T]
        return np.asarray(np.arctan2(second, first))

    @property
    def at_second(self) -> FloatArray:
        first, second = self.radii[self.kites.T]
        return np.asarray(np.arctan2(first, second))


@dataclass(frozen=True, eq=False)
class RadiusProblem:
    """The problem of finding the radii of a circle pattern: which circles meet, and which radii and angles are given.

    n_vertices: the n circles are those of the vertices, then those of the faces.
    kites (K, 2): a vertex circle and a face circle.
    unknowns (n,): the unknown that each radius is a multiple of, numbered from 0; -1 where the radius is given, or the
    circle has no kite.
    factors (n,): the radius where it is given; else the radius over its unknown.
    angles (U,): the angle that the kites fill about the centres of the circles of each unknown.

    >>> import numpy as np
    >>> kites = [[0, 3], [1, 3], [2, 3]]  # three vertices around one face
    >>> problem = RadiusProblem(3, kites, [-1, -1, -1, 0], [1.0, 1.0, 1.0, 1.0], [2 * np.pi])
    >>> problem.radii().round(6).tolist()
    [1.0, 1.0, 1.0, 0.57735]
    """

    n_vertices: int
    kites: IntArray
    unknowns: IntArray
    factors: FloatArray
    angles: FloatArray

    def __post_init__(self) -> None:
        for name in ("kites", "unknowns"):
            object.__setattr__(self, name, integers(getattr(self, name)))
        for name in ("factors", "angles"):
            object.__setattr__(self, name, floats(getattr(self, name)))

    @property
    def n_unknowns(self) -> int:
        return len(self.angles)

    @property
    def links(self) -> IntArray:
        """(K, 2) the unknowns at the two ends of each kite, -1 where the radius is given."""
        return self.unknowns[self.kites]

    def radii(self) -> FloatArray:
        """(n,) radii for which the kites fill the angles: the only ones, up to a scale where none is given.

        Raises GeometryError where there are none: the message names circles whose angles have too large a
        sum. Raises ConvergenceError where Newton's method ends above `ANGLE_TOLERANCE`.
        """
        multipliers, best, steps = self._start(), np.inf, 0
        found = multipliers
        while steps <= MAX_RADIUS_STEPS:
            excess = self._excess(multipliers)
            worst = max_norm(excess)
            settled = worst <= ANGLE_ROUNDING or (best <= ANGLE_TOLERANCE and worst > best / 2)
            if worst < best:
                found, best = multipliers, worst
            if settled or np.ptp(np.log(multipliers)) > LARGEST_LOG_RATIO:
                break
            multipliers = multipliers * np.exp(self._newton_step(multipliers, excess))
            steps += 1
        if best > ANGLE_TOLERANCE:
            self._refuse_crowded(multipliers)
            reason = Reason.STEP_LIMIT if steps > MAX_RADIUS_STEPS else Reason.STALLED
            raise ConvergenceError(
                f"the circle pattern misses its angles by {best:.1e} radians after {steps} steps, allowed "
                f"{ANGLE_TOLERANCE:.0e}; its radii differ by a factor of {multipliers.max() / multipliers.min():.0e}, "
                "and beyond 1e+14 the smallest polygons would be points on the sphere",
                solution=Solution(found, np.zeros(0), best, steps, reason),
                value=best,
                bound=ANGLE_TOLERANCE,
            )
        return self._all_radii(found)

    def _refuse_crowded(self, multipliers: FloatArray) -> None:
        """Raises GeometryError where some circles cannot have their angles, whatever the radii are.

        A kite has less than pi at its two centres together. So the angles of any set of unknowns are less than pi for
        each kite at them. Otherwise, Newton's method shrinks the circles of such a set without bound, so that the
        set consists of the smallest radii.
        """
        order = np.argsort(multipliers, kind="stable")
        rank = np.append(np.empty(len(order), dtype=np.int64), len(order))
        rank[order] = np.arange(len(order))
        room = np.pi * np.cumsum(np.bincount(rank[self.links].min(axis=1), minlength=len(order) + 1)[: len(order)])
        asked = np.cumsum(self.angles[order])
        if not self._scaled:  # the sum over all is right
            room, asked = room[:-1], asked[:-1]
        lacking = asked - room
        if lacking.max(initial=-np.inf) < -ANGLE_TOLERANCE:
            return
        size = int(lacking.argmax())
        circles = np.flatnonzero(np.isin(self.unknowns, order[: size + 1]))
        vertices, faces = circles[circles < self.n_vertices], circles[circles >= self.n_vertices] - self.n_vertices
        raise GeometryError(
            f"there is no circle pattern with these values: the angles about {_listed('vertex', vertices)} and "
            f"{_listed('face', faces)} sum to {asked[size]:.6g} radians, and must be less than {room[size]:.6g}, "
            "pi for each corner there: ask for smaller angles at these vertices",
            elements=vertices.tolist(),
            value=float(asked[size]),
            bound=float(room[size]),
        )

    # --- Newton's method

    def _all_radii(self, multipliers: FloatArray) -> FloatArray:
        return self.factors * np.where(self.unknowns >= 0, multipliers[self.unknowns], 1.0)

    def _start(self) -> FloatArray:
        """(U,) the radii for which all neighbours would have the same radius, at the scale of the given ones."""
        n_kites = np.bincount(self.links[self.links >= 0], minlength=self.n_unknowns)
        halves = np.clip(self.angles / (2 * n_kites), 0.02, np.pi / 2 - 0.02)
        given = self.factors[np.unique(self.kites[self.links < 0])]
        scale = np.exp(np.log(given).mean()) if len(given) else 1.0
        return np.asarray(scale / np.sqrt(np.tan(halves)))

    def _excess(self, multipliers: FloatArray) -> FloatArray:
        """(U,) the angle about each centre minus the required one: minus the gradient."""
        kites = KiteAngles(self.kites, self._all_radii(multipliers))
        total = np.zeros(self.n_unknowns)
        for end, halves in zip(self.links.T, (kites.at_first, kites.at_second), strict=True):
            total += np.bincount(end[end >= 0], 2 * halves[end >= 0], minlength=self.n_unknowns)
        excess = total - self.angles
        # without a given radius the sum is 0: its rounding would accumulate in the equation that is left out
        return excess if self._scaled else excess - excess.mean()

    @property
    def _scaled(self) -> bool:
        """Whether a radius is given, so that the pattern has a size."""
        return bool((self.links < 0).any())

    def _newton_step(self, multipliers: FloatArray, excess: FloatArray) -> FloatArray:
        """(U,) a step of the logarithms, short enough that the convex function falls all along it.

        Along a direction d, a second derivative sech(x) of the function changes at most by the factor exp(b t) over a
        step t, where b is the largest difference of d along a kite. So the slope stays negative up to
        t = log(1 + b) / b.
        """
        first, second = self._all_radii(multipliers)[self.kites.T]
        weights = 2 / (first / second + second / first)
        links = self.links
        laplacian = GroundedLaplacian(self.n_unknowns, links, weights)
        direction = laplacian.solve(excess, accuracy=min(LOOSEST_STEP_ACCURACY, max_norm(excess)))
        padded = np.append(direction, 0.0)
        steepest = float(np.abs(padded[links[:, 0]] - padded[links[:, 1]]).max())
        return direction * (np.log1p(steepest) / steepest if steepest > 0 else 1.0)


def _listed(kind: str, numbers: IntArray) -> str:
    """Such as "3 vertices (4, 7, 9)", with the first few numbers."""
    if len(numbers) < 2:
        return f"{kind} {numbers[0]}" if len(numbers) else f"no {kind}"
    shown = ", ".join(str(number) for number in numbers[:SHOWN_CIRCLES]) + (
        ", ..." if len(numbers) > SHOWN_CIRCLES else ""
    )
    return f"{len(numbers)} {'vertices' if kind == 'vertex' else 'faces'} ({shown})"

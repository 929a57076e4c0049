"""Which of many curves, and which parts of them, cover a surface evenly [JobardLefer1997]."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import KDTree

from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["Coverage", "SampledCurve"]

SAMPLES_PER_SPACING = 4
"""Samples of a curve in the spacing of curves, for distances between curves."""

LEAST_DISTANCE = 0.6
"""Distance of two curves over their spacing, below which the later one ends."""

SEED_DISTANCE = 0.95
"""Distance of a new curve from all others over their spacing, at least, where it begins: that between neighbours is
measured along chords."""

OPPOSITE_SIDE_SHARE = 0.7
"""Length of the normal over the spacing that is added to positions as three more coordinates, so that curves on the
two sides of a thin shell are far from each other."""


@dataclass(frozen=True, eq=False)
class SampledCurve:
    """A curve (k, 3) with its arc length (k,) at the points, and samples: positions and normals (m, 6), see `Coverage`,
    arc lengths (m,), and the sample `seed` where it was begun."""

    arc: FloatArray
    samples: FloatArray
    sample_arc: FloatArray
    seed: int
    is_closed: bool

    @classmethod
    def of(cls, points: FloatArray, normals: FloatArray, seed: int, is_closed: bool, spacing: float) -> SampledCurve:
        """Of a curve with points and normals (k, 3), begun at one of these points."""
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        count = max(int(np.ceil(arc[-1] / spacing * SAMPLES_PER_SPACING)), 1)
        sample_arc = np.linspace(0.0, arc[-1], count + 1)
        six = np.concatenate([points, OPPOSITE_SIDE_SHARE * spacing * normals], axis=1)
        samples = np.stack([np.interp(sample_arc, arc, each) for each in six.T], axis=1)
        return cls(arc, samples, sample_arc, int(np.abs(sample_arc - arc[seed]).argmin()), is_closed)

    @property
    def length(self) -> float:
        return float(self.arc[-1])


@dataclass(eq=False)
class Coverage:
    """The samples (n, 6) of the curves of one family so far."""

    spacing: float
    samples: list[FloatArray] = field(default_factory=list)

    def distances(self, points: FloatArray) -> FloatArray:
        """(n,) distances of points (n, 6) from the curves so far."""
        if not self.samples or not len(points):
            return np.full(len(points), np.inf)
        return np.asarray(KDTree(np.concatenate(self.samples)).query(points)[0])

    def accept(self, curves: list[SampledCurve]) -> list[tuple[int, float, float]]:
        """Take as many of the curves as have room, the longest first: their numbers, and from which to which arc length
        they are far enough from all others."""
        if not curves:
            return []
        starts = np.cumsum([0, *(len(curve.samples) for curve in curves)])
        everything = np.concatenate([curve.samples for curve in curves])
        tree, distances = KDTree(everything), self.distances(everything)
        found = []
        for number in sorted(range(len(curves)), key=lambda k: -curves[k].length):
            curve, mine = curves[number], slice(int(starts[number]), int(starts[number + 1]))
            if distances[mine][curve.seed] < SEED_DISTANCE * self.spacing:
                continue
            first, last = self._free_part(curve, distances[mine])
            low, high = float(curve.sample_arc[first]), float(curve.sample_arc[last])
            if high - low < self.spacing:
                continue
            taken = curve.samples[first : last + 1]
            self.samples.append(taken)
            near = tree.query_ball_point(taken, self.spacing)
            touched = np.unique(np.concatenate([np.asarray(each, dtype=np.int64) for each in near]))
            distances[touched] = np.minimum(distances[touched], KDTree(taken).query(everything[touched])[0])
            found.append((number, low, high))
        return found

    def _free_part(self, curve: SampledCurve, distances: FloatArray) -> tuple[int, int]:
        """The first and the last sample of the part about the seed that is far enough from other curves and itself."""
        free = distances >= LEAST_DISTANCE * self.spacing
        if not curve.is_closed:
            free &= ~_near_itself(curve, LEAST_DISTANCE * self.spacing)
        blocked = np.flatnonzero(~free)
        before, after = blocked[blocked < curve.seed], blocked[blocked > curve.seed]
        return int(before[-1]) + 1 if len(before) else 0, int(after[0]) - 1 if len(after) else len(free) - 1


def _near_itself(curve: SampledCurve, least: float) -> BoolArray:
    """(m,) whether a sample is near to one that lies between it and the seed, or on the other side of the seed and not
    farther along the curve."""
    near = np.zeros(len(curve.samples), dtype=bool)
    pairs: IntArray = KDTree(curve.samples).query_pairs(least, output_type="ndarray")
    far = np.abs(curve.sample_arc[pairs[:, 0]] - curve.sample_arc[pairs[:, 1]]) > np.pi * least
    pairs = pairs[far]
    outer = np.abs(pairs - curve.seed).argmax(axis=1)
    near[pairs[np.arange(len(pairs)), outer]] = True
    return near

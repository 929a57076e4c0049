"""The edges of oblique ends of round bars, in angle and height on their cylinders.

Readers lay an ellipse on its cylinder themselves where a file does not say how it lies there: OCCT by a spline through
23 points, with which volumes are 4e-7 off. All other edges are straight lines there, or lie in planes.
"""

from __future__ import annotations

from functools import lru_cache
from math import comb

import numpy as np

from fabkit.parts import Measures
from geometry.arrays import FloatArray, floats

__all__ = ["p_curve_entities", "p_curve_numbers"]

P_CURVE_DEGREE, P_CURVE_SPANS = 9, 4
"""Degree and number of spans of the spline in place of a cosine: it is off by 3e-11 of the amplitude, so that a bar
that leans by a metre is true to a tenth of STEP_ACCURACY_MM."""

N_POLES = P_CURVE_DEGREE * P_CURVE_SPANS + 1
"""Number of poles of that spline: those at the ends of spans are shared."""


def p_curve_entities(first: int, ellipse: str, cylinder: str) -> list[str]:
    """The entities of an edge on an ellipse, numbered from `first`; the last one is the curve of that edge. They are
    filled in with a row of `p_curve_numbers`."""
    poles = [f"#<{first + k}>" for k in range(N_POLES)]
    knots = ",".join(repr(2 * np.pi * k / P_CURVE_SPANS) for k in range(P_CURVE_SPANS + 1))
    ends = P_CURVE_DEGREE + 1
    counts = ",".join(map(str, (ends, *[P_CURVE_DEGREE] * (P_CURVE_SPANS - 1), ends)))
    spline, context, flat, p_curve = (f"#<{first + N_POLES + k}>" for k in range(4))
    return [
        *["CARTESIAN_POINT('',(%s,%s))"] * N_POLES,
        f"B_SPLINE_CURVE_WITH_KNOTS('',{P_CURVE_DEGREE},({','.join(poles)}),.UNSPECIFIED.,.F.,.F.,({counts}),({knots}),"
        ".UNSPECIFIED.)",
        "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''))",
        f"DEFINITIONAL_REPRESENTATION('',({spline}),{context})",
        f"PCURVE('',{cylinder},{flat})",
        f"SURFACE_CURVE('',{ellipse},({p_curve}),.CURVE_3D.)",
    ]


def p_curve_numbers(of: Measures, k: int, end: int) -> FloatArray:
    """(P, 2 m) angles in radians and heights in mm of the m poles of the edge of round k at an end, 0 or 1. It begins
    at the rim, with the angle 0 where it runs with the angle, and 2 pi where it runs against it."""
    face = of.topology.rounds[k, 4 + end]
    along = np.einsum("pj,jp->p", of.normals[:, face], of.round_axes[:, :, k])[:, None] > 0
    angles, cosines = _poles()
    heights = end * of.lengths[:, k, None] + of.leans[end, :, k, None] * cosines
    return np.stack([np.where(along, angles, 2 * np.pi - angles), heights], axis=2).reshape(len(heights), -1)


@lru_cache(maxsize=1)
def _poles() -> tuple[FloatArray, FloatArray]:
    """(m,) abscissae and ordinates of the poles of a cosine over a turn: the Bernstein polynomials through its values
    at the Chebyshev points of each span."""
    degree, width = P_CURVE_DEGREE, 2 * np.pi / P_CURVE_SPANS
    share = (1 - np.cos(np.pi * np.arange(degree + 1) / degree)) / 2
    basis = np.stack([comb(degree, i) * share**i * (1 - share) ** (degree - i) for i in range(degree + 1)], axis=1)
    spans = [np.linalg.solve(basis, np.cos(width * (k + share))) for k in range(P_CURVE_SPANS)]
    ordinates = np.concatenate([spans[0], *(span[1:] for span in spans[1:])])
    return floats(width / degree * np.arange(len(ordinates))), floats(ordinates)

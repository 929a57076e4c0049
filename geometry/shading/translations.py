"""The translate S + x of a Gauss image whose fins cast most shade on the panels [Pottmann2007, 4.4, Fig. 1]."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats
from geometry.errors import GeometryError
from geometry.shading.fins import Fins
from geometry.shading.panel_shadows import Blinds, Shading, cast_shadows, shadow_areas
from geometry.shading.suns import Suns

__all__ = ["MostShade", "most_shade"]

FULL_SHADE_SHARE = 0.999
"""Share of shade from which on the panels count as completely shaded: of the translations that reach it, a shortest
one is sought."""

FULL_SHADE_TOLERANCE, DIFFERENCE_STEP = 1e-5, 1e-4
"""Deviation of the shortest translation's share from `FULL_SHADE_SHARE` that is allowed, and the step of the finite
differences by which it is sought."""

LEAST_RISE = 1e-3
"""Least height of S + x above the plane of a panel at its corners, unless S itself is lower."""

SAMPLED_PANELS = 32
"""Number of panels that are sampled to find out where to search; the last search is with all panels."""

SAMPLED_TRANSLATIONS, SEARCH_STARTS = 48, 2
"""Translations of the largest length, spread over the sphere, that are compared, and the number of best ones from
which the search starts."""

MAX_EVALUATIONS = 60
"""Most translations evaluated from one start."""

COARSE_STEPS, FINE_STEPS = (0.15, 0.01), (0.05, 0.0005)
"""First and last step lengths of a search, on the sample and on all panels."""


@dataclass(frozen=True, eq=False)
class MostShade:
    """The translation x = shift (3,) with most shade, and the shade with S (before) and with S + x (after).

    The translated S + x is `after.fins.pair.gauss_image`. Translated fins are larger: `shadow_per_fin_area` and the
    areas of the fins, before and after, show how much of the gain comes from their size alone.

    >>> import numpy as np
    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import grid
    >>> flat = grid(1, 1)
    >>> upright = Pair(flat, flat.with_vertices(0 * flat.vertices + [0, 0, 1]))
    >>> fins, suns = Fins(upright, 0.0, 0.2), Suns([[1, 0, 2]])
    >>> x = np.array([-0.5, 0, 0])
    >>> found = MostShade(x, cast_shadows(fins, suns), cast_shadows(fins.tilted(x), suns))
    >>> round(found.before.share, 6), round(found.after.share, 6)
    (0.1, 0.2)
    """

    shift: FloatArray
    before: Shading
    after: Shading


def most_shade(fins: Fins, suns: Suns, *, bound: float = 0.99, opaque: bool = False) -> MostShade:
    """The x, |x| <= bound, with the largest area of shadow of fins over S + x, by the weights of the suns.

    Where all panels can be completely shaded (a share of .999), it is a shortest x that does so. S + x stays above all
    panels. The maximum is sought without derivatives from the best of many translations; there may be a
    larger one elsewhere. opaque: whether panels shade panels, as in `cast_shadows`.

    Raises GeometryError where the bound is not above 0 and below 1 or no panel faces any sun.

    >>> import numpy as np
    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import grid
    >>> flat = grid(1, 1)
    >>> upright = Pair(flat, flat.with_vertices(0 * flat.vertices + [0, 0, 1]))
    >>> found = most_shade(Fins(upright, 0.0, 0.2), Suns([[1, 0, 2]]))
    >>> found.after.share > found.before.share, bool(np.linalg.norm(found.shift) <= 0.99 + 1e-9)
    (True, True)
    """
    if not 0 < bound < 1:
        raise GeometryError(
            f"the bound of the translation is {bound:g}: it must be above 0 and below 1, so that S + x stays on the "
            "outer side of the panels; the paper takes 0.99",
            value=float(bound),
            bound=1.0,
        )
    before = cast_shadows(fins, suns, opaque=opaque)
    n = fins.mesh.n_faces
    sunlit = np.flatnonzero((before.sunlit_areas > 0).any(axis=0))
    sample = sunlit[np.unique(np.linspace(0, len(sunlit) - 1, SAMPLED_PANELS).round().astype(np.int64))]
    coarse, fine = (_cost(before, faces, opaque=opaque) for faces in (sample, np.arange(n)))
    starts = [x for x in bound * _spread(SAMPLED_TRANSLATIONS) if _least_rise(fins, x) >= 0]
    starts = sorted([np.zeros(3), *starts], key=coarse)[:SEARCH_STARTS]
    best = min((_best_near(coarse, start, fins, bound, COARSE_STEPS) for start in starts), key=coarse)
    if -fine(best) < FULL_SHADE_SHARE:
        best = min(np.zeros(3), _best_near(fine, best, fins, bound, FINE_STEPS), key=fine)
    shift = _shortest(fine, best, fins) if -fine(best) >= FULL_SHADE_SHARE else best
    return MostShade(floats(shift), before, cast_shadows(fins.tilted(shift), suns, opaque=opaque))


def _cost(before: Shading, faces: IntArray, *, opaque: bool) -> Callable[[FloatArray], float]:
    """Minus the share of shade on faces (f,), for a translation x (3,) of the fins before."""
    fins, suns = before.fins, before.suns
    levels = np.array([fins.lower, fins.lower, fins.upper, fins.upper])
    sunlit = suns.weights @ before.sunlit_areas[:, faces].sum(axis=1)
    by_panels = before.panel_shadows[:, faces]

    def cost(x: FloatArray) -> float:
        blinds = Blinds.of(fins.mesh, fins.quads + levels[:, None] * x, opaque=opaque)
        areas = shadow_areas(fins.mesh, faces, blinds, suns.directions) - by_panels
        return -float(suns.weights @ areas.sum(axis=1) / sunlit)

    return cost


def _best_near(
    cost: Callable[[FloatArray], float], start: FloatArray, fins: Fins, bound: float, steps: tuple[float, float]
) -> FloatArray:
    """(3,) the x of least cost near a start, |x| <= bound, with S + x above all panels."""
    from scipy.optimize import LinearConstraint, NonlinearConstraint, minimize  # takes long to import

    c = fins.mesh.combinatorics
    least = min(LEAST_RISE, float(fins.rises.min()))
    near = np.flatnonzero(fins.rises < bound + least)  # others rise enough for every x
    constraints: list[NonlinearConstraint | LinearConstraint] = [
        NonlinearConstraint(lambda x: x @ x, -np.inf, bound**2)
    ]
    if len(near):
        normals = fins.mesh.face_normals[c.corner_face[near]]
        constraints.append(LinearConstraint(normals, least - fins.rises[near], np.inf))
    found = minimize(
        cost,
        start,
        method="COBYQA",
        constraints=constraints,
        options={"initial_tr_radius": steps[0], "final_tr_radius": steps[1], "maxfev": MAX_EVALUATIONS},
    )
    return np.asarray(found.x * min(1.0, bound / max(float(np.linalg.norm(found.x)), 1e-300)))


def _shortest(cost: Callable[[FloatArray], float], start: FloatArray, fins: Fins) -> FloatArray:
    """(3,) a shortest translation near a start for which all panels are completely shaded."""
    from scipy.optimize import NonlinearConstraint, approx_fprime, minimize  # takes long to import

    def squared_length(x: FloatArray) -> float:
        return float(x @ x)

    def slope(x: FloatArray) -> FloatArray:
        return np.asarray(approx_fprime(x, cost, DIFFERENCE_STEP))

    found = minimize(
        squared_length,
        start,
        method="SLSQP",
        constraints=[NonlinearConstraint(lambda x: np.array([cost(x)]), -np.inf, -FULL_SHADE_SHARE, jac=slope)],
        options={"maxiter": 12, "ftol": 1e-6},
    )
    usable = [
        x
        for x in (np.zeros(3), found.x)
        if cost(x) < FULL_SHADE_TOLERANCE - FULL_SHADE_SHARE and _least_rise(fins, x) >= 0
    ]
    return min([*usable, start], key=np.linalg.norm)


def _least_rise(fins: Fins, x: FloatArray) -> float:
    """Least height of S + x above the plane of a panel, minus the required height; negative where x is not allowed."""
    c = fins.mesh.combinatorics
    rises = fins.rises + fins.mesh.face_normals[c.corner_face] @ x
    return float(rises.min() - min(LEAST_RISE, fins.rises.min()))


def _spread(n: int) -> FloatArray:
    """(n, 3) unit vectors spread evenly over the sphere, along a spiral."""
    z = 1 - (2 * np.arange(n) + 1) / n
    turn = np.pi * (3 - np.sqrt(5)) * np.arange(n)
    level = np.sqrt(1 - z * z)
    return np.stack([level * np.cos(turn), level * np.sin(turn), z], axis=1)

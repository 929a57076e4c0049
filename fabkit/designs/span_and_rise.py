"""The size of a design: its span, the longer side of its plan, and its rise, from the lowest to the highest vertex."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from fabkit.designs.edge_offset_design import EdgeOffsetDesign
from fabkit.errors import ProjectError
from fabkit.rules import LARGEST_LENGTH_MM
from geometry.gauss import Pair
from geometry.mesh import Mesh

__all__ = ["COVERAGE_RANGE", "TURN_RANGE_DEG", "with_rise", "with_span"]

COVERAGE_RANGE = (1e-4, 0.95)
"""Range of the share of the sphere that the S of a dome covers, in which its rise is searched: from nearly flat to
where faces at the rim become very small."""

TURN_RANGE_DEG = (0.1, 89.9)
"""Range of the turn of the normals of the surface of Enneper, in degrees, in which its rise is searched."""

RISE_TOLERANCE = 1e-9
"""Tolerance of the coverage or turn, relative to its value, at which the search for a rise ends."""


def with_span(design: EdgeOffsetDesign, span_mm: float) -> EdgeOffsetDesign:
    """The design scaled so that the longer side of its plan, along x or y, has this length; M is in mm then.

    Raises ProjectError for a span that is not a positive number of at most `LARGEST_LENGTH_MM`.

    >>> from fabkit.designs import minimal_design
    >>> shell = with_span(minimal_design(count=12), 12_000)
    >>> round(float(shell.mesh.vertices[:, 0].max() - shell.mesh.vertices[:, 0].min()))
    12000
    """
    _check_length("span", span_mm)
    scale = span_mm / _span(design.mesh)
    pair = Pair(design.mesh * scale, design.pair.gauss_image)
    return replace(design, pair=pair, settings=design.settings | {"span_mm": span_mm}, is_in_mm=True)


def with_rise(
    designed: Callable[[float], EdgeOffsetDesign], bounds: tuple[float, float], *, span_mm: float, rise_mm: float
) -> EdgeOffsetDesign:
    """A design of the given span and rise, in mm, for which a parameter is searched between the bounds.

    designed: a function from the parameter to a design, whose rise over span grows with the parameter. Raises
    ProjectError for lengths that are not positive, and for a rise that is not reached between the bounds; it gives the
    rises that are possible.

    >>> from fabkit.designs import minimal_design
    >>> from fabkit.families import MinimalShape
    >>> def designed(turn_deg):
    ...     return minimal_design(shape=MinimalShape.ENNEPER, count=4, turn_deg=turn_deg)
    >>> shell = with_rise(designed, TURN_RANGE_DEG, span_mm=9000, rise_mm=2000)
    >>> (shell.mesh.vertices.max(axis=0) - shell.mesh.vertices.min(axis=0)).round(3).tolist()
    [9000.0, 9000.0, 2000.0]
    """
    _check_length("span", span_mm)
    _check_length("rise", rise_mm)
    low, high = (_slenderness(designed(bound).mesh) for bound in bounds)
    rise_over_span = rise_mm / span_mm
    if not low < rise_over_span < high:
        raise ProjectError(
            f"a rise of {rise_mm:g} mm over a span of {span_mm:g} mm was requested, and with these faces it can be "
            f"between {low * span_mm:.4g} and {high * span_mm:.4g} mm: choose another rise or span"
        )
    parameter = brentq(lambda value: _slenderness(designed(value).mesh) - rise_over_span, *bounds, rtol=RISE_TOLERANCE)
    design = with_span(designed(parameter), span_mm)
    return replace(design, settings=design.settings | {"rise_mm": rise_mm})


def _check_length(name: str, value_mm: float) -> None:
    if not 0 < value_mm <= LARGEST_LENGTH_MM:
        raise ProjectError(f"the {name} is {value_mm:g} mm: above 0 and at most {LARGEST_LENGTH_MM:g} mm is needed")


def _span(mesh: Mesh) -> float:
    return float(np.ptp(mesh.vertices[:, :2], axis=0).max())


def _slenderness(mesh: Mesh) -> float:
    """Rise over span."""
    return float(np.ptp(mesh.vertices[:, 2])) / _span(mesh)

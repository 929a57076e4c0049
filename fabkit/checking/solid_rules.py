"""What each solid must satisfy by itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.checking.convex import is_splittable
from fabkit.checking.round_edges import round_clearances
from fabkit.parts import Measures, SolidArray
from geometry.arrays import BoolArray, FloatArray

__all__ = ["Rule", "solid_rules"]

ORTHONORMALITY_TOLERANCE = 1e-10
"""Largest entry of axes axes^T - 1 for the axes of a placement. Over 10 m it moves a point by 1e-6 mm, as FIT_MM."""


@dataclass(frozen=True, eq=False)
class Rule:
    """A check of solids. values (P,); holds (P,): whether each passes; words: the finding about one that does not."""

    values: FloatArray
    holds: BoolArray
    words: str
    cure: str


def solid_rules(axes: FloatArray, batch: SolidArray, fit_mm: float, shortest_edge_mm: float) -> list[Rule]:
    """The rules in their order; each is only meaningful for solids that pass all rules before it."""
    skew = np.abs(axes @ axes.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    measures = Measures(batch.topology, batch.vertices)
    volume = measures.volumes
    tail, head = batch.topology.edges.T
    edges = np.linalg.norm(batch.vertices[:, head] - batch.vertices[:, tail], axis=-1)
    of_rounds = (measures.shortest_sides, measures.radii, measures.fillets.radii)
    shortest = np.concatenate([edges, *of_rounds], axis=1).min(axis=1)
    bulge, clearance = _bulges(measures), round_clearances(measures)
    measured = (skew <= ORTHONORMALITY_TOLERANCE) & (volume > 0) & (shortest >= shortest_edge_mm) & (bulge <= fit_mm)
    splittable = measured.copy()
    splittable[measured] = is_splittable(batch[measured])
    return [
        Rule(
            skew,
            skew <= ORTHONORMALITY_TOLERANCE,
            f"has axes that are {{:.3g}} from orthonormal, allowed {ORTHONORMALITY_TOLERANCE:g}",
            "give each part's placement unit axes at right angles",
        ),
        Rule(
            volume,
            (volume > 0) | (clearance < 0),  # a bore that is larger than the solid is told below
            "has a volume of {:.6g} mm3, which must be positive",
            "it is inside out or empty: make the edges of the mesh longer, or section, setbacks and joints smaller, or "
            "leave it out",
        ),
        Rule(
            shortest,
            shortest >= shortest_edge_mm,
            f"has an edge of {{:.3g}} mm, allowed {shortest_edge_mm:g} mm and more",
            "change the clearance or the joint a little, so that its corners are further apart",
        ),
        Rule(
            bulge,
            bulge <= fit_mm,
            f"has a face that is off its plane by {{:.3g}} mm, allowed {fit_mm:g} mm",
            "planarise the mesh first",
        ),
        Rule(
            clearance,
            clearance > 0,
            "has a bore or round bar whose edge is {:.3g} mm from another edge of its face, which must be positive",
            "make it smaller, or place it further inside the face",
        ),
        Rule(
            volume,
            splittable,
            "is neither convex nor a prism whose outline does not cross itself",
            "widen the angles between its edges, or leave it out",
        ),
    ]


def _bulges(of: Measures) -> FloatArray:
    """(P,) largest distance of a corner from the middle plane of its face, of the edge of a round from its face, or of
    a fillet from a quarter of a cylinder."""
    levels = np.einsum("pck,kpc->pc", of.normals[:, of.topology.corner_face], of.from_apex)
    highest, lowest = (of.topology.by_face(function, levels, empty=0.0) for function in (np.maximum, np.minimum))
    off = np.concatenate([(highest - lowest) / 2, of.round_misfits, of.fillet_misfits], axis=1)
    bulges: FloatArray = off.max(axis=1)
    return bulges

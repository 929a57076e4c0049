"""The targets of a mesh M and its Gauss image S that are optimised together."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite

from geometry.errors import GeometryError

__all__ = ["LEAST_HEIGHT_ERROR", "PairTargets"]

LEAST_HEIGHT_ERROR = 0.002
"""Least `height_error`: with a smaller one, heights weigh so much that faces turn over."""


@dataclass(frozen=True)
class PairTargets:
    """The targets of a pair M, S, in any combination.

    edges, vertices, faces: edge lines, vertices and face planes of S at distance 1 from the origin, as nearly as the
      rest allows: beams, nodes or panels of constant height, over d.
    height_error: the deviation of such a distance that is tolerated, relative to the other terms; the deviation that
    results
      is about proportional to its power 0.6. From `LEAST_HEIGHT_ERROR` up.
    upright: no node axis leans from the normal by more than `pair_objective.LARGEST_UPRIGHT_LEAN`, as nearly as the
      rest allows.
    circular, conical: faces, or vertices, are exactly so.
    mean, gaussian: H or K with respect to S, exactly constant, one over a length of M or its square; signs as in
      `curvature.face_curvatures`.

    Raises GeometryError for numbers out of range, targets that exclude each other, and where there is no target.

    >>> targets = PairTargets(edges=True, upright=True)  # beams of constant height, axes near the normals
    >>> targets.heights, targets.curved
    (True, False)
    """

    edges: bool = False
    vertices: bool = False
    faces: bool = False
    height_error: float = 0.01
    upright: bool = False
    circular: bool = False
    conical: bool = False
    mean: float | None = None
    gaussian: float | None = None

    def __post_init__(self) -> None:
        if not LEAST_HEIGHT_ERROR <= self.height_error < float("inf"):
            raise GeometryError(
                f"height_error is {self.height_error}: at least {LEAST_HEIGHT_ERROR} is needed, as faces turn over "
                "where heights count for more",
                value=self.height_error,
                bound=LEAST_HEIGHT_ERROR,
            )
        for name, number in [("mean", self.mean), ("gaussian", self.gaussian)]:
            if number is not None and not isfinite(number):
                raise GeometryError(f"the {name} curvature is {number}: a number is needed", value=number)
        if self.mean is not None and self.gaussian is not None:
            raise GeometryError(
                "mean and gaussian curvature exclude each other: only spheres, cylinders and planes have both of them "
                "constant; ask for one"
            )
        if not (self.heights or self.upright or self.circular or self.conical or self.curved):
            raise GeometryError(
                "the pair has no target: give one, such as edges for beams of constant height, or upright"
            )

    @property
    def heights(self) -> bool:
        """Whether distances from the origin are a target."""
        return self.edges or self.vertices or self.faces

    @property
    def curved(self) -> bool:
        """Whether a curvature is a target."""
        return self.mean is not None or self.gaussian is not None

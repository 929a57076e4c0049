"""A planar mesh and its Gauss image optimised together: what is asked for, and what it changed."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator

from fabkit.errors import ProjectError
from fabkit.production import OptimisedGaussImage
from fabkit.rules import Positive
from geometry.errors import GeometryError
from geometry.gauss import Pair
from geometry.optimised_pairs import LEAST_HEIGHT_ERROR, OptimisedPair, PairTargets, optimise_pair
from geometry.surface import Surface

__all__ = ["OptimiseRules", "optimised"]

Target = Literal["heights", "axes"]

MOST_VERTICES_PERCENTILE = 95
"""Percentile of the vertices whose movement is compared with `OptimiseRules.moves_refused`."""


class OptimiseRules(BaseModel):
    """The mesh and its Gauss image are optimised together, while the mesh glides on its surface.

    targets: "heights", beams of nearly constant height; "axes", node axes within 15 degrees of the normals; one of
    them, or both in a list. height_error: deviation of a height from the nominal one that is tolerated, as a share of
    it; heights vary less, and vertices move more, where it is small. moves_refused: movement of 95 % of the vertices
    from which the result is refused, in mean edge lengths.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    targets: tuple[Target, ...] = ("heights",)
    height_error: Annotated[float, Field(ge=LEAST_HEIGHT_ERROR, le=1, allow_inf_nan=False)] = 0.01
    moves_refused: Positive = 1.0

    @field_validator("targets", mode="before")
    @classmethod
    def _target_alone(cls, given: Any) -> Any:
        return given.split(",") if isinstance(given, str) else given

    @field_validator("targets")
    @classmethod
    def _at_least_one(cls, targets: tuple[Target, ...]) -> tuple[Target, ...]:
        if not targets:
            raise ValueError("a target is needed: heights, axes or both; or leave the table [optimise] out")
        return tuple(dict.fromkeys(targets))


def optimised(
    given: Pair, rules: OptimiseRules, *, offset: str | None, surface: Surface | None
) -> tuple[Pair, OptimisedGaussImage]:
    """The pair optimised by these rules, and what that changed.

    given: a pair in mm; offset: of which kind its Gauss image is an exact offset, None if of none. surface: on which
    vertices glide; None for that of the mesh itself. Raises ProjectError where all beams have one height already, and
    GeometryError as `optimise_pair` does, and where vertices move further than is allowed.
    """
    if offset == "edge" and "heights" in rules.targets:
        raise ProjectError(
            "the mesh has an exact edge offset, so that all its beams have one height already: leave out heights in "
            "--optimise, or [optimise]"
        )
    targets = PairTargets(
        edges="heights" in rules.targets, upright="axes" in rules.targets, height_error=rules.height_error
    )
    found = optimise_pair(given, targets, surface=surface)
    moved = float(np.percentile(found.moves, MOST_VERTICES_PERCENTILE))
    if moved > rules.moves_refused:
        raise GeometryError(
            f"{MOST_VERTICES_PERCENTILE} % of the vertices move by up to {moved:.2g} mean edge lengths while the mesh "
            f"and its Gauss image are optimised, allowed {rules.moves_refused:g}: raise moves_refused or height_error "
            "in [optimise], or lay the mesh along principal directions",
            value=moved,
            bound=rules.moves_refused,
        )
    return found.pair, _changes(found, rules, given.mesh.mean_edge_length)


def _changes(found: OptimisedPair, rules: OptimiseRules, length_mm: float) -> OptimisedGaussImage:
    before, after = found.before, found.after
    return OptimisedGaussImage(
        targets=rules.targets,
        height_spread=(before.edge_spread, after.edge_spread),
        lean_p95_deg=(float(np.degrees(before.lean[1])), float(np.degrees(after.lean[1]))),
        moves_mm=(float(np.median(found.moves)) * length_mm, float(found.moves.max()) * length_mm),
        farthest_vertex=int(found.moves.argmax()),
        off_surface_p95_mm=after.surface_distance[0] * length_mm,
        no_longer_convex=tuple(found.no_longer_convex.tolist()),
    )

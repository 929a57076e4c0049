"""Criteria that decide whether a mesh is fit to be built; `inspect` and `build` share them."""

from fabkit.fitness.finding import (
    CRITERIA,
    MAX_NAMED_ELEMENTS,
    Finding,
    FitnessError,
    check_fit_to_build,
    with_accepted,
)
from fabkit.fitness.rules import FitnessRules

__all__ = [
    "CRITERIA",
    "MAX_NAMED_ELEMENTS",
    "Finding",
    "FitnessError",
    "FitnessRules",
    "check_fit_to_build",
    "with_accepted",
]

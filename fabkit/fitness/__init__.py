"""Whether a mesh is fit to be built from: one judgement, which `inspect` and `build` share, criterion by criterion."""

from fabkit.fitness.finding import CRITERIA, TOLD_BY_NAME, Finding, FitnessError, allowed, check_fit_to_build
from fabkit.fitness.rules import FitnessRules

__all__ = ["CRITERIA", "TOLD_BY_NAME", "Finding", "FitnessError", "FitnessRules", "allowed", "check_fit_to_build"]

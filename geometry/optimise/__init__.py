"""Solvers: quadratic problems, Newton's method under constraints, penalties. They know arrays and no meshes."""

from geometry.optimise.affine import AffineMap, ComposedFunctional
from geometry.optimise.blocks import Blocks
from geometry.optimise.bounded_quadratic import distances_from_zero, minimise_bounded
from geometry.optimise.constrained_quadratic import ConstrainedQuadratic, minimise_quadratic
from geometry.optimise.functional import (
    Functional,
    LinearFunctional,
    SparseMatrix,
    StackedFunctional,
    apply,
    max_norm,
    normal_equations,
)
from geometry.optimise.grounded_laplacian import GroundedLaplacian
from geometry.optimise.hinge import Hinge
from geometry.optimise.newton import nearest_feasible
from geometry.optimise.penalty import minimise_by_penalty
from geometry.optimise.remembered import Remembered
from geometry.optimise.saddle_point import Factor, factorise
from geometry.optimise.semidefinite_quadratic import minimise_semidefinite
from geometry.optimise.solution import ConvergenceError, Reason, Solution

__all__ = [
    "AffineMap",
    "Blocks",
    "ComposedFunctional",
    "ConstrainedQuadratic",
    "ConvergenceError",
    "Factor",
    "Functional",
    "GroundedLaplacian",
    "Hinge",
    "LinearFunctional",
    "Reason",
    "Remembered",
    "Solution",
    "SparseMatrix",
    "StackedFunctional",
    "apply",
    "distances_from_zero",
    "factorise",
    "max_norm",
    "minimise_bounded",
    "minimise_by_penalty",
    "minimise_quadratic",
    "minimise_semidefinite",
    "nearest_feasible",
    "normal_equations",
]

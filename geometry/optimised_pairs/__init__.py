"""A mesh M and its Gauss image S optimised together [Pottmann2007, 4.4]."""

from geometry.optimised_pairs.pair_measures import PairMeasures
from geometry.optimised_pairs.pair_optimisation import OptimisedPair, height_trade_off, optimise_pair
from geometry.optimised_pairs.pair_targets import LEAST_HEIGHT_ERROR, PairTargets

__all__ = [
    "LEAST_HEIGHT_ERROR",
    "OptimisedPair",
    "PairMeasures",
    "PairTargets",
    "height_trade_off",
    "optimise_pair",
]

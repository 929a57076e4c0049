"""A mesh M and its Gauss image S optimised together [Pottmann2007, 4.4]."""

from geometry.optimised_pairs.pair_measures import PairMeasures
from geometry.optimised_pairs.pair_optimisation import OptimisedPair, height_trade_off, optimise_pair
from geometry.optimised_pairs.pair_targets import PairTargets

__all__ = ["OptimisedPair", "PairMeasures", "PairTargets", "height_trade_off", "optimise_pair"]

"""A mesh M and its Gauss image S optimised together [Pottmann2007, 4.4]."""

from geometry.combined.aims import Aims
from geometry.combined.measures import PairMeasures
from geometry.combined.pair_optimisation import OptimisedPair, optimise_pair, trade_of_heights

__all__ = ["Aims", "OptimisedPair", "PairMeasures", "optimise_pair", "trade_of_heights"]

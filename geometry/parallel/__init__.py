"""The meshes parallel to a mesh [Pottmann2007, 2]: the space P(M), its elements, and minimising over it."""

from geometry.parallel.edge_parallelity import edge_factors, parallelity
from geometry.parallel.space import ParallelSpace
from geometry.parallel.spectrum import Spectrum

__all__ = ["ParallelSpace", "Spectrum", "edge_factors", "parallelity"]

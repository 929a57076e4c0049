"""Transformations of oriented spheres, planes and cones: Moebius and Laguerre [Pottmann2007, 3.3]."""

from geometry.spheres.laguerre import LaguerreTransformation
from geometry.spheres.moebius import MoebiusTransformation
from geometry.spheres.oriented_cones import VertexCones

__all__ = ["LaguerreTransformation", "MoebiusTransformation", "VertexCones"]

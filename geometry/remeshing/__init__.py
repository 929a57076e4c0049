"""From a design surface to a mesh with planar faces: laid along conjugate lines, then made planar on the surface."""

from geometry.remeshing.network_study import NetworkTrial, affine_stretches, study_networks
from geometry.remeshing.remeshed_surface import RemeshedSurface, remesh

__all__ = ["NetworkTrial", "RemeshedSurface", "affine_stretches", "remesh", "study_networks"]

"""Meshes with planar faces, circular and conical meshes [Pottmann2007, 4.3], near a given mesh or on a surface."""

from geometry.meshing.circular import make_circular
from geometry.meshing.conical import make_conical
from geometry.meshing.optimised import OptimisedMesh
from geometry.meshing.planar import planarise
from geometry.meshing.vertex_guides import Effort, Guides

__all__ = ["Effort", "Guides", "OptimisedMesh", "make_circular", "make_conical", "planarise"]

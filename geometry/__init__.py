"""Meshes with planar faces and meshes parallel to them. No units; angles in radians."""

from geometry.errors import GeometryError
from geometry.mesh import Combinatorics, Mesh, MeshFile, read_mesh, write_mesh
from geometry.meshing import Planarised, planarise
from geometry.parallel import ParallelSpace, SupportStructure, gauss_image

__all__ = [
    "Combinatorics",
    "GeometryError",
    "Mesh",
    "MeshFile",
    "ParallelSpace",
    "Planarised",
    "SupportStructure",
    "gauss_image",
    "planarise",
    "read_mesh",
    "write_mesh",
]

"""Meshes with planar faces and meshes parallel to them. No units; angles in radians.

What most people need is here; exact shapes are in `geometry.mesh.shapes` and `geometry.mesh.solids`, what may be asked
of a mesh in `geometry.functionals`, measures of offsets in `geometry.parallel`.
"""

from geometry.curvature import FaceCurvatures, face_curvatures, steiner_area, steiner_areas
from geometry.errors import GeometryError, MeshError, MeshFileError, ParallelityError, RankError
from geometry.mesh import Combinatorics, Mesh, MeshFile, Surface, read_mesh, write_mesh
from geometry.meshing import OptimisedMesh, make_circular, make_conical, planarise
from geometry.optimise.solution import ConvergenceError
from geometry.parallel import (
    ParallelSpace,
    SupportStructure,
    edge_distances,
    edge_factors,
    edge_gauss_image,
    exact_gauss_images,
    face_distances,
    face_gauss_image,
    gauss_image,
    node_axes,
    parallel_from_axes,
    parallelity,
    vertex_distances,
    vertex_gauss_image,
)

__all__ = [
    "Combinatorics",
    "ConvergenceError",
    "FaceCurvatures",
    "GeometryError",
    "Mesh",
    "MeshError",
    "MeshFile",
    "MeshFileError",
    "OptimisedMesh",
    "ParallelSpace",
    "ParallelityError",
    "RankError",
    "SupportStructure",
    "Surface",
    "edge_distances",
    "edge_factors",
    "edge_gauss_image",
    "exact_gauss_images",
    "face_curvatures",
    "face_distances",
    "face_gauss_image",
    "gauss_image",
    "make_circular",
    "make_conical",
    "node_axes",
    "parallel_from_axes",
    "parallelity",
    "planarise",
    "read_mesh",
    "steiner_area",
    "steiner_areas",
    "vertex_distances",
    "vertex_gauss_image",
    "write_mesh",
]

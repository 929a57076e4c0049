"""What the things are: combinatorics, meshes, polygons, exact shapes. Knows no optimisation and no files."""

from geometry.mesh import shapes, solids, tilings
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh import Mesh
from geometry.mesh.mesh_arguments import (
    CombinatoricsLike,
    HasMesh,
    MeshLike,
    as_combinatorics,
    as_gauss_image,
    as_mesh,
)
from geometry.mesh.other_libraries import to_compas, to_meshio, to_trimesh

__all__ = [
    "Combinatorics",
    "CombinatoricsLike",
    "HasMesh",
    "Mesh",
    "MeshLike",
    "as_combinatorics",
    "as_gauss_image",
    "as_mesh",
    "shapes",
    "solids",
    "tilings",
    "to_compas",
    "to_meshio",
    "to_trimesh",
]

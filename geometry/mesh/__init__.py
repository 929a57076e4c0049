"""What the things are: combinatorics, meshes, polygons, files. Knows no optimisation."""

from geometry.mesh import shapes, solids
from geometry.mesh.checks import check_faces
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.files import MeshFile, read_mesh, write_mesh
from geometry.mesh.mending import mend
from geometry.mesh.mesh import Mesh
from geometry.mesh.pairs import read_mesh_pair
from geometry.mesh.surface import Surface

__all__ = [
    "Combinatorics",
    "Mesh",
    "MeshFile",
    "Surface",
    "check_faces",
    "mend",
    "read_mesh",
    "read_mesh_pair",
    "shapes",
    "solids",
    "write_mesh",
]

"""What the things are: combinatorics, meshes, polygons, files. Knows no optimisation."""

from geometry.mesh import shapes
from geometry.mesh.checks import check_faces
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.files import MeshFile, read_mesh, write_mesh
from geometry.mesh.mending import mend
from geometry.mesh.mesh import Mesh

__all__ = ["Combinatorics", "Mesh", "MeshFile", "check_faces", "mend", "read_mesh", "shapes", "write_mesh"]

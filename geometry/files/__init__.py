"""Mesh files: reading them, alone or as pairs, mending, checking and writing them."""

from geometry.files.face_checks import check_faces
from geometry.files.mending import mend
from geometry.files.mesh_files import MeshFile, read_mesh, write_mesh
from geometry.files.mesh_pairs import read_mesh_pair

__all__ = ["MeshFile", "check_faces", "mend", "read_mesh", "read_mesh_pair", "write_mesh"]

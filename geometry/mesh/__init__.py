"""What the things are: combinatorics, meshes, polygons, files. Knows no optimisation."""

from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh import Mesh

__all__ = ["Combinatorics", "Mesh"]

"""What the things are: combinatorics, meshes, polygons, exact shapes. Knows no optimisation and no files."""

from geometry.mesh import shapes, solids, tilings
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh import Mesh

__all__ = ["Combinatorics", "Mesh", "shapes", "solids", "tilings"]

"""Koebe polyhedra from circle patterns that are known in the plane, lifted by stereographic projection."""

from __future__ import annotations

import numpy as np

from geometry.errors import GeometryError
from geometry.mesh import Mesh, shapes
from geometry.spheres.stereographic import circle_planes, poles

__all__ = ["enneper_koebe"]


def enneper_koebe(faces: int, *, reach: float = 1.0) -> Mesh:
    """S over a square grid of equal circles: its Christoffel dual is a discrete surface of Enneper.

    faces: along a side of the square, at least 2. reach: half the side of the square in the plane z = 0, where the unit
    circle is the image of the equator; the south pole is the middle of S. The larger it is, the further the surface of
    Enneper winds; it meets itself from sqrt(3) on, at the middles of the sides.

    All edges touch the unit sphere; faces are counter-clockwise seen from outside. A disc; vertex (i, j) of the grid
    has number i (faces + 1) + j, with j running towards +x and i towards +y.

    Raises GeometryError for numbers out of range, and where a vertex circle would be as large as a hemisphere.

    >>> import numpy as np
    >>> from geometry.gauss import edge_distances
    >>> S = enneper_koebe(6)
    >>> S.n_faces, bool(np.abs(edge_distances(S) - 1).max() < 1e-9)
    (36, True)
    """
    if not isinstance(faces, (int, np.integer)) or faces < 2:
        raise GeometryError(
            f"{faces} faces along a side are asked for, an integer from 2 upwards is needed", value=faces, bound=2
        )
    if not (np.isfinite(reach) and reach > 0):
        raise GeometryError(f"the reach is {reach}: a number above 0 is needed", value=reach, bound=0.0)
    grid = shapes.grid(faces, faces)
    centres = (grid.vertices[:, 1::-1] - faces / 2) * (2 * reach / faces)  # x and y changed: seen from below
    # vertex circles of radius half a spacing touch in the middles of edges; face circles cross them there
    normals, distances = circle_planes(centres, np.full(len(centres), reach / faces))
    if not distances.min() > 0:
        raise GeometryError(
            f"with {faces} faces along a side of {2 * reach:g} circles in the middle are hemispheres or more; take "
            f"more than {reach:g} faces",
            value=faces,
            bound=reach,
        )
    return grid.with_vertices(poles(normals, distances))

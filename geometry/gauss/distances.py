"""Distances of a Gauss image from the origin: how far it is from the unit sphere [Pottmann2007, 3.1, 3.2].

They are those of the vertices, edge lines and face planes of S. Where an edge of S has no length or runs against that
of M, the edge of M gives the direction.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray
from geometry.mesh import MeshLike, as_gauss_image
from geometry.mesh.polygons import face_centroids
from geometry.parallel.edge_parallelity import perpendicular_part

__all__ = [
    "DISTANCE_TOLERANCE",
    "edge_distances",
    "edge_feet",
    "face_distances",
    "vertex_distances",
]

DISTANCE_TOLERANCE = 1e-9
"""Deviation of a distance of S from 1 that counts as exact: the accuracy that faces planar to 1e-12 give in meshes
with a thousand edges from end to end."""


def vertex_distances(gauss_image: MeshLike) -> FloatArray:
    """(N,) distances of the vertices of S from the origin: all 1 for a vertex offset [Pottmann2007, Prop. 2].

    >>> from geometry.mesh.shapes import box, dome
    >>> vertex_distances(dome(8, 2)).round(9).max().item()
    1.0
    >>> vertex_distances(box(2, 2, 2)).round(4).min().item()
    1.7321
    """
    gauss_image = as_gauss_image(gauss_image)
    return np.asarray(np.linalg.norm(gauss_image.vertices, axis=1))


def edge_distances(gauss_image: MeshLike, directions: FloatArray | None = None) -> FloatArray:
    """(E,) distances of the edge lines of S from the origin: all 1 for an edge offset; beam heights over d.

    directions (E, 3): unit vectors along the lines, such as the edge directions of M, if an edge of S may have no
    length; by default those of S, which raises MeshError for such an edge.

    >>> from geometry.mesh.shapes import box
    >>> edge_distances(box(2, 2, 2)).round(4).min().item()
    1.4142
    """
    gauss_image = as_gauss_image(gauss_image)
    return np.asarray(np.linalg.norm(edge_feet(gauss_image, directions), axis=1))


def edge_feet(gauss_image: MeshLike, directions: FloatArray | None = None) -> FloatArray:
    """(E, 3) the nearest points to the origin of the edge lines of S; directions as in `edge_distances`.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import box
    >>> feet = edge_feet(box(2, 2, 2))
    >>> feet.shape, np.abs(feet).sum(axis=1).max().item()
    ((12, 3), 2.0)
    """
    gauss_image = as_gauss_image(gauss_image)
    middles = gauss_image.vertices[gauss_image.combinatorics.edges].mean(axis=1)
    return perpendicular_part(middles, gauss_image.edge_directions if directions is None else directions)


def face_distances(gauss_image: MeshLike, normals: FloatArray | None = None) -> FloatArray:
    """(F,) signed distances of the face planes of S from the origin along unit normals (F, 3), such as those of M; left
    out, along those of S: all 1 for a face offset.

    >>> from geometry.mesh.shapes import box
    >>> face_distances(box(2, 4, 6)).tolist()
    [1.0, 2.0, 3.0, 3.0, 2.0, 1.0]
    """
    gauss_image = as_gauss_image(gauss_image)
    centroids = face_centroids(gauss_image.vertices, gauss_image.combinatorics)
    return np.asarray(np.einsum("fi,fi->f", centroids, gauss_image.face_normals if normals is None else normals))

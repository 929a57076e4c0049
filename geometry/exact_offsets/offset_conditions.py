"""Measures of which exact offsets a mesh is fit for [Pottmann2007, 3.1, 3.2].

A mesh of quads has vertex offsets if it is circular; any mesh has face offsets if it is conical, and edge offsets only
if the edges at each vertex lie on a cone of revolution, Prop. 3. Each measure is zero where its condition holds.
"""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, angles_between
from geometry.exact_offsets.edge_cones import best_cones, edge_stars
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.mesh.polygons import face_centroids, face_mean_edge_lengths, face_sums
from geometry.parallel.edge_parallelity import perpendicular_part

__all__ = ["circularity", "conicality", "edge_axis_twist", "edge_cone_deviation", "least_norm", "vertex_sums"]

SCATTER_RANK_TOLERANCE = 1e-12
"""Eigenvalue of a scatter matrix over the largest one, below which it counts as zero: spreads below 1e-6 of another
are rounding."""


def circularity(mesh: MeshLike) -> FloatArray:
    """(F,) largest distance of a corner from the best circle of its face, over the face's mean edge length.

    The corners are taken in the best plane of the face. Triangles are circular.

    >>> from geometry.mesh.shapes import dome, grid
    >>> bool(circularity(dome(8, 3)).max() < 1e-12)
    True
    >>> quad = grid(1, 1)
    >>> circularity(quad.with_vertices([[0, 0, 0], [0, 1, 0], [1, 0, 0], [1.2, 1.2, 0]])).round(3).tolist()
    [0.065]
    """
    mesh = as_mesh(mesh)
    c = mesh.combinatorics
    size = face_mean_edge_lengths(mesh.vertices, c)
    here = mesh.vertices[c.corners] - face_centroids(mesh.vertices, c)[c.corner_face]
    normals = mesh.face_normals[c.corner_face]
    flat = (here - np.einsum("ci,ci->c", here, normals)[:, None] * normals) / size[c.corner_face, None]
    return _circle_deviations(flat, mesh)


def _circle_deviations(flat: FloatArray, mesh: Mesh) -> FloatArray:
    """flat (C, 3): corners in the plane of their face, about its centroid.

    The centre x minimises the sum of (|p|^2 - mean |p|^2 - 2 p x)^2: linear, and exact for corners on a circle.
    """
    c = mesh.combinatorics
    squares = np.einsum("ci,ci->c", flat, flat)
    squares = squares - (face_sums(c, squares) / c.face_sizes)[c.corner_face]
    scatter = face_sums(c, flat[:, :, None] * flat[:, None, :])
    moments = face_sums(c, flat * squares[:, None])
    centres = least_norm(scatter, moments) / 2
    radii = np.linalg.norm(flat - centres[c.corner_face], axis=1)
    off = np.abs(radii - (face_sums(c, radii) / c.face_sizes)[c.corner_face])
    return np.maximum.reduceat(off, c.face_starts[:-1])


def conicality(mesh: MeshLike) -> FloatArray:
    """(N,) how far the faces at a vertex are from tangent to a cone of revolution, in radians [PottmannWallner2007].

    Largest difference between the angle of a face normal with the best axis and the mean of these angles. NaN at the
    boundary and for unused vertices, where there is no condition; zero for interior vertices of valence 3.

    >>> import numpy as np
    >>> from geometry.mesh.shapes import dome
    >>> cones = conicality(dome(8, 3))
    >>> bool(np.nanmax(cones) < 1e-12), np.isnan(cones).sum().item()  # boundary vertices have none
    (True, 16)
    """
    mesh = as_mesh(mesh)
    c = mesh.combinatorics
    normals = mesh.face_normals[c.corner_face]
    has_condition = c.is_used & ~c.is_boundary_vertex
    counts = np.maximum(np.bincount(c.corners, minlength=c.n_vertices), 1)
    means = vertex_sums(mesh, normals) / counts[:, None]
    middle = means[c.corners] / np.maximum(np.linalg.norm(means, axis=1), 1e-300)[c.corners, None]
    # the axis is middle + b with b across the middle, which minimises (normal - mean) . axis
    deviations = normals - means[c.corners]
    up = np.einsum("ci,ci->c", deviations, middle)
    flat = deviations - up[:, None] * middle
    scatter = vertex_sums(mesh, flat[:, :, None] * flat[:, None, :])
    axes = middle - least_norm(scatter, vertex_sums(mesh, flat * up[:, None]))[c.corners]
    angles = angles_between(normals, axes)
    off = np.abs(angles - (vertex_sums(mesh, angles) / counts)[c.corners])
    largest = np.zeros(c.n_vertices)
    np.maximum.at(largest, c.corners, off)
    return np.where(has_condition, largest, np.nan)


def edge_cone_deviation(mesh: MeshLike) -> FloatArray:
    """(N,) how far the edges at a vertex are from a cone of revolution, in radians [Pottmann2007, Prop. 3].

    Largest difference between the angle of an edge line with the best axis and the mean of these angles. In the Gauss
    image some edges may run the other way (Fig. 11), so the edges may lie on either half of the cone; the best of the
    cones of `best_cones` counts. NaN for vertices with less than 4 edges, which have no condition:
    three lines always lie on a cone. Zero everywhere is necessary for an edge offset, not sufficient.

    >>> import numpy as np
    >>> from geometry.mesh import shapes, solids
    >>> bool(edge_cone_deviation(solids.cuboctahedron()).max() < 1e-12)
    True
    >>> bool(np.isnan(edge_cone_deviation(shapes.cube())).all())  # three lines always lie on a cone
    True
    """
    mesh = as_mesh(mesh)
    deviations = np.full(mesh.n_vertices, np.nan)
    for vertices, directions in edge_stars(mesh, least_valence=4):
        deviations[vertices] = best_cones(directions)[1].min(axis=1)
    return deviations


def edge_axis_twist(mesh: MeshLike) -> FloatArray:
    """(E,) angle in radians between the planes that an edge spans with the axes of the cones at its two ends.

    In a mesh with an edge offset these are the node axes, so the angle is zero [Pottmann2007, Prop. 1, 3]. It says
    what `edge_cone_deviation` cannot for vertices with 3 edges, whose lines lie on 4 cones: the
    least angle over these counts. NaN where an end has less than 3 edges.

    >>> from geometry.mesh import solids
    >>> from geometry.mesh.shapes import dodecahedron
    >>> bool(edge_axis_twist(dodecahedron()).max() < 1e-7)
    True
    """
    mesh = as_mesh(mesh)
    axes = np.full((mesh.n_vertices, 4, 3), np.nan)
    for vertices, directions in edge_stars(mesh, least_valence=3):
        candidates, deviations = best_cones(directions)
        if directions.shape[1] > 3:
            candidates = np.take_along_axis(candidates, deviations.argmin(axis=1)[:, None, None], axis=1)
        axes[vertices] = candidates
    along = mesh.edge_directions[:, None, :]
    ends = axes[mesh.combinatorics.edges]
    first, second = (perpendicular_part(end, along) for end in ends.swapaxes(0, 1))
    angles = angles_between(first[:, :, None], second[:, None, :])
    return np.asarray(np.minimum(angles, np.pi - angles).min(axis=(1, 2)))


def vertex_sums(mesh: Mesh, per_corner: FloatArray) -> FloatArray:
    """(N, ...) sum over the corners at each vertex of values (C, ...)."""
    sums = np.zeros((mesh.n_vertices, *per_corner.shape[1:]))
    np.add.at(sums, mesh.combinatorics.corners, per_corner)
    return sums


def least_norm(scatter: FloatArray, moments: FloatArray) -> FloatArray:
    """(n, 3) x of least norm with scatter x nearest to moments; scatter (n, 3, 3) symmetric, of any rank."""
    return np.asarray(
        np.einsum("nij,nj->ni", np.linalg.pinv(scatter, rcond=SCATTER_RANK_TOLERANCE, hermitian=True), moments)
    )

"""Functionals of a mesh or a pair of meshes, one condition a file."""

from geometry.functionals.boundary_normals import extrapolated_normals
from geometry.functionals.circular_faces import CircularFaces
from geometry.functionals.closeness import InsideBalls, OnCurve, OnSmoothSurface, OnSurface, close_to
from geometry.functionals.conical_vertices import ConicalVertices, closed_fans
from geometry.functionals.constant_curvature import ConstantCurvature
from geometry.functionals.convex_faces import ConvexFaces
from geometry.functionals.fairness import laplacian, strain
from geometry.functionals.gauss_image_terms import (
    close_to_vertex_normals,
    edge_normals,
    edges_at_unit_distance,
    faces_at_unit_distance,
    vertices_at_unit_distance,
)
from geometry.functionals.pair_distances import (
    EdgesAtUnitDistance,
    FacesAtUnitDistance,
    UprightFaces,
    VerticesAtUnitDistance,
)
from geometry.functionals.parallel_edges import ParallelEdges, parallel_to
from geometry.functionals.planar_faces import PlanarFaces, relative_plane_deviations
from geometry.functionals.unknowns import coordinates
from geometry.functionals.upright_axes import (
    CloseToNormals,
    EdgeStretch,
    FaceNormalCosines,
    InsideCones,
    UprightVertices,
)

__all__ = [
    "CircularFaces",
    "CloseToNormals",
    "ConicalVertices",
    "ConstantCurvature",
    "ConvexFaces",
    "EdgeStretch",
    "EdgesAtUnitDistance",
    "FaceNormalCosines",
    "FacesAtUnitDistance",
    "InsideBalls",
    "InsideCones",
    "OnCurve",
    "OnSmoothSurface",
    "OnSurface",
    "ParallelEdges",
    "PlanarFaces",
    "UprightFaces",
    "UprightVertices",
    "VerticesAtUnitDistance",
    "close_to",
    "close_to_vertex_normals",
    "closed_fans",
    "coordinates",
    "edge_normals",
    "edges_at_unit_distance",
    "extrapolated_normals",
    "faces_at_unit_distance",
    "laplacian",
    "parallel_to",
    "relative_plane_deviations",
    "strain",
    "vertices_at_unit_distance",
]

"""What may be asked of a mesh, one objective a file."""

from geometry.functionals.circularity import Circularity
from geometry.functionals.closeness import OnCurve, OnSmoothSurface, OnSurface, close_to
from geometry.functionals.conicality import Conicality, closed_fans
from geometry.functionals.convexity import Convexity
from geometry.functionals.fairness import laplacian, strain
from geometry.functionals.normals import (
    close_to_vertex_normals,
    edge_normals,
    unit_edge_distances,
    unit_face_distances,
    unit_vertex_distances,
)
from geometry.functionals.pair_curvature import ConstantCurvature
from geometry.functionals.pair_distances import EdgeDistances, FaceAxes, FaceDistances, VertexDistances
from geometry.functionals.parallelity import Parallelity, parallel_to
from geometry.functionals.planarity import Planarity, face_deviations
from geometry.functionals.rim_normals import extrapolated_normals
from geometry.functionals.unknowns import coordinates
from geometry.functionals.uprightness import CloseToNormals, EdgeStretch, FaceTurns, InsideCones

__all__ = [
    "Circularity",
    "CloseToNormals",
    "Conicality",
    "ConstantCurvature",
    "Convexity",
    "EdgeDistances",
    "EdgeStretch",
    "FaceAxes",
    "FaceDistances",
    "FaceTurns",
    "InsideCones",
    "OnCurve",
    "OnSmoothSurface",
    "OnSurface",
    "Parallelity",
    "Planarity",
    "VertexDistances",
    "close_to",
    "close_to_vertex_normals",
    "closed_fans",
    "coordinates",
    "edge_normals",
    "extrapolated_normals",
    "face_deviations",
    "laplacian",
    "parallel_to",
    "strain",
    "unit_edge_distances",
    "unit_face_distances",
    "unit_vertex_distances",
]

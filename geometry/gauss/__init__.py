"""The pair of a mesh M and its Gauss image S [Pottmann2007, 2 to 4]: approximate and exact S, distances, axes, support
structure."""

from geometry.gauss.approximate_gauss_image import approximate_pair, refuse_triangle_mesh
from geometry.gauss.axes import node_axes, parallel_from_axes
from geometry.gauss.distances import (
    DISTANCE_TOLERANCE,
    edge_distances,
    edge_feet,
    face_distances,
    vertex_distances,
)
from geometry.gauss.joined_pairs import JoinedPair, join_pairs
from geometry.gauss.lean import axis_lean, closed_mesh_advice
from geometry.gauss.nearest_pair import nearest_parallel_pair, nearest_planar_mesh
from geometry.gauss.pair import PARALLEL_TOLERANCE, Pair, PairLike, as_pair, points_inwards
from geometry.gauss.rounded_mesh import rounded_mesh_pair
from geometry.gauss.support_structure import SupportStructure

__all__ = [
    "DISTANCE_TOLERANCE",
    "PARALLEL_TOLERANCE",
    "JoinedPair",
    "Pair",
    "PairLike",
    "SupportStructure",
    "approximate_pair",
    "as_pair",
    "axis_lean",
    "closed_mesh_advice",
    "edge_distances",
    "edge_feet",
    "face_distances",
    "join_pairs",
    "nearest_parallel_pair",
    "nearest_planar_mesh",
    "node_axes",
    "parallel_from_axes",
    "points_inwards",
    "refuse_triangle_mesh",
    "rounded_mesh_pair",
    "vertex_distances",
]

"""What `import geometry` offers."""

from geometry.curvature import (
    FaceCurvatures,
    christoffel_dual,
    constant_mean,
    constant_mean_of_revolution,
    face_curvatures,
    minimal_of_revolution,
    steiner_area,
    steiner_areas,
)
from geometry.edge_offset import KoebePolyhedron, edge_offset_mesh, koebe, rotational_koebe, tangent_mesh
from geometry.errors import FoldedError, GeometryError, MeshError, MeshFileError, ParallelityError, RankError
from geometry.exact_offsets import (
    OffsetMesh,
    edge_offset_pair,
    exact_pairs,
    face_offset_pair,
    offset,
    vertex_offset_pair,
)
from geometry.files import MeshFile, read_mesh, read_mesh_pair, write_mesh
from geometry.gauss import (
    JoinedPair,
    Pair,
    SupportStructure,
    approximate_pair,
    edge_distances,
    face_distances,
    join_pairs,
    nearest_parallel_pair,
    node_axes,
    parallel_from_axes,
    vertex_distances,
)
from geometry.layout import LaidMesh, boundary_lengths, lay_quads
from geometry.mesh import Combinatorics, Mesh, as_mesh, to_compas, to_meshio, to_trimesh
from geometry.meshing import Effort, Guides, OptimisedMesh, make_circular, make_conical, planarise
from geometry.optimise.solution import ConvergenceError
from geometry.optimised_pairs import OptimisedPair, PairTargets, height_trade_off, optimise_pair
from geometry.parallel import ParallelSpace, edge_factors, parallelity
from geometry.pictures import plot
from geometry.remeshing import NetworkTrial, RemeshedSurface, affine_stretches, remesh, study_networks
from geometry.spheres import LaguerreTransformation, MoebiusTransformation
from geometry.surface import Curvature, SmoothedSurface, Surface, refined, smoothed, subdivided
from geometry.traced_curves import TracedCurves, trace_curves

__all__ = [
    "Combinatorics",
    "ConvergenceError",
    "Curvature",
    "Effort",
    "FaceCurvatures",
    "FoldedError",
    "GeometryError",
    "Guides",
    "JoinedPair",
    "KoebePolyhedron",
    "LaguerreTransformation",
    "LaidMesh",
    "Mesh",
    "MeshError",
    "MeshFile",
    "MeshFileError",
    "MoebiusTransformation",
    "NetworkTrial",
    "OffsetMesh",
    "OptimisedMesh",
    "OptimisedPair",
    "Pair",
    "PairTargets",
    "ParallelSpace",
    "ParallelityError",
    "RankError",
    "RemeshedSurface",
    "SmoothedSurface",
    "SupportStructure",
    "Surface",
    "TracedCurves",
    "affine_stretches",
    "approximate_pair",
    "as_mesh",
    "boundary_lengths",
    "christoffel_dual",
    "constant_mean",
    "constant_mean_of_revolution",
    "edge_distances",
    "edge_factors",
    "edge_offset_mesh",
    "edge_offset_pair",
    "exact_pairs",
    "face_curvatures",
    "face_distances",
    "face_offset_pair",
    "height_trade_off",
    "join_pairs",
    "koebe",
    "lay_quads",
    "make_circular",
    "make_conical",
    "minimal_of_revolution",
    "nearest_parallel_pair",
    "node_axes",
    "offset",
    "optimise_pair",
    "parallel_from_axes",
    "parallelity",
    "planarise",
    "plot",
    "read_mesh",
    "read_mesh_pair",
    "refined",
    "remesh",
    "rotational_koebe",
    "smoothed",
    "steiner_area",
    "steiner_areas",
    "study_networks",
    "subdivided",
    "tangent_mesh",
    "to_compas",
    "to_meshio",
    "to_trimesh",
    "trace_curves",
    "vertex_distances",
    "vertex_offset_pair",
    "write_mesh",
]

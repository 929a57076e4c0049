"""What `import geometry` offers."""

from geometry.combined import Aims, OptimisedPair, optimise_pair, trade_of_heights
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
from geometry.edge_offset import (
    KoebePolyhedron,
    edge_offset_mesh,
    koebe,
    rotational_koebe,
    tangent_mesh,
)
from geometry.errors import FoldedError, GeometryError, MeshError, MeshFileError, ParallelityError, RankError
from geometry.files import MeshFile, read_mesh, read_mesh_pair, write_mesh
from geometry.gauss import (
    Pair,
    SupportStructure,
    approximate_pair,
    edge_distances,
    edge_offset_pair,
    exact_pairs,
    face_distances,
    face_offset_pair,
    nearest_parallel_pair,
    node_axes,
    parallel_from_axes,
    vertex_distances,
    vertex_offset_pair,
)
from geometry.layout import LaidMesh, lay_quads
from geometry.mesh import Combinatorics, Mesh
from geometry.meshing import Effort, Guides, OptimisedMesh, make_circular, make_conical, planarise
from geometry.optimise.solution import ConvergenceError
from geometry.parallel import ParallelSpace, edge_factors, parallelity
from geometry.pictures import plot
from geometry.spheres import LaguerreTransformation, MoebiusTransformation
from geometry.surface import Curvature, SmoothedSurface, Surface, refined, smoothed, subdivided

__all__ = [
    "Aims",
    "Combinatorics",
    "ConvergenceError",
    "Curvature",
    "Effort",
    "FaceCurvatures",
    "FoldedError",
    "GeometryError",
    "Guides",
    "KoebePolyhedron",
    "LaguerreTransformation",
    "LaidMesh",
    "Mesh",
    "MeshError",
    "MeshFile",
    "MeshFileError",
    "MoebiusTransformation",
    "OptimisedMesh",
    "OptimisedPair",
    "Pair",
    "ParallelSpace",
    "ParallelityError",
    "RankError",
    "SmoothedSurface",
    "SupportStructure",
    "Surface",
    "approximate_pair",
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
    "koebe",
    "lay_quads",
    "make_circular",
    "make_conical",
    "minimal_of_revolution",
    "nearest_parallel_pair",
    "node_axes",
    "optimise_pair",
    "parallel_from_axes",
    "parallelity",
    "planarise",
    "plot",
    "read_mesh",
    "read_mesh_pair",
    "refined",
    "rotational_koebe",
    "smoothed",
    "steiner_area",
    "steiner_areas",
    "subdivided",
    "tangent_mesh",
    "trade_of_heights",
    "vertex_distances",
    "vertex_offset_pair",
    "write_mesh",
]

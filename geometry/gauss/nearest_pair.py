"""M and S moved together until they are exactly planar and parallel, for meshes whose coordinates were rounded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray, IntArray, integers
from geometry.errors import MeshError, ParallelityError, raise_worst
from geometry.functionals import ParallelEdges, PlanarFaces, coordinates, relative_plane_deviations
from geometry.gauss.pair import Pair
from geometry.gauss.unit_distances import GAUSS_IMAGE_PARALLELITY
from geometry.mesh import Mesh, MeshLike, as_gauss_image, as_mesh
from geometry.optimise import Blocks, ConvergenceError, LinearFunctional, Reason, StackedFunctional, nearest_feasible
from geometry.parallel.edge_parallelity import PLANARITY_TOLERANCE, parallelity

__all__ = ["nearest_parallel_pair", "nearest_planar_mesh"]

PAIR_ACCURACY = 1e-13
"""Parallelity and planarity of the result, over the size of S and the mean edge length: a tenth of what others
require, so that they accept the pair unchanged."""

LONGEST_PAIR_STEP = 0.1
"""Longest move of a vertex in a step, over the mean edge length of M or the size of S: a pair further off is not
nearly parallel."""

LEAST_GAUSS_IMAGE_SIZE = 1e-60
"""Least mean distance of the vertices of S from the origin; one over it is the largest. Products of four such lengths
are still in the range of a double."""

PAIR_ANCHORED_STEPS = 2
"""First steps that also minimise the distance from the given pair."""

MAX_PAIR_STEPS = 12
"""Largest number of Newton steps: from six digits, two or three reach rounding accuracy; from four digits, four."""


def nearest_parallel_pair(
    mesh: MeshLike, gauss_image: MeshLike, *, tolerance: float = np.inf, fixed: Sequence[int] | IntArray = ()
) -> Pair:
    """The pair of planar meshes M and S, parallel to rounding, nearest to two meshes that were a pair before they were
    rounded.

    The squared moves of the vertices of M, over its mean edge length, and of those of S, over the mean distance of its
    vertices from the origin, have a small sum. Both move together, because a mesh
    made planar alone may be parallel to no mesh near S: P(M) often has more dimensions than that of a mesh nearby.
    Exact meshes are returned as the same objects. `Pair.moves_from` gives the moves of others.

    tolerance: the largest move of a vertex of S, in radii of the unit sphere, and of a vertex of M, in mean edge
    lengths. fixed: numbers of vertices that do not move, neither in M nor in S.

    Raises MeshError where the faces differ, an edge of M has no length or S no size; ConvergenceError, naming the
    worst edge, where no such pair is found near the given meshes; and ParallelityError, naming the vertex, where one
    would move by more than the tolerance.

    >>> from geometry.mesh.shapes import dome
    >>> mesh = dome(8, 3)
    >>> rounded = mesh.with_vertices(mesh.vertices.round(5))  # as a file with five digits holds it
    >>> pair = nearest_parallel_pair(rounded * 700.0, rounded)
    >>> bool(pair.moves_from(rounded * 700.0, rounded)[0].max() < 1e-4)
    True
    """
    mesh = as_mesh(mesh)
    gauss_image = as_gauss_image(gauss_image)
    if (
        parallelity(mesh, gauss_image).max() <= GAUSS_IMAGE_PARALLELITY
        and relative_plane_deviations(mesh).max() <= PLANARITY_TOLERANCE
    ):
        return Pair(mesh, gauss_image)
    found = _moved_together(mesh, gauss_image, integers(fixed))
    of_mesh, of_gauss_image = found.moves_from(mesh, gauss_image)
    _check_moves("of the Gauss image", "of the unit sphere's radius", of_gauss_image, tolerance)
    _check_moves("of the mesh", "of its mean edge length", of_mesh, tolerance)
    return found


def nearest_planar_mesh(mesh: MeshLike, *, tolerance: float = np.inf) -> Mesh:
    """The planar mesh nearest to one that was rounded; the mesh itself if it is exact.

    Unlike `planarise`, it changes distances from the origin by no more than rounding. tolerance, and what is raised: as
    in `nearest_parallel_pair`, of the mesh with itself.

    >>> from geometry.mesh.shapes import dome
    >>> rounded = dome(8, 3).with_vertices(dome(8, 3).vertices.round(5))
    >>> bool(nearest_planar_mesh(rounded).planarity.max() < 1e-11)
    True
    """
    mesh = as_mesh(mesh)
    return nearest_parallel_pair(mesh, mesh, tolerance=tolerance).gauss_image


def _moved_together(mesh: Mesh, gauss_image: Mesh, fixed: IntArray) -> Pair:
    centre = mesh.vertices.mean(axis=0)
    size, radius = mesh.mean_edge_length, float(np.linalg.norm(gauss_image.vertices, axis=1).mean())
    if not LEAST_GAUSS_IMAGE_SIZE <= radius <= 1 / LEAST_GAUSS_IMAGE_SIZE:
        raise MeshError(
            f"the vertices of the Gauss image are {radius:.1e} from the origin on average; this must be "
            f"between {LEAST_GAUSS_IMAGE_SIZE:.0e} and {1 / LEAST_GAUSS_IMAGE_SIZE:.0e}: a Gauss image lies near the "
            "unit sphere about the origin",
            value=radius,
            bound=LEAST_GAUSS_IMAGE_SIZE if radius < LEAST_GAUSS_IMAGE_SIZE else 1 / LEAST_GAUSS_IMAGE_SIZE,
        )
    blocks = Blocks({"M": mesh.vertices.shape, "S": mesh.vertices.shape})
    start = blocks.join(M=(mesh.vertices - centre) / size, S=gauss_image.vertices / radius)
    solution = nearest_feasible(
        _exactness(mesh, blocks, start, fixed),
        start,
        csr_array(eye_array(len(start))),
        tolerance=PAIR_ACCURACY,
        longest_step=LONGEST_PAIR_STEP,
        blocks=blocks,
        anchored_steps=PAIR_ANCHORED_STEPS,
        max_steps=MAX_PAIR_STEPS,
    )
    found = blocks.split(solution.x)
    vertices, normals = found["M"], found["S"]
    if solution.reason is not Reason.CONVERGED:
        sideways = parallelity(mesh.with_vertices(vertices), gauss_image.with_vertices(normals))
        edge = int(sideways.argmax())
        raise ConvergenceError(
            f"no mesh near the given one is parallel to one near the given Gauss image: "
            f"{mesh.combinatorics.edge_name(edge)} stays {sideways[edge]:.1e} off the direction of its mesh edge after "
            f"{solution.steps} steps, allowed {PAIR_ACCURACY:.0e}: {solution.reason.value}; write both with "
            "more digits",
            solution=solution,
            elements=[edge],
            value=float(sideways[edge]),
            bound=PAIR_ACCURACY,
        )
    vertices, normals = vertices * size + centre, normals * radius
    vertices[fixed], normals[fixed] = mesh.vertices[fixed], gauss_image.vertices[fixed]  # to the last digit
    return Pair(mesh.with_vertices(vertices), gauss_image.with_vertices(normals))


def _check_moves(place: str, unit: str, moves: FloatArray, tolerance: float) -> None:
    raise_worst(
        moves,
        "<=",
        tolerance,
        lambda vertex, move: (
            f"vertex {vertex} (counted from 0) {place} would have to move by {move:.1e} {unit} for the two meshes to "
            f"be planar and parallel, allowed {tolerance:.0e}: write both files with more digits"
        ),
        error=ParallelityError,
    )


def _exactness(mesh: Mesh, blocks: Blocks, start: FloatArray, fixed: IntArray) -> StackedFunctional:
    """S parallel to M, both with planar faces, fixed vertices where they are at the start: residuals of x (6N,).

    Planarity of M follows where no edge of S vanishes; asked for all the same, it also holds where one does.
    """
    c = mesh.combinatorics
    planar = [blocks.of(PlanarFaces(c, near.ravel()), name) for name, near in blocks.split(start).items()]
    columns = coordinates(np.concatenate([fixed, c.n_vertices + fixed])).ravel()
    in_place = LinearFunctional(csr_array(csr_array(eye_array(len(start)))[columns]), start[columns])
    return StackedFunctional([blocks.of(ParallelEdges(c), "M", "S"), *planar, *([in_place] if len(fixed) else [])])

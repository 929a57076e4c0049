"""The Gauss image to build with: computed, or given as a file beside that of the mesh, and what that takes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.wording import readable
from geometry.arrays import FloatArray
from geometry.errors import MeshError, ParallelityError
from geometry.files import MeshFile, read_mesh_pair
from geometry.gauss import edge_distances, gauss_image_pair, nearest_parallel_pair, offset_gauss_image
from geometry.gauss.distances import edge_feet
from geometry.mesh import Mesh
from geometry.parallel import parallelity

__all__ = [
    "EXACT",
    "TOLERANCE",
    "ExactPair",
    "GivenPair",
    "computed_image",
    "exact_pair",
    "points_inwards",
    "read_given_pair",
]

TOLERANCE = 1e-3
"""How far a pair may be off parallel, and be moved to be exact, in radii of the unit sphere, if nothing is said."""

EXACT = 1e-6
"""How far distances of an exact S may be from 1: a ten-thousandth of a millimetre in a beam. Drawing programs write
seven digits; a mesh that had an exact offset before should have it still."""

ROUNDED = 4.0
"""By how many roundings of coordinates, over the mean edge length, distances of an exact S may differ: a seventh of one
at map coordinates of fair meshes, and more where edges are short or angles sharp."""

LEAST_SIZE, LARGEST_SIZE = 0.5, 2.0
"""Where the median distance of the edges of S from the origin has to be: they are beam heights over the nominal one,
so a value far from 1 means another scale than that of the unit sphere."""


@dataclass(frozen=True, eq=False)
class GivenPair:
    """A mesh as read, near zero, turned to the outside that its Gauss image shows; that image; name and sha256 of its
    file."""

    file: MeshFile
    image: Mesh
    name: str
    sha256: str


@dataclass(frozen=True, eq=False)
class ExactPair:
    """A mesh with planar faces and a Gauss image parallel to it, both to rounding. largest_move, mean_move: of the
    vertices of the image from where they were given, in radii of the unit sphere."""

    mesh: Mesh
    image: Mesh
    largest_move: float
    mean_move: float


def computed_image(
    mesh: Mesh, weights: Mapping[str, Any], *, moved: float = 0.0, rounding: float = 0.0
) -> tuple[Mesh, Mesh, str | None]:
    """M and S of a planar mesh, and of which offset S is if it is exact: "edge", "vertex" or "face" where M has one and
    no weights are given; else S is as near to the unit sphere as the weights say.

    moved: how far a vertex moved at most where faces were made planar; M is moved as little again where that would
    decide about S.

    rounding: of the coordinates that M was read with, in its unit: distances of S are no more exact than they are.

    Beams follow the mean normals of the faces that they carry, at the boundary too. Raises as `gauss_image` does, but
    for meshes of triangles that have an exact S.
    """
    tolerance = max(EXACT, ROUNDED * rounding / mesh.mean_edge_length)
    exact = None if weights else offset_gauss_image(mesh, tolerance=tolerance)
    if exact is not None:
        return mesh, exact[1], exact[0]
    return *gauss_image_pair(mesh, moved, normals=mesh.vertex_normals, **weights), None


def read_given_pair(mesh: Path, image: Path, *, flip: bool, tolerance: float) -> GivenPair:
    """Read M and S from two files with the same faces; vertices correspond by their numbers.

    S points to the outside: where most of its edges lie on the other side of the faces of M, M is turned round. `flip`
    turns both about at the end, so that S points inwards, negated. S is in radii of the unit sphere.

    Raises GeometryError where a file cannot be read or used or the faces differ; where the edges of S are not near the
    unit sphere; and ParallelityError, naming the worst edge, where one of S is off the direction of its edge of M by
    more than `tolerance` of the sphere's radius.
    """
    file, gauss_image = read_mesh_pair(mesh, image)
    file = file.near_zero()
    found, mended = file.mesh, file.mended
    _check_size(found, gauss_image, image)
    _check_parallel(found, gauss_image, tolerance, image)
    if points_inwards(found, gauss_image):
        found, gauss_image = found.reversed(), gauss_image.reversed()
        mended = (*mended, f"all faces turned round to the outside that {image.name} shows")
    if flip:
        found, gauss_image = found.reversed(), -1.0 * gauss_image.reversed()
        mended = (*mended, "all faces turned round, as asked")
    return GivenPair(replace(file, mesh=found, mended=mended), gauss_image, readable(image.name), file.companion_sha256)


def exact_pair(mesh: Mesh, image: Mesh, *, tolerance: float) -> ExactPair:
    """The planar and exactly parallel pair next to a given one, which lost its last digits in a file.

    Both meshes are moved together: making M planar alone could leave no mesh parallel to it near S. A pair that is
    exact stays as it is. Raises ParallelityError, naming the vertex, where one of S would move by more than `tolerance`
    of the unit sphere's radius, or one of M by that part of its mean edge length; ConvergenceError where there is none.
    """
    found, gauss_image = nearest_parallel_pair(mesh, image)
    moves = np.linalg.norm(gauss_image.vertices - image.vertices, axis=1)
    _check_moves("of the Gauss image", "of the unit sphere's radius", moves, tolerance)
    of_mesh = np.linalg.norm(found.vertices - mesh.vertices, axis=1) / mesh.mean_edge_length
    _check_moves("of the mesh", "of its mean edge length", of_mesh, tolerance)
    return ExactPair(found, gauss_image, float(moves.max()), float(moves.mean()))


def _check_moves(place: str, unit: str, moves: FloatArray, tolerance: float) -> None:
    vertex = int(moves.argmax())
    if moves[vertex] > tolerance:
        raise ParallelityError(
            f"vertex {vertex} (counted from 0) {place} would have to move by {moves[vertex]:.1e} {unit} for the two "
            f"meshes to be planar and parallel, allowed {tolerance:.0e}: write both files with more digits",
            elements=[vertex],
            value=float(moves[vertex]),
            bound=tolerance,
        )


def _check_size(mesh: Mesh, image: Mesh, path: Path) -> None:
    median = float(np.median(edge_distances(mesh, image)))
    if not LEAST_SIZE <= median <= LARGEST_SIZE:
        raise MeshError(
            f"the edges of {path.name} have a distance of {median:.3g} from the origin in the median, and from "
            f"{LEAST_SIZE:g} to {LARGEST_SIZE:g} is needed: a Gauss image lies near the unit sphere about the origin, "
            "whatever the unit of the mesh; scale and move it there",
            value=median,
            bound=LEAST_SIZE if median < LEAST_SIZE else LARGEST_SIZE,
        )


def _check_parallel(mesh: Mesh, image: Mesh, tolerance: float, path: Path) -> None:
    sideways = parallelity(mesh, image)
    edge = int(sideways.argmax())
    if sideways[edge] > tolerance:
        count = int((sideways > tolerance).sum())
        raise ParallelityError(
            f"{mesh.combinatorics.edge_name(edge)} (counted from 0) of {path.name} is off the direction of its mesh "
            f"edge by {sideways[edge]:.1e} of the unit sphere's radius, allowed {tolerance:.0e}, and {count} of "
            f"{mesh.n_edges} edges are off by more than that: the two meshes are not parallel; give the Gauss image of "
            "this mesh, with its vertices in the same order",
            elements=[edge],
            value=float(sideways[edge]),
            bound=tolerance,
        )


def points_inwards(mesh: Mesh, image: Mesh) -> bool:
    """Whether S points to the inside of M: most feet of its edges lie below the faces of M beside them."""
    c = mesh.combinatorics
    facing = np.einsum("ck,ck->c", edge_feet(mesh, image)[c.corner_edge], mesh.face_normals[c.corner_face])
    return bool(np.count_nonzero(facing < 0) > np.count_nonzero(facing > 0))

"""The rules for the Gauss image to build with, and reading it if it is given as a file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from fabkit.rules import Positive
from fabkit.wording import readable
from geometry.errors import MeshError, ParallelityError, raise_worst
from geometry.files import MeshFile, read_mesh_pair
from geometry.gauss import edge_distances, points_inwards
from geometry.mesh import Mesh
from geometry.parallel import parallelity

__all__ = ["GIVEN_PAIR_TOLERANCE", "GaussImageRules", "GivenPair", "read_given_pair"]

GIVEN_PAIR_TOLERANCE = 1e-3
"""Default of the largest deviation of a given pair from parallel, in radii of the unit sphere, up to which the pair is
made exact."""

LEAST_MEDIAN_DISTANCE, LARGEST_MEDIAN_DISTANCE = 0.5, 2.0
"""Bounds of the median distance of the edges of a given S from the origin. These distances are beam heights over the
nominal height, so a value far from 1 means that S is not scaled to the unit sphere."""


class GaussImageRules(BaseModel):
    """The Gauss image: given as a file, or computed by weights.

    file: a mesh file with the faces of the mesh, parallel to it, near the unit sphere; no unit applies to it.
    tolerance: how far the given one may be off parallel, and its vertices move to become it, in radii of that sphere.
    faces, edges, vertices, fairness: weights of face distance, beam height, vertex normals and fairness.
    rounds: how often directions are estimated anew, so that distances themselves go to 1.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    file: Path | None = None
    tolerance: Positive = GIVEN_PAIR_TOLERANCE
    faces: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    edges: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    vertices: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    fairness: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    rounds: Annotated[int, Field(ge=1, le=1000)] | None = None

    @model_validator(mode="after")
    def _given_or_computed(self) -> GaussImageRules:
        if self.file is not None and self.weights:
            raise ValueError(
                f"the Gauss image is given by file, so there is nothing to compute: take out "
                f"{', '.join(self.weights)}, or file"
            )
        return self

    @property
    def weights(self) -> dict[str, Any]:
        """The weights that are given."""
        return self.model_dump(exclude={"file", "tolerance"}, exclude_none=True)


@dataclass(frozen=True, eq=False)
class GivenPair:
    """A mesh and its Gauss image as read, before they are made an exact `Pair`.

    file: the mesh near zero, its faces oriented to the outside that the Gauss image shows. gauss_image: parallel to the
    mesh up to the digits that files lose. name, sha256: of the file of the Gauss image.
    """

    file: MeshFile
    gauss_image: Mesh
    name: str
    sha256: str


def read_given_pair(mesh: Path, gauss_image: Path, *, flip: bool, tolerance: float) -> GivenPair:
    """Read M and S from two files with the same faces; vertices correspond by their numbers.

    S points to the outside of M: if most of its edges lie on the inner side of the faces of M, the faces of M are
    reversed. `flip` then reverses both meshes and negates S, which exchanges outside and inside. S is in radii of the
    unit sphere.

    Raises GeometryError where a file cannot be read or used or the faces differ; where the edges of S are not near the
    unit sphere; and ParallelityError, naming the worst edge, where an edge of S deviates from the direction of its
    edge of M by more than `tolerance` of the sphere's radius.
    """
    file, S = read_mesh_pair(mesh, gauss_image)
    file = file.near_zero()
    M, mended = file.mesh, file.mended
    _check_size(M, S, gauss_image)
    _check_parallel(M, S, tolerance, gauss_image)
    if points_inwards(M, S):
        M, S = M.reversed(), S.reversed()
        mended = (*mended, f"all faces reversed to face the outside that {gauss_image.name} shows")
    if flip:
        M, S = M.reversed(), -1.0 * S.reversed()
        mended = (*mended, "all faces reversed, as requested")
    return GivenPair(replace(file, mesh=M, mended=mended), S, readable(gauss_image.name), file.companion_sha256)


def _check_size(mesh: Mesh, gauss_image: Mesh, path: Path) -> None:
    median = float(np.median(edge_distances(gauss_image, mesh.edge_directions)))
    if not LEAST_MEDIAN_DISTANCE <= median <= LARGEST_MEDIAN_DISTANCE:
        raise MeshError(
            f"the median distance of the edges of {path.name} from the origin is {median:.3g}, and "
            f"{LEAST_MEDIAN_DISTANCE:g} to {LARGEST_MEDIAN_DISTANCE:g} is needed: a Gauss "
            "image lies near the unit sphere about the origin, whatever the unit of the mesh; scale and move it there",
            value=median,
            bound=LEAST_MEDIAN_DISTANCE if median < LEAST_MEDIAN_DISTANCE else LARGEST_MEDIAN_DISTANCE,
        )


def _check_parallel(mesh: Mesh, gauss_image: Mesh, tolerance: float, path: Path) -> None:
    deviations = parallelity(mesh, gauss_image)
    raise_worst(
        deviations,
        "<=",
        tolerance,
        lambda edge, value: (
            f"{mesh.combinatorics.edge_name(edge)} (counted from 0) of {path.name} is off the direction of its mesh "
            f"edge by {value:.1e} of the unit sphere's radius, allowed {tolerance:.0e}, and "
            f"{(deviations > tolerance).sum()} of {mesh.n_edges} edges are off by more than that: the two meshes are "
            "not parallel; give the Gauss image of this mesh, with its vertices in the same order"
        ),
        error=ParallelityError,
    )

"""Networks of many affine maps on one surface, compared by coarse meshes along each of them [Pottmann2007, 4.3]."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats, short_repr
from geometry.errors import GeometryError
from geometry.gauss import Pair, approximate_pair
from geometry.remeshing.remeshed_surface import RemeshedSurface, remesh
from geometry.surface import Surface

__all__ = ["NetworkTrial", "affine_stretches", "study_networks"]

STRETCH_FACTORS = (0.5, 2.0)
"""Factors of the affine maps that are compared: on most surfaces the crossing angles are at least 2 atan(1/2), which
is 53 degrees."""

HEIGHT_SPREAD_QUANTILES = (0.05, 0.95)
"""Quantiles of the edge distances; the height spread is their difference."""


@dataclass(frozen=True, eq=False)
class NetworkTrial:
    """A network, judged by a coarse mesh along it.

    affine (3, 3): the map whose principal lines these are. crossing_angles (2,): in radians, the 5 % quantile by area,
    and the median. n_singularities. remeshed, pair: the coarse mesh, and it with its Gauss image; None where they
    could not be made, and `reason` says why. height_spread: difference between the 5 % and 95 % quantiles of the edge
    distances, by which beam heights would vary (somewhat less in finer meshes); infinite without a pair. lean: in
    radians, the 95 % quantile over the node axes.

    >>> from geometry import Surface, study_networks
    >>> from geometry.mesh import shapes
    >>> dome = Surface(shapes.rotational_mesh([[2 + k / 10, 1 - k * k / 200] for k in range(10, -1, -1)], 40))
    >>> (trial,) = study_networks(dome, maps=[[[1, 0, 0], [0, 1, 0], [0, 0, 1]]], n_faces=150)
    >>> trial.n_singularities, trial.height_spread < 0.01, trial.remeshed.mesh.n_faces > 100
    (0, True, True)
    """

    __repr__ = short_repr

    affine: FloatArray
    crossing_angles: FloatArray
    n_singularities: int
    remeshed: RemeshedSurface | None
    pair: Pair | None
    reason: str

    @property
    def height_spread(self) -> float:
        if self.pair is None:
            return float("inf")
        low, high = np.quantile(self.pair.edge_distances, HEIGHT_SPREAD_QUANTILES)
        return float(high - low)

    @property
    def lean(self) -> float:
        return float("inf") if self.pair is None else float(np.quantile(self.pair.leans, HEIGHT_SPREAD_QUANTILES[1]))


def affine_stretches(surface: Surface) -> tuple[FloatArray, ...]:
    """Maps (3, 3) to begin a study with: the identity, which gives principal lines, and stretches by 1/2 and 2 along
    the three axes of inertia of the surface and the ten diagonals between them.

    >>> from geometry import Surface, affine_stretches
    >>> from geometry.mesh import shapes
    >>> maps = affine_stretches(Surface(shapes.dome(20, 8)))
    >>> len(maps), maps[0].tolist()
    (27, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    """
    vertices = surface.triangulated.vertices
    offsets = vertices - vertices.mean(axis=0)
    axes = np.linalg.eigh(offsets.T @ offsets)[1].T
    maps = [np.eye(3)]
    for signs in itertools.product((0, 1, -1), repeat=3):
        if next((sign for sign in signs if sign), -1) > 0:  # one of two opposite directions
            along = np.array(signs) @ axes / np.linalg.norm(signs)
            maps += [np.eye(3) + (factor - 1) * np.outer(along, along) for factor in STRETCH_FACTORS]
    return tuple(floats(each) for each in maps)


def study_networks(
    surface: Surface,
    *,
    maps: Sequence[Any] | None = None,
    n_faces: int = 300,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> tuple[NetworkTrial, ...]:
    """The networks of many affine maps, the one whose beams would vary least in height first.

    maps: affine maps (3, 3); None: those of `affine_stretches`. n_faces: of the coarse mesh that is laid along each,
    made planar and given a Gauss image. options: `boundary` and `strokes` of `remesh`. progress: called with the share
    of maps that are done. Maps along whose lines no such mesh was found come last, with the reason.

    Raises GeometryError where there is no map.

    >>> import numpy as np
    >>> from geometry import Surface
    >>> from geometry.mesh import shapes
    >>> plan = shapes.grid(20, 20).vertices / 10 - [1, 1, 0]
    >>> saddle = shapes.grid(20, 20).with_vertices(plan + [0, 0, 1] * (plan[:, :1] ** 2 / 2 - plan[:, 1:2] ** 2 / 4))
    >>> trials = study_networks(Surface(saddle), maps=[np.diag([1, 1, 0.5]), np.eye(3)], n_faces=80)
    >>> [trial.affine.diagonal().tolist() for trial in trials]
    [[1.0, 1.0, 1.0], [1.0, 1.0, 0.5]]
    """
    chosen = affine_stretches(surface) if maps is None else tuple(floats(each) for each in maps)
    if not chosen:
        raise GeometryError("there is no affine map to study: give at least one")
    trials = []
    for k, affine in enumerate(chosen):
        trials.append(_trial(surface, affine, n_faces, options))
        if progress is not None:
            progress((k + 1) / len(chosen))
    return tuple(sorted(trials, key=lambda trial: trial.height_spread))


def _trial(surface: Surface, affine: FloatArray, n_faces: int, options: dict[str, Any]) -> NetworkTrial:
    no_angles = floats(np.full(2, np.nan))
    try:
        remeshed = remesh(surface, n_faces=n_faces, affine=affine, **options)
    except GeometryError as error:
        return NetworkTrial(affine, no_angles, -1, None, None, error.message)
    angles = remeshed.laid.network.crossing_angles
    count = len(remeshed.laid.singularities)
    try:
        pair = approximate_pair(remeshed.mesh)
    except GeometryError as error:
        return NetworkTrial(affine, angles, count, remeshed, None, error.message)
    return NetworkTrial(affine, angles, count, remeshed, pair, "")

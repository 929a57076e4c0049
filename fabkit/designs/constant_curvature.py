"""Meshes of constant mean curvature, zero or not, with Koebe polyhedra as Gauss images [Pottmann2007, 5]."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from fabkit.designs.edge_offset_design import (
    KOEBE_TOLERANCE,
    MAX_FACES_IN_CLOSED_FORM,
    EdgeOffsetDesign,
    check_count,
    check_touching,
)
from fabkit.errors import ProjectError, error_sentence
from fabkit.families import Faces, MinimalShape
from geometry.curvature import (
    christoffel_dual,
    constant_mean,
    constant_mean_of_revolution,
    face_curvatures,
    minimal_of_revolution,
    radii_at_inflections,
)
from geometry.edge_offset import BandTiling, enneper_koebe, rotational_koebe, rows_within
from geometry.errors import GeometryError
from geometry.files import read_mesh, read_mesh_pair
from geometry.gauss import Pair, edge_distances, nearest_parallel_pair, nearest_planar_mesh
from geometry.mesh import Mesh

__all__ = ["cmc_design", "cmc_near_design", "minimal_design"]


EXACT_KOEBE_DEVIATION = 1e-10
"""Distance of the edges of S from the unit sphere, in radii, above which a missing dual is put down to the file."""


LARGEST_BULGE_RADIUS = 1e6
"""Largest radius of a bulge with mean curvature 1: added to the square of a larger one, 1 loses most of its digits."""


LARGEST_RELATIVE_CURVATURE = 1e3
"""Largest mean curvature times mean edge length of a start, at which the radius of a sphere is a thousandth of an
edge."""


BAND_TILINGS = {Faces.QUADS: BandTiling.QUADS, Faces.HEXAGONS: BandTiling.POINTY_TOP_HEXAGONS}


def minimal_design(
    *,
    shape: MinimalShape = MinimalShape.CATENOID,
    faces: Faces = Faces.QUADS,
    count: int = 24,
    turn_deg: float = 60.0,
    gauss_image: Path | None = None,
) -> EdgeOffsetDesign:
    """A mesh with mean curvature zero in every face [Pottmann2007, Figs 17, 18].

    count: faces around the axis of a catenoid, or along a side of Enneper's surface. turn_deg: by how much normals turn
    from the middle to the rim. gauss_image: instead of all that, the file of a Koebe polyhedron with boundary, whose
    fairest Christoffel dual is taken.

    Raises GeometryError for numbers out of range, and for a Gauss image that has no dual.

    >>> catenoid = minimal_design(count=12)
    >>> catenoid.mesh.n_faces
    48
    >>> bool(abs(catenoid.measures()["mean_curvature"]["largest"]) < 1e-9)
    True
    """
    if gauss_image is not None:
        file = read_mesh(gauss_image)
        pair = _dual_of(file.mesh, gauss_image.name)
        design = EdgeOffsetDesign.of("minimal", pair, {"gauss_image": gauss_image.name})
        return replace(design, inputs={gauss_image: file.sha256})
    _check_turn(turn_deg)
    turn = float(np.radians(turn_deg))
    settings = {"shape": str(shape), "faces": str(faces), "count": count, "turn_deg": turn_deg}
    check_count(count, MAX_FACES_IN_CLOSED_FORM)
    if shape is MinimalShape.CATENOID:
        rows = rows_within(BAND_TILINGS[faces], count, turn)
        check_count(count * rows, MAX_FACES_IN_CLOSED_FORM)
        S = rotational_koebe(BAND_TILINGS[faces], count, rows)
        return EdgeOffsetDesign.of("minimal", minimal_of_revolution(S), settings)
    if faces is not Faces.QUADS:
        raise ProjectError(
            "the surface of Enneper is only made of quads; leave out --faces hexagons, or take the catenoid"
        )
    check_count(max(count, 0) ** 2, MAX_FACES_IN_CLOSED_FORM)
    S = enneper_koebe(count, reach=float(np.tan(turn / 2)))
    return EdgeOffsetDesign.of("minimal", christoffel_dual(S), settings)


def _dual_of(given: Mesh, name: str) -> Pair:
    """The Koebe polyhedron read from a file, planar to the last digit, and its Christoffel dual."""
    check_touching(given)
    S = nearest_planar_mesh(given, tolerance=KOEBE_TOLERANCE)
    try:
        return christoffel_dual(S)
    except GeometryError as error:
        off = float(np.abs(edge_distances(given) - 1).max())
        if off <= EXACT_KOEBE_DEVIATION:
            raise
        raise ProjectError(
            f"{error_sentence(error)}; {name} is off the unit sphere by {off:.1e} of its radius, more than "
            f"{EXACT_KOEBE_DEVIATION:.0e}: write it with more digits"
        ) from error


def _check_turn(turn_deg: float) -> None:
    if not 0 < turn_deg < 90:
        raise ProjectError(f"the normals are to turn by {turn_deg:g} degrees: above 0 and below 90 is needed (--turn)")


def cmc_design(
    *,
    faces: Faces = Faces.QUADS,
    count: int = 24,
    rows: int = 6,
    folds: int | None = None,
    bulge: float | None = None,
) -> EdgeOffsetDesign:
    """A mesh of revolution with the same mean curvature -1 in every face [Pottmann2007, Figs 10, 19].

    count: faces around the axis; rows of them from one inflection to the next; folds: how many inflections there are
    between bulges and necks, 2 if left out, but none of hexagons, which cannot fold. bulge: the widest radius, where a
    sphere has 1 and a cylinder 0.5; left out: such that S folds at the inflections, or without folds, half way from a
    mesh with inflections at its rim to a sphere.

    Raises GeometryError for numbers out of range; ProjectError where rows would reach beyond the inflections, with
    the bulges that there are.

    >>> bulges = cmc_design(count=12, rows=3)
    >>> curvatures = bulges.measures()["mean_curvature"]
    >>> round(float(curvatures["least"]), 9), round(float(curvatures["largest"]), 9)
    (-1.0, -1.0)
    """
    if folds is None:
        folds = 0 if faces is Faces.HEXAGONS else 2
    if folds > 0 and faces is Faces.HEXAGONS:
        raise ProjectError(
            f"a band of hexagons cannot fold over itself, and {folds} folds were requested: take quads, or no folds"
        )
    check_count(max(count, 0) * max(rows, 0) * (max(folds, 0) + 1), MAX_FACES_IN_CLOSED_FORM)
    S = rotational_koebe(BAND_TILINGS[faces], count, rows, folds=folds)
    low, high = radii_at_inflections(S)
    if bulge is not None and bulge > LARGEST_BULGE_RADIUS:
        raise ProjectError(
            f"a bulge of {bulge:g} was requested, and at most {LARGEST_BULGE_RADIUS:g} is possible; a sphere has 1"
        )
    if bulge is None:
        bulge = None if folds else (2 * high + low) / 2
    elif low < bulge < high and not np.isclose(bulge, [low, high], rtol=1e-9, atol=0).any():
        raise ProjectError(
            f"a bulge of {bulge:g} has inflections before {rows} rows of {count} faces end: it has to be at least "
            f"{high:.4f}, or a neck of at most {low:.4f}; take fewer rows, or leave it out"
        )
    pair = constant_mean_of_revolution(S, -1.0, radius=bulge)
    settings = {"faces": str(faces), "count": count, "rows": rows, "folds": folds, "bulge": bulge}
    return EdgeOffsetDesign.of("cmc", pair, settings)


def cmc_near_design(start: Path, gauss_image: Path, *, mean: float | None = None) -> EdgeOffsetDesign:
    """A mesh with the same mean curvature in every face, near a given mesh, such as one of `koebe_design`.

    start, gauss_image: files of M and of S, a Koebe polyhedron, with the same faces. mean: H, in one over the unit of
    M, negative where M is convex like a sphere; the default is the median over the faces of M, which preserves its
    size. The result lies at the place of M; the origin of the design is that of M.

    Raises GeometryError where the pair does not fit together, and either error where there is no such mesh near.

    >>> from fabkit.designs import koebe_design, write_design
    >>> _ = write_design(koebe_design(count=4), Path("dome"))
    >>> even = cmc_near_design(Path("dome/M.obj"), Path("dome/S.obj"))
    >>> curvatures = even.measures()["mean_curvature"]
    >>> round(float(curvatures["largest"] / curvatures["least"]), 6)
    1.0
    """
    file, S = read_mesh_pair(start, gauss_image)
    file = file.near_zero()
    check_touching(S)
    pair = nearest_parallel_pair(file.mesh, S, tolerance=KOEBE_TOLERANCE)
    median = float(np.median(face_curvatures(pair).mean))
    S = nearest_planar_mesh(S, tolerance=KOEBE_TOLERANCE)  # itself if it is planar, however coarse M is
    H = median if mean is None else mean
    largest = LARGEST_RELATIVE_CURVATURE / pair.mesh.mean_edge_length
    if np.isfinite(H) and abs(H) > largest:
        raise ProjectError(
            f"a mean curvature of {H:g} was requested, and with edges as long as those of {start.name} at most "
            f"{largest:g} "
            f"is possible: the median of {start.name} is {median:g}; take a smaller --mean"
        )
    pair = _moved_to_start(pair.mesh, constant_mean(S, H, pair.mesh))
    settings = {"start": start.name, "gauss_image": gauss_image.name, "mean": H}
    design = EdgeOffsetDesign.of("cmc", pair, settings)
    return replace(design, origin=file.origin, inputs={start: file.sha256, gauss_image: file.companion_sha256})


def _moved_to_start(start: Mesh, pair: Pair) -> Pair:
    """The pair with M moved, so that each connected piece has the same mean of its vertices as in the start."""
    mesh, c = pair.mesh, pair.mesh.combinatorics
    piece = np.zeros(c.n_vertices, dtype=np.int64)
    piece[c.corners] = c.face_components[c.corner_face]
    moves = start.vertices - mesh.vertices
    means = np.stack([np.bincount(piece, moves[:, axis]) for axis in range(3)], axis=1) / np.bincount(piece)[:, None]
    return Pair(mesh.with_vertices(mesh.vertices + means[piece]), pair.gauss_image)

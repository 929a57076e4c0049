"""Edge offset meshes from a Koebe polyhedron of any combinatorics [Pottmann2007, 3.2, Fig. 11]."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.designs.edge_offset_design import MAX_FACES_SOLVED_FOR, EdgeOffsetDesign, check_count
from fabkit.errors import ProjectError, error_sentence
from fabkit.families import Bend, Tiles
from geometry.arrays import FloatArray, IntArray
from geometry.edge_offset import edge_offset_mesh, koebe, saddle_signs
from geometry.edge_offset.buildability import without_unbuildable_rim
from geometry.errors import GeometryError
from geometry.files import read_mesh
from geometry.gauss import Pair
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.tilings import dual, hexagon_patch, pentagon_patch, quad_patch

__all__ = ["koebe_design", "patch"]

SOUTH_POLE = (0.0, 0.0, -1.0)
"""The point of the sphere opposite the middle of an open polyhedron. Directions on the polyhedron are those of its
stereographic projection from there."""

DEFAULT_COVERAGE, PENTAGON_SADDLE_COVERAGE = 0.4, 0.2
"""Default share of the sphere that an open S covers; for saddles of pentagons it is half as much, as with more bending
they cross themselves in a wider part of their rim."""

LARGEST_MINORITY_SHARE, MINORITY_LENGTH = 0.4, 1.5
"""Largest share of edges that count as a minority of one sign, and their minimum length over that of the others. In
saddles of hexagons a third of the edges are such a minority; with equal lengths, the two zigzags of a hexagon would
touch or cross."""


def patch(tiles: Tiles, count: int) -> Combinatorics:
    """A patch that is about as long as wide. Raises ProjectError for too many faces."""
    check_count(max(count, 0) ** 2, MAX_FACES_SOLVED_FOR)
    if tiles is Tiles.QUADS:
        return quad_patch(count, count)
    if tiles is Tiles.PENTAGONS:
        return pentagon_patch(count, count)
    return hexagon_patch(count, round(count * 2 / 3**0.5))


def koebe_design(
    *,
    tiles: Tiles = Tiles.QUADS,
    count: int = 12,
    combinatorics: Path | None = None,
    take_dual: bool = False,
    coverage: float | None = None,
    bend: Bend = Bend.DOME,
    direction_deg: float = 45.0,
) -> EdgeOffsetDesign:
    """The fairest mesh parallel to a Koebe polyhedron S, with no edge shorter than 1.

    tiles: shape of the faces of a patch of about `count` by `count` faces; combinatorics: instead of a patch, the file
    of an open or closed mesh, of which only the faces are used; take_dual: take the dual instead. coverage: share of
    the sphere that an open S covers, by default 0.4, for a saddle of pentagons 0.2; with a larger one M bends more.
    bend: a dome keeps the orientation of all edges of S; a saddle reverses those across `direction_deg`, an angle from
    the x axis, and its faces that cross each other or are too narrow, as pentagons may be at the rim, are cut off; a
    sphere is S itself.

    Raises GeometryError where no polyhedron has these combinatorics, where no mesh has these orientations, naming
    edges, and for numbers out of range.

    >>> from fabkit.families import Tiles
    >>> dome = koebe_design(tiles=Tiles.HEXAGONS, count=4)
    >>> dome.mesh.n_faces, dome.measures()["edges_reversed"]
    (20, 0)
    >>> set(dome.pair.edge_distances.round(9).tolist())
    {1.0}
    """
    if not np.isfinite(direction_deg):
        raise ProjectError(f"the direction is {direction_deg} degrees (--direction): a finite number is needed")
    settings: dict[str, Any] = {"tiles": str(tiles), "count": count}
    inputs: dict[Path, str] = {}
    if combinatorics is None:
        faces = patch(tiles, count)
    else:
        file = read_mesh(combinatorics)
        faces, inputs, settings = (
            file.mesh.combinatorics,
            {combinatorics: file.sha256},
            {"combinatorics": combinatorics.name},
        )
    if take_dual:
        faces = dual(faces)
    is_open = bool(faces.is_boundary_edge.any())
    is_pentagon_saddle = bend is Bend.SADDLE and combinatorics is None and tiles is Tiles.PENTAGONS
    share = (
        (PENTAGON_SADDLE_COVERAGE if is_pentagon_saddle else DEFAULT_COVERAGE)
        if coverage is None and is_open
        else coverage
    )
    S = koebe(faces, coverage=share).mesh
    settings |= {"dual": take_dual, "coverage": share, "bend": str(bend), "direction_deg": direction_deg}
    pair = Pair(_bent(S, bend, direction_deg, is_open), S)
    n = pair.mesh.n_faces
    kept = without_unbuildable_rim(pair.mesh) if bend is Bend.SADDLE else np.arange(n)
    design = EdgeOffsetDesign.of("koebe", pair.part(kept), settings)
    n_cut = n - len(kept)
    note = f"{n_cut} of {n} faces at the rim were cut off, as some of them were too narrow or crossed each other"
    return replace(design, notes=(note,) if n_cut else (), inputs=inputs)


def _bent(gauss_image: Mesh, bend: Bend, direction_deg: float, is_open: bool) -> Mesh:
    if bend is Bend.SPHERE:
        return gauss_image
    if bend is Bend.DOME:
        return edge_offset_mesh(gauss_image, signs=1, lengths=(1.0, np.inf))
    if not is_open:
        raise ProjectError(
            "a closed polyhedron has no saddle parallel to it: take a mesh with boundary, or another bend"
        )
    angle = np.radians(direction_deg)
    signs = saddle_signs(gauss_image, [np.cos(angle), np.sin(angle), 0.0], pole=SOUTH_POLE)
    try:
        return edge_offset_mesh(gauss_image, signs=signs, lengths=(_min_lengths(gauss_image, signs), np.inf))
    except GeometryError as error:
        raise ProjectError(
            f"no saddle reverses the edges across the direction of {direction_deg:g} degrees "
            f"({error_sentence(error)}): take another --direction, or quads"
        ) from error


def _min_lengths(gauss_image: Mesh, signs: IntArray) -> FloatArray:
    """(E,) minimum lengths: 1, but `MINORITY_LENGTH` for edges with a sign that fewer than `LARGEST_MINORITY_SHARE` of
    all have. If no sign is so rare, the lengths of S over their mean."""
    is_minority = signs == (1 if 2 * (signs > 0).sum() < len(signs) else -1)
    if is_minority.mean() < LARGEST_MINORITY_SHARE:
        return np.where(is_minority, MINORITY_LENGTH, 1.0)
    return gauss_image.edge_lengths / gauss_image.mean_edge_length

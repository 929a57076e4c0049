"""Hexagonal edge offset meshes that touch a given surface [Pottmann2007, end of 3.3]."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from fabkit.designs.edge_offset_design import MAX_FACES_SOLVED_FOR, EdgeOffsetDesign, check_count, check_lengths
from fabkit.designs.koebe import patch
from fabkit.errors import ProjectError
from fabkit.families import Tiles
from geometry.arrays import IntArray
from geometry.edge_offset import TangentMesh, koebe, mean_normal, surface_cover
from geometry.edge_offset.buildability import LEAST_FACE_WIDTH
from geometry.files import read_mesh
from geometry.gauss import Pair
from geometry.surface import Surface

__all__ = ["hexagons_design"]

COVERAGE_MARGIN = 1.3
"""Share of the sphere that S covers at first, over the share within the largest turn of the normals. It is more than 1,
as a patch is not round."""

LARGEST_NORMAL_TURN_DEG = 90.0
"""Largest turn of the normals from their mean, in degrees, that a patch can cover."""

REPORTED_COVERINGS = 1.5
"""Average number of points of a surface with the same normal, above which it is reported. On a smooth convex surface it
is 1, and the rim and rough meshes add to it."""

LEAST_KEPT_SHARE = 0.5
"""Minimum share of the touching faces that are kept; where it is less, M jumps between places with the same normal."""

TURNS_DEG = (0.0, 15.0, 30.0, 45.0)
"""Turns of the hexagons about the mean normal in degrees, of which the most buildable is taken; a turn of 60 degrees
changes nothing."""


def hexagons_design(
    surface: Path, *, count: int = 12, curvature: int = 0, turn_deg: float | None = None, flip: bool = False
) -> EdgeOffsetDesign:
    """A mesh of hexagons, parallel to a Koebe polyhedron S, whose face planes touch a surface.

    surface: the file of a finely meshed surface. count: number of hexagons across the part of the sphere that its
    normals fill. curvature: 1 or -1 to touch only parts of the surface with positive or negative Gaussian curvature.
    turn_deg: angle by which S is turned about the mean normal; on saddles it determines the length of the shortest
    edges; the most buildable of `TURNS_DEG` by default. flip: exchanges the sides of the surface. S ends where the
    surface has no more normals; faces that cross themselves or others, fold over or are too narrow, as at the rim of
    saddles, are cut off both meshes. M is in the unit of the surface, near zero; the origin of the design is that of
    the surface.

    Raises GeometryError where nothing can touch, for surfaces that are not usable and numbers out of range;
    ProjectError where less than `LEAST_KEPT_SHARE` of the faces is left.

    >>> import numpy as np
    >>> from geometry import write_mesh
    >>> from geometry.mesh import shapes
    >>> grid = shapes.grid(12, 12)
    >>> x, y = grid.vertices[:, 0] - 6, grid.vertices[:, 1] - 6
    >>> write_mesh("roof.obj", grid.with_vertices(np.column_stack((x, y, -(x**2 + y**2) / 30))))
    >>> touching = hexagons_design(Path("roof.obj"), count=4, turn_deg=0)
    >>> touching.has_unit, set(touching.pair.edge_distances.round(9).tolist())
    (True, {1.0})
    """
    _check_numbers(count, turn_deg)
    file = read_mesh(surface, flip=flip).near_zero()
    phi = Surface(file.mesh)
    widest = float(np.degrees(mean_normal(phi.mesh)[1]))
    if not widest < LARGEST_NORMAL_TURN_DEG:
        raise ProjectError(
            f"the normals of {surface.name} turn by {widest:.0f} degrees from their mean, and less than "
            f"{LARGEST_NORMAL_TURN_DEG:g} is needed: cut the surface into parts"
        )
    coverage = min(1.0, COVERAGE_MARGIN * (1 - np.cos(np.radians(widest))) / 2)
    turns = TURNS_DEG if turn_deg is None else (turn_deg,)
    polyhedron = koebe(patch(Tiles.HEXAGONS, count), coverage=coverage)
    covers = {turn: surface_cover(phi, polyhedron.mesh, np.radians(turn), curvature=curvature) for turn in turns}
    turn_deg, best = max(covers.items(), key=lambda cover: cover[1].fitness)
    kept, found = best.kept, best.found
    _check_enough(len(kept), best.gauss_image.n_faces, surface.name, best.times)
    settings = {
        "surface": surface.name,
        "count": count,
        "curvature": curvature,
        "turn_deg": turn_deg,
        "flip": flip,
    }
    mesh = found.mesh.part(kept)
    check_lengths(mesh)  # planes may meet in edges of no length, to which nothing is parallel
    design = EdgeOffsetDesign.of("hexagons", Pair(mesh, best.gauss_image.part(kept)), settings)
    notes = _notes(found, kept, surface.name, best.times)
    return replace(design, notes=notes, has_unit=True, origin=file.origin, inputs={surface: file.sha256})


def _check_numbers(count: int, turn_deg: float | None) -> None:
    check_count(max(count, 0) ** 2, MAX_FACES_SOLVED_FOR)
    if count < 2:
        raise ProjectError(f"{count} hexagons across were requested (--count), at least 2 are needed")
    if turn_deg is not None and not np.isfinite(turn_deg):
        raise ProjectError(f"the hexagons are to be turned by {turn_deg} degrees (--turn): a finite number is needed")


def _notes(found: TangentMesh, kept: IntArray, surface: str, times: float) -> tuple[str, ...]:
    n = found.mesh.n_faces
    touching = int(np.isin(kept, found.missing, invert=True).sum())
    cut = f"; {n - len(kept)} were cut off, as they crossed, folded over or were too narrow" if len(kept) < n else ""
    notes = [f"{touching} of {len(kept)} faces touch the surface{cut}"]
    if times > REPORTED_COVERINGS:
        notes.append(_covered_often(surface, times))
    return tuple(notes)


def _check_enough(n_kept: int, n: int, surface: str, times: float) -> None:
    if n_kept < LEAST_KEPT_SHARE * n:
        raise ProjectError(
            f"only {n_kept} of {n} hexagons that touch {surface} can be built together, as others cross, fold over or "
            f"are narrower than {LEAST_FACE_WIDTH:g} times the mean edge length; "
            + (
                _covered_often(surface, times)
                if times > REPORTED_COVERINGS
                else "turn them by another angle (--turn), or take more of them (--count)"
            )
        )


def _covered_often(surface: str, times: float) -> str:
    return (
        f"each normal of {surface} occurs {times:.1f} times on average, and the hexagon with this normal touches "
        "only one "
        "of these places: cut the surface into convex parts and saddles, in which all normals differ, and cover them "
        "one by one"
    )

"""From a Koebe polyhedron to a hall: a mesh of constant mean curvature, and its image under a Laguerre transformation
[Pottmann2007, Prop. 4, Fig. 10].

The Koebe polyhedron S, of hexagons around an axis, is folded at its upper end and overlaps itself. The fold is a row of
degenerate faces, folded flat (gold). M has mean curvature -1 with respect to S. Below the row of the fold it bulges;
above, its Gaussian curvature is negative (clay). An offset followed by a Laguerre boost gives M', which leans and has
no symmetry axis, but has the same combinatorics and again edge offsets: its Gauss image S' touches the unit sphere as S
does.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import CLAY, GOLD, Note, Panel, Shapes, View, draw_page, faces, mixed
from geometry import Mesh, Pair, edge_distances, face_curvatures, parallelity
from geometry.curvature import constant_mean_of_revolution
from geometry.edge_offset.rotational import BandTiling, rotational_koebe
from geometry.mesh.intersections.meeting_faces import intersecting_faces, self_crossing_faces
from geometry.spheres.laguerre import LaguerreTransformation

AROUND, ROWS, LATITUDE = 8, 7, 0.2
MEAN = -1.0
DISTANCE = 0.1
FLAT = 1e-9  # the faces of the fold have Gaussian curvature 0, but for rounding
TRANSFORMATION = LaguerreTransformation.boost((0.35, 0.0, -0.2)) @ LaguerreTransformation.offset(0.2)


@cache
def original() -> Pair:
    """M, S."""
    s = rotational_koebe(BandTiling.FLAT_TOP_HEXAGONS, AROUND, ROWS, latitude=LATITUDE, folds=1)
    return constant_mean_of_revolution(s, MEAN)


@cache
def transformed() -> Pair:
    """M', S'."""
    return original().laguerre(TRANSFORMATION)


def apart(pair: Pair) -> float:
    """How far edges of M and M + d S are from the distance d, over d: the largest of all."""
    between = pair.offset_mesh(DISTANCE) - pair.mesh
    return float(np.abs(edge_distances(between, pair.mesh.edge_directions) / DISTANCE - 1).max())


def main() -> dict[str, float]:
    pair, moved = original(), transformed()
    m1, s1 = moved.mesh, moved.gauss_image
    curvatures = face_curvatures(pair)
    return {
        "faces": pair.mesh.n_faces,
        "largest deviation of the mean curvature of M from -1": float(np.abs(curvatures.mean - MEAN).max()),
        "faces of M with negative Gaussian curvature": int((curvatures.gaussian < -FLAT).sum()),
        "largest deviation of an edge of S from distance 1": float(np.abs(edge_distances(pair.gauss_image) - 1).max()),
        "largest deviation of an edge of S' from distance 1": float(np.abs(edge_distances(s1) - 1).max()),
        "largest deviation of edges of M and M + d S from distance d, over d": apart(pair),
        "largest deviation of edges of M' and M' + d S' from distance d, over d": apart(moved),
        "largest sine between edges of M' and S'": float((parallelity(m1, s1) / s1.edge_lengths).max()),
        "faces of M' that cross themselves or others": len(self_crossing_faces(m1)) + len(intersecting_faces(m1)),
    }


def rows() -> dict[str, range]:
    """Faces with a special colour: the fold, and those above it."""
    fold, end = AROUND * ROWS, original().mesh.n_faces
    return {GOLD: range(fold, fold + AROUND), mixed([CLAY], np.ones(1)): range(fold + AROUND, end)}


def coloured(mesh: Mesh, *, width: float = 1.0) -> Shapes:
    return faces(mesh, special=rows(), width=width)


def first_cover(mesh: Mesh) -> Shapes:
    """S without what runs over it once more."""
    return faces(mesh.part(np.arange(AROUND * (ROWS + 1))), special={GOLD: rows()[GOLD]}, width=1.0)


def draw(path: Path) -> None:
    pair, moved = original(), transformed()
    view = View(-75, 22)
    panels = [
        Panel(first_cover(pair.gauss_image), view, (20, 130, 270, 300)),
        Panel(coloured(pair.mesh), view, (330, 40, 300, 430)),
        Panel(coloured(moved.mesh), view, (690, 20, 390, 460)),
        Panel(first_cover(moved.gauss_image), view, (1120, 130, 260, 300)),
    ]
    names = [(155, r"$\mathcal{S}$"), (480, r"$\mathcal{M}$"), (885, r"$\mathcal{M}'$"), (1250, r"$\mathcal{S}'$")]
    draw_page(path, 1400, 540, panels, [Note(x, 510, name, 30) for x, name in names])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_10.png")
    print(main())

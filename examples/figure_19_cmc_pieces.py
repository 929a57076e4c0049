"""Pieces of constant mean curvature, obtained in different ways, as one mesh [Pottmann2007, 5, Fig. 19].

Three bulges (gold) have hexagons and, at their ends, pentagons: edge offset meshes whose mean curvature with respect to
a Koebe polyhedron is exactly -1, in closed form. A junction of quads (glass) begins as three tubes that meet, with the
boundaries of the bulges and an approximate Gauss image. Joined, M and S are optimised together until all faces have
mean curvature -1 with respect to S. The edges of S are then off distance 1 by less than a hundredth in the bulges,
which adapt to the junction as it does to them. With respect to a Gauss image of M alone, mean curvature is nearly
constant: the paper has [.966, 1.048] for its junction. At the right, the Gauss image of one bulge.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import GOLD, Note, Panel, View, draw_page, faces
from geometry import (
    JoinedPair,
    Mesh,
    OptimisedPair,
    Pair,
    PairTargets,
    approximate_pair,
    constant_mean_of_revolution,
    face_curvatures,
    join_pairs,
    optimise_pair,
    planarise,
    rotational_koebe,
)
from geometry.arrays import FloatArray
from geometry.edge_offset import BandTiling

MEAN = -1.0
AROUND, ROWS, BULGE = 20, 3, 0.73
"""Faces around a bulge, rows of hexagons, and its largest radius; a sphere of the same curvature has 1."""

RINGS, ARM_LENGTH = 9, 2.2
"""Quads along an arm of the junction, and from its centre to the bulges."""

BLEND, RELAXATIONS = 0.35, 20
"""Over what distance the tubes are blended, and how often vertices move to the means of their neighbours."""

LARGEST_GAP = 0.2
"""In mean edge lengths and radii: the tubes are but a start."""

ARMS = np.array([[np.cos(angle), np.sin(angle), 0.0] for angle in 2 * np.pi * np.arange(3) / 3])


@cache
def bulge() -> Pair:
    image = rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, AROUND, ROWS, level_ends=True)
    return constant_mean_of_revolution(image, MEAN, radius=BULGE)


def arm_radii(along: FloatArray) -> FloatArray:
    """Radii of the unduloid that the bulge is a part of, at distances (...) from the centre of the junction."""
    neck, rim = -1 / MEAN - BULGE, float(np.linalg.norm(bulge().mesh.vertices[0, :2]))
    radii = np.sqrt((neck**2 + BULGE**2 - (BULGE**2 - neck**2) * np.cos(np.linspace(0, np.pi, 500))) / 2)
    slopes = (radii**2 + neck * BULGE) / (2 * radii)  # of the height, by the angle
    heights = np.concatenate([[0.0], np.cumsum((slopes[1:] + slopes[:-1]) / 2) * np.pi / 499])
    neck_at = ARM_LENGTH - np.interp(rim, radii, heights)
    return np.asarray(np.interp(np.abs(along - neck_at), heights, radii))


def height(points: FloatArray) -> FloatArray:
    """(N,) of points over the three blended tubes."""
    along = np.maximum(points @ ARMS.T, 0.0)
    distances = np.linalg.norm(points[:, None] - along[:, :, None] * ARMS, axis=2) - arm_radii(along)
    return np.asarray(-BLEND * np.log(np.exp(-distances / BLEND).sum(axis=1)))


def tubes() -> Mesh:
    """Quads around three arms, from where they meet to their ends; two vertices have valence 6."""
    angles = np.pi / 2 + 2 * np.pi * np.arange(AROUND) / AROUND
    sides = np.cross([0.0, 0.0, 1.0], ARMS)
    around = np.cos(angles)[:, None] * sides[:, None] + np.sin(angles)[:, None] * [0.0, 0.0, 1.0]
    shares = np.linspace(0, 1, RINGS + 1)
    seam = np.abs(np.cos(angles))[:, None] / np.tan(np.pi / 3)  # where arms meet, in the plane halfway between them

    def points(radii: FloatArray) -> FloatArray:
        along = (1 - shares) * seam * radii + shares * ARM_LENGTH
        return np.asarray(radii[..., None] * around[:, :, None] + along[..., None] * ARMS[:, None, None])

    low, high = np.zeros((AROUND, RINGS + 1)), np.full((AROUND, RINGS + 1), 3.0)
    for _ in range(40):
        middle = (low + high) / 2
        outside = height(points(middle)[0].reshape(-1, 3)).reshape(middle.shape) > 0
        low, high = np.where(outside, low, middle), np.where(outside, middle, high)
    low[:, -1] = arm_radii(np.array(ARM_LENGTH))
    grid = points(low)
    at = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    ahead = np.roll(at, -1, axis=1)
    quads = np.stack([at[:, :, :-1], ahead[:, :, :-1], ahead[:, :, 1:], at[:, :, 1:]], axis=-1).reshape(-1, 4)
    flat = grid.reshape(-1, 3)
    _, kept, number = np.unique(flat.round(9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return relaxed(Mesh.from_faces(flat[kept], number.ravel()[quads].tolist()))


def relaxed(mesh: Mesh) -> Mesh:
    """Inner vertices evenly spread over the blended tubes."""
    c, points = mesh.combinatorics, mesh.vertices.copy()
    free = ~c.is_boundary_vertex
    for _ in range(RELAXATIONS):
        points[free] += 0.5 * ((c.adjacency @ points) / c.vertex_degrees[:, None] - points)[free]
        for _ in range(3):
            slopes = np.stack([(height(points + h) - height(points - h)) / 2e-5 for h in 1e-5 * np.eye(3)], axis=1)
            steps = height(points)[:, None] * slopes / np.square(slopes).sum(axis=1).clip(min=1e-3)[:, None]
            points[free] -= steps[free]
    return mesh.with_vertices(points)


@cache
def start() -> JoinedPair:
    junction = approximate_pair(planarise(tubes()).mesh)
    return join_pairs([junction, bulge(), bulge(), bulge()], tolerance=LARGEST_GAP)


@cache
def found() -> OptimisedPair:
    return optimise_pair(start(), PairTargets(mean=MEAN), keep_boundary=False)


def off_unit_distance(joined: JoinedPair, pair: Pair) -> FloatArray:
    """Of the edges of the bulges."""
    ends = np.isin(pair.mesh.combinatorics.edges, joined.vertices_of([1, 2, 3])).all(axis=1)
    return np.asarray(np.abs(pair.edge_distances - 1)[ends])


def main() -> dict[str, float]:
    joined, pair = start(), found().pair
    low, high = np.quantile(face_curvatures(approximate_pair(pair.mesh)).mean, [0.025, 0.975]).tolist()
    return {
        "quads of the junction": int((joined.pieces == 0).sum()),
        "hexagons and pentagons of the bulges": int((joined.pieces > 0).sum()),
        "largest deviation of the mean curvature from -1": float(np.abs(face_curvatures(pair).mean - MEAN).max()),
        "mean curvature of 95 % of the faces, S from M alone, from": low,
        "to": high,
        "plane deviation, in mean edge lengths": found().after.plane_deviation,
        "lean of 95 % of the axes, at most, in degrees": float(np.degrees(found().after.lean[1])),
        "least distance of vertices of S from the origin": float(pair.vertex_distances.min()),
        "largest distance of vertices of S from the origin": float(pair.vertex_distances.max()),
        "largest deviation of edges of the bulges from distance 1": float(off_unit_distance(joined, pair).max()),
    }


def draw(path: Path) -> None:
    pair, bulges = found().pair, start().pieces > 0
    one = pair.gauss_image.part(np.flatnonzero(start().pieces == 2))
    panels = [
        Panel(faces(pair.mesh, special={GOLD: np.flatnonzero(bulges)}, width=1.0), View(-75, 35), (20, 20, 1000, 720)),
        Panel(faces(one, GOLD, back=GOLD), View(-75, 35), (1080, 220, 280, 280)),
    ]
    draw_page(path, 1400, 800, panels, [Note(520, 770, r"$\mathcal{M}$", 30), Note(1220, 770, r"$\mathcal{S}$", 30)])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_19.png")
    print(main())

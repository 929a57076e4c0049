"""The meshes parallel to a given one form a linear space, so they can be blended [Pottmann2007, 2.2 and Fig. 5].

M, at the top, is a pavilion of planar quads with a waist. The other two corners are the parallel meshes nearest to a
bell and to an oval chalice. All meshes between them are blends of the three, so they are parallel to M too.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, GOLD, Note, Panel, View, draw_page, faces, mixed
from geometry import Mesh, ParallelSpace
from geometry.arrays import FloatArray
from geometry.mesh import shapes
from geometry.parallel import parallelity

STEPS = 3
NAMES = (r"$\mathcal{M}$", r"$\mathcal{M}'$", r"$\mathcal{M}''$")


def pavilion(lower: float, upper: float, stretch: float) -> Mesh:
    """Its meridians are arcs that bend outwards below and above; each half is scaled by itself. The plan is stretched
    in x, and the whole a little oblique: a projective map keeps planes plane."""
    turn = np.linspace(-0.95, 1.05, 15)
    steps = np.stack([np.sin(turn), np.cos(turn)], axis=1)
    steps *= np.where(turn < 0, lower, upper)[:, None] * 0.13
    profile = np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])
    profile[:, 0] += 0.45 - profile[:, 0].min()
    points = shapes.rotational_mesh(profile, 30)
    places = points.vertices * [stretch, 1 / stretch, 1]
    return points.with_vertices(places / (1 + 0.12 * places[:, :1] + 0.06 * places[:, 2:]))


@cache
def corners() -> tuple[Mesh, Mesh, Mesh]:
    mesh = pavilion(1.0, 1.0, 1.0)
    space = ParallelSpace(mesh)
    return mesh, space.project(pavilion(1.7, 0.35, 1.0)), space.project(pavilion(0.3, 1.4, 1.5))


def weights() -> FloatArray:
    """(10, 3) shares of the three corners in the blends, row by row."""
    return np.array([(STEPS - row, row - k, k) for row in range(STEPS + 1) for k in range(row + 1)]) / STEPS


def blends() -> list[Mesh]:
    space = ParallelSpace(corners()[0])
    return [space.blend(shares, corners()) for shares in weights().tolist()]


def main() -> dict[str, float]:
    mesh = corners()[0]
    sines = [float((parallelity(mesh, blend) / blend.edge_lengths).max()) for blend in blends()]
    return {
        "faces": mesh.n_faces,
        "dimension of P(M)": ParallelSpace(mesh).dimension,
        "largest sine between corresponding edges": max(sines),
    }


def draw(path: Path) -> None:
    width, height = 340, 268
    panels, names = [], []
    for shares, mesh in zip(weights(), blends(), strict=True):
        row, aside = STEPS * (1 - shares[0]), STEPS * (shares[2] - shares[1])
        left, top = round(700 + width * (aside - 1) / 2), round(10 + row * height)
        picture = faces(mesh, mixed((GOLD, BLUE, CLAY), shares), width=0.6)
        panels.append(Panel(picture, View(-65, 22), (left, top, width, height), scale=122))
        if shares.max() == 1:
            names.append(Note(left + 45, top + 125, NAMES[shares.argmax()], 32))
    draw_page(path, 1400, 20 + 4 * height, panels, names)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_05.png")
    print(main())

"""An approximate offset of a mesh whose curvature changes its sign [Pottmann2007, 4.2 and Fig. 12].

Among all meshes parallel to M, optimisation finds S nearest to the unit sphere; M' = M + d S. Faces where M is
saddle-shaped (warm) have the opposite orientation in S, which is therefore folded along the image of the parabolic
line.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, LINEN, Note, Panel, View, bars, draw_page, faces, mixed, sphere
from geometry import SupportStructure, approximate_pair
from geometry.arrays import IntArray
from geometry.curvature import face_curvatures
from geometry.mesh import shapes

DISTANCE = 0.16


@cache
def support() -> SupportStructure:
    """Over a bell with a wide brim, stretched and bent by a projective map."""
    turn = np.radians(np.concatenate([np.linspace(12, 56, 8), np.linspace(58, 8, 10)]))[::-1]
    lengths = np.linspace(0.26, 0.16, len(turn))
    steps = np.stack([-np.cos(turn), np.sin(turn)], axis=1) * lengths[:, None]
    profile = np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])
    profile[:, 0] += 0.42 - profile[-1, 0]
    plain = shapes.rotational_mesh(profile, 44)
    places = plain.vertices * [1.25, 1, 1]
    mesh = plain.with_vertices(places / (1 + 0.07 * places[:, :1]))
    return SupportStructure(approximate_pair(mesh, normals=mesh.vertex_normals), DISTANCE)


@cache
def saddles() -> IntArray:
    """Faces of negative Gaussian curvature with respect to S."""
    return np.flatnonzero(face_curvatures(support().pair).gaussian < 0)


def main() -> dict[str, float]:
    structure, pair = support(), support().pair
    return {
        "faces": pair.mesh.n_faces,
        "faces of negative curvature": len(saddles()),
        "innermost radius of S": float(pair.face_distances.min()),
        "outermost radius of S": float(pair.vertex_distances.max()),
        "least height over d": float(structure.heights.min()),
        "largest height over d": float(structure.heights.max()),
    }


def draw(path: Path) -> None:
    structure = support()
    mesh, s = structure.mesh, structure.gauss_image
    warm, cold = mixed([CLAY], np.ones(1)), mixed([BLUE], np.ones(1))
    special = {warm: saddles(), cold: np.setdiff1d(np.arange(mesh.n_faces), saddles())}
    shell = faces(mesh, special=special, width=0.6)
    fins = bars(structure.quads, structure.width_directions * 0.008, LINEN, width=0.4)
    ball = [*sphere(0.97, LINEN), *faces(s, special=special, width=0.6, opacity=0.8)]
    view = View(-65, 30)
    panels = [
        Panel(shell, view, (20, 20, 800, 330)),
        Panel([*shell, *fins], view, (20, 380, 800, 330)),
        Panel(ball, view, (900, 90, 460, 500)),
    ]
    names = [(70, 40, r"$\mathcal{M}$"), (70, 405, r"$\mathcal{M}'$"), (940, 120, r"$\mathcal{S}$")]
    draw_page(path, 1400, 730, panels, [Note(*name, 32) for name in names])


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_12.png")
    print(main())

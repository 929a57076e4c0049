"""Draw docs/howto/constant-heights.png: how far vertices move for beams of nearly constant height, on real meshes.

`python -m docs.tools.height_curves FOLDER` needs the folder of the meshes, which are not part of the project, and
prints the table of docs/howto/constant-heights.md.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from geometry.files import read_mesh
from geometry.gauss import approximate_pair
from geometry.meshing import planarise
from geometry.optimised_pairs import OptimisedPair, PairTargets, height_trade_off
from geometry.remeshing import remesh
from geometry.surface import Surface

__all__ = ["MESHES", "curve", "draw"]

PICTURE = Path(__file__).parents[1] / "howto" / "constant-heights.png"

MESHES = {
    "YasIsland": "libhedra/YasIsland.off",
    "botanic-garden": "dos/botanic-garden-bubble-0.obj",
    "gitter": "libhedra/gitter.off",
    "six-armed": "dos/planarizednormalized_six_quad.obj",
    "inspired": "directional/inspired_mesh_quads_Conjugate.off",
    "train-station": "directional/train-station.off",
}
"""Names and files; a mesh is laid on those of triangles."""

LAID_FACES = 1000
"""Faces of a mesh that is laid on a surface."""

COLOURS = ("#24303a", "#b5532f", "#2f7d8c", "#c9962b", "#7a5c99", "#6b8e4e")


def curve(path: Path) -> list[OptimisedPair]:
    """Pairs of the mesh in a file for several height errors, from the largest down."""
    mesh, surface = read_mesh(path).mesh.near_zero()[0], None
    if mesh.combinatorics.face_sizes.max() == 3:
        laid = remesh(Surface(mesh), n_faces=LAID_FACES)
        mesh, surface = laid.mesh, laid.surface
    else:
        mesh = planarise(mesh).mesh
    return height_trade_off(approximate_pair(mesh), PairTargets(edges=True), surface=surface)


def draw(path: Path, curves: dict[str, list[OptimisedPair]]) -> None:
    """Spread of the heights over the median movement of the vertices; a curve each mesh, from the mesh as it was."""
    figure = Figure((9.0, 5.5), dpi=100, layout="constrained")
    axes = figure.add_subplot()
    for (name, pairs), colour in zip(curves.items(), COLOURS, strict=True):
        moves = [0.0, *(float(np.median(pair.moves)) for pair in pairs)]
        spreads = [pairs[0].before.edge_spread, *(pair.after.edge_spread for pair in pairs)]
        axes.plot(moves, spreads, "o-", color=colour, label=name, markersize=5)
        default = next(k for k, pair in enumerate(pairs) if pair.targets.height_error == PairTargets.height_error)
        axes.plot(moves[default + 1], spreads[default + 1], "o", color=colour, markersize=11, fillstyle="none")
    axes.set_yscale("log")
    axes.set_yticks([0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5], ["0.5 %", "1 %", "2 %", "5 %", "10 %", "20 %", "50 %"])
    axes.set_yticks([], minor=True)
    axes.set_xlabel("median movement of the vertices, in mean edge lengths")
    axes.set_ylabel("spread of the beam heights (2.5 to 97.5 %) over their median")
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend(frameon=False)
    figure.savefig(path)


def main(folder: Path) -> None:
    curves = {name: curve(folder / file) for name, file in MESHES.items()}
    draw(PICTURE, curves)
    print(
        "| mesh | faces | before | " + " | ".join(f"{pair.targets.height_error:g}" for pair in curves["gitter"]) + " |"
    )
    for name, pairs in curves.items():
        cells = [f"{pair.after.edge_spread:.3f}, {np.median(pair.moves):.2f}" for pair in pairs]
        print(f"| {name} | {pairs[0].mesh.n_faces} | {pairs[0].before.edge_spread:.3f} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main(Path(sys.argv[1]))

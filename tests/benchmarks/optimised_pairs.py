"""M and S optimised together, on real meshes: `python -m tests.benchmarks.optimised_pairs [quick]`.

Height spread (2.5 to 97.5 %) and lean before and after, what it costs in moves, and processor seconds; the same of a
design surface on which a mesh was laid. Then the curve of height errors against spread and moves; how seconds grow, on
a mesh that is refined and made planar again; and meshes of constant mean curvature. `quick` leaves out what takes
minutes. Set OPENBLAS_NUM_THREADS=1 where cores are shared.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from geometry.curvature import face_curvatures
from geometry.errors import GeometryError
from geometry.files import read_mesh
from geometry.gauss import approximate_pair
from geometry.mesh import Mesh, shapes
from geometry.meshing import Guides, planarise
from geometry.optimised_pairs import OptimisedPair, PairTargets, height_trade_off, optimise_pair
from geometry.optimised_pairs.pair_measures import faces_off_the_rim, independent_curvatures
from geometry.remeshing import remesh
from geometry.surface import Surface
from tests.geometry.junctions import three_tubes

DATA = Path(__file__).parents[2].parent / "shared" / "data"
MESHES = {
    "YasIsland": ("libhedra/YasIsland.off", 0.025),
    "botanic-garden": ("dos/botanic-garden-bubble-0.obj", 0.020),
    "gitter": ("libhedra/gitter.off", 0.030),
    "six-armed": ("dos/planarizednormalized_six_quad.obj", 0.015),
    "inspired": ("directional/inspired_mesh_quads_Conjugate.off", 0.011),
}
"""Files, and the spreads that are to be reached."""


def planar(name: str) -> Mesh:
    return planarise(read_mesh(DATA / MESHES[name][0]).mesh.near_zero()[0]).mesh


def subdivided(mesh: Mesh) -> Mesh:
    """By the rule of Catmull and Clark; corners of the boundary stay."""
    c, v = mesh.combinatorics, mesh.vertices
    rim, degrees = c.is_boundary_edge, np.maximum(np.bincount(c.corners, minlength=c.n_vertices), 1)[:, None]
    centres = np.add.reduceat(v[c.corners], c.face_starts[:-1]) / c.face_sizes[:, None]
    middles = v[c.edges].mean(axis=1)
    on_edges = np.where(rim[:, None], middles, (2 * middles + centres[c.edge_faces].sum(axis=1)) / 4)

    def mean(per_end: np.ndarray, ends: np.ndarray) -> np.ndarray:
        sums = np.zeros_like(v)
        np.add.at(sums, ends, per_end)
        return sums / np.maximum(np.bincount(ends, minlength=c.n_vertices), 1)[:, None]

    faces, ends = mean(centres[c.corner_face], c.corners), c.edges.ravel()
    moved = (faces + 2 * mean(np.repeat(middles, 2, axis=0), ends) + (degrees - 3) * v) / degrees
    along = mean(np.repeat(middles[rim], 2, axis=0), c.edges[rim].ravel())
    on_rim = np.where(degrees == 1, v, (along + v) / 2)
    points = np.concatenate([np.where(c.is_boundary_vertex[:, None], on_rim, moved), on_edges, centres])
    n, e = c.n_vertices, c.n_edges
    before = c.corner_edge[c.previous_corner]
    quads = np.stack([c.corners, n + c.corner_edge, n + e + c.corner_face, n + before], axis=1)
    return Mesh.from_faces(points, quads.tolist())


def timed(mesh: Mesh, targets: PairTargets, surface: Surface | None = None) -> tuple[OptimisedPair, float]:
    """The pair of its approximate Gauss image, optimised."""
    given = approximate_pair(mesh)
    started = time.process_time()
    pair = optimise_pair(given, targets, surface=surface)
    return pair, time.process_time() - started


def table(title: str, *columns: str) -> Table:
    found = Table(title=title)
    for number, column in enumerate(columns):
        found.add_column(column, justify="right" if number else "left", no_wrap=True)
    return found


def degrees(leans: tuple[float, ...]) -> str:
    return " / ".join(f"{np.degrees(lean):.1f}" for lean in leans)


def heights(console: Console) -> None:
    found = table(
        "Beams of constant height, height_error .01",
        *("mesh", "faces", "spread", "after", "asked", "move", "lean", "after", "off Phi", "rim", "edge", "lost", "s"),
    )
    for name, (_, asked) in MESHES.items():
        mesh = planar(name)
        for upright in (False, True):
            pair, seconds = timed(mesh, PairTargets(edges=True, upright=upright))
            found.add_row(
                f"{name}{', upright' if upright else ''}",
                f"{mesh.n_faces}",
                f"{pair.before.edge_spread:.4f}",
                f"{pair.after.edge_spread:.4f}",
                f"{asked:.3f}",
                f"{np.median(pair.moves):.3f}",
                degrees(pair.before.lean),
                degrees(pair.after.lean),
                " / ".join(f"{each:.3f}" for each in pair.after.surface_distance),
                " / ".join(f"{each:.3f}" for each in pair.boundary_distance),
                f"{pair.shortest_edge:.2f}",
                f"{len(pair.no_longer_convex)}",
                f"{seconds:.1f}",
            )
    console.print(found)


def laid(console: Console) -> None:
    """From a surface of triangles: a mesh is laid on it, and optimised while it glides there."""
    given = Surface(read_mesh(DATA / "directional" / "train-station.off").mesh.near_zero()[0])
    found = table(
        "train-station, laid and optimised; asked: spread below .04, lean of 95 % within 15 degrees",
        *("faces", "targets", "spread", "after", "moves", "lean", "after", "off Phi", "rim", "edge", "lost", "s"),
    )
    for n_faces in (300, 1000):
        made = remesh(given, n_faces=n_faces)
        for upright in (False, True):
            pair, seconds = timed(made.mesh, PairTargets(edges=True, upright=upright), made.surface)
            found.add_row(
                f"{made.mesh.n_faces}",
                "heights, axes" if upright else "heights",
                f"{pair.before.edge_spread:.4f}",
                f"{pair.after.edge_spread:.4f}",
                " / ".join(f"{each:.2f}" for each in np.quantile(pair.moves, [0.5, 0.95, 1])),
                degrees(pair.before.lean),
                degrees(pair.after.lean),
                " / ".join(f"{each:.3f}" for each in pair.after.surface_distance),
                " / ".join(f"{each:.3f}" for each in pair.boundary_distance),
                f"{pair.shortest_edge:.2f}",
                f"{len(pair.no_longer_convex)}",
                f"{seconds:.1f}",
            )
    console.print(found)


def trades(console: Console) -> None:
    found = table("Height error: spread, median move", "mesh", ".1", ".03", ".01", ".003")
    for name in MESHES:
        mesh = planar(name)
        pairs = height_trade_off(approximate_pair(mesh), PairTargets(edges=True))
        found.add_row(name, *(f"{pair.after.edge_spread:.4f}, {np.median(pair.moves):.2f}" for pair in pairs))
    console.print(found)


def growth(console: Console) -> None:
    found = table("How processor seconds grow: six-armed, refined", "faces", "spread", "after", "s", "exponent")
    mesh, last = planar("six-armed"), None
    for _ in range(3):
        pair, seconds = timed(mesh, PairTargets(edges=True))
        exponent = "" if last is None else f"{np.log(seconds / last) / np.log(4):.2f}"
        spreads = (f"{pair.before.edge_spread:.4f}", f"{pair.after.edge_spread:.4f}")
        found.add_row(f"{mesh.n_faces}", *spreads, f"{seconds:.1f}", exponent)
        finer, last = subdivided(mesh), seconds
        mesh = planarise(finer, Guides(surface=Surface(finer))).mesh
    console.print(found)


def hyperboloid(n: int, rings: int) -> Mesh:
    z = np.linspace(-0.8, 0.8, rings + 1)
    return shapes.rotational_mesh(np.stack([np.sqrt(1 + (np.cosh(0.8) ** 2 - 1) * (z / 0.8) ** 2), z], axis=1), n)


def curvatures(console: Console) -> None:
    found = table("Hyperboloid to H = 0", "faces", "off the catenoid", "after", "H", "fresh H", "lean", "s")
    for n in (24, 48, 72):
        mesh = hyperboloid(n, n // 2)
        pair, seconds = timed(mesh, PairTargets(mean=0.0))
        off = [
            float(np.abs(np.hypot(*m.vertices[:, :2].T) - np.cosh(m.vertices[:, 2])).max())
            for m in (mesh, pair.pair.mesh)
        ]
        fresh = independent_curvatures(pair.pair.mesh, gaussian=False)[0][faces_off_the_rim(mesh.combinatorics, 2)]
        found.add_row(
            f"{mesh.n_faces}",
            *(f"{each:.1e}" for each in off),
            f"{np.abs(face_curvatures(pair.pair).mean).max():.0e}",
            f"{fresh.min():.4f} .. {fresh.max():.4f}",
            degrees(pair.after.lean),
            f"{seconds:.1f}",
        )
    console.print(found)
    found = table("Three tubes to H = -.49", "faces", "H - H", "fresh H", "lean", "|s|", "rim", "s")
    for n in (12, 24, 48):
        pair, seconds = timed(three_tubes(n, 2 * n // 3), PairTargets(mean=-0.49))
        c = pair.pair.mesh.combinatorics
        fresh = independent_curvatures(pair.pair.mesh, gaussian=False)[0][faces_off_the_rim(c, 2)]
        distances = pair.pair.vertex_distances
        found.add_row(
            f"{c.n_faces}",
            f"{np.abs(face_curvatures(pair.pair).mean + 0.49).max():.0e}",
            f"{fresh.min():.4f} .. {fresh.max():.4f}",
            degrees(pair.after.lean),
            f"{distances.min():.3f} .. {distances.max():.3f}",
            f"{pair.boundary_distance[1]:.3f}",
            f"{seconds:.1f}",
        )
    console.print(found)
    for name in ("YasIsland", "botanic-garden"):
        pair = approximate_pair(planar(name))
        mean = float(np.median(face_curvatures(pair).mean))
        try:
            optimise_pair(pair, PairTargets(mean=mean))
            console.print(f"{name}: H = {mean:.3g} reached")
        except GeometryError as error:
            console.print(f"{name}, H = {mean:.3g}: refused: {error}")


def main(quick: bool) -> None:
    console = Console(width=180)
    heights(console)
    laid(console)
    if quick:
        return
    trades(console)
    growth(console)
    curvatures(console)


if __name__ == "__main__":
    main("quick" in sys.argv[1:])

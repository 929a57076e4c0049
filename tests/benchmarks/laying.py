"""Meshes laid on surfaces and planarised, beside what is asked: `python tests/benchmarks/laying.py [faces ...]`.

Three roofs, where they are at hand, and six surfaces with known principal lines, all with the same defaults. Lengths
are in mean edge lengths, angles in degrees. lay, plan, Gauss: seconds of the processor. quads: share of the faces.
irregular: inner vertices of valence 3, 5 and so on. on: share of edges within 10 degrees of the network. moves and off:
by planarising, and from the surface afterwards, 95 % and largest. corners: smallest and largest, afterwards. planar:
largest deviation. axes: 95 % of node axes from the normals; heights: of beams, 5 - 95 %, where there is a Gauss image.
! marks what misses its bound, which is meant for 1 000 faces. Then these as powers of the number of faces, and how the
families of an ellipsoid become conjugate: |II(u, v)| over the root of II(u, u) II(v, v), where surface and quads are
refined. Set OPENBLAS_NUM_THREADS=1 where cores are shared.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
from numerics import table
from rich.console import Console
from rich.table import Table

from geometry.errors import GeometryError
from geometry.gauss import approximate_pair
from geometry.layout import LaidMesh, lay_quads
from geometry.mesh import Mesh
from geometry.meshing import Guides, OptimisedMesh, planarise
from geometry.surface import Surface, refined

sys.path.insert(0, str(Path(__file__).parents[2]))

from tests.geometry.design_surfaces import KNOWN, ROOFS, ball, off_conjugate, roof

NAMES = ("train-station", "botanic-garden-bubble", "dome")
COLUMNS = (
    *("mesh", "faces", "lay plan Gauss", "quads", "irregular", "on", "planarity"),
    *("moves", "off", "corners", "planar", "axes", "heights"),
)
SIZES = (300, 1000, 3000, 10_000)


def surfaces() -> dict[str, Surface]:
    roofs = {name: roof(name) for name in NAMES} if ROOFS.is_dir() else {}
    return roofs | {name: make() for name, (make, _) in KNOWN.items()}


def planar(laid: LaidMesh, smooth: Surface) -> OptimisedMesh:
    """As `remesh` does it, timed by itself."""
    return planarise(laid.mesh, Guides(surface=smooth, keep_boundary=True))


def marked(text: str, value: float, low: float, high: float) -> str:
    return text if low <= value <= high else f"{text} !"


def row(name: str, surface: Surface, n_faces: int) -> tuple[list[str], list[float]]:
    clock = [time.process_time()]
    laid = lay_quads(surface, n_faces=n_faces)
    clock.append(time.process_time())
    smooth, quality = refined(surface), laid.quality
    clock.append(time.process_time())
    cells = [
        name,
        str(laid.mesh.n_faces),
        "",
        marked(f"{quality.quad_share:.3f}", quality.quad_share, 0.95, 1),
        " ".join(f"{count} x {valence}" for valence, count in quality.valences.items()) or "-",
        marked(f"{(on := float((quality.off_network < np.radians(10)).mean())):.3f}", on, 0.9, 1),
        f"{quality.planarity.mean():.4f} {quality.planarity.max():.3f}",
    ]
    same = laid.mesh.combinatorics.euler_characteristic == surface.triangulated.combinatorics.euler_characteristic
    cells[4] += "" if same else " chi !"
    try:
        result = planar(laid, smooth)
    except GeometryError as error:
        return [*cells, "! " + error.message[:24]], [clock[1] - clock[0]]
    clock.append(time.process_time())
    mesh = result.mesh
    off = np.linalg.norm(smooth.closest(mesh.vertices)[0] - mesh.vertices, axis=1) / laid.mesh.mean_edge_length
    corners = np.degrees(mesh.corner_angles)
    sharpest = 20 if name in NAMES else 8
    move, far = np.quantile(result.moves, 0.95), np.quantile(off, 0.95)
    axes, heights = gauss(mesh, smooth)
    clock.append(time.process_time())
    seconds = [clock[1] - clock[0], clock[3] - clock[2], clock[4] - clock[3]]
    cells[2] = " ".join(f"{value:.1f}" for value in seconds)
    cells += [
        marked(f"{move:.3f} {result.moves.max():.2f}", move, 0, 0.08),
        marked(f"{far:.3f} {off.max():.3f}", max(far / 0.03, off.max() / 0.1), 0, 1),
        marked(f"{corners.min():.0f} {corners.max():.0f}", 0, corners.max() - 172, corners.min() - sharpest),
        marked(f"{mesh.planarity.max():.0e}", mesh.planarity.max(), 0, 1e-12),
        axes,
        heights,
    ]
    return cells, seconds


def gauss(mesh: Mesh, smooth: Surface) -> tuple[str, str]:
    try:
        pair = approximate_pair(mesh)
    except GeometryError:
        return "-", "-"
    directions = pair.gauss_image.vertices / np.linalg.norm(pair.gauss_image.vertices, axis=1, keepdims=True)
    cosines = np.abs(np.einsum("ni,ni->n", directions, smooth.closest(mesh.vertices)[1]))
    lean = np.degrees(np.arccos(np.clip(cosines, 0, 1)))
    heights = np.quantile(pair.edge_distances, [0.05, 0.95])
    return f"{np.quantile(lean, 0.95):.0f}", f"{heights[0]:.3f} {heights[1]:.3f}"


def main(sizes: tuple[int, ...]) -> None:
    console = Console(width=170)
    times: dict[str, list[list[float]]] = {}
    for n_faces in sizes:
        made = table(f"{n_faces} faces wanted", *COLUMNS)
        for name, surface in surfaces().items():
            cells, seconds = row(name, surface, n_faces)
            made.add_row(*cells)
            times.setdefault(name, []).append(seconds)
        console.print(made)
    if len(sizes) > 1:
        made = table("Growth: seconds as a power of the number of faces", "mesh", "lay", "plan", "Gauss")
        for name, taken in times.items():
            ends = list(zip(taken[0], taken[-1], strict=False))
            ratio = np.log(sizes[-1] / sizes[0])
            made.add_row(name, *(f"{np.log(last / first) / ratio:.2f}" for first, last in ends))
        console.print(made)
    console.print(conjugacy())


def conjugacy() -> Table:
    made = table("Conjugate on an ellipsoid", "map", "faces", "median", "mean", "order of median", "of mean")
    axes = (3.0, 2.0, 1.2)
    for name, affine in (("identity", np.eye(3)), ("shear", np.array([[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]))):
        before = np.full(2, np.nan)
        for halvings, n_faces in ((2, 100), (3, 400), (4, 1600), (5, 6400)):
            off = off_conjugate(lay_quads(ball(halvings, axes), n_faces=n_faces, affine=affine).mesh, axes)
            now = np.array([np.median(off), off.mean()])
            orders = [f"{order:.2f}" for order in np.log2(before / now).tolist()]
            made.add_row(name, str(n_faces), *(f"{value:.4f}" for value in now.tolist()), *orders)
            before = now
    return made


if __name__ == "__main__":
    main(tuple(int(word) for word in sys.argv[1:]) or SIZES)

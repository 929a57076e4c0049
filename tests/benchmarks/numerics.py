"""How long planar, circular, conical meshes and Gauss images take: `python tests/benchmarks/numerics.py [sizes]`.

First the real meshes, where they are at hand, then smooth meshes of about the given numbers of vertices. Times are in
milliseconds, the best of three; lengths in mean edge lengths. Set OPENBLAS_NUM_THREADS=1 where cores are shared.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import numpy as np
from rich.console import Console
from rich.table import Table

from geometry.errors import GeometryError
from geometry.exact_offsets import circularity, conicality, edge_axis_twist
from geometry.files import read_mesh
from geometry.gauss import Pair
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.gauss.distances import vertex_distances
from geometry.mesh import Combinatorics, Mesh, shapes
from geometry.meshing import OptimisedMesh, make_circular, make_conical, planarise
from geometry.parallel.edge_parallelity import parallelity
from geometry.parallel.space import ParallelSpace

DATA = Path(__file__).parents[2].parent / "shared" / "data"
REAL = (
    "dos/conical1.obj",
    "dos/planarizednormalized_six_quad.obj",
    "dos/botanic-garden-bubble-0.obj",
    "libhedra/YasIsland.off",
    "libhedra/gitter.off",
    "libhedra/hexagonalminimal_plusgauss.off",
    "libhedra/catenoid3.off",
    "libhedra/circular_wo_boundary.off",
    "directional/inspired_mesh_quads_Conjugate.off",
)
SIZES = (1_000, 10_000, 100_000)
LARGEST_DIMENSION = 1000
"""Dimension up to which the dimension of P(M) is looked for here; the time grows with its square."""

T = TypeVar("T")


def timed(work: Callable[[], T], repeats: int = 3) -> tuple[T, float]:
    """What the work returns, and the shortest time in milliseconds."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - start)
    return result, 1e3 * min(times)


def fresh(mesh: Mesh) -> Mesh:
    """The same mesh with nothing computed yet."""
    c = mesh.combinatorics
    return Mesh(mesh.vertices, Combinatorics(c.n_vertices, c.corners, c.face_starts))


def smooth(n_vertices: int) -> Mesh:
    """Planar quads over a dome: parallelograms, made unlike by a projective map."""
    n = round(n_vertices**0.5)
    u = np.linspace(-1, 1, n)
    first = np.stack([u, 0 * u, -0.3 * u**2], axis=1)
    second = np.stack([0 * u, 0.9 * u, -0.25 * u**2 + 0.05 * np.sin(3 * u)], axis=1)
    mesh = shapes.translation_surface(first, second)
    return mesh.with_vertices(mesh.vertices / (1 + mesh.vertices[:, :2] @ [[0.2], [0.1]]))


def planarise_row(name: str, mesh: Mesh) -> tuple[Mesh, list[str]]:
    result, milliseconds = timed(lambda: planarise(fresh(mesh)))
    return result.mesh, [
        name,
        f"{mesh.n_vertices} / {mesh.n_faces}",
        f"{milliseconds:.0f}",
        str(result.iterations),
        f"{result.plane_deviation_before:.1e}",
        f"{result.plane_deviation_after:.1e}",
        f"{result.largest_move:.5f}",
        f"{result.mean_move:.5f}",
    ]


def principal_row(name: str, mesh: Mesh, make: Callable[[Mesh], OptimisedMesh]) -> list[str]:
    """Circular or conical: only meshes along principal curvature lines can be, and the others are refused."""
    try:
        result, milliseconds = timed(lambda: make(fresh(mesh)), repeats=1)
    except GeometryError as refused:
        return [name, make.__name__, "", "", f"refused: {refused.message[:44]}...", ""]
    after = f"{max(result.plane_deviation_after, result.residual_after):.1e}"
    return [name, make.__name__, f"{milliseconds:.0f}", str(result.iterations), after, f"{result.largest_move:.3f}"]


def gauss_row(name: str, mesh: Mesh) -> list[str]:
    image, milliseconds = timed(
        lambda: approximate_pair(fresh(mesh)).gauss_image, repeats=3 if mesh.n_vertices < 50_000 else 1
    )
    heights = np.percentile(Pair(mesh, image).edge_distances, [0, 5, 50, 95, 100])
    radii = vertex_distances(image)
    return [
        name,
        str(mesh.n_vertices),
        f"{milliseconds:.0f}",
        f"{parallelity(mesh, image).max():.1e}",
        " ".join(f"{height:.3f}" for height in heights),
        f"{radii.min():.2f} - {radii.max():.2f}",
    ]


def space_row(name: str, mesh: Mesh) -> list[str]:
    space = ParallelSpace(mesh)
    if space.expected_dimension > LARGEST_DIMENSION:
        return [name, f"({space.expected_dimension})", "", "", ""]
    spectrum, milliseconds = timed(lambda: ParallelSpace(mesh).spectrum, repeats=1)
    return [
        name,
        f"{spectrum.dimension} ({space.expected_dimension})",
        f"{spectrum.last_zero:.1e}",
        f"{spectrum.first_nonzero:.1e}",
        f"{milliseconds:.0f}",
    ]


def fitness_row(name: str, mesh: Mesh) -> list[str]:
    return [name, *(f"{np.nanmedian(measure(mesh)):.1e}" for measure in (circularity, conicality, edge_axis_twist))]


def table(title: str, *columns: str) -> Table:
    made = Table(title=title, title_justify="left")
    for column in columns:
        made.add_column(column, justify="left" if column == "mesh" else "right", no_wrap=True)
    return made


def main(sizes: tuple[int, ...]) -> None:
    console = Console(width=120)
    planar = table("Planarise", "mesh", "V / F", "ms", "steps", "before", "after", "largest move", "mean")
    principal = table("Circular and conical", "mesh", "by", "ms", "steps", "planar and so on to", "largest move")
    gauss = table("Gauss image", "mesh", "V", "ms", "off parallel", "heights 0 5 50 95 100 %", "|s|")
    spaces = table("P(M)", "mesh", "dimension (count)", "last kept", "first dropped", "ms")
    fitness = table("Medians of", "mesh", "circularity", "conicality", "edge axis twist")
    for path in (DATA / name for name in REAL) if DATA.is_dir() else ():
        name = path.stem
        mesh, row = planarise_row(name, read_mesh(path).mesh)
        planar.add_row(*row)
        for make in (make_circular, make_conical):
            principal.add_row(*principal_row(name, mesh, make))
        gauss.add_row(*gauss_row(name, mesh))
        spaces.add_row(*space_row(name, mesh))
        fitness.add_row(*fitness_row(name, mesh))
    for size in sizes:
        gauss.add_row(*gauss_row("smooth", smooth(size)))
    for filled in (planar, principal, gauss, spaces, fitness):
        console.print(filled)


if __name__ == "__main__":
    main(tuple(int(argument) for argument in sys.argv[1:]) or SIZES)

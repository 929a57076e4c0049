"""How long Koebe polyhedra of random graphs take: `python -m tests.benchmarks.koebe [vertices ...]`.

The graphs are 3-connected: hulls of random points, all of triangles, and their duals with a third of the faces
stellated, of triangles and polygons with up to a dozen sides. Each is made in a process of its own, whose peak memory
is read from /proc as Linux has it. Planarity is over the mean edge length of a face. Set OPENBLAS_NUM_THREADS=1 where
cores are shared.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from geometry.circle_patterns import circle_pattern
from geometry.circle_patterns.radii import RadiusProblem
from geometry.gauss.distances import edge_distances
from tests.geometry.random_polyhedra import random_polyhedron

making = import_module("geometry.edge_offset.koebe")  # the function has the same name

SIZES = (100, 1_000, 10_000, 100_000)
STAGES = {
    "check": (making, "refuse_other_than_polyhedra"),
    "radii": (RadiusProblem, "radii"),
    "layout": (circle_pattern, "circle_centres"),
    "centre": (making, "centring_similarity"),
}


def watch(owner: Any, name: str, seconds: list[float]) -> None:
    """From now on, each call of a function of a module or class adds how long it took."""
    function: Callable[..., Any] = getattr(owner, name)

    def watched(*arguments: Any, **named: Any) -> Any:
        start = time.perf_counter()
        result = function(*arguments, **named)
        seconds.append(time.perf_counter() - start)
        return result

    setattr(owner, name, watched)


def alone(kind: str, size: int) -> str:
    """A row of the table, of this process."""
    made = size if kind == "triangles" else size * 3 // 7  # the dual has 2 n vertices, and n / 3 faces are stellated
    c = random_polyhedron(np.random.default_rng(0), made, kind)
    _ = c.edges, c.twin  # as a mesh has them that is checked when it is read
    spent: dict[str, list[float]] = {stage: [] for stage in STAGES}
    for stage, (owner, name) in STAGES.items():
        watch(owner, name, spent[stage])
    start = time.perf_counter()
    S = making.koebe(c)
    total = time.perf_counter() - start
    times = [f"{sum(spent[stage]):.2f}" for stage in STAGES]
    reached = [np.abs(edge_distances(S.mesh) - 1).max(), S.mesh.planarity.max()]
    centre = np.linalg.norm(S.tangency_points.mean(axis=0))
    (peak,) = (line.split()[1] for line in Path("/proc/self/status").read_text().splitlines() if line[:6] == "VmHWM:")
    accuracies = [f"{value:.0e}" for value in (*reached, centre)]
    return " ".join([str(c.n_vertices), str(c.n_faces), *times, f"{total:.2f}", *accuracies, f"{int(peak) / 1e6:.2f}"])


def main(sizes: tuple[int, ...]) -> None:
    for kind in ("triangles", "mixed"):
        table = Table(title=f"Koebe polyhedra of random graphs, {kind}", title_justify="left")
        for column in ("vertices", "faces", *(f"{stage} s" for stage in STAGES), "total s", "off tangent", "off plane"):
            table.add_column(column, justify="right")
        table.add_column("off centre", justify="right")
        table.add_column("peak GB", justify="right")
        for size in sizes:
            command = [sys.executable, "-m", "tests.benchmarks.koebe", "alone", kind, str(size)]
            root = Path(__file__).parents[2]
            table.add_row(*subprocess.run(command, check=True, capture_output=True, text=True, cwd=root).stdout.split())
        Console(width=140).print(table)


if __name__ == "__main__":
    if sys.argv[1:2] == ["alone"]:
        print(alone(sys.argv[2], int(sys.argv[3])))
    else:
        main(tuple(int(argument) for argument in sys.argv[1:]) or SIZES)

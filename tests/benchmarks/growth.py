"""How time and memory of a build grow with the mesh: `python tests/benchmarks/growth.py [faces ...]`.

Squares that are all equal, quads of which no two are, and these bolted, with sixteen parts a face, in numbers of faces
each about four times the one before.
Each build runs in a process of its own; a stage's seconds are processor time, its memory is the largest that the
process had in it, as Linux tells (/proc). An exponent p says that a stage grows as faces^p, from the smallest to the
largest number: 1 is in proportion, 2 each with each; memory is taken above that of the stage before all, reading.
Last come the whole builds that have a bound, in seconds as a clock shows them. Set OPENBLAS_NUM_THREADS=1 where
cores are shared, and TMPDIR=/dev/shm where the disk is: a build of different parts writes five files a face.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from fabkit import Project, build
from geometry.arrays import FloatArray
from geometry.files import write_mesh
from geometry.mesh import Mesh, shapes

SIZES = (1024, 4096, 16384)
KINDS = ("equal", "different", "bolted")
BOUNDS = {("equal", 10_000): (25.0, 1000.0), ("different", 16_384): (90.0, None), ("bolted", 1225): (60.0, 2000.0)}
"""Seconds and MB of whole builds; the bolted one has 20 000 parts, and no nesting."""
LEAST_SECONDS, LEAST_MB = 0.05, 10.0
"""What is less at the largest size has no exponent."""


def squares(n: int) -> Mesh:
    """n x n squares of 1 m."""
    return shapes.grid(n, n)


def different(n: int) -> Mesh:
    """n x n planar quads about 1.5 m long, no two alike: a curved translation surface with uneven steps, seen in a
    perspective, which keeps planes."""
    rng = np.random.default_rng(n)

    def steps() -> FloatArray:
        places = 1.5 * np.cumsum(np.concatenate([[0.0], rng.uniform(0.9, 1.1, n)]))
        return np.asarray(places - places.mean())

    u, v, radius = steps(), steps(), 1.1 * n
    first = np.stack([u, 0 * u, -(u**2) / (4 * radius)], axis=1)
    second = np.stack([0 * v, v, -(v**2) / (5 * radius)], axis=1)
    mesh = shapes.translation_surface(first, second)
    return mesh.with_vertices(mesh.vertices / (1 + mesh.vertices[:, :2] @ [[0.1 / radius], [0.07 / radius]]))


def peak_mb() -> float:
    """The largest memory of this process since `forget_peak`."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM")) / 1e3


def forget_peak() -> None:
    Path("/proc/self/clear_refs").write_text("5")


def alone(kind: str, n_faces: int) -> dict[str, object]:
    """Build in this process: for each stage processor seconds and MB, seconds of the whole, MB of report.html."""
    n, stages, started = round(n_faces**0.5), {}, 0.0

    def listener(stage: str, share: float) -> None:
        nonlocal started
        if share == 0.0:
            forget_peak()
            started = time.process_time()
        elif share == 1.0:
            stages[stage] = (time.process_time() - started, peak_mb())

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_mesh(folder / "mesh.obj", squares(n) if kind == "equal" else different(n))
        bolted = {"connection": {"kind": "bolted"}, "nesting": {"mode": "off"}} if kind == "bolted" else {}
        clock = time.perf_counter()
        build(Project(mesh=folder / "mesh.obj", unit="m", out=folder / "out", **bolted), listener=listener)
        seconds = time.perf_counter() - clock
        return {
            "faces": n * n,
            "stages": stages,
            "seconds": seconds,
            "report": (folder / "out" / "report.html").stat().st_size / 1e6,
        }


def measured(kind: str, n_faces: int) -> dict:
    command = [sys.executable, __file__, "alone", kind, str(n_faces)]
    return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def exponent(first: float, last: float, least: float, ratio: float) -> str:
    return f"{np.log(last / max(first, 1e-9)) / np.log(ratio):.2f}" if last >= least and ratio > 1 else ""


def stage_table(kind: str, runs: list[dict]) -> Table:
    table = Table(title=f"All faces {kind}: processor seconds and peak MB by stage")
    for column in ("stage", *(f"{run['faces']}" for run in runs), "exponent", *("MB" for _ in runs), "exponent"):
        table.add_column(column, justify="left" if column == "stage" else "right", no_wrap=True)
    ratio = runs[-1]["faces"] / runs[0]["faces"]
    for stage in runs[0]["stages"]:
        seconds, peaks = zip(*(run["stages"][stage] for run in runs), strict=True)
        above = [peak - run["stages"]["Read"][1] for peak, run in zip(peaks, runs, strict=True)]
        table.add_row(
            stage,
            *(f"{each:.2f}" for each in seconds),
            exponent(seconds[0], seconds[-1], LEAST_SECONDS, ratio),
            *(f"{each:.0f}" for each in peaks),
            exponent(above[0], above[-1], LEAST_MB, ratio),
        )
    whole = [sum(seconds for seconds, _ in run["stages"].values()) for run in runs]
    peaks = [max(peak for _, peak in run["stages"].values()) for run in runs]
    table.add_section()
    table.add_row(
        "whole",
        *(f"{each:.2f}" for each in whole),
        exponent(whole[0], whole[-1], LEAST_SECONDS, ratio),
        *(f"{each:.0f}" for each in peaks),
        "",
    )
    return table


def main(sizes: tuple[int, ...]) -> None:
    console = Console(width=150)
    known: dict[tuple[str, int], dict] = {}
    for kind in KINDS:
        runs = [known.setdefault((kind, size), measured(kind, size)) for size in sizes]
        console.print(stage_table(kind, runs))
    bounds = Table("whole build", "seconds", "bound", "peak MB", "bound", "report MB", title="Against the clock")
    for (kind, size), (seconds, megabytes) in BOUNDS.items():
        run = known.get((kind, size)) or measured(kind, size)
        peak = max(peak for _, peak in run["stages"].values())
        limits = (f"{seconds:.0f}", f"{megabytes:.0f}" if megabytes else "")
        bounds.add_row(
            f"{size} {kind}", f"{run['seconds']:.1f}", limits[0], f"{peak:.0f}", limits[1], f"{run['report']:.0f}"
        )
    console.print(bounds)


if __name__ == "__main__":
    if sys.argv[1:2] == ["alone"]:
        print(json.dumps(alone(sys.argv[2], int(sys.argv[3]))))
    else:
        main(tuple(int(argument) for argument in sys.argv[1:]) or SIZES)

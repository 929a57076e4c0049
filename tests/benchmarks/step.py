"""How fast STEP files are written, and with how much memory: `python tests/benchmarks/step.py [parts]`.

Prisms with four to twelve corners (beams and boxes have four), and solids with bores, rounds and fillets, no two alike,
each placed once; the best of some runs, in processor time, since files are written by one thread. Where build123d is
installed, its own export_step writes the first of the same parts, as solids made beforehand.
"""

from __future__ import annotations

import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from fabkit.formats.kernels import to_build123d
from fabkit.formats.step.files import stream_step
from fabkit.kinds import NODE, NodeDetails, plain_kind
from fabkit.parts import Assembly, Details, Material, Parts, Ragged, Solid, Solids
from tests.fabkit.round_solids import SOLIDS

STEEL = Material("S355", 7850.0)


def prism_parts(corners: tuple[int, ...], n_parts: int, at_once: int = 1000) -> Iterator[Parts[NodeDetails]]:
    """Prisms over polygons with these numbers of corners in turn, turned and placed at random, some at a time."""
    rng = np.random.default_rng(0)
    for first in range(0, n_parts, at_once):
        numbers = np.arange(first, min(first + at_once, n_parts))
        outlines, axes = [], []
        for n in numbers.tolist():
            k = corners[n % len(corners)]
            angles = 2 * np.pi * np.arange(k) / k
            radii = rng.uniform(300, 700, k)
            outlines.append(np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1))
            turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            axes.append(turn * np.linalg.det(turn))
        count = len(numbers)
        around = Ragged(np.zeros(0), np.zeros(count + 1, dtype=np.int64))
        yield Parts.each_its_own(
            NODE, numbers, Solids.prisms(Ragged.of(outlines, shape=(2,)), np.zeros(count), rng.uniform(8, 1500, count)),
            origins=rng.uniform(-1e4, 1e4, (count, 3)), axes=np.array(axes), material=STEEL,
            details=NodeDetails(around, around, around, around, around, *np.zeros((3, count))),
        )  # fmt: skip


def parts_like(solid: Solid, n_parts: int) -> Parts[Details]:
    """Parts of one shape in as many sizes, turned and placed at random."""
    rng = np.random.default_rng(0)
    axes, _ = np.linalg.qr(rng.normal(size=(n_parts, 3, 3)))
    return Parts.each_its_own(
        plain_kind("thing", letter="T"), np.arange(n_parts),
        Solids.alike(solid.vertices * rng.uniform(0.5, 2, n_parts)[:, None, None], solid.topology),
        origins=rng.uniform(-1e4, 1e4, (n_parts, 3)), axes=axes * np.linalg.det(axes)[:, None, None], material=STEEL,
        details=Details(),
    )  # fmt: skip


PRISMS = {"prisms, 4 corners": (4,), "prisms, 4 to 6 corners": (4, 5, 6), "prisms, 12 corners": (12,)}
ROUND = {
    "tubes of hubs": "hub",
    "plates with 3 bores": "plate with bores",
    "blocks with 6 bores": "block",
    "mitred hollow sections": "hollow section, mitred",
    "the same with a hand hole and 2 bores": "hand hole",
    "the same with rounded corners": "rounded section, mitred",
}
"""What stands in the table, by the names of solids of the tests."""


def seconds(write: Callable[[], None], runs: int) -> float:
    """The least processor time of some runs."""
    best = np.inf
    for _ in range(runs):
        start = time.process_time()
        write()
        best = min(best, time.process_time() - start)
    return best


def speed(table: Table, kind: str, parts: Parts[Any], folder: Path) -> None:
    n_parts, path = len(parts), folder / "model.step"
    spent = seconds(lambda: stream_step(path, kind, [parts]), runs=5)
    row = [kind, f"{n_parts}", f"{n_parts / spent:.0f}", f"{path.stat().st_size / n_parts / 1000:.1f}"]
    if find_spec("build123d"):
        import build123d

        few = parts[:300]
        compound = to_build123d(Assembly(kind, (few,)))
        ours = seconds(lambda: stream_step(path, kind, [few]), runs=9)
        theirs = seconds(lambda: build123d.export_step(compound, path), runs=3)
        row += [f"{len(few) / theirs:.0f}", f"{path.stat().st_size / len(few) / 1000:.1f}", f"{theirs / ours:.0f}"]
    table.add_row(*row)


def memory(n_parts: int, folder: Path) -> float:
    """Largest memory in MB while parts are made and written a thousand at a time."""
    tracemalloc.start()
    stream_step(folder / "model.step", "many", prism_parts((4,), n_parts))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def main(n_parts: int = 20_000) -> None:
    table = Table("parts", "number", "parts/s", "kB a part", title="write_step, properties and colours included")
    if find_spec("build123d"):
        for heading in ("build123d parts/s", "kB a part", "times faster"):
            table.add_column(heading)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for kind, corners in PRISMS.items():
            (parts,) = prism_parts(corners, n_parts, n_parts)
            speed(table, kind, parts, folder)
        for kind, name in ROUND.items():
            speed(table, kind, parts_like(SOLIDS[name], n_parts), folder)
        Console().print(table)
        growth = Table("parts", "peak MB", "bytes a part", title="memory, all marks different")
        before, least = memory(100, folder), n_parts // 4
        for n in (least, 10 * least):
            peak = memory(n, folder)
            growth.add_row(f"{n}", f"{peak:.1f}", f"{(peak - before) * 1e6 / n:.0f}")
        Console().print(growth)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))

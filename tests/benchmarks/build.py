"""How long the whole road takes, stage by stage, on the roof that ships and on the real meshes where they are, and on
one of them with each connection, whose parts are from one to four times as many.

Run: python tests/benchmarks/build.py
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

from fabkit import Project, build

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data"
REPEATS = 3
CONNECTIONS = {
    "plain bars": {"beams": {"width_mm": 50, "height_mm": 120}, "connection": {"kind": "contact"}},
    "welded": {"connection": {"kind": "welded"}},
    "hub": {"beams": {"section": "tee 120x80x10x8"}, "connection": {"kind": "hub"}},
    "bolted": {"connection": {"kind": "bolted"}},
}


def projects() -> dict[str, Project]:
    found = {"examples/roof": Project(mesh=ROOT / "examples" / "roof.obj", unit="m")}
    for name in (
        "dos/conical1.obj",
        "dos/planarizednormalized_six_quad.obj",
        "dos/botanic-garden-bubble-0.obj",
        "libhedra/YasIsland.off",
        "libhedra/gitter.off",
        "libhedra/hexagonalminimal_plusgauss.off",
        "directional/inspired_mesh_quads_Conjugate.off",
    ):
        if (DATA / name).is_file():
            found[Path(name).stem] = Project(mesh=DATA / name, mean_edge_mm=1500.0, skip_unbuildable=True)
    if "conical1" in found:
        found |= {
            f"conical1, {name}": Project(mesh=DATA / "dos" / "conical1.obj", mean_edge_mm=1500.0, **tables)
            for name, tables in CONNECTIONS.items()
        }
    return found


def main() -> None:
    table = Table(title=f"Whole build, seconds (best of {REPEATS}, each stage by itself)")
    stages: list[str] = []
    measured: dict[str, tuple[int, float, dict[str, float]]] = {}
    for name, project in projects().items():
        runs = []
        for _ in range(REPEATS):
            with tempfile.TemporaryDirectory() as folder:
                built = build(project.model_copy(update={"out": Path(folder) / "out"}))
            runs.append(built.seconds)
        stages = list(runs[0])
        best = {stage: min(run[stage] for run in runs) for stage in stages}
        measured[name] = (sum(1 for _ in built.assembly.parts()), min(sum(run.values()) for run in runs), best)
    for column in ("mesh", "parts", "whole", *stages):
        table.add_column(column, justify="left" if column == "mesh" else "right")
    for name, (parts, whole, best) in measured.items():
        table.add_row(name, str(parts), f"{whole:.1f}", *(f"{best[stage]:.2f}" for stage in stages))
    Console(width=200).print(table)


if __name__ == "__main__":
    main()

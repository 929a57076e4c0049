"""Build all OBJ files of a folder; a table gives the parts made, or why a mesh was refused.

python examples/batch.py meshes --unit m
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

from fabkit import FabkitError, Project, build
from geometry import GeometryError


def main(folder: Path, out: Path = Path("built"), unit: str = "m") -> list[tuple[str, str, str]]:
    """A row for each mesh: its file, what was made or "refused", and the reason."""
    out.mkdir(exist_ok=True)
    rows = []
    for mesh in sorted(folder.glob("*.obj")):
        try:
            built = build(Project(mesh=mesh, unit=unit, out=out / mesh.stem))
        except (GeometryError, FabkitError) as error:
            rows.append((mesh.name, "refused", str(error)))
        else:
            counts = ", ".join(f"{len(parts)} {parts.kind.group}" for parts in built.assembly.groups)
            rows.append((mesh.name, counts, ""))
    with (out / "table.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([("file", "built", "reason"), *rows])
    return rows


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--unit", default="m")
    given = parser.parse_args()
    for name, made, reason in main(given.folder, unit=given.unit):
        print(f"{name}: {made}{': ' if reason else ''}{reason}")

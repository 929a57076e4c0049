"""Outlines from a CSV file, nested on stock sheets and written as DXF: no mesh, no structure.

    python examples/nest_only.py examples/outlines.csv

A row of the CSV file is a corner: the name of the pane, x and y in millimetres, pane after pane. Panes may be rotated,
not mirrored. Layers: CUT contours, MARK names, SHEET the stock.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from fabkit.formats.drawings import write_dxf
from fabkit.parts import Material
from fabkit.production import Sheet, nest_panels, panels_from_outlines, sheet_drawings

OUTLINES = Path(__file__).with_name("outlines.csv")
GLASS = Material("glass", density_kg_m3=2500.0)


def main(source: Path = OUTLINES, out: Path = Path("sheets")) -> dict[str, float]:
    outlines: dict[str, list[tuple[float, float]]] = {}
    with source.open(newline="", encoding="utf-8") as file:
        for row in csv.DictReader(file):
            outlines.setdefault(row["name"], []).append((float(row["x_mm"]), float(row["y_mm"])))
    panes = panels_from_outlines(outlines, thickness_mm=8.0, material=GLASS)
    nest = nest_panels(panes, Sheet(length_mm=3210, width_mm=2250), gap_mm=12, border_mm=15)
    out.mkdir(exist_ok=True)
    for drawing in sheet_drawings(nest, panes):
        write_dxf(out / f"{drawing.name}.dxf", drawing)
    return {"panes": len(panes), "sheets": nest.n_sheets, "used": nest.utilisation}


if __name__ == "__main__":
    print(main(*map(Path, sys.argv[1:])))

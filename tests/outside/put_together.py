"""Cut every beam and every panel from its table, put all pieces at their places, and say how far that
is from the model.

Given a folder of `fabkit build`, and nothing else: python put_together.py FOLDER
"""

import json
import sys
from pathlib import Path

import numpy as np
from part21 import Part21, distance
from tables import Folder, at, frame, vector


def beam_corners(row: dict[str, str]) -> np.ndarray:
    """Of a bar in its own frame: outer side at z = 0, end A at x = 0 there, angles from the square cut as the saw is
    set, positive where the outer side is the longer one."""
    kind, sizes = row["Section"].split()
    height, width, *wall = (float(size) for size in sizes.split("x"))
    if kind not in ("flat", "rhs"):
        raise ValueError(f"cannot cut {row['Section']}")
    insets = [0.0, *wall]
    outline = np.array(
        [
            (side * (width / 2 - inset), level)
            for inset in insets
            for side in (-1, 1)
            for level in (-inset, -(height - inset))
        ]
    )
    head, tail = (np.tan(np.radians(float(row[f"End {end} (deg)"]))) for end in "AB")
    # the long point is the extent along the axis, wherever along the height the ends reach furthest
    outer = float(row["Long point (mm)"]) + min(0.0, height * head) + min(0.0, height * tail)
    depth = -outline[:, 1]
    first = np.column_stack([depth * head, outline])
    last = np.column_stack([outer - depth * tail, outline])
    return np.concatenate([first, last])


def panel_corners(edges: list[dict[str, str]], thickness: float) -> np.ndarray:
    """Of a plate in its own frame: corner 1 at zero, edge 1 along x, corner k at the start of edge k."""
    inner = np.radians([float(row["Corner (deg)"]) for row in edges])
    turns = np.concatenate([[0.0], np.cumsum(np.pi - inner[1:])])
    steps = np.array([float(row["Length (mm)"]) for row in edges])[:, None] * np.stack(
        [np.cos(turns), np.sin(turns)], axis=1
    )
    outline = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)[:-1]])
    reach = thickness * np.tan(np.radians([float(row["Bevel (deg)"] or 0.0) for row in edges]))
    outwards = np.stack([np.sin(turns), -np.cos(turns)], axis=1)
    upper = [  # where the sides before and after a corner meet, each moved outwards by its own reach
        corner + np.linalg.solve(outwards[[k - 1, k]], reach[[k - 1, k]]) for k, corner in enumerate(outline)
    ]
    return np.array([(*corner, level) for level, side in ((0.0, outline), (thickness, upper)) for corner in side])


def main(path: Path) -> dict[str, float]:
    folder, model = Folder(path), Part21(path / "model.step").placed()
    beams = {row["Mark"]: beam_corners(row) for row in folder.rows("beams")}
    edges: dict[str, list[dict[str, str]]] = {}
    for row in folder.rows("panel_edges"):
        edges.setdefault(row["Panel"], []).append(row)
    thicknesses = {row["Mark"]: float(row["Thickness (mm)"]) for row in folder.rows("panels")}
    kinds = {row["Piece"]: row["Kind"] for row in folder.rows("pieces")}
    solids: dict[str, np.ndarray] = {}
    largest = {"beams": 0.0, "panels": 0.0, "others": 0.0}
    placements = folder.rows("placements")
    if {row["Piece"] for row in placements} != set(model) or set(kinds) != set(model):
        raise ValueError("the pieces of the tables are not those of the model")
    for row in placements:
        mark, kind = row["Mark"], kinds[row["Piece"]]
        if mark not in solids and kind == "beam":
            solids[mark] = beams[mark]
        elif mark not in solids and kind == "panel":
            solids[mark] = panel_corners(edges[row["Piece"]], thicknesses[mark])
        elif mark not in solids:
            ((_, solids[mark]),) = Part21(path / "parts" / f"{mark}.step").solids().values()
        place = frame(vector(row, "Origin", " (mm)"), vector(row, "X axis"), vector(row, "Z axis"))
        off = distance(at(place, solids[mark]), model[row["Piece"]])
        key = f"{kind}s" if kind in ("beam", "panel") else "others"
        largest[key] = max(largest[key], off)
    counts = {"n_beams": sum(kind == "beam" for kind in kinds.values()), "n_others": len(kinds)}
    counts["n_others"] -= counts["n_beams"]
    return {**largest, **counts}


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1]))))

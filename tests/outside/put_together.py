"""Cut every beam from the table of beams, put all pieces at their places, and say how far that is from the model.

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


def main(path: Path) -> dict[str, float]:
    folder, model = Folder(path), Part21(path / "model.step").placed()
    beams = {row["Mark"]: beam_corners(row) for row in folder.rows("beams")}
    kinds = {row["Piece"]: row["Kind"] for row in folder.rows("pieces")}
    solids: dict[str, np.ndarray] = {}
    largest = {"beams": 0.0, "others": 0.0}
    placements = folder.rows("placements")
    if {row["Piece"] for row in placements} != set(model) or set(kinds) != set(model):
        raise ValueError("the pieces of the tables are not those of the model")
    for row in placements:
        mark, is_beam = row["Mark"], kinds[row["Piece"]] == "beam"
        if mark not in solids:
            own = beams.get(mark) if is_beam else None
            if own is None:
                ((_, own),) = Part21(path / "parts" / f"{mark}.step").solids().values()
            solids[mark] = own
        place = frame(vector(row, "Origin", " (mm)"), vector(row, "X axis"), vector(row, "Z axis"))
        off = distance(at(place, solids[mark]), model[row["Piece"]])
        key = "beams" if is_beam else "others"
        largest[key] = max(largest[key], off)
    counts = {"n_beams": sum(kind == "beam" for kind in kinds.values()), "n_others": len(kinds)}
    counts["n_others"] -= counts["n_beams"]
    return {**largest, **counts}


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1]))))

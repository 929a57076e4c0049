"""Set out all nodes from the survey table, in the site's coordinates, and say how far they are from the model.

Given a folder of `fabkit build`, and nothing else: python set_out.py FOLDER
"""

import json
import re
import sys
from pathlib import Path

import numpy as np
from part21 import Part21, distance
from tables import Folder, at, frame, vector

NUMBERS = re.compile(r"\(([-\d., ]+)\)")


def site_of(folder: Folder) -> np.ndarray:
    """4 x 4, from the coordinates of the model to those of the site, as the legend states it."""
    sentence = next(row["Meaning"] for row in folder.rows("legend") if row["Sign"] == "Site")
    found = [np.array([float(text) for text in group.split(",")]) for group in NUMBERS.findall(sentence)]
    matrix = np.eye(4)
    if found:
        origin, *axes = found
        matrix[:3] = np.column_stack([*axes, origin])
    return matrix


def main(path: Path) -> dict[str, float]:
    folder, model = Folder(path), Part21(path / "model.step").placed()
    site, rows = site_of(folder), folder.rows("survey")
    facets: dict[str, list[dict[str, str]]] = {}
    for row in folder.rows("node_facets"):
        facets.setdefault(row["Node"], []).append(row)
    largest = {"blocks": 0.0, "heights": 0.0, "facets": 0.0}
    for row in rows:
        place = frame(vector(row, "Point", " (mm)"), vector(row, "Facet 1"), vector(row, "Axis"))
        ((_, block),) = Part21(path / "parts" / f"{row['Mark']}.step").solids().values()
        there = at(site, model[row["Node"]])
        largest["blocks"] = max(largest["blocks"], distance(at(place, block), there))
        own = (there - place[:3, 3]) @ place[:3, :3]
        off = max(abs(own[:, 2].max() - float(row["Top (mm)"])), abs(own[:, 2].min() - float(row["Bottom (mm)"])))
        largest["heights"] = max(largest["heights"], off)
        for facet in facets[row["Node"]]:
            azimuth = np.radians(float(facet["Azimuth (deg)"]))
            normal = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
            setback = float(facet["Setback (mm)"])
            on_it = own[
                np.abs(own @ normal - setback) < 1.0
            ]  # four corners, or the facet is not where it is said to be
            if len(on_it) < 4:
                raise ValueError(f"facet {facet['Facet']} of {row['Node']} is not at {setback} mm")
            middle = np.median(on_it[:, 2])
            top, bottom = (on_it[keep, 2].mean() for keep in (on_it[:, 2] > middle, on_it[:, 2] <= middle))
            across = np.ptp(on_it @ np.array([-normal[1], normal[0], 0.0]))
            said = [float(facet[f"Facet {what} (mm)"]) for what in ("top", "bottom", "width")]
            off = max(
                float(np.abs(on_it @ normal - setback).max()), *np.abs(np.array([top, bottom, across]) - said).tolist()
            )
            largest["facets"] = max(largest["facets"], off)
    return {**largest, "n": len(rows)}


if __name__ == "__main__":
    print(json.dumps(main(Path(sys.argv[1]))))

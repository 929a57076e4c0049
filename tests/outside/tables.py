"""The tables of a folder, in whatever dialect its manifest states: standard library and numpy."""

import csv
import json
import re
from pathlib import Path

import numpy as np


class Folder:
    def __init__(self, path: Path) -> None:
        self.path = path
        self.settings = json.loads((path / "manifest.json").read_text())["settings"]

    def rows(self, name: str) -> list[dict[str, str]]:
        rules = self.settings["tables"]
        separator = "\t" if rules["separator"] == "tab" else rules["separator"]
        with (self.path / f"{name}.csv").open(newline="", encoding="utf-8-sig") as stream:
            rows = list(csv.DictReader(stream, delimiter=separator))
        number = re.compile(rf"-?\d+{re.escape(rules['decimal'])}\d+")

        def read(text: str) -> str:
            return text.replace(rules["decimal"], ".") if number.fullmatch(text) else text

        own = [{key: read(value) for key, value in row.items()} for row in rows]
        first = next(iter(own[0])) if own else ""
        return [row for row in own if row[first] != "Total" and not row[first].startswith("left out")]


def vector(row: dict[str, str], name: str, unit: str = "") -> np.ndarray:
    return np.array([float(row[f"{name} {axis}{unit}"]) for axis in "xyz"])


def frame(origin: np.ndarray, x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """4 x 4, from the frame to outside."""
    matrix = np.eye(4)
    matrix[:3] = np.stack([x, np.cross(z, x), z, origin], axis=1)
    return matrix


def at(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    return points @ matrix[:3, :3].T + matrix[:3, 3]

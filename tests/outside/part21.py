"""What a STEP file says of solids and their places, read without any program of ours: standard library and numpy."""

import re
from pathlib import Path

import numpy as np

ENTITY = re.compile(r"#(\d+)\s*=\s*(.*?);\s*(?=#|ENDSEC)", re.DOTALL)
NUMBER = re.compile(r"[-+]?\d+\.\d*(?:E[-+]?\d+)?")


class Part21:
    def __init__(self, path: Path) -> None:
        text = path.read_text(encoding="ascii")
        data = text[text.index("DATA;") + 5 :].replace("\n", "") + ""
        self.entities = {int(n): body for n, body in ENTITY.findall(data)}
        self.by_name: dict[str, list[int]] = {}
        for n, body in self.entities.items():
            self.by_name.setdefault(re.match(r"\(?\s*(\w+)", body)[1], []).append(n)

    def refs(self, n: int) -> list[int]:
        return [int(ref) for ref in re.findall(r"#(\d+)", self.entities[n])]

    def numbers(self, n: int) -> np.ndarray:
        return np.array([float(text) for text in NUMBER.findall(self.entities[n])])

    def string(self, n: int, place: int = 0) -> str:
        return re.findall(r"'((?:[^']|'')*)'", self.entities[n])[place]

    def kind(self, n: int) -> str:
        return re.match(r"\(?\s*(\w+)", self.entities[n])[1]

    def placement(self, n: int) -> np.ndarray:
        """4 x 4, from the frame to outside."""
        origin, z, x = (self.numbers(ref) for ref in self.refs(n)[:3])
        x = x - z * (x @ z)
        x = x / np.linalg.norm(x)
        matrix = np.eye(4)
        matrix[:3] = np.stack([x, np.cross(z, x), z, origin], axis=1)
        return matrix

    def corners(self, brep: int) -> np.ndarray:
        """(k, 3) the vertices of a solid."""
        waiting, seen, found = [brep], set(), []
        while waiting:
            n = waiting.pop()
            if n in seen:
                continue
            seen.add(n)
            if self.kind(n) == "VERTEX_POINT":
                found.append(self.numbers(self.refs(n)[0]))
            else:
                waiting += self.refs(n)
        return np.array(found)

    def solids(self) -> dict[int, tuple[str, np.ndarray]]:
        """By the representations of products: name and corners of the solid."""
        found = {}
        for n in self.by_name.get("ADVANCED_BREP_SHAPE_REPRESENTATION", []):
            for ref in self.refs(n):
                if self.kind(ref) == "MANIFOLD_SOLID_BREP":
                    found[n] = (self.string(ref), self.corners(ref))
        return found

    def placed(self) -> dict[str, np.ndarray]:
        """The corners of every instance of a solid, at its place, by the name of the instance."""
        solids = self.solids()
        parents: dict[int, tuple[int, np.ndarray]] = {}
        uses = []
        for n in self.by_name["CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"]:
            relation, shape = self.refs(n)
            child, parent, item = self.refs(relation)
            inner, outer = (self.placement(ref) for ref in self.refs(item))
            uses.append((child, parent, outer @ np.linalg.inv(inner), self.string(self.refs(shape)[0], 1)))
        for child, parent, matrix, _ in uses:
            if child not in solids:
                parents[child] = (parent, matrix)
        found = {}
        for child, parent, matrix, name in uses:
            if child in solids:
                whole, above = matrix, parent
                while above in parents:
                    above, step = parents[above]
                    whole = step @ whole
                found[name] = solids[child][1] @ whole[:3, :3].T + whole[:3, 3]
        return found


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """The largest distance from a point of either set to the nearest of the other."""
    apart = np.linalg.norm(one[:, None] - other[None], axis=2)
    return float(max(apart.min(axis=0).max(), apart.min(axis=1).max()))

"""An interactive page: sliders for the free parameters of edge offset meshes, with the M and S that they give.

The meshes of `parameters_koebe.py` and `parameters_revolution.py` are computed here and embedded in one file that
opens offline in a browser; the browser only displays them. Run it to write docs/gallery/parameters.html.
"""

from __future__ import annotations

import base64
import json
from collections import Counter
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from itertools import product
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import numpy.typing as npt

from docs.tools.parameters_koebe import KOEBE, SIGNS
from docs.tools.parameters_revolution import CONSTANT_MEAN, LAGUERRE, MINIMAL
from docs.tools.parameters_study import Parameter, Study
from geometry.arrays import BoolArray, FloatArray
from geometry.curvature import FaceCurvatures, face_curvatures
from geometry.gauss import Pair, edge_distances
from geometry.mesh import Combinatorics, Mesh
from geometry.parallel import parallelity

__all__ = ["State", "main", "page", "states"]

TOOLS = Path(__file__).parent
PAGE = TOOLS.parent / "gallery" / "parameters.html"

ROUNDING = 1e-9
"""Size of a number below which it is zero except for rounding, so that its digits depend on the machine."""

ROWS = (
    ("Faces", "range"),
    ("Edges reversed", "share"),
    ("Edge lengths of M", "range"),
    ("Beam height / d", "range"),
    ("Curvature H", "range"),
    ("Node height / d", "range"),
    ("Width by height", "pair"),
)
"""The numbers shown next to the meshes, two each: least and greatest value, a count and its total, or a pair."""


@dataclass(frozen=True, eq=False)
class State:
    """M and S of one combination of values."""

    pair: Pair
    curvatures: FaceCurvatures

    @classmethod
    def of(cls, pair: Pair) -> State:
        return cls(pair, face_curvatures(pair))

    @property
    def numbers(self) -> list[float]:
        """Two for each of `ROWS`."""
        pair, mesh = self.pair, self.pair.mesh
        wide, _, high = np.ptp(mesh.vertices, axis=0)
        twos = [
            (mesh.n_faces, mesh.n_faces),
            (int(pair.reversed_edges.sum()), mesh.n_edges),
            _ends(mesh.edge_lengths),
            _ends(pair.edge_distances),
            _ends(self.curvatures.mean),
            _ends(pair.vertex_distances),
            (_short(wide), _short(high)),
        ]
        return [number for two in twos for number in two]


def _ends(values: FloatArray) -> tuple[float, float]:
    """Least and greatest, equal where they differ by rounding only."""
    low, high = float(values.min()), float(values.max())
    if high - low <= ROUNDING * max(1.0, abs(low)):
        low = high = (low + high) / 2
    return _short(low), _short(high)


def _short(value: float) -> float:
    return 0.0 if abs(value) < ROUNDING else float(f"{value:.5g}")


@cache
def states() -> list[tuple[Study, list[State]]]:
    """For each study the meshes for all combinations of its values; the last parameter varies fastest."""
    return [
        (study, [State.of(study.make(*values)) for values in product(*(p.values for p in study.parameters))])
        for study in (*KOEBE, *MINIMAL, *CONSTANT_MEAN, *LAGUERRE, *SIGNS)
    ]


def main() -> dict[str, float]:
    everything = [(study, state) for study, found in states() for state in found]
    families = Counter(study.family for study, _ in everything)
    return {
        **{f"meshes, {family}": count for family, count in families.items()},
        "largest deviation of an edge of S from distance 1": max(
            float(np.abs(edge_distances(s.pair.gauss_image) - 1).max()) for _, s in everything
        ),
        "largest sine between corresponding edges": max(
            float((parallelity(s.pair.mesh, s.pair.gauss_image) / s.pair.gauss_image.edge_lengths).max())
            for _, s in everything
        ),
        "largest deviation of H from what it should be": max(
            float(np.abs(state.curvatures.mean - study.mean).max())
            for study, state in everything
            if study.mean is not None
        ),
    }


# --- the page


def page() -> str:
    """The text of the page, with no network requests, time or place."""
    found = main()
    tangency, parallelity_, curvature = list(found.values())[-3:]
    shared = [files("fabkit.formats.report").joinpath(name) for name in ("camera.js", "program.js")]
    own = [TOOLS / name for name in ("parameters_view.js", "parameters_page.js")]
    scripts = [script.read_text(encoding="utf-8") for script in (*shared, *own)]
    return Template((TOOLS / "parameters.html").read_text(encoding="utf-8")).substitute(
        n_meshes=sum(len(each) for _, each in states()),
        tangency=_power_of_ten(tangency),
        parallelity=_power_of_ten(parallelity_),
        curvature=_power_of_ten(curvature),
        data=json.dumps(_data(), separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
        script="".join(scripts),
    )


def _power_of_ten(value: float) -> str:
    """A bound that does not differ from machine to machine."""
    return "1e-9" if value < ROUNDING else f"{value:.0e}"


class _TextTable:
    """Distinct texts; `place` gives the index of one."""

    def __init__(self) -> None:
        self.kept: dict[str, int] = {}

    def place(self, text: str) -> int:
        return self.kept.setdefault(text, len(self.kept))


def _data() -> dict[str, Any]:
    arrays, topologies = _TextTable(), _TextTable()

    def written(state: State) -> dict[str, Any]:
        return {
            "topology": topologies.place(json.dumps(_topology(state.pair.mesh.combinatorics))),
            "mesh": arrays.place(json.dumps(_packed(_centred(state.pair.mesh)))),
            "image": arrays.place(json.dumps(_packed(state.pair.gauss_image.vertices))),
            "reversed": _bits(state.pair.reversed_edges),
            "turned": _bits(state.curvatures.gaussian < 0),
            "numbers": state.numbers,
        }

    described = [
        {
            "family": study.family,
            "title": study.title,
            "sentence": study.sentence,
            "beam": study.beam,
            "view": study.view,
            "parameters": [_described(parameter) for parameter in study.parameters],
            "states": [written(state) for state in found],
        }
        for study, found in states()
    ]
    return {
        "rows": [{"label": label, "kind": kind} for label, kind in ROWS],
        "topologies": [json.loads(text) for text in topologies.kept],
        "arrays": [json.loads(text) for text in arrays.kept],
        "studies": described,
    }


def _described(parameter: Parameter) -> dict[str, Any]:
    is_choice = isinstance(parameter.values[0], str)
    shown = [parameter.shown.format(value) for value in parameter.values]
    return {
        "name": parameter.name,
        "sentence": parameter.sentence,
        "values": shown if is_choice else [text.replace("-", "\u2212") for text in shown],
        "start": parameter.start,
        "isChoice": is_choice,
    }


def _centred(mesh: Mesh) -> FloatArray:
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    return np.asarray(mesh.vertices - (low + high) / 2)


def _packed(points: FloatArray) -> list[Any]:
    """Least coordinate, step, and coordinates in steps from there, in 24 bits: to 1e-7 of their range."""
    low = float(points.min())
    step = (float(points.max()) - low) / (2**24 - 1)
    steps = np.rint((points - low) / step).astype("<u4")
    return [low, step, _base64(steps.ravel().view("u1").reshape(-1, 4)[:, :3], "u1")]


def _topology(combinatorics: Combinatorics) -> dict[str, str]:
    c = combinatorics
    return {
        "sizes": _base64(c.face_sizes, "u1"),
        "corners": _base64(c.corners, "<u2"),
        "edges": _base64(c.edges, "<u2"),
    }


def _bits(flags: BoolArray) -> str:
    return base64.b64encode(np.packbits(flags).tobytes()).decode()


def _base64(values: npt.ArrayLike, kind: str) -> str:
    return base64.b64encode(np.asarray(values).astype(kind).tobytes()).decode()


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
    print(main())

"""Programs that know nothing of fabkit make the structure from its folder alone."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabkit import Project, build
from fabkit.errors import ProjectError
from fabkit.formats.finished import check_folder
from fabkit.rules import SiteRules
from geometry.mesh import shapes

OUTSIDE = Path(__file__).parents[1] / "outside"
WITHIN_MM = 0.01
WELDED: dict[str, Any] = {
    "beams": {"section": "rhs 120x60x5"},
    "connection": {"kind": "welded"},
    "nodes": {"top": "trimmed"},
    "nesting": {"mode": "off"},
}
TURN = [[0.0, 1.0, 0.0], [-0.6, 0.0, 0.8], [0.8, 0.0, 0.6]]


def said_by(program: str, folder: Path) -> dict[str, float]:
    """What a program says of a folder; it runs without our packages in reach."""
    script = f"import sys, runpy; sys.path.insert(0, {str(OUTSIDE)!r}); sys.argv = ['', {str(folder)!r}]; "
    script += f"runpy.run_path({str(OUTSIDE / program)!r}, run_name='__main__'); "
    script += "assert not {'fabkit', 'geometry'} & set(sys.modules)"
    done = subprocess.run([sys.executable, "-I", "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, float] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dome whose parts nearly agree, so that marks hide differences, far from zero and turned on its site."""
    dome = shapes.dome(8, 3)
    vertices = dome.vertices + np.random.default_rng(2).uniform(-1e-4, 1e-4, dome.vertices.shape)
    out = tmp_path_factory.mktemp("outside") / "dome"
    only = {"documents": ["meshes", "step", "parts", "tables"], "tables": {"separator": ";", "decimal": ","}}
    site = {"origin_mm": [2.6e6, -1.2e6, 400.0], "axes": TURN}
    built = build(Project(mesh=dome.with_vertices(vertices), mean_edge_mm=1500, out=out, site=site, **only, **WELDED))
    assert max(parts.hidden_mm.max() for parts in built.assembly.groups) > 0.1
    return out


def test_they_import_nothing_of_ours() -> None:
    allowed = {"csv", "json", "re", "sys", "pathlib", "numpy", "part21", "tables"}
    for path in OUTSIDE.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [each.name for each in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert {name.split(".")[0] for name in names} <= allowed, path.name


def test_beams_and_panels_cut_from_their_tables_and_all_pieces_in_place_meet_the_model(folder: Path) -> None:
    found = said_by("put_together.py", folder)
    assert found["n_beams"] == len(shapes.dome(8, 3).combinatorics.edges)
    assert max(found["beams"], found["panels"], found["others"]) < WITHIN_MM


def test_panels_with_mitred_edges_are_cut_from_their_tables_too(tmp_path: Path) -> None:
    layers = [{"build_up": "8/16Ar/44.2", "edges": "mitred"}]
    only: dict[str, Any] = {"documents": ["meshes", "step", "parts", "tables"], "layers": layers}
    build(Project(mesh=shapes.dome(6, 2), mean_edge_mm=1500, out=tmp_path / "dome", **only, **WELDED))
    found = said_by("put_together.py", tmp_path / "dome")
    assert max(found["beams"], found["panels"], found["others"]) < WITHIN_MM


def test_nodes_set_out_from_the_survey_meet_the_model(folder: Path) -> None:
    found = said_by("set_out.py", folder)
    assert found["n"] == shapes.dome(8, 3).n_vertices
    assert max(found["blocks"], found["heights"], found["facets"]) < WITHIN_MM


def test_a_folder_on_a_site_is_checked_like_others(folder: Path) -> None:
    assert check_folder(folder) == ()


@pytest.mark.parametrize(
    ("site", "sentence"),
    [
        (
            {"axes": [[1, 0, 0], [0, 1.001, 0], [0, 0, 1]]},
            "not perpendicular unit vectors: .* off by 0.002",
        ),
        ({"axes": [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}, "left-handed, which would mirror"),
        ({"axes": TURN, "turn_deg": 30}, "take out one of the two"),
        ({"origin_mm": [0, 0, float("inf")]}, "site.origin_mm.2 is inf"),
        ({"axes": [[1, 0, 0], [0, 1, 0]]}, "site.axes"),
    ],
)
def test_what_is_no_rigid_transformation_is_refused(site: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence):
        Project(mesh=shapes.dome(4, 1), mean_edge_mm=1500, site=site)


def test_rounded_axes_become_exact_ones() -> None:
    rounded = tuple(tuple(round(float(each), 7) for each in row) for row in SiteRules(turn_deg=33.3).frame.axes)
    axes = SiteRules(axes=rounded).frame.axes  # type: ignore[arg-type]
    assert np.abs(axes @ axes.T - np.eye(3)).max() < 1e-14
    assert np.abs(axes - SiteRules(turn_deg=33.3).frame.axes).max() < 1e-7

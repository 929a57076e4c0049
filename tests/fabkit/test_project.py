"""Project files: what they say is what is built, and what they get wrong is said in one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from fabkit.errors import ProjectError
from fabkit.production.marks import EQUAL_WITHIN_MM
from fabkit.project import load_project, project_from

GOOD = """
mesh = "roof.obj"
unit = "m"
out = "made"
[beams]
width_mm = 60
reference = "centre"
[nesting]
mode = "off"
[densities_kg_m3]
steel = 7800
glass = 2500
"""


def test_a_project_file_with_paths_from_its_folder_and_overrides(tmp_path: Path) -> None:
    file = tmp_path / "p.toml"
    file.write_text(GOOD)
    project = load_project(file, {"beams": {"width_mm": 70.0}, "nodes": {"clearance_mm": 9}})
    assert project.mesh == tmp_path / "roof.obj"
    assert project.out == tmp_path / "made"
    assert project.rules.beams.width_mm == 70.0
    assert project.rules.beams.reference == "centre"
    assert project.rules.beams.height_mm == 120.0
    assert project.rules.nodes.clearance_mm == 9
    assert project.rules.densities_kg_m3["steel"] == 7800
    assert project.title == "roof"
    assert project.equal_within_mm == EQUAL_WITHIN_MM


def test_a_mean_edge_on_the_command_line_replaces_the_unit_of_the_file(tmp_path: Path) -> None:
    file = tmp_path / "p.toml"
    file.write_text(GOOD)
    project = load_project(file, {"mean_edge_mm": 1500})
    assert (project.unit, project.mean_edge_mm) == (None, 1500)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({}, "either the unit of the mesh or the length of its mean edge is needed, and neither is given"),
        ({"unit": "m", "mean_edge_mm": 1500}, "both are given"),
        ({"unit": "km"}, "unit is 'km'"),
        ({"unit": "m", "beems": {}}, "unknown key 'beems' in the project; did you mean beams?"),
        ({"unit": "m", "beams": {"width": 50}}, r"unknown key 'width' in \[beams\]; did you mean width_mm?"),
        ({"unit": "m", "nesting": {"modus": "off"}}, r"unknown key 'modus' in \[nesting\]; did you mean mode?"),
        ({"unit": "m", "beams": {"width_mm": -5}}, "beams.width_mm is -5: input should be greater than 0"),
        ({"unit": "m", "nodes": {"clearance_mm": float("nan")}}, "nodes.clearance_mm is nan"),
        ({"unit": "m", "equal_within_mm": 3}, "equal_within_mm is 3: input should be less than or equal to 1"),
        ({"unit": "m", "panels": {"material": "oak"}}, "panels.material is 'oak', but densities_kg_m3 has only"),
    ],
)
def test_wrong_settings_are_named_with_what_would_do(settings: dict[str, object], sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence) as caught:
        project_from({"mesh": "roof.obj", **settings})
    assert "\n" not in str(caught.value)


def test_files_that_are_no_project(tmp_path: Path) -> None:
    with pytest.raises(ProjectError, match="there is no project file"):
        load_project(tmp_path / "none.toml", {})
    broken = tmp_path / "broken.toml"
    broken.write_text("mesh = ")
    with pytest.raises(ProjectError, match=r"broken\.toml is not TOML"):
        load_project(broken, {})
    broken.write_text("unit = 'm'")
    with pytest.raises(ProjectError, match="names no mesh"):
        load_project(broken, {})

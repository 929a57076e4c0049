"""Project files: what they say is what is built, and what they get wrong is said in one sentence."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

from fabkit import Project, build, design
from fabkit.errors import ProjectError
from fabkit.production.marks import EQUAL_WITHIN_MM
from fabkit.project import load_project, project_from
from geometry.errors import MeshError
from geometry.files import write_mesh
from geometry.mesh import Mesh
from geometry.mesh.shapes import dome

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
    project = load_project(file, {"beams": {"width_mm": 70.0}, "connection": {"slot_mm": 30}})
    assert project.mesh == tmp_path / "roof.obj"
    assert project.out == tmp_path / "made"
    assert project.rules.beams.width_mm == 70.0
    assert project.rules.beams.reference == "centre"
    assert project.rules.beams.profile.name == "flat 120x70"
    assert load_project(file, {"beams": {"section": "rhs 120x60x5"}}).rules.beams.profile.name == "rhs 120x60x5"
    assert project.rules.connection.slot == 30
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
        ({"unit": "m", "beams": {"section": "rhs 120x60x40"}}, "beams.section is 'rhs 120x60x40': the wall of the"),
        ({"unit": "m", "beams": {"section": "rhs 120x60x5", "height_mm": 9}}, "height_mm given too"),
        ({"unit": "m", "connection": {"kind": "glued"}}, "connection.kind is 'glued'"),
        ({"unit": "m", "equal_within_mm": 3}, "equal_within_mm is 3: input should be less than or equal to 1"),
        (
            {"unit": "m", "layers": [{"thickness_mm": 20, "material": "oak"}]},
            "layers.0.material is 'oak', but densities_kg_m3 has only",
        ),
    ],
)
def test_wrong_settings_are_named_with_what_would_do(settings: dict[str, object], sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence) as caught:
        project_from({"mesh": "roof.obj", **settings})
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "data",
    [
        pytest.param(b"\xef\xbb\xbf" + GOOD.encode(), id="byte order mark"),
        pytest.param(GOOD.replace("\n", "\r\n").encode(), id="line ends of Windows"),
    ],
)
def test_files_as_editors_write_them(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "p.toml").write_bytes(data)
    assert load_project(tmp_path / "p.toml", {}).rules.beams.width_mm == 60


SINGLE_QUOTES = "write backslashes in single quotes"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (rb'mesh = "C:\models\roof.obj"', SINGLE_QUOTES),
        (rb'mesh = "C:\Users\roof.obj"', SINGLE_QUOTES),
        (rb'mesh = "C:\new\table.obj"', SINGLE_QUOTES),
        (rb'mesh = "C:\models', SINGLE_QUOTES),
        (b'mesh = "a.obj"\n' + rb'out = "C:\temp"', SINGLE_QUOTES),
        (b'mesh = "a.obj"\n' + rb'gauss_image = "C:\temp"', SINGLE_QUOTES),
        (b'mesh = "a.obj"\n[gauss_image]\n' + rb'file = "C:\temp"', SINGLE_QUOTES),
        (rb'mesh = "a\u0000.obj"', SINGLE_QUOTES),
        (GOOD.encode("utf-16"), r"is not UTF-8 text \(byte 1 is 0xff\): save it as UTF-8"),
        (b'name = "\xe4"', r"is not UTF-8 text \(byte 9 is 0xe4\)"),
        (b"x = " + b"[" * 3000 + b"]" * 3000, "nested too deeply"),
        (b"x = " + b"{a = " * 3000 + b"1" + b"}" * 3000, "nested too deeply"),
        (b"beams." + b".".join([b"a"] * 3000) + b" = 1", "names no mesh"),
        (GOOD.encode() + b"[beams.width_mm]\n" + b".".join([b"a"] * 3000) + b" = 1", "is not TOML"),
        (b"x = " + b"9" * 5000, "thousands of digits"),
        (GOOD.encode() + b"[planarise]\nfairness = 0x" + b"f" * 5000, "planarise.fairness is a number of thousands"),
        (GOOD.encode() + b"[gauss_image]\nrounds = 1" + b"0" * 4000, r"rounds is 1000.*000: input should be less than"),
        (b"y" * 3000 + b" = 1\n" + GOOD.encode(), "unknown key 'yyy"),
        (
            GOOD.encode() + b"[[layers]]\nthickness_mm = 8\nmaterial = '" + b"y" * 3000 + b"'",
            "layers.0.material is 'yyy",
        ),
        (b"\0\0", "is not TOML"),
        (b"mesh = 'a.obj'\nmesh = 'b.obj'", "there twice: take one of the two out"),
        (b"[beams]\n[nodes]\n[beams]\n", "there twice: take one of the two out"),
        (b"beams = { width_mm = 5, width_mm = 5 }\n", "there twice: take one of the two out"),
        (b"mesh = 1979-05-27\nunit = 'm'", r"mesh is 1979-05-27: a path in quotes is needed, as in 'roof\.obj'"),
        (GOOD.encode().replace(b"[beams]", b"[fitness.a]"), "unknown key 'a' in \\[fitness\\]"),
        (b"mesh = 'a.obj'\nunit = 'm'\nbeams = 07:32:00", "beams is 07:32:00: a table is needed"),
        (b"mesh = 'a.obj'\nunit = 'm'\naccept = 'lean'", r"accept is 'lean': a list in brackets .* as in \['lean'\]"),
        (
            b"mesh = 'a.obj'\nunit = 'm'\nsite = { origin_mm = [1, 2, 3, 4] }",
            r"origin_mm is \[1, 2, 3, 4\]: it has more than 3 entries",
        ),
        (b"mesh = 'a.obj'\nunit = 'm'\ntitle_block = { date = 2026-03-01T10:00:00 }", "a date such as 2026-03-01"),
        (b"mesh = 'a.obj'\nunit = 'm'\ntitle_block = { date = 20260301 }", "input should be a valid string"),
        (b"mesh = 'a.obj'\nunit = 'm'\nmarks = { start = true }", "marks.start is True: a number is needed"),
        (b"mesh = 'a.obj'\nunit = 'm'\nlayers = [{ joint_mm = false }]", "layers.0.joint_mm is False: a number"),
    ],
)
def test_what_no_project_file_says_gets_one_short_sentence(tmp_path: Path, text: bytes, sentence: str) -> None:
    (tmp_path / "p.toml").write_bytes(text)
    with pytest.raises(ProjectError, match=sentence) as caught:
        load_project(tmp_path / "p.toml", {})
    assert len(str(caught.value)) < 400
    assert "\n" not in str(caught.value)
    assert not re.search("class|pathlib|datetime|dictionary|tuple", str(caught.value))


@pytest.mark.parametrize("value", [1e300, 1e10, float("inf"), float("nan"), -1.0, 0.0])
def test_lengths_that_overflow_or_are_none_are_refused(value: float) -> None:
    for settings in ({"mean_edge_mm": value}, {"unit": "m", "beams": {"height_mm": value}}):
        with pytest.raises(ProjectError, match=r"(mean_edge|height)_mm is .*: input should be"):
            project_from({"mesh": "roof.obj", **settings})


def test_a_file_that_cannot_be_read_gets_a_sentence(tmp_path: Path) -> None:
    for name in (tmp_path, tmp_path / ("x" * 300)):
        with pytest.raises(ProjectError, match=r"cannot be read: (Is a directory|File name too long)"):
            load_project(name, {})


def test_names_that_are_not_utf_8_are_titles_all_the_same() -> None:
    assert project_from({"mesh": os.fsdecode(b"\xfe.obj"), "unit": "m"}).title == r"\xfe"


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


def test_of_many_mistakes_the_first_are_named_and_the_others_counted() -> None:
    wrong = {f"colour_{n}": n for n in range(300)}
    with pytest.raises(ProjectError, match=r"^unknown key 'colour_0' .*; and \d+ more things$") as caught:
        project_from({"mesh": "roof.obj", "unit": "m", "fitness": wrong, "beams": wrong})
    assert len(str(caught.value)) < 590  # three lines of a terminal
    with pytest.raises(ProjectError, match=r"^name is 4: .*; flip is 3: [^;]*$"):
        project_from({"mesh": "roof.obj", "unit": "m", "flip": 3, "name": 4})


def test_a_mesh_in_memory_is_built_like_its_file(tmp_path: Path) -> None:
    mesh = dome(6, 2)
    write_mesh(tmp_path / "dome.obj", mesh)
    of_mesh, of_file = (
        build(project_from({"mesh": given, "unit": "m", "flip": True, "name": "dome", "out": tmp_path / out}))
        for given, out in ((mesh, "memory"), (tmp_path / "dome.obj", "file"))
    )
    assert of_mesh.assembly["nodes"].mark_names == of_file.assembly["nodes"].mark_names
    np.testing.assert_array_equal(of_mesh.assembly["beams"].origins, of_file.assembly["beams"].origins)
    manifest, by_file = (json.loads((tmp_path / out / "manifest.json").read_text()) for out in ("memory", "file"))
    assert manifest["input"] is None
    assert by_file["input"]["file"] == "dome.obj"
    assert "from a mesh in memory" in (tmp_path / "memory" / "report.html").read_text()


def test_what_no_mesh_in_memory_may_be() -> None:
    folded = Mesh.from_faces([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [1, -1, 0]], [[0, 1, 2, 3]])
    with pytest.raises(MeshError, match="face 0"):
        design(project_from({"mesh": folded, "unit": "m"}))
    with pytest.raises(ProjectError, match="needs a mesh file beside it"):
        project_from({"mesh": dome(6, 2), "unit": "m", "gauss_image": "S.obj"})
    with pytest.raises(ProjectError, match="is in memory"):
        _ = project_from({"mesh": dome(6, 2), "unit": "m"}).mesh_path


@pytest.mark.parametrize(
    "given", [{"name": "ro\x07of"}, {"name": "a\nb"}, {"densities_kg_m3": {"S\n355": 7850.0}}, {"name": "\x1b[31mroof"}]
)
def test_names_have_no_control_characters(given: dict[str, object]) -> None:
    with pytest.raises(ProjectError, match="control characters cannot stand in a name or title; take them out"):
        Project(mesh="roof.obj", unit="m", **given)  # type: ignore[arg-type]
    assert Project(mesh="roof.obj", unit="m", name="Dach (ß) 1").title == "Dach (ß) 1"


@pytest.mark.parametrize("date", ["2026-03-01", "'2026-03-01'", "'20260301'"])
def test_a_date_may_be_one_of_toml(tmp_path: Path, date: str) -> None:
    path = tmp_path / "roof.toml"
    path.write_text(f"mesh = 'a.obj'\nunit = 'm'\n[title_block]\ndate = {date}")
    assert load_project(path, {}).title_block.date == "2026-03-01"

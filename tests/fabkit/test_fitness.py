"""One judgement for `inspect` and `build`: what it finds, from where on it tells or refuses, and where that is said."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from fabkit import FabkitError, Project, design
from fabkit.commands.command_line import app
from fabkit.commands.inspection import inspect_mesh, inspect_project
from fabkit.errors import ProjectError, error_sentence
from fabkit.fitness import CRITERIA, Finding, FitnessError, FitnessRules, check_fit_to_build, with_accepted
from fabkit.fitness.parts import mitres, underside
from fabkit.fitness.shape import heights, lean, moves, self_intersection, tilt
from fabkit.project import project_from
from geometry.errors import GeometryError, MeshError, MeshFileError
from geometry.files import write_mesh
from geometry.gauss import Pair, SupportStructure
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.mesh import Mesh, shapes
from tests.fabkit import unfit_meshes as unfit
from tests.geometry.bent_meshes import rotation, shaken, vault

RULES = FitnessRules()
KINDS = {
    "along rulings": unfit.along_rulings(),
    "across rulings": unfit.across_rulings(),
    "askew": unfit.askew(),
    "through itself": unfit.through_itself(),
    "two flat faces": unfit.two_flat_faces(),
    "narrow": unfit.narrow(),
    "rough": unfit.rough(),
    "triangles": unfit.triangles(),
    "vault": vault(),
}
REFUSED = {"along rulings": "moves", "askew": "lean", "through itself": "self-intersection", "rough": "folding"}


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def written(folder: Path, mesh: Mesh) -> Path:
    write_mesh(folder / "mesh.obj", mesh)
    return folder / "mesh.obj"


def of_name(findings: tuple[Finding, ...], name: str) -> Finding:
    (found,) = [finding for finding in findings if finding.name == name]
    return found


# --- inspect and build agree


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("options", [(), ("--skip-unbuildable",), ("--sheet", "1200x1000"), ("--beam", "300x120")])
def test_inspect_ends_as_build_does(kind: str, options: tuple[str, ...], tmp_path: Path) -> None:
    file = written(tmp_path, KINDS[kind])
    inspected = run("inspect", file, "--unit", "m", *options)
    built = run("build", file, "--unit", "m", *options, "-o", tmp_path / "out")
    assert (inspected.exit_code, built.exit_code) in ((0, 0), (1, 2)), inspected.output + built.output
    assert ("unfit: a build would be refused" in inspected.stdout) == (built.exit_code != 0)
    assert (tmp_path / "out").exists() == (built.exit_code == 0)


@settings(max_examples=12)
@given(seed=st.integers(0, 1000), amount=st.floats(0, 0.3), size=st.floats(150, 2500), width=st.floats(30, 200))
def test_inspection_is_unfit_exactly_where_a_design_is_refused(
    seed: int, amount: float, size: float, width: float, tmp_path_factory: pytest.TempPathFactory
) -> None:
    file = written(tmp_path_factory.mktemp("shaken"), shaken(vault(), amount, seed))
    project = project_from({"mesh": file, "mean_edge_mm": size, "beams": {"width_mm": width}})
    found = inspect_project(project)
    try:
        built = design(project)
    except (FabkitError, GeometryError):
        assert found.is_unfit
    else:
        assert not found.is_unfit
        assert found.findings == built.summary.fitness


@pytest.mark.parametrize(("kind", "name"), REFUSED.items())
def test_what_is_refused_is_named_with_number_bound_and_cure(kind: str, name: str, tmp_path: Path) -> None:
    file = written(tmp_path, KINDS[kind])
    result = run("build", file, "--unit", "m", "-o", tmp_path / "out")
    assert result.exit_code == 2
    (sentence,) = [line for line in result.stderr.splitlines() if line.startswith("fabkit:")]
    assert f"unfit ({name})" in sentence
    assert "counted from 0" in sentence
    assert (f"--accept {name}" in sentence) == (not CRITERIA[name])
    assert "use more fairness" not in sentence
    for options in ((), ("--unit", "m")):
        inspected = run("inspect", file, *options)
        assert inspected.exit_code == 1
        assert f"{name}: " in inspected.stdout


def test_without_sizes_inspect_says_what_needs_them(tmp_path: Path) -> None:
    file = written(tmp_path, unfit.narrow())
    unsized = inspect_mesh(file)
    assert not unsized.is_unfit
    assert "give --unit or --mean-edge" in dict(unsized.facts())["not judged"]
    sized = run("inspect", file, "--unit", "m")
    assert sized.exit_code == 1
    assert "cannot be welded" in " ".join(sized.stdout.split())
    assert "not judged" not in sized.stdout


def test_inspect_takes_a_project_file_and_the_sizes_in_it(tmp_path: Path) -> None:
    written(tmp_path, vault())
    project = tmp_path / "p.toml"
    project.write_text('mesh = "mesh.obj"\nunit = "m"\n')
    assert run("inspect", project).exit_code == 0
    project.write_text('mesh = "mesh.obj"\nunit = "m"\n[sheets]\nlength_mm = 400\nwidth_mm = 300\n')
    inspected = run("inspect", project)
    assert inspected.exit_code == 1
    assert "sheets: panel P001" in inspected.stdout
    assert f"nor do {vault().n_faces - 1} more, with the mark" in " ".join(inspected.stdout.split())
    assert run("inspect", project, "--nest", "off").exit_code == 0
    assert run("inspect", written(tmp_path, vault()), "--beam", "40x80").exit_code == 2  # a size without a unit
    assert run("inspect", tmp_path / "none.obj").exit_code == 2


# --- the cures are cures


def test_other_lines_over_the_same_surface_are_fit(tmp_path: Path) -> None:
    found = inspect_project(Project(mesh=written(tmp_path, unfit.across_rulings()), unit="m"))
    assert not found.is_unfit
    assert [finding.name for finding in found.findings if finding.name != "going-in"] == []  # that is of beams


def test_even_heights_can_be_asked_for(tmp_path: Path) -> None:
    mesh = unfit.askew(turn_deg=30.0)
    spreads = [
        np.ptp(np.percentile(SupportStructure(pair, 1.0).heights, [2.5, 97.5]))
        for pair in (approximate_pair(mesh), approximate_pair(mesh, edges=1.0, rounds=5))
    ]
    assert spreads[1] < 0.8 * spreads[0]


def test_what_runs_through_itself_is_built_without_what_shares_room(tmp_path: Path) -> None:
    file = written(tmp_path, unfit.through_itself())
    accepted = run("build", file, "--unit", "m", "-o", tmp_path / "out", "--accept", "self-intersection")
    assert accepted.exit_code == 2
    assert "share no vertex of the mesh, which intersects itself" in accepted.stderr
    assert "increase the slot between beams" not in accepted.stderr
    # the parts have no marks yet, so they are called by their edges and faces
    assert re.search(
        r"the (beam on edge|panel on face) \d+ and the (node at vertex|panel on face) \d+ share", accepted.stderr
    )
    assert not re.search(r"\b[BNP]\d", accepted.stderr)
    skipped = run(
        "build", file, "--unit", "m", "-o", tmp_path / "out", "--accept", "self-intersection", "--skip-unbuildable"
    )
    assert skipped.exit_code == 0, skipped.output
    manifest = json.loads((tmp_path / "out" / "manifest.json").read_text())
    reasons = [part["reason"] for part in manifest["left_out"]]
    assert manifest["counts"]["left_out"] == len(set(reasons)) > 10
    for part, reason in zip(
        manifest["left_out"], reasons, strict=True
    ):  # each is named, with no advice to leave it out
        place = {"panel": "panel on face", "beam": "beam on edge"}[part["kind"]]
        assert reason.startswith(f"the {place} {part['element']}, because the ")
        assert "--" not in reason
    assert skipped.stdout.count("left out: the ") == 10
    assert f"left out: {len(reasons) - 10} more, which the report and the manifest name" in skipped.stdout
    assert manifest["fitness"][0]["level"] == "accepted"


@pytest.mark.parametrize("mesh", [unfit.two_flat_faces(), unfit.narrow()], ids=["flat", "narrow"])
def test_where_nothing_is_left_one_sentence_says_why(mesh: Mesh, tmp_path: Path) -> None:
    arguments = ("--unit", "m", "-o", tmp_path / "out", "--skip-unbuildable", "--joint", "1600")
    result = run("build", written(tmp_path, mesh), *arguments)
    assert result.exit_code == 2
    assert "can be built; the reason for the first is" in result.stderr
    assert result.exception is None or isinstance(result.exception, SystemExit)
    tiny = run("build", written(tmp_path, vault()), *arguments[:-2], "--sheet", "300x200")
    assert tiny.exit_code == 2
    assert "none of the 20 panels fits on a sheet" in tiny.stderr


# --- bounds


@given(share=st.floats(0, 1), far=st.floats(0, 2))
def test_most_vertices_decide_and_the_farthest_is_named(share: float, far: float) -> None:
    mesh = shapes.grid(9, 9)  # 100 vertices with edges of 1
    count = round(100 * share)
    moved = np.random.default_rng(count).permutation(100)[:count]
    vertices = mesh.vertices.copy()
    vertices[moved, 2] += far
    found = moves(mesh, mesh.with_vertices(vertices), RULES)
    # between the 95th and the 96th of 100 values numpy interpolates; five that move are not most
    most = 0.0 if count < 5 else far if count > 5 else far * 0.05
    if most >= RULES.moves_refused:
        assert found
        assert (found.level, found.bound) == ("refused", RULES.moves_refused)
    elif most >= RULES.moves_noted or (count and far >= RULES.moves_refused):
        assert found
        assert (found.level, found.bound) == ("note", RULES.moves_noted)
    else:
        assert found is None
        return
    assert found.value == pytest.approx(most)
    assert found.elements[0] in moved
    assert f"vertex {found.elements[0]} (counted from 0)" in found.sentence


@given(seed=st.integers(0, 10**6), size=st.floats(1e-3, 1e6))
def test_what_is_judged_depends_neither_on_size_nor_on_place(seed: int, size: float) -> None:
    turn, shift = rotation(seed), np.random.default_rng(seed).uniform(-5, 5, 3)

    def judged(pair: Pair) -> list[Finding | None]:
        structure = SupportStructure(pair, 1.0)
        return [tilt(structure, strict), lean(pair, strict), heights(structure, strict)]

    strict = FitnessRules(tilt_noted_deg=1.0, lean_noted_deg=1.0, heights_noted=1e-3)
    mesh = unfit.askew(6, turn_deg=30.0)
    pair = approximate_pair(mesh)
    S = pair.gauss_image
    moved = Pair(mesh.with_vertices(size * (mesh.vertices + shift) @ turn), S.with_vertices(S.vertices @ turn))
    for here, there in zip(judged(pair), judged(moved), strict=True):
        assert here
        assert there
        assert there.value == pytest.approx(here.value, rel=1e-6)  # angles near 0 and 90 lose half of the digits
        assert there.level == here.level


def test_bounds_in_the_project_file_hold(tmp_path: Path) -> None:
    file = written(tmp_path, unfit.along_rulings())
    project = tmp_path / "p.toml"
    project.write_text('mesh = "mesh.obj"\nunit = "m"\n[fitness]\nmoves_refused = 0.9\n')
    found = inspect_project(project_from({"mesh": file, "unit": "m", "fitness": {"moves_refused": 0.9}}))
    assert of_name(found.findings, "moves").level == "note"
    assert run("inspect", project).exit_code == 0
    project.write_text('mesh = "mesh.obj"\nunit = "m"\naccept = ["moves"]\n')
    assert run("inspect", project).exit_code == 0
    assert "accepted" in run("inspect", project).stdout


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"accept": ["move"]}, "'move' is no criterion; did you mean moves"),
        ({"accept": ["xyz"]}, "those that can be accepted are moves, self-intersection, lean"),
        (
            {"accept": ["mitres"]},
            "'mitres' cannot be accepted: it is only noted and stops no build; those that can be are moves",
        ),
        ({"accept": ["tilt"]}, "'tilt' cannot be accepted: a beam that does not point to the outside"),
        ({"fitness": {"move_noted": 1}}, r"unknown key 'move_noted' in \[fitness\]; did you mean moves_noted"),
        ({"fitness": {"moves_noted": 0.5}}, "moves_noted is 0.5, but moves_refused is 0.3"),
        ({"fitness": {"lean_noted_deg": 95}}, "less than or equal to 90"),
    ],
)
def test_names_and_bounds_that_make_no_sense(settings: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence):
        project_from({"mesh": "roof.obj", "unit": "m", **settings})


@given(st.lists(st.floats(-89, 89), min_size=1, max_size=60), st.integers(0, 3))
def test_slanted_cuts_are_counted_and_the_steepest_named(angles: list[float], seed: int) -> None:
    cuts = np.array([angles, np.random.default_rng(seed).permutation(angles)]).T
    names = [f"B{k:03d}" for k in range(len(angles))]
    found = mitres(cuts, names, range(len(angles)), RULES)
    worst = np.abs(cuts).max(axis=1)
    if (worst < RULES.mitres_noted_deg).all():
        assert found is None
        return
    assert found
    assert set(found.elements) == set(np.flatnonzero(worst >= RULES.mitres_noted_deg).tolist())
    assert worst[list(found.elements)].tolist() == sorted(worst[list(found.elements)], reverse=True)
    steep = [name for name, angle in zip(names, worst, strict=True) if angle >= RULES.mitres_listed_deg]
    named = [name for name in names if name in found.sentence]
    assert set(named) <= set(steep)
    assert len(named) == min(10, len(steep))
    assert (f"and {len(steep) - 10} more" in found.sentence) == (len(steep) > 10)


@given(ask=st.floats(0, 300), one=st.floats(0, 300))
def test_one_node_that_raises_all_panels_is_named(ask: float, one: float) -> None:
    asked = np.full(101, ask)  # of 101 values the 95th percentile is the 96th
    asked[7] = one
    found = underside(asked, {vertex: f"N{vertex:03d}" for vertex in range(101)}, 120.0, RULES)
    assert (found is not None) == ((one - ask) / 120.0 >= RULES.underside_noted)
    if found:
        assert found.elements == (7,)
        assert "N007 (vertex 7, counted from 0)" in found.sentence


def test_faces_that_meet_are_counted_and_all_kept() -> None:
    found = self_intersection(unfit.through_itself())
    assert found
    assert found.value >= 4
    assert len(found.elements) >= 4
    assert self_intersection(vault()) is None


# --- levels


@given(st.lists(st.sampled_from(sorted(CRITERIA)), unique=True), st.lists(st.sampled_from(sorted(CRITERIA))))
def test_only_what_can_be_accepted_is_accepted(found: list[str], allow: list[str]) -> None:
    findings = tuple(Finding(name, "refused", 2.0, 1.0, "mm", f"it is {name}", "mend it") for name in found)
    levelled = with_accepted(findings, allow)
    refused = [name for name in found if name not in allow or CRITERIA[name]]
    assert [finding.name for finding in levelled if finding.level == "refused"] == refused
    assert with_accepted(levelled, ()) == findings
    if not refused:
        check_fit_to_build(levelled)
        return
    with pytest.raises(FitnessError) as caught:
        check_fit_to_build(levelled)
    assert all(f"unfit ({name}): it is {name}: mend it" in str(caught.value) for name in refused)
    assert caught.value.findings == levelled


# --- from where it counts


def test_what_numbers_elements_says_from_where_it_counts() -> None:
    assert error_sentence(MeshError("face 3 is bent", elements=[3])).endswith("faces counted from 0)")
    named = "face 4 is bent (vertices and faces counted from 1)"
    assert error_sentence(MeshError(named, elements=[3])) == named
    assert error_sentence(MeshFileError("line 3 is no face", elements=[3])) == "line 3 is no face"
    assert error_sentence(GeometryError("the weight is 0")) == "the weight is 0"
    assert error_sentence(ProjectError("unit is 3")) == "unit is 3"


# --- where it is said


@pytest.fixture(scope="module")
def leaning(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    folder = tmp_path_factory.mktemp("leaning")
    file = written(folder, unfit.askew())
    return folder / "out", run(
        "build", file, "--unit", "m", "-o", folder / "out", "--accept", "lean", "--connection", "contact"
    )


def test_terminal_report_workbook_and_manifest_say_the_same(leaning: tuple[Path, Result]) -> None:
    out, result = leaning
    assert result.exit_code == 0, result.output
    manifest = json.loads((out / "manifest.json").read_text())
    levels = {entry["name"]: entry["level"] for entry in manifest["fitness"]}
    assert levels["lean"] == "accepted"
    report = (out / "report.html").read_text(encoding="utf-8")
    cells = {cell for row in openpyxl.load_workbook(out / "cutlist.xlsx")["Summary"].values for cell in row}
    printed = " ".join(result.stdout.split())
    for entry in manifest["fitness"]:
        assert entry["sentence"] in report
        assert entry["cure"] in report
        assert entry["sentence"] in cells
        assert f"{entry['name']}: {entry['sentence']}" in printed
        is_below = entry["name"] in ("corners", "short-edges")
        assert (entry["value"] < entry["bound"]) == is_below
        assert entry["bound"] > 0


def test_the_manifest_tells_shares_of_heights_and_leans(leaning: tuple[Path, Result]) -> None:
    manifest = json.loads((leaning[0] / "manifest.json").read_text())
    assert list(manifest["heights"]) == ["least", "p2_5", "median", "p97_5", "largest"]
    assert sorted(manifest["heights"].values()) == list(manifest["heights"].values())
    assert 30 < manifest["lean_deg"]["median"] < manifest["lean_deg"]["p95"] < manifest["lean_deg"]["largest"] < 90
    assert of(manifest, "lean")["value"] == manifest["lean_deg"]["median"]
    assert set(manifest["counts"]["marks"]) == {"beams", "nodes", "panels"}
    assert manifest["panel_underside"]["mm"] > 0


def of(manifest: dict[str, Any], name: str) -> dict[str, Any]:
    return next(entry for entry in manifest["fitness"] if entry["name"] == name)

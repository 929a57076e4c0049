"""Finished folders: damage is found, also where the hashes are taken away; two builds are compared."""

from __future__ import annotations

import csv
import json
import random
import re
import shutil
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fabkit import Project, build
from fabkit.errors import FolderError
from fabkit.formats.finished import check_folder, differences_page, folder_differences
from fabkit.formats.finished.view_checks import LINE_TOLERANCE_MM, _are_drawn, _off_axes
from fabkit.production.part_drawing import VIEW_GAP_MM
from geometry.mesh import Mesh
from geometry.mesh.shapes import dome, grid
from tests.fabkit.browser import Browser
from tests.fabkit.corruption import corrupt

N_CORRUPTIONS = 200
FOUND_WITHOUT_HASHES = 0.9
"""Share of random corruptions that must be found by what the files say alone."""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("finished") / "roof"
    tables = {"separator": ";", "decimal": ",", "bom": True}
    build(Project(mesh=dome(6, 2), mean_edge_mm=1500, out=out, beams={"section": "rhs 120x60x5"}, tables=tables))
    return out


def found_in(folder: Path, *, hashes: bool) -> tuple[str, ...]:
    try:
        return check_folder(folder, hashes=hashes)
    except FolderError as error:
        return (str(error),)


def of_version(folder: Path, version: str) -> None:
    path = folder / "manifest.json"
    path.write_text(re.sub(r'("versions": \{\s*"fabkit": )"[^"]*"', rf'\1"{version}"', path.read_text()))


def in_manifest(folder: Path, **changes: Any) -> None:
    path = folder / "manifest.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | changes))


def test_a_folder_of_another_version_is_not_compared(made: Path, tmp_path: Path) -> None:
    shutil.copytree(made, tmp_path / "old")
    of_version(tmp_path / "old", "99.0")
    for old, new in ((tmp_path / "old", made), (made, tmp_path / "old")):
        with pytest.raises(FolderError, match=r"old was written by fabkit 99\.0"):
            folder_differences(old, new)


def test_a_whole_folder_is_found_whole(made: Path) -> None:
    assert check_folder(made) == ()
    assert check_folder(made, hashes=False) == ()


@pytest.mark.parametrize(
    "settings",
    [
        {"mesh": dome(3, 2), "layers": [{"build_up": "8/16Ar/44.2", "edges": "mitred"}]},  # edges of S vanish
        {"drawings": {"version": "R12"}, "name": "gr\u00fcn ^ %%d \\U+00DF", "title_block": {"revision": "1^"}},
        {"marks": {"mirrored_panes": True, "prefix": "NO1-"}, "drawings": {"labels": "middle"}},
        {"beams": {"section": "chs 76.1x5", "reference": "glass"}, "nodes": {"bottom": "trimmed"}},
        {"beams": {"section": "round 60"}, "supports": {"loop": 0}, "step": {"schema": "AP214"}},
        {"documents": ["parts", "drawings", "panels"], "name": "A & B <x>"},
        {"mesh": grid(12, 12), "mean_edge_mm": 150, "documents": ["tables", "parts", "sheets"]},  # handles above 330
        {"documents": ["sheets", "step", "tables"]},
        {"documents": ["report", "workbook", "glb"]},
    ],
)
def test_other_folders_are_found_whole_too(tmp_path: Path, settings: dict[str, Any]) -> None:
    build(Project(**{"mesh": dome(4, 1), "mean_edge_mm": 1500, "out": tmp_path / "roof", **settings}))
    assert check_folder(tmp_path / "roof") == ()


def test_random_corruptions_are_found(made: Path, tmp_path: Path) -> None:
    """All by their hashes; without them by what the files say of each other, which `-s` prints."""
    source, without, missed = random.Random(7), 0, []
    for number in range(N_CORRUPTIONS):
        copy = tmp_path / "copy"
        shutil.copytree(made, copy)
        what = corrupt(copy, source)
        assert found_in(copy, hashes=True), f"{number}: {what}"
        found = found_in(copy, hashes=False)
        assert all(len(sentence) < 1000 and "\n" not in sentence for sentence in found)
        without += bool(found)
        missed += [] if found else [what]
        shutil.rmtree(copy)
    print(f"found without hashes: {without} of {N_CORRUPTIONS}; missed: {missed}")
    assert without >= FOUND_WITHOUT_HASHES * N_CORRUPTIONS


def of_first_piece(folder: Path, last_cell: str) -> None:
    lines = (folder / "placements.csv").read_text().splitlines()
    lines[1] = lines[1].rpartition(";")[0] + ";" + last_cell
    (folder / "placements.csv").write_text("\n".join([*lines, ""]))


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda folder: shutil.rmtree(folder), "is not a folder"),
        (lambda folder: (folder / "manifest.json").unlink(), "has no manifest.json"),
        (lambda folder: (folder / "manifest.json").write_text("{"), "damaged, or of another version"),
        (lambda folder: (folder / "manifest.json").write_text('{"files": {}}'), "damaged, or of another version"),
        (lambda folder: in_manifest(folder, files=["M.obj"]), "damaged, or of another version"),
        (lambda folder: in_manifest(folder, files={"M.obj": 5}), "damaged, or of another version"),
        (lambda folder: in_manifest(folder, settings={"tables": None}), "damaged, or of another version"),
        (lambda folder: in_manifest(folder, settings={"tables": {"separator": "x"}}), "damaged, or of another"),
        (lambda folder: in_manifest(folder, origin={"mm": ["a"]}), "'origin.mm"),
        (lambda folder: of_version(folder, "0.0.0"), "was written by fabkit 0.0.0"),
        (lambda folder: (folder / "pieces.csv").unlink(), "pieces.csv is missing"),
        (lambda folder: (folder / "pieces.csv").write_bytes(b"\xff\xfe\x00"), "pieces.csv is not text"),
        (lambda folder: (folder / "parts" / "B001.step").write_text(""), "B001.step is no complete STEP file"),
        (
            lambda folder: of_first_piece(folder, "nan"),
            "placements.csv has nan in the column Centre z (mm), which is no",
        ),
        (lambda folder: of_first_piece(folder, "-INF"), "placements.csv has -INF in the column Centre z (mm)"),
        (lambda folder: (folder / "notes.txt").write_text("mine"), "notes.txt was added"),
    ],
)
def test_damage_is_named(made: Path, tmp_path: Path, damage: Callable[[Path], object], sentence: str) -> None:
    shutil.copytree(made, tmp_path / "copy")
    damage(tmp_path / "copy")
    found = found_in(tmp_path / "copy", hashes=False)
    assert any(sentence in each for each in found), found


@pytest.mark.parametrize(("column", "more"), [("Length (mm)", 0.003), ("Corner (deg)", 2e-6), ("Bevel (deg)", 2e-4)])
def test_edges_of_panels_are_those_of_their_solids(tmp_path: Path, column: str, more: float) -> None:
    layers, documents = [{"edges": "mitred"}], ["parts", "tables"]
    build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out=tmp_path / "roof", layers=layers, documents=documents))
    path = tmp_path / "roof" / "panel_edges.csv"
    head, *lines = path.read_text().splitlines()
    cells, place = lines[2].split(","), head.split(",").index(column)
    cells[place] = f"{float(cells[place]) + more:.6f}"
    path.write_text("\n".join([head, *lines[:2], ",".join(cells), *lines[3:], ""]))
    assert check_folder(tmp_path / "roof", hashes=False) == (f"panel_edges.csv does not have the edges of {cells[0]}",)


@pytest.mark.parametrize("mesh", [dome(4, 1), grid(2, 2)])
@pytest.mark.parametrize("factor", [2.0, 1.0001])
def test_the_mesh_has_the_size_that_its_unit_says(tmp_path: Path, mesh: Mesh, factor: float) -> None:
    build(Project(mesh=mesh * 2.0, unit="m", out=tmp_path / "roof", documents=["meshes", "tables"]))
    assert check_folder(tmp_path / "roof") == ()
    path = tmp_path / "roof" / "M.obj"
    vertices = [line.split()[1:] for line in path.read_text().splitlines() if line.startswith("v ")]
    larger = [f"v {' '.join(str(factor * float(number)) for number in each)}" for each in vertices]
    rest = [line for line in path.read_text().splitlines() if not line.startswith("v ")]
    path.write_text("\n".join([*larger, *rest, ""]))
    found = check_folder(tmp_path / "roof", hashes=False)
    assert "vertex 2 (counted from 0) of M.obj is not where survey.csv has it" in found


def test_an_edited_manifest_is_named_alone(made: Path, tmp_path: Path) -> None:
    shutil.copytree(made, tmp_path / "copy")
    in_manifest(tmp_path / "copy", note="mine")
    assert found_in(tmp_path / "copy", hashes=True) == (
        "manifest.json is not as it was written, so that its hashes say nothing of other files",
    )


def test_a_build_differs_from_itself_in_nothing_and_from_a_moved_vertex_around_it(made: Path, tmp_path: Path) -> None:
    assert folder_differences(made, made).rows == ()
    mesh = dome(6, 2)
    vertices = mesh.vertices.copy()
    vertices[0] += [0, 0, 0.01 * mesh.mean_edge_length]
    for name, each in (("a", mesh), ("b", Mesh(vertices, mesh.combinatorics))):
        build(Project(mesh=each, mean_edge_mm=1500, out=tmp_path / name))
    rows = folder_differences(tmp_path / "a", tmp_path / "b").rows
    assert {row[0] for row in rows} == {"changed"}
    moved = {row[2]: row[4] for row in rows}
    (top,) = (value for name, value in moved.items() if re.fullmatch(r"N\d+ v0", str(name)))
    assert isinstance(top, float)
    assert 5 < top < 40  # 15 mm, less what planarising takes back
    page = tmp_path / "diff.html"
    page.write_text(differences_page(made, tmp_path / "b", folder_differences(made, tmp_path / "b")), encoding="utf-8")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not installed")
    with Browser(chromium, tmp_path / "profile") as browser:
        browser.size(500, 400)
        browser.open(page.as_uri())
        assert (browser.evaluate("document.documentElement.dataset.ready"), browser.problems) == ("yes", [])
        shown = dict(browser.evaluate("viewer.shapes.map(({ layer }) => [layer.name, layer.names])"))
        assert shown.keys() <= {"same", "changed", "new"}
        assert sum(map(len, shown.values())) == 60
        assert browser.evaluate(f"pick({shown['changed'][0]!r})") == 1
        assert "Moved (mm)" in browser.evaluate("document.querySelector('#part').innerText")


@pytest.fixture(scope="module")
def revisions(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """A dome: as it is; three vertices moved; a face removed; both, its elements renumbered, with thicker panels."""
    folder, mesh = tmp_path_factory.mktemp("revisions"), dome(6, 3)
    moved = mesh.vertices.copy()
    moved[[0, 8, 15]] += 0.02 * mesh.mean_edge_length
    opened = mesh.faces[:4] + mesh.faces[5:]
    order = np.random.default_rng(1).permutation(len(moved))
    renumbered = [[int(order[vertex]) for vertex in face] for face in opened[::-1]]
    built = []
    for k, (vertices, faces, thickness) in enumerate(
        [
            (mesh.vertices, mesh.faces, 10),
            (moved, mesh.faces, 10),
            (mesh.vertices, opened, 10),
            (moved[np.argsort(order)], renumbered, 12),
        ]
    ):
        built.append(folder / str(k))
        layers, scale = [{"thickness_mm": thickness}], {"unit": "m", "out": built[-1], "documents": ["tables"]}
        build(Project(mesh=Mesh.from_faces(vertices * 5, faces), layers=layers, **scale))
    return built


@pytest.mark.parametrize(("one", "other"), [*combinations(range(4), 2)])
def test_differences_are_the_same_from_both_sides_and_every_piece_has_its_row_or_none(
    revisions: list[Path], one: int, other: int
) -> None:
    there, back = (folder_differences(revisions[a], revisions[b]).rows for a, b in ((one, other), (other, one)))
    turned = {"gone": "new", "new": "gone", "changed": "changed"}
    assert sorted((turned[row[0]], row[1], row[3], row[2]) for row in there) == sorted(row[:4] for row in back)
    numbers_there = {(row[3], row[2]): row[4:8] for row in there}
    for row in back:  # moved as far, and the sizes, angles and mass changed by as much, to the other side
        assert [abs(number or 0.0) for number in row[4:8]] == pytest.approx(
            [abs(number or 0.0) for number in numbers_there[row[2], row[3]]], abs=1e-9
        )
    names = [
        {row["Piece"]: row["Kind"] for row in csv.DictReader((revisions[k] / "pieces.csv").open())}
        for k in (one, other)
    ]
    for kind in set(names[0].values()):
        numbers = [sum(found == kind for found in own.values()) for own in names]
        of_kind = [row[0] for row in there if row[1] == kind]
        assert numbers[0] - of_kind.count("gone") == numbers[1] - of_kind.count("new")
    assert all(row[2] in names[0] for row in there if row[0] != "new")
    assert all(row[3] in names[1] for row in there if row[0] != "gone")


def test_tables_that_were_edited_are_not_compared(made: Path, tmp_path: Path) -> None:
    shutil.copytree(made, tmp_path / "edited")
    lines = (made / "beams.csv").read_text().splitlines()
    (tmp_path / "edited" / "beams.csv").write_text("\n".join([*lines[:1], *lines[2:], ""]))
    with pytest.raises(
        FolderError, match=r"edited cannot be compared: beams\.csv there was changed after it was written"
    ):
        folder_differences(made, tmp_path / "edited")


def test_a_page_of_differences_needs_both_reports(made: Path, tmp_path: Path) -> None:
    shutil.copytree(made, tmp_path / "old")
    (tmp_path / "old" / "report.html").write_text("<html></html>")
    with pytest.raises(FolderError, match=r"report\.html in .*old has no model that can be read"):
        differences_page(tmp_path / "old", made, folder_differences(made, made))


def test_pieces_are_found_again_by_their_place(tmp_path: Path) -> None:
    """The same dome with its faces numbered the other way round: the same pieces with other names."""
    mesh = dome(6, 2)
    order = np.arange(mesh.n_vertices)[::-1]
    turned = Mesh.from_faces(mesh.vertices[order], [[len(order) - 1 - k for k in face] for face in [*mesh.faces][::-1]])
    for name, each in (("a", mesh), ("b", turned)):
        build(Project(mesh=each, mean_edge_mm=1500, out=tmp_path / name))
    rows = folder_differences(tmp_path / "a", tmp_path / "b").rows
    assert {row[0] for row in rows} <= {"changed"}
    assert all(row[4] < 0.01 and row[5] < 0.02 for row in rows)  # type: ignore[operator]


def test_a_bore_that_is_seen_a_little_obliquely_is_a_circle_at_both_of_its_ends() -> None:
    axis = np.array([3e-4, 0.0, 1.0])
    solid = SimpleNamespace(
        rounds=np.array([[10.0, 20.0, 0.0, *axis / np.linalg.norm(axis), 2.5]]),
        corners=np.array([[0.0, 0.0, -120.0], [60.0, 60.0, 0.0]]),
        centres=np.zeros((0, 3)),
    )
    outside = -120.0 - VIEW_GAP_MM - 60.0
    rings = np.array(
        [[10.0 + off, 20.0 + aside + outside, 2.5] for off, aside in ((0, 0), (6e-4, 0), (0, 6e-4), (1, 0))]
    )
    assert (_off_axes(rings, solid, 1) < LINE_TOLERANCE_MM).tolist() == [True, True, False, False]  # type: ignore[arg-type]


def test_edges_that_are_nearly_one_line_are_drawn_once() -> None:
    line = np.array([[[0.0, -180.0], [0.0, -240.0]]])
    edges = np.array([[[off, -240.0], [off, -180.0]] for off in (0.0, 3.8e-4, 2e-3)])
    assert _are_drawn(edges, line).tolist() == [True, True, False]

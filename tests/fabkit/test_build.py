"""The whole road, on the roof that ships: everything is there, agrees, and comes out the same again."""

from __future__ import annotations

import csv
import hashlib
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely

from fabkit import Built, Project, build, design, write_built
from fabkit.checking.placed_parts import violations
from fabkit.errors import OutputError, ProjectError
from fabkit.parts import Part
from geometry.files import read_mesh
from geometry.mesh.shapes import dome
from tests.fabkit.part21 import StepText

ROOF = Path(__file__).parents[2] / "examples" / "roof.obj"
N_BEAMS, N_NODES, N_PANELS = 612, 325, 288


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Built]:
    out = tmp_path_factory.mktemp("build") / "roof"
    return out, build(Project(mesh=ROOF, unit="m", out=out, equal_within_mm=1e-7))


def rows(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as stream:
        return [row for row in csv.DictReader(stream) if row["Mark"] != "Total"]


def test_every_document_is_there(made: tuple[Path, Built]) -> None:
    out, built = made
    names = {path.name for path in out.iterdir()}
    assert names == {
        "M.obj",
        "S.obj",
        "model.step",
        "parts",
        "sheets",
        "panels",
        "drawings",
        "beams.csv",
        "nodes.csv",
        "panels.csv",
        "pieces.csv",
        "placements.csv",
        "survey.csv",
        "node_facets.csv",
        "panel_edges.csv",
        "legend.csv",
        "mark_points.csv",
        "cutlist.xlsx",
        "model.glb",
        "report.html",
        "manifest.json",
    }
    marks = {part.mark for part in built.assembly.parts()}
    assert {path.stem for path in (out / "parts").iterdir()} == marks
    bars = {part.mark for group in ("beams", "nodes") for part in built.assembly[group]}
    assert {path.stem for path in (out / "drawings").iterdir()} == bars
    assert {path.stem for path in (out / "panels").iterdir()} == {panel.mark for panel in built.assembly["panels"]}
    assert built.nest is not None
    assert len(list((out / "sheets").iterdir())) == built.nest.n_sheets


def test_counts_agree_everywhere(made: tuple[Path, Built]) -> None:
    out, _ = made
    counts = json.loads((out / "manifest.json").read_text())["counts"]
    for kind, n in (("beams", N_BEAMS), ("nodes", N_NODES), ("panels", N_PANELS)):
        table = rows(out / f"{kind}.csv")
        assert counts[kind] == n
        assert counts["marks"][kind] == len(table)
        assert sum(int(row["Count"]) for row in table) == n
    text = (out / "model.step").read_text(encoding="ascii")
    # one occurrence a part, and one a group
    assert text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE(") == N_BEAMS + N_NODES + N_PANELS + 3
    assert text.count("MANIFOLD_SOLID_BREP(") == sum(counts["marks"].values())


def test_a_symmetric_roof_has_equal_beams(made: tuple[Path, Built]) -> None:
    # 13 rows of 24 along, symmetric about the middle one; 25 arches of 12, each beam the mirror image of another,
    # which is the same beam turned end for end
    beams = made[1].assembly["beams"]
    assert len({beam.mark for beam in beams}) == 7 * 24 + 25 * 6
    first: dict[str, Part] = {}
    for beam in beams:  # what is said of equal beams is said from the same end
        twin = first.setdefault(beam.mark, beam)
        assert beam.details.cut_angles_deg == pytest.approx(twin.details.cut_angles_deg, abs=1e-8)
        assert np.array_equal(beam.solid.vertices, twin.solid.vertices)
        starts = beam.placement.origin - made[1].structure.mesh.vertices[list(beam.details.nodes)]
        assert np.linalg.norm(starts[0]) < np.linalg.norm(starts[1])


def test_the_sheets_hold_every_panel_once(made: tuple[Path, Built]) -> None:
    out, built = made
    found: list[float] = []
    for path in sorted((out / "sheets").iterdir()):
        for line in ezdxf.readfile(path).modelspace().query("LWPOLYLINE[layer=='CUT']"):
            assert line.closed
            found.append(shapely.Polygon([(x, y) for x, y, *_ in line]).area)
    # coordinates are written to 1e-9 mm
    assert sorted(found) == pytest.approx(
        sorted(panel.details.area_mm2 for panel in built.assembly["panels"]), rel=1e-9
    )


def test_what_is_written_fits(made: tuple[Path, Built]) -> None:
    assert violations(made[1].assembly) == ()


def test_the_manifest_tells_what_was_done(made: tuple[Path, Built]) -> None:
    manifest = json.loads((made[0] / "manifest.json").read_text())
    assert manifest["input"]["sha256"] == hashlib.sha256(ROOF.read_bytes()).hexdigest()
    assert manifest["largest_twist_deg"] < 1e-6
    assert 0.9 < manifest["heights"]["least"] <= manifest["heights"]["median"] <= manifest["heights"]["largest"] < 1.1
    assert manifest["planarity"]["after"] < 1e-12 < manifest["planarity"]["before"]
    assert manifest["settings"]["sheets"]["length_mm"] == 6000
    assert {"Read", "Planarise", "Gauss image", "Nest", "Report"} <= set(made[1].seconds)
    listed = {path.relative_to(made[0]).as_posix() for path in made[0].rglob("*") if path.is_file()}
    assert set(manifest["files"]) == listed - {"manifest.json"}
    for name, sha256 in manifest["files"].items():
        assert hashlib.sha256((made[0] / name).read_bytes()).hexdigest() == sha256
    assert str(made[0].parent) not in (made[0] / "manifest.json").read_text()


def test_the_same_input_gives_the_same_bytes(made: tuple[Path, Built], tmp_path: Path) -> None:
    """In another process, where hashes of strings are others."""
    again = tmp_path / "again"
    settings = f"mesh={str(ROOF)!r}, unit='m', out={str(again)!r}, equal_within_mm=1e-7"
    script = f"from fabkit import Project, build; build(Project({settings}))"
    subprocess.run([sys.executable, "-c", script], check=True)
    first = {p.relative_to(made[0]): p for p in made[0].rglob("*") if p.is_file()}
    second = {p.relative_to(again): p for p in again.rglob("*") if p.is_file()}
    assert set(first) == set(second)
    assert [str(name) for name in first if first[name].read_bytes() != second[name].read_bytes()] == []


def test_a_mean_edge_instead_of_a_unit() -> None:
    built = design(Project(mesh=ROOF, mean_edge_mm=900.0, nesting={"mode": "off"}))
    assert built.structure.mesh.mean_edge_length == pytest.approx(900.0, rel=1e-6)
    assert built.nest is None


def test_flipping_turns_the_outside_round() -> None:
    up = design(Project(mesh=ROOF, unit="m", nesting={"mode": "off"})).structure
    down = design(Project(mesh=ROOF, unit="m", flip=True, nesting={"mode": "off"})).structure
    assert up.gauss_image.vertices[:, 2].min() > 0 > down.gauss_image.vertices[:, 2].max()
    assert np.sort(up.heights) == pytest.approx(np.sort(down.heights), abs=1e-6)


def test_heights_and_the_boundary_are_what_the_project_asks_for(made: tuple[Path, Built]) -> None:
    usual = made[1].structure
    settings = {"gauss_image": {"faces": 0.0, "edges": 1.0, "rounds": 5}, "planarise": {"keep_boundary": True}}
    asked = design(Project(mesh=ROOF, unit="m", nesting={"mode": "off"}, **settings)).structure
    assert asked.heights.std() < 0.9 * usual.heights.std()
    corners = asked.mesh.combinatorics.vertex_degrees == 2
    given = read_mesh(ROOF).mesh.vertices[corners] * 1000
    assert np.abs(asked.mesh.vertices[corners] - given).max() < 1e-9  # corners of the boundary stay
    assert np.abs(usual.mesh.vertices[corners] - given).max() > 1e-3


def test_a_folder_that_may_not_be_replaced_is_refused_before_any_work(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="exists already"):
        build(Project(mesh=tmp_path / "not even there.obj", unit="m", out=tmp_path))


def test_a_project_without_a_folder_is_refused_before_any_work() -> None:
    with pytest.raises(ProjectError, match="there is no output folder"):
        build(Project(mesh=ROOF, unit="m"))


def test_a_project_chooses_its_documents(tmp_path: Path) -> None:
    chosen: dict[str, set[str]] = {
        "meshes": {"M.obj", "S.obj"},
        "step": {"model.step"},
        "parts": {"parts"},
        "sheets": {"sheets"},
        "panels": {"panels"},
        "plates": set(),  # there are none but panels
        "drawings": {"drawings"},
        "workbook": {"cutlist.xlsx"},
        "glb": {"model.glb"},
        "report": {"report.html"},
    }
    built = design(Project(mesh=dome(4, 1), mean_edge_mm=1500))
    for document, expected in chosen.items():
        project = Project(mesh=dome(4, 1), mean_edge_mm=1500, out=tmp_path / document, documents=[document])
        write_built(replace(built, project=project))
        assert {path.name for path in (tmp_path / document).iterdir()} == expected | {"manifest.json"}
    project = Project(mesh=dome(4, 1), mean_edge_mm=1500, out=tmp_path / "lists", documents=["tables", "panels"])
    write_built(replace(built, project=project))
    for table in ("beams", "nodes", "panels", "pieces"):
        with (tmp_path / "lists" / f"{table}.csv").open(newline="") as file:
            files = [row["File"] for row in csv.DictReader(file)]
        assert all((tmp_path / "lists" / each).is_file() for each in files if each)  # and none that is not written
        assert any(files) == (table in ("panels", "pieces"))
    for documents in ([], ["letters"]):
        with pytest.raises(ProjectError, match=r"documents"):
            Project(mesh=dome(4, 1), mean_edge_mm=1500, documents=documents)


def test_the_title_block_is_in_the_step_files(tmp_path: Path) -> None:
    block = {"author": "A. \u00d6ther 100 %", "organisation": "Shop", "date": "2026-03-01", "revision": "B"}
    project = Project(
        mesh=dome(4, 1), mean_edge_mm=1500, out=tmp_path / "a", title_block=block, step={"schema": "AP214"}
    )
    build(project)
    for name in ("model.step", "parts/B001.step"):
        file = StepText((tmp_path / "a" / name).read_text())
        assert "'2026-03-01T00:00:00',('A. \\X2\\00D6\\X0\\ther 100 %'),('Shop')" in file.header
        assert "AUTOMOTIVE_DESIGN" in file.header
        assert {each.values[0] for each in file.all("PRODUCT_DEFINITION_FORMATION")} == {"B"}
        labels = {each.values[0]: each.values[1] for each in file.all("PRODUCT")}
        assert labels["B001"] == "B001 rhs 120x60x5 beam"
        assert not any(label[-1].isdigit() for label in labels.values())
    for key, value in (("date", "1.3.2026"), ("author", "a\nb"), ("datum", "2026-03-01")):
        with pytest.raises(ProjectError, match=key):
            Project(mesh=dome(4, 1), mean_edge_mm=1500, title_block={key: value})

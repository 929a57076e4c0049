"""A kind of part that fabkit does not have goes through everything that comes after detailing."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import openpyxl
import pytest
import trimesh

from fabkit import Project, design, write_built
from fabkit.checking import check_fit, clashes
from fabkit.errors import DetailingError, FabkitError, ProjectError
from fabkit.formats.kernels import to_build123d, to_cadquery
from fabkit.kinds import NODE
from fabkit.parts import Assembly, Parts
from fabkit.production import share_equal_parts
from geometry.files import write_mesh
from geometry.mesh import shapes
from tests.fabkit.bolts import BOLT, HEIGHT, NOSE, RADIUS, BoltDetails, bolts
from tests.fabkit.dome import dome
from tests.fabkit.part21 import StepText, written
from tests.fabkit.plain_bars import PLAIN_TABLES

BOLT_MM3 = (4 * RADIUS**2 + 2 * RADIUS * NOSE) * 3**0.5 / 4 * HEIGHT


def bolted(assembly: Assembly, *, gap_mm: float = 20.0) -> Assembly:
    """With a bolt over each node block, no two neighbours turned alike."""
    nodes = assembly.of(NODE)
    tops = np.array([part.solid.vertices[:, 2].max() for part in nodes])
    origins = nodes.origins + (tops + gap_mm)[:, None] * nodes.axes[:, 2]
    return assembly.with_group(bolts(nodes.elements, origins, nodes.axes, turned=np.arange(len(nodes)) % 6))


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A build with bolts as well."""
    folder = tmp_path_factory.mktemp("kinds")
    write_mesh(folder / "dome.obj", shapes.dome(8, 2))
    built = design(Project(mesh=folder / "dome.obj", mean_edge_mm=1500.0, out=folder / "out"))
    write_built(built.with_parts(bolted(built.assembly).of(BOLT)))
    return folder / "out"


def test_it_is_checked_where_it_joins_a_build(tmp_path: Path) -> None:
    write_mesh(tmp_path / "dome.obj", shapes.dome(8, 2))
    built = design(Project(mesh=tmp_path / "dome.obj", mean_edge_mm=1500.0, **PLAIN_TABLES))
    with pytest.raises(DetailingError, match=r"node N\d+ .* share volume, 5 mm deep"):
        built.with_parts(bolted(built.assembly, gap_mm=-5.0).of(BOLT))
    with pytest.raises(ProjectError, match="no output folder"):
        write_built(built)


N_BOLTS = shapes.dome(8, 2).n_vertices


def test_equal_ones_share_a_mark_whichever_way_they_are_turned() -> None:
    own = bolted(dome())
    shared = share_equal_parts(own).of(BOLT)
    assert set(shared.marks) == {"S001"}
    assert len(shared.solids) == 1
    assert np.array_equal(shared.elements, own["bolts"].elements)
    assert (shared.details.stamps.values.reshape(-1, 6) == np.arange(6)).all()  # turned with their frames
    for before, after in zip(own["bolts"].placed(), shared.placed(), strict=True):
        apart = np.linalg.norm(before.vertices[:, :, None] - after.vertices[:, None], axis=3)
        assert apart.min(axis=1).max() < 1e-9


def test_it_is_checked() -> None:
    check_fit(bolted(dome()))
    sunk = bolted(dome(), gap_mm=-5.0)
    assert {(a.kind.name, b.kind.name) for a, b, _ in clashes(sunk)} == {("node", "bolt")}
    with pytest.raises(DetailingError, match=r"node N4 \(vertex 4\) and bolt S4 \(vertex 4\) share volume, 5 mm deep"):
        check_fit(sunk)
    twice = bolted(dome())
    again = twice["bolts"].take(np.array([*range(9), 4]))
    away = replace(again, origins=again.origins + 1000.0 * np.eye(10)[:, 9:] * [0, 0, 1])
    with pytest.raises(DetailingError, match="vertex 4 has 2 bolts, allowed 1"):
        check_fit(twice.with_group(away))


def test_no_two_kinds_may_be_mixed_up() -> None:
    whole = bolted(dome())
    nothing = Parts.of(replace(BOLT, letter="N"))
    with pytest.raises(DetailingError, match="nodes and bolts have the same letter of marks, 'N'"):
        whole.with_group(nothing)
    with pytest.raises(DetailingError, match="beams and beams have the same group"):
        replace(whole, groups=(*whole.groups, whole["beams"]))


def test_a_part_is_a_view_with_its_own_record() -> None:
    group = bolted(dome()).of(BOLT)
    last = group[-1]
    assert (last.kind, last.element, last.details.thread, last.details.torque_nm) == (BOLT, 8, "M12", 88.0)
    assert last.details.stamps.tolist() == [2, 3, 4, 5, 0, 1]
    assert last.mass_kg == pytest.approx(7.85e-6 * BOLT_MM3) == group.masses_kg[8]
    again = Parts.of(BOLT, group)
    for name in ("elements", "origins", "axes"):
        assert np.array_equal(getattr(again, name), getattr(group, name))
    assert np.array_equal(again.details.stamps.values, group.details.stamps.values)
    assert isinstance(again.details, BoltDetails)


def test_it_stands_in_the_model_and_in_a_file_of_its_own(out: Path) -> None:
    file = StepText((out / "model.step").read_text())
    names = [each.values[1] for each in file.all("NEXT_ASSEMBLY_USAGE_OCCURRENCE")]
    assert [name for name in names if name[0] == "S"] == [f"S001 v{k}" for k in range(N_BOLTS)]
    assert "bolts" in names
    assert list(BOLT.colour) in [each.values[1:] for each in file.all("COLOUR_RGB")]
    own = StepText((out / "parts" / "S001.step").read_text())
    assert own.all("PRODUCT")[0].values[:3] == ["S001", "S001 bolt", "bolt"]


def test_it_has_a_list(out: Path) -> None:
    head, row, totals = csv.reader(io.StringIO((out / "bolts.csv").read_text()))
    cells = dict(zip(head, row, strict=True))
    assert (cells["Mark"], cells["Count"], cells["Thread"], cells["Material"]) == ("S001", f"{N_BOLTS}", "M12", "8.8")
    assert cells["File"] == "parts/S001.step"
    pieces = [row for row in csv.reader(io.StringIO((out / "pieces.csv").read_text())) if row[2] == "bolt"]
    assert len(pieces) == N_BOLTS
    assert all(row[1] == "S001" and row[5].endswith(f" v{row[4]}") for row in pieces)
    assert float(totals[head.index("Mass (kg)")]) == pytest.approx(N_BOLTS * 7.85e-6 * BOLT_MM3, abs=5e-4)
    book = openpyxl.load_workbook(out / "cutlist.xlsx")
    assert "Bolts" in book.sheetnames
    assert book["Bolts"]["C2"].value == "M12"
    assert dict(book["Summary"].iter_rows(max_col=2, values_only=True))["Bolts"] == N_BOLTS


def test_it_is_shown(out: Path) -> None:
    scene = trimesh.load_scene(out / "model.glb")
    shown = [name for name in scene.graph.nodes_geometry if name.startswith("S001")]
    assert len(shown) == N_BOLTS
    body = scene.geometry[scene.graph[shown[0]][1]].copy()
    body.merge_vertices(merge_norm=True, merge_tex=True)
    assert body.volume == pytest.approx(BOLT_MM3 * 1e-9, rel=1e-5)  # single precision
    text = (out / "report.html").read_text()
    assert '<input type="checkbox" value="bolts" checked>' in text
    assert "--kind-bolts: #e6cc1a" in text
    assert ".bolts rect { fill: var(--kind-bolts); }" in text
    assert 'id="table-bolts"' in text
    data = json.loads(re.search(r'id="data">(.*?)</script>', text)[1])  # type: ignore[index]
    assert data["labels"]["bolts"] == ["M12 bolt"] * N_BOLTS
    assert data["forms"]["bolts"] == "block"
    assert [each["values"] for each in data["measures"] if each["group"] == "bolts"] == [
        [80 + k for k in range(N_BOLTS)]
    ]


def test_it_is_counted(out: Path) -> None:
    counts = json.loads((out / "manifest.json").read_text())["counts"]
    assert counts["bolts"] == N_BOLTS
    assert counts["marks"]["bolts"] == 1


@pytest.mark.kernel
@pytest.mark.parametrize(("package", "make"), [("build123d", to_build123d), ("cadquery", to_cadquery)])
def test_kernels_get_it(package: str, make: object) -> None:
    if find_spec(package) is None:
        with pytest.raises(FabkitError, match=package):
            make(bolted(dome()))  # type: ignore[operator]
        pytest.skip(f"{package} is not installed")
    made = make(bolted(dome()))  # type: ignore[operator]
    groups = {getattr(group, "label", None) or group.name: group for group in made.children}
    assert len(groups["bolts"].children) == 9


def test_its_own_file_is_that_of_its_kind() -> None:
    assert written(bolted(dome())["bolts"][0]).all("MANIFOLD_SOLID_BREP")[0].values[0] == "S0"

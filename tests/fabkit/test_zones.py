"""Zones: which parts belong to them, in which order they go up, and what all files say of them."""

from __future__ import annotations

import csv
import json
import re
from collections import defaultdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fabkit import Project, build, design
from fabkit.errors import FabkitError
from fabkit.formats import glb_bytes
from fabkit.formats.finished import check_folder, folder_differences
from fabkit.kinds import BEAM, NODE, PANEL
from fabkit.parts import Assembly, Zones
from fabkit.production import build_facts, erection_order, piece_tables
from geometry.arrays import IntArray
from geometry.mesh.shapes import dome
from tests.fabkit.occt import HAS_KERNEL, read_step

MESH = dome(6, 3)
ZONES = [{"name": "Zone 1", "faces": [0, 1, 2, 3]}, {"name": "Höhe", "below_mm": 1200.0}, {"name": "St John's"}]


@pytest.fixture(scope="module")
def secondary() -> Assembly:
    """A dome of two layers of beams on supports, under insulating glass, with fins, in three zones."""
    own: dict[str, Any] = {
        "second_layer": {"distance_mm": -500},
        "supports": {"loop": 0},
        "fins": {"from_mm": 120, "to_mm": 300},
        "layers": [{"build_up": "8/16/44.2"}],
    }
    return design(Project(mesh=MESH, mean_edge_mm=1500, zones=ZONES, nesting={"mode": "off"}, **own)).assembly


def zoned(assembly: Assembly, of_faces: IntArray) -> Assembly:
    """The same assembly with other zones, by way of another formula than that of the program."""
    c = MESH.combinatorics
    of_vertices = [min(of_faces[c.corner_face[c.corners == v]]) for v in range(c.n_vertices)]
    of_edges = [min(of_faces[c.corner_face[c.corner_edge == e]]) for e in range(c.n_edges)]
    names = tuple(f"Z{k}" for k in range(int(of_faces.max()) + 1))
    zones = Zones(names, np.array(of_vertices), np.array(of_edges), of_faces)
    return Assembly(assembly.name, assembly.groups, zones=zones)


def test_elements_between_zones_belong_to_the_first(secondary: Assembly) -> None:
    zones, c = secondary.zones, MESH.combinatorics
    heights = MESH.vertices[:, 2] * 1500 / MESH.mean_edge_length
    middles = [heights[face].mean() for face in c.faces]
    assert zones.of_faces.tolist() == [0 if f < 4 else 1 if middles[f] < 1200 else 2 for f in range(c.n_faces)]
    assert len(set(zones.of_faces.tolist())) == 3
    other = zoned(secondary, zones.of_faces).zones
    assert zones.of_vertices.tolist() == other.of_vertices.tolist()
    assert zones.of_edges.tolist() == other.of_edges.tolist()


def test_what_a_part_stands_on_is_there_before_it(secondary: Assembly) -> None:
    goes_up(secondary)


@given(of_faces=st.lists(st.integers(0, 2), min_size=18, max_size=18))
def test_any_zones_go_up_one_after_the_other(secondary: Assembly, of_faces: list[int]) -> None:
    goes_up(zoned(secondary, np.unique(of_faces, return_inverse=True)[1].ravel()))


def goes_up(assembly: Assembly) -> None:
    numbers = erection_order(assembly).numbers
    every = np.concatenate(list(numbers.values()))
    assert set(every.tolist()) == set(range(1, int(every.max()) + 1))
    spans = defaultdict(list)
    for group, own in numbers.items():
        for zone, number in zip(assembly.zones.of(assembly[group]).tolist(), own.tolist(), strict=True):
            spans[zone].append(number)
    ends = [(min(spans[zone]), max(spans[zone])) for zone in sorted(spans)]
    assert all(one[1] < other[0] for one, other in pairwise(ends))

    def at(group: str, elements: IntArray) -> IntArray:
        return np.asarray(numbers[group][assembly[group].find(elements)])

    supported = assembly["stubs"].elements
    assert (numbers["base plates"] == numbers["stubs"]).all()
    assert (numbers["stubs"] < at("lower nodes", supported)).all()
    struts = assembly["struts"].elements
    assert (at("lower nodes", struts) < numbers["struts"]).all()
    assert (numbers["struts"] < at("nodes", struts)).all()
    for layer in ("", "lower "):
        beams, closing = assembly[f"{layer}beams"], erection_order(assembly).is_closing[f"{layer}beams"]
        later = at(f"{layer}nodes", beams.details.nodes.ravel()).reshape(-1, 2).max(axis=1)
        own_zone, zones = assembly.zones.of(beams), assembly.zones.of_vertices[beams.details.nodes]
        own = numbers[f"{layer}beams"]
        assert (own[~closing] == later[~closing]).all()
        assert (own[closing] > later[closing]).all()
        assert len(np.unique(own)) == len(own)
        assert closing[(zones < own_zone[:, None]).all(axis=1)].all()  # both its nodes stand
    panels = assembly.of(PANEL)
    around = panels.details.beams
    assert (numbers["panels"][around.row] > at("beams", around.values)).all()
    faces = [set(numbers["panels"][panels.elements == face].tolist()) for face in range(MESH.n_faces)]
    assert [len(own) for own in faces] == [1] * MESH.n_faces  # both panes at once
    assert len(set.union(*faces)) == MESH.n_faces
    last = {zone: numbers["panels"][assembly.zones.of(panels) == zone].max() for zone in spans}
    fins = assembly["fins"]
    assert (numbers["fins"] > [last[zone] for zone in assembly.zones.of(fins).tolist()]).all()


def test_layers_go_up_from_the_beams_outwards_and_then_inwards() -> None:
    layers = [
        {"thickness_mm": 8, "z_mm": 300},
        {"thickness_mm": 10},
        {"thickness_mm": 6, "z_mm": -260},
        {"thickness_mm": 6, "z_mm": -400},
    ]
    assembly = design(Project(mesh=dome(4, 1), mean_edge_mm=1500, layers=layers, nesting={"mode": "off"})).assembly
    order, layer = erection_order(assembly).numbers["panels"], assembly.of(PANEL).details.layer
    assert layer[np.argsort(order)].tolist() == [1] * 4 + [0] * 4 + [2] * 4 + [3] * 4


@pytest.mark.parametrize(
    ("zones", "sentence"),
    [
        ([{"name": "A", "faces": [0]}], "17 of 18 faces are in no zone, the first of them face 1 .* a name alone"),
        ([{"name": "A", "faces": [0, 18]}, {"name": "B"}], "zone 'A' has face 18, .* counted from 0 to 17"),
        ([{"name": "A", "faces": [0, 10**20]}, {"name": "B"}], f"zone 'A' has face {10**20}, .* counted from 0 to 17"),
        ([{"name": "A", "faces": [-1]}, {"name": "B"}], "zones.0.faces.0 is -1"),
        ([{"name": "A", "faces": [3]}, {"name": "B", "faces": [3]}], r"face 3 .* is in zones 'A' and 'B': take it out"),
        ([{"name": "A"}, {"name": "B"}], "zones 'A' and 'B' both say nothing of their faces"),
        ([{"name": "A"}, {"name": "a", "faces": [1]}], "zones 0 and 1 .* have the same name, 'a': give each its own"),
        (
            [{"name": "A"}, {"name": "B", "below_mm": -1e6}],
            r"zone 'B' has no face: the lowest .* is 1\d{6}\.\d mm above",
        ),
        ([{"name": "A", "below_mm": 1e6}, {"name": "B"}], "zone 'B' has no face, as none is left for it"),
        ([{"name": "A"}, {"name": "B", "faces": []}], "zone 'B' has no face"),
        ([{"name": ""}], "a zone needs a name, such as 'North'"),
        ([{"name": " A"}], "not with a blank"),
        ([{"name": "A\nB"}], "line breaks and control characters"),
        ([{"name": "A\x00"}], "line breaks and control characters"),
        ([{"name": "=1+1"}], "a spreadsheet would run what begins with =, "),
        ([{"name": "A;@SUM(1)"}], "or after a semicolon"),
        ([{"name": "A" * 41}], "at most 40 letters, and this one has 41"),
        ([{"name": "structure"}], "a zone is called 'structure', like the structure: give it another name"),
        ([{"name": "A", "panels": [1]}], r"unknown key 'panels' in \[zones.0\]"),
        ([{"faces": [1]}], "zones.0.name is missing"),
        ({"name": "A"}, r"zones is one table: write \[\[zones\]\] above it, as for the first of a list"),
    ],
)
def test_zones_that_cannot_be_are_told_in_a_sentence(zones: Any, sentence: str) -> None:
    with pytest.raises(FabkitError, match=sentence):
        design(Project(mesh=MESH, mean_edge_mm=1500, zones=zones))


def test_nodes_in_the_air_are_named() -> None:
    mesh = dome(6, 3)
    middles = np.array([mesh.vertices[face, 2].mean() for face in mesh.combinatorics.faces])
    top = {"name": "Top", "faces": np.flatnonzero(middles > middles.max() - 1e-6).tolist()}
    bottom = {"name": "Bottom"}

    def propped(**own: Any) -> list[int]:
        built = design(Project(mesh=mesh, mean_edge_mm=1500, nesting={"mode": "off"}, **own))
        found = [finding for finding in built.summary.fitness if finding.name == "props"]
        assert [finding.level for finding in found] in ([], ["note"])
        return [vertex for finding in found for vertex in finding.elements]

    on_top = {v for face in top["faces"] for v in mesh.combinatorics.face(face).tolist()}
    (hanging,) = propped(zones=[top, bottom], supports={"loop": 0})
    assert hanging in on_top
    assert propped(zones=[bottom, top], supports={"loop": 0}) == []
    assert propped(zones=[bottom, top]) == propped() == propped(supports={"loop": 0}) == []


def test_facts_count_the_parts_of_each_zone(secondary: Assembly) -> None:
    (pieces,) = (table for table in piece_tables(secondary, None) if table.title == "pieces")
    zone, mass = (pieces.columns.index(title) for title in ("Zone", "Mass (kg)"))
    own = [row for row in pieces.rows if row[zone] == "Höhe"]
    summary = design(Project(mesh=dome(4, 1), mean_edge_mm=1500)).summary
    (fact,) = (fact for fact in build_facts(summary, secondary, None).parts if fact.name == "Parts in Höhe")
    assert fact.values == (len(own),)
    assert fact.note == f"{sum(float(row[mass] or 0) for row in own):,.0f} kg"


# --- files


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("zones") / "roof"
    documents = ("step", "parts", "tables", "glb")
    zones = [{"name": "Zone 1", "faces": [0]}, {"name": "St John's", "faces": [2]}, {"name": "Höhe"}]
    build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out=out, zones=zones, documents=documents))
    return out


def rows(folder: Path, name: str) -> list[dict[str, str]]:
    with (folder / f"{name}.csv").open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def test_tables_and_models_agree_on_zones(folder: Path) -> None:
    zones = {row["Piece"]: row["Zone"] for row in rows(folder, "pieces")}
    assert set(zones.values()) == {"Zone 1", "St John's", "Höhe"}
    assert {row["Node"]: row["Zone"] for row in rows(folder, "survey")}.items() <= zones.items()
    assert check_folder(folder) == ()
    data = (folder / "model.glb").read_bytes()
    nodes = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])["nodes"]
    of_zones = {child: node["name"] for k in nodes[0]["children"] for node in [nodes[k]] for child in node["children"]}
    found = {part: zone for group, zone in of_zones.items() for part in nodes[group]["children"]}
    assert [found[part] for part in sorted(found)] == list(zones.values())


@pytest.mark.kernel
@pytest.mark.skipif(not HAS_KERNEL, reason="needs OCP")
def test_zones_are_sub_assemblies(folder: Path) -> None:
    zones = {row["Piece"]: row["Zone"] for row in rows(folder, "pieces")}
    placed = read_step(folder / "model.step")
    assert {each.path[-1]: each.path[-3] for each in placed} == zones
    assert {each.path[-2] for each in placed} >= {"Zone 1 beams", "St John's panels", "Höhe beams"}


@pytest.mark.parametrize(
    ("name", "old", "new", "finding"),
    [
        ("pieces.csv", ",panel,Zone 1,", ",panel,Höhe,", "in zone Höhe, the manifest in Zone 1"),
        ("pieces.csv", ",panel,Zone 1,", ",panel,Zone 2,", "in zone 'Zone 2', which the manifest does not have"),
        ("pieces.csv", ",node,Zone 1,", ",node,Höhe,", "on which it stands in a later one"),
        ("pieces.csv", ",beam,Höhe,", ",beam,Zone 1,", "a piece of a later zone before number"),
        ("survey.csv", ",Zone 1,", ",Höhe,", "in zone Höhe in survey.csv, and in zone Zone 1 in pieces.csv"),
        ("model.step", "OCCURRENCE('Höhe'", "OCCURRENCE('Zone 1'", "model.step does not have .* in zone Höhe"),
    ],
)
def test_what_disagrees_is_found(folder: Path, name: str, old: str, new: str, finding: str) -> None:
    path = folder / name
    data = path.read_bytes()
    ascii_only = str.maketrans({"ö": "\\X2\\00F6\\X0\\"}) if name == "model.step" else {}
    one, other = (text.translate(ascii_only).encode() for text in (old, new))
    assert one in data
    try:
        path.write_bytes(data.replace(one, other, 1))
        assert any(re.search(finding, sentence) for sentence in check_folder(folder, hashes=False))
    finally:
        path.write_bytes(data)


def test_a_piece_in_another_zone_is_a_difference(folder: Path, tmp_path: Path) -> None:
    zones = [{"name": "Zone 1", "faces": [0]}, {"name": "St John's", "faces": [2, 3]}, {"name": "Höhe"}]
    build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out=tmp_path / "b", zones=zones, documents=("tables",)))
    table = folder_differences(folder, tmp_path / "b")
    changed = {row[table.columns.index("Piece now")]: row[table.columns.index("Zone")] for row in table.rows}
    before, after = ({r["Piece"]: r["Zone"] for r in rows(each, "pieces")} for each in (folder, tmp_path / "b"))
    assert changed == {name: "Höhe now St John's" for name in before if before[name] != after[name]}
    assert len(changed) > 1


def test_names_like_numbers_are_names_with_decimal_commas_too(tmp_path: Path) -> None:
    own: dict[str, Any] = {"zones": [{"name": "1,5", "faces": [0]}, {"name": "2"}], "documents": ("tables", "step")}
    tables = {"separator": ";", "decimal": ","}
    build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out=tmp_path / "a", tables=tables, **own))
    assert check_folder(tmp_path / "a") == ()


def test_a_structure_without_zones_has_none() -> None:
    assembly = design(Project(mesh=dome(4, 1), mean_edge_mm=1500)).assembly
    assert set(assembly.zones.named(assembly.of(BEAM))) == {""}
    assert assembly.zones.of(assembly.of(NODE)).tolist() == [0] * 8
    assert b'"name":"beams"' in glb_bytes(assembly)

"""A second layer of beams, struts and fins: where they are, and what is refused."""

from __future__ import annotations

import re
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely

from fabkit import Project, build, design, load_project
from fabkit.checking import clashes, violations
from fabkit.errors import DetailingError, ProjectError
from fabkit.formats.finished import check_folder
from fabkit.parts import Parts
from fabkit.pipeline import Built
from fabkit.production import cut_list, piece_tables
from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.files import write_mesh
from geometry.mesh.shapes import dome

WELDED: dict[str, Any] = {
    "beams": {"section": "rhs 120x60x5"},
    "connection": {"kind": "welded", "slot_mm": 25},
    "layers": [{"joint_mm": 20, "thickness_mm": 10, "seat_mm": 5}],
}
BELOW = {"distance_mm": -600.0, "section": "rhs 100x50x4", "strut": "chs 48.3x4"}
ABOVE_GLASS = {"from_mm": 90.0, "to_mm": 350.0, "direction": [0.3, -0.2, 0.0], "gap_mm": 12.0}

EXACT_MM = 1e-9
"""Rounding of coordinates of some metres, in mm."""


@cache
def both(top: str = "enclosing", kind: str = "welded") -> Built:
    own: dict[str, Any] = {"nodes": {"top": top}, "connection": {"kind": kind}}
    section = "rhs 120x60x5" if kind == "bolted" else "rhs 100x50x4"
    fins = ABOVE_GLASS | {"from_mm": 150.0, "to_mm": 400.0}  # enclosing blocks lift the panels
    return design(project(**own, second_layer=BELOW | {"section": section}, fins=fins))


def project(**settings: Any) -> Project:
    return Project(**{"mesh": dome(8, 3), "mean_edge_mm": 2000, "nesting": {"mode": "off"}} | WELDED | settings)


def meshes(built: Built, distance: float, direction: Any = (0.0, 0.0, 0.0)) -> FloatArray:
    """(N, 3) M + d (S + x)."""
    pair = built.structure.pair
    return np.asarray(pair.mesh.vertices + distance * (pair.gauss_image.vertices + np.array(direction)))


def corners(parts: Parts[Any], k: int) -> FloatArray:
    return np.asarray(parts[k].placement.to_world(parts[k].solid.vertices))


# --- what every such structure must be


def test_beams_and_nodes_of_both_layers_are_judged_and_named() -> None:
    """With bounds that some of them reach; the lower beams are shallower, so their blocks are judged by their own
    height, and they have another connection than those above."""
    bounds = {"mitres_noted_deg": 10, "mitres_listed_deg": 20, "block_heights_noted": 1.1, "slots_noted_deg": 75}
    found = design(project(second_layer=BELOW, fitness=bounds))
    for layer, height in (("", 120.0), ("lower", 100.0)):
        own = {each.name: each for each in found.summary.fitness if each.layer == layer and each.noun != "face"}
        beams, nodes = (found.assembly[f"{layer} {group}".strip()] for group in ("beams", "nodes"))
        steep = np.abs(beams.details.cut_angles_deg).max(axis=1)
        assert set(own["mitres"].elements) == set(beams.elements[steep >= 10].tolist())
        assert beams.marks[int(steep.argmax())] in own["mitres"].sentence
        assert f" of {len(beams)} {layer} beams ".replace("  ", " ") in own["mitres"].sentence
        high = nodes.details.height_mm >= 1.1 * height
        assert high.any()
        assert set(own["block-heights"].elements) == set(nodes.elements[high].tolist())
        narrow = [each for each in own["slots"].elements if nodes.marks[int(nodes.find(np.array([each]))[0])]]
        assert len(narrow) == len(own["slots"].elements) > 0
        assert nodes.marks[int(nodes.find(np.array(narrow[:1]))[0])] in own["slots"].sentence
    touching = design(project(second_layer=BELOW | {"connection": {"kind": "contact"}}, fitness=bounds))
    assert [each.layer for each in touching.summary.fitness if each.name == "slots"] == [""]


@pytest.mark.parametrize(("top", "kind"), [("enclosing", "welded"), ("trimmed", "welded"), ("enclosing", "bolted")])
def test_all_parts_are_sound_and_none_share_volume(top: str, kind: str) -> None:
    assembly = both(top, kind).assembly
    assert violations(assembly) == ()
    assert clashes(assembly) == []
    counts = {parts.kind.group: len(parts) for parts in assembly.groups}
    for group in ("beams", "nodes"):
        assert counts[f"lower {group}"] == counts[group]
    assert counts["struts"] == counts["nodes"]
    assert counts["fins"] == counts["beams"]
    if kind == "bolted":
        assert counts["lower bolts"] == counts["bolts"] == 2 * counts["beams"]


def test_a_lower_part_that_is_moved_is_found() -> None:
    assembly = both().assembly
    lower = assembly["lower beams"]
    moved = Parts.each_its_own(
        lower.kind,
        lower.elements,
        lower.solids.take(lower.shape),
        lower.origins + np.array([0.0, 0.0, 1e-3]),
        lower.axes,
        lower.materials[0],
        lower.details,
    )
    found = violations(assembly.with_group(moved))
    assert any("lower beam" in each.finding and "facet of lower node" in each.finding for each in found)


# --- the second layer


def test_the_second_layer_stands_on_the_parallel_mesh_at_its_distance() -> None:
    built = both()
    nodes, points = built.assembly["lower nodes"], meshes(built, -600.0)
    assert np.abs(nodes.origins - points[nodes.elements]).max() < EXACT_MM
    directions = {}
    for group in ("beams", "lower beams"):
        beams = built.assembly[group]
        i, j = np.sort(beams.details.nodes, axis=1).T
        along = (points if group != "beams" else meshes(built, 0.0))[j] - points[i] * (group != "beams")
        along = along - meshes(built, 0.0)[i] * (group == "beams")
        directions[group] = along / np.linalg.norm(along, axis=1, keepdims=True)
    assert np.abs(np.cross(directions["beams"], directions["lower beams"])).max() < 1e-12
    assert {section.name for section in built.assembly["lower beams"].details.section} == {"rhs 100x50x4"}


@pytest.mark.parametrize(("top", "distance"), [("enclosing", -600.0), ("trimmed", 650.0)])
def test_struts_fill_the_gap_between_both_blocks_on_the_node_axis(top: str, distance: float) -> None:
    layer = BELOW | {"distance_mm": distance, "strut": "round 16"}
    built = design(project(nodes={"top": top}, layers=[{"joint_mm": 60, "least_bearing_mm": -60}], second_layer=layer))
    nodes, others = built.assembly["nodes"], built.assembly["lower nodes" if distance < 0 else "upper nodes"]
    inner, outer = (others, nodes) if distance < 0 else (nodes, others)
    struts, axes = built.assembly["struts"], built.structure.axes
    assert len(struts) == built.structure.mesh.n_vertices
    for k, vertex in enumerate(struts.elements.tolist()):
        axis, ends = axes[vertex], corners(struts, k)[[0, 3]]
        gaps = []
        for end, blocks, level in ((ends[0], inner, 1), (ends[1], outer, 0)):
            block = blocks[int(blocks.find(np.array(vertex)))]
            points = block.placement.to_world(block.solid.vertices)
            half = len(points) // 2
            face = points[half:] if level else points[:half]
            normal = np.cross(face[1] - face[0], face[2] - face[0])
            gaps.append(abs((end - face[0]) @ normal) / np.linalg.norm(normal))
            assert np.linalg.norm(np.cross(end - built.structure.mesh.vertices[vertex], axis)) < 1e-8  # on the axis
        assert max(gaps) < 1e-8  # on the planes of both blocks
        area = np.pi * 8.0**2
        assert struts[k].solid.volume_mm3 == pytest.approx(area * np.linalg.norm(ends[1] - ends[0]), rel=1e-12)
    tilted = struts.details.cut_angle_deg
    assert (tilted.max() > 0.1) == (top == "trimmed")


def test_tables_list_both_layers() -> None:
    built = both()
    tables = {table.title: table for table in piece_tables(built.assembly, None)}
    n_nodes = len(built.assembly["nodes"])
    assert len(tables["survey"].rows) == 2 * n_nodes
    assert {row[0].split()[0][:2] for row in tables["survey"].rows} == {"N0", "LN"}
    facets = [row for row in tables["node_facets"].rows if row[0].startswith("LN")]
    assert len(facets) == 2 * len(built.assembly["lower beams"])
    assert {row[3][:2] for row in facets} == {"LB"}
    pieces = {row[0]: row for row in tables["pieces"].rows}
    lower = [row for row in pieces.values() if row[2] == "lower beam"]
    assert all(row[5].startswith("LN") and row[7].startswith("LN") for row in lower)
    ends = [row[0] for row in cut_list(built.assembly, None)["lower beams"].rows]
    assert ends[0] == "LB001"


# --- fins


def test_fins_lie_between_the_two_meshes_and_have_their_thickness() -> None:
    built = both()
    fins = built.assembly["fins"]
    low, high = (meshes(built, d, ABOVE_GLASS["direction"]) for d in (150.0, 400.0))
    for k in range(len(fins)):
        points = corners(fins, k)
        middle = (points[:4] + points[4:]) / 2
        assert np.linalg.norm(points[4:] - points[:4], axis=1) == pytest.approx(np.full(4, 8.0), rel=1e-12)
        for pair, mesh in ((middle[:2], low), (middle[2:], high)):
            i, j = fins.details.nodes[k]
            along = (mesh[j] - mesh[i]) / np.linalg.norm(mesh[j] - mesh[i])
            assert np.abs(np.cross(pair - mesh[i], along)).max() < 1e-8  # on the line of the mesh
    areas = [shapely.Polygon(part.solid.vertices[:4, :2]).area for part in fins]
    assert fins.details.area_mm2 == pytest.approx(areas, rel=1e-12)


def test_neighbouring_fins_are_apart_by_the_gap() -> None:
    built = both()
    fins, pair = built.assembly["fins"], built.structure.pair
    axes = pair.gauss_image.vertices + np.array(ABOVE_GLASS["direction"])
    closest = []
    for vertex in range(pair.mesh.n_vertices):
        z = axes[vertex] / np.linalg.norm(axes[vertex])
        x = np.cross(z, np.eye(3)[np.abs(z).argmin()])
        plane = np.stack([x / np.linalg.norm(x), np.cross(z, x / np.linalg.norm(x))], axis=1)
        own = np.flatnonzero((fins.details.nodes == vertex).any(axis=1)).tolist()
        hulls = [shapely.MultiPoint(corners(fins, k) @ plane).convex_hull for k in own]
        closest.append(min(a.distance(b) for a, b in combinations(hulls, 2)))
    assert min(closest) >= 12.0 - 1e-8
    assert max(closest) == pytest.approx(12.0, abs=1e-8)  # the setbacks are the least ones


def test_fins_lean_towards_the_suns_for_more_shade() -> None:
    settings: dict[str, Any] = {"mesh": dome(4, 1), "mean_edge_mm": 1500}
    built = design(project(**settings, fins={"from_mm": 150, "to_mm": 300, "suns": [[180.0, 60.0]]}))
    before, after = built.summary.fin_shade
    assert before + 0.05 < after <= 1
    assert 0 < np.linalg.norm(built.summary.fin_direction) < 0.99 + 1e-9
    given = design(project(**settings, fins={"from_mm": 150, "to_mm": 300, "direction": built.summary.fin_direction}))
    assert np.abs(given.assembly["fins"].origins - built.assembly["fins"].origins).max() < EXACT_MM


def test_equal_fins_share_a_mark_also_end_for_end() -> None:
    upright = design(project(fins={"from_mm": 90, "to_mm": 300})).assembly["fins"]
    assert len(upright.mark_names) < len(upright) / 5  # a dome has eight sectors, mirrored into themselves


# --- what cannot be made


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"second_layer": {"distance_mm": 0}}, "distance_mm is 0, where the first layer is"),
        ({"second_layer": BELOW | {"strut": "rhs 50x50x4"}}, "struts are round: write one like chs 60.3x4"),
        ({"second_layer": BELOW | {"connection": {"kind": "hub"}}}, "in the second layer, beams on hubs are flats or"),
        ({"second_layer": BELOW | {"material": "steal"}}, "second_layer.material is 'steal'"),
        ({"fins": {"from_mm": 80, "to_mm": 80}}, "fins from 80 to 80 mm have no height"),
        ({"fins": {"from_mm": 80}}, "to_mm is missing"),
        ({"fins": {"from_mm": 80, "to_mm": 90, "thikness_mm": 5}}, "unknown key .* did you mean thickness_mm"),
        ({"fins": {"from_mm": 80, "to_mm": 90, "suns": [[10]]}}, "sun 0 has 1 numbers"),
        (
            {"fins": {"from_mm": 80, "to_mm": 90, "suns": [[10, -5]]}},
            "sun 0, \\[10.0, -5.0\\], is not above the horizon",
        ),
        (
            {"fins": {"from_mm": 80, "to_mm": 90, "suns": [[10, 5]], "direction": [0.1, 0, 0]}},
            "direction and suns are both given",
        ),
        ({"fins": {"from_mm": 80, "to_mm": 90, "material": "wood"}}, "fins.material is 'wood'"),
    ],
)
def test_what_no_project_may_say(settings: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence):
        project(**settings)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"second_layer": BELOW | {"distance_mm": -120}}, "too near to each other.*distance_mm to -[0-9.]+ or further"),
        ({"second_layer": BELOW | {"distance_mm": -90000}}, "turned inside out: edge [0-9]+ .* has no length at -"),
        (
            {"second_layer": BELOW | {"distance_mm": 700}},
            "strut at vertex .* share volume.*thinner section for second_la.* another z_mm or a wider joint_mm",
        ),
        (
            {"second_layer": BELOW, "layers": [{}, {"z_mm": -650, "thickness_mm": 8}]},
            "in layer 1 and the lower beam on edge .* share volume.* another z_mm",
        ),
        ({"second_layer": BELOW | {"distance_mm": -2950}}, "in the lower layer the beam on edge .* "),
        ({"fins": {"from_mm": 30, "to_mm": 300}}, "fin on edge .* mm, and 10 mm must be clear: set fins.from_mm to"),
        ({"fins": {"from_mm": -150, "to_mm": -20}}, "and the fin on edge 0 share volume, .*: move the fins by"),
        (
            {"fins": {"from_mm": -5e3, "to_mm": 300}},
            "at fins.from_mm = -5000 some fins have turned inside out: set it be",
        ),
        ({"fins": {"from_mm": 90, "to_mm": 300, "least_length_mm": 1900}}, "fins cannot be built: the fin on edge"),
        ({"fins": {"from_mm": 90, "to_mm": 300, "direction": [5, 0, 0]}}, "fins at vertex .* would lie behind face"),
        ({"fins": {"from_mm": -90, "to_mm": -30, "suns": [[180, 45]]}}, "cast no shadow"),
    ],
)
def test_what_cannot_be_made_is_one_sentence_and_nothing_is_written(
    settings: dict[str, Any], sentence: str, tmp_path: Path
) -> None:
    with pytest.raises((DetailingError, GeometryError), match=sentence) as caught:
        build(project(**settings, out=tmp_path / "roof"))
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_the_least_distances_that_are_told_will_do() -> None:
    def told(settings: dict[str, Any], words: str) -> float:
        with pytest.raises(DetailingError) as caught:
            design(project(**settings))
        return float(str(caught.value).split(words)[1].split()[0])

    near = {"distance_mm": -120.0}
    least = told({"second_layer": BELOW | near}, "second_layer.distance_mm to")
    struts = design(project(second_layer=BELOW | {"distance_mm": least})).assembly["struts"]
    assert 20 <= struts.details.length_mm.min() < 20.2  # least_strut_mm, and a rounding to 0.1 mm
    begin = told({"fins": {"from_mm": 30, "to_mm": 300}}, "fins.from_mm to")
    assert len(design(project(fins={"from_mm": begin, "to_mm": 300})).assembly["fins"])


def test_what_cannot_be_built_is_left_out_where_asked() -> None:
    built = design(project(skip_unbuildable=True, fins={"from_mm": 90, "to_mm": 300, "least_length_mm": 1900}))
    left = [each for each in built.assembly.left_out if each.kind == "fin"]
    assert len(left) + len(built.assembly["fins"]) == len(built.assembly["beams"])
    assert 0 < len(left) < len(built.assembly["beams"])


def test_a_project_file_alone_builds_all_of_it(tmp_path: Path) -> None:
    write_mesh(tmp_path / "roof.obj", dome(6, 2))
    (tmp_path / "roof.toml").write_text(
        'mesh = "roof.obj"\nmean_edge_mm = 2000\nout = "roof"\n'
        '[beams]\nsection = "rhs 120x60x5"\n[connection]\nkind = "welded"\n[[layers]]\njoint_mm = 20\n'
        '[second_layer]\ndistance_mm = -600\nstrut = "chs 48.3x4"\n[fins]\nfrom_mm = 150\nto_mm = 400\n'
    )
    built = build(load_project(tmp_path / "roof.toml", {}))
    assert list(check_folder(tmp_path / "roof")) == []
    for fin in built.assembly["fins"].mark_names:
        assert (tmp_path / "roof" / "panels" / f"{fin}.dxf").exists()
    step = (tmp_path / "roof" / "model.step").read_text()
    for group in ("lower beams", "lower nodes", "struts", "fins"):
        assert f"'{group}'" in step
        assert (tmp_path / "roof" / f"{group.replace(' ', '_')}.csv").exists()
        assert len(built.assembly[group])
    assert not [path for path in (tmp_path / "roof").rglob("*") if " " in path.name]
    table = tmp_path / "roof" / "lower_beams.csv"
    table.write_text(re.sub(r"^(LB001),(\d+)", r"\1,1\2", table.read_text(), flags=re.MULTILINE))
    assert any("lower_beams.csv has 1" in sentence for sentence in check_folder(tmp_path / "roof", hashes=False))


def test_a_support_that_meets_lower_beams_is_left_out_rather_than_they() -> None:
    thick = {"loop": "rim", "stub": "chs 168.3x5", "plate_mm": 300}
    with pytest.raises(DetailingError, match=r"lower beam on edge \d+ and the stub .* share volume.* a longer stub"):
        design(project(second_layer=BELOW, supports=thick))
    made = design(project(second_layer=BELOW, supports=thick, skip_unbuildable=True)).assembly
    assert len(made["lower beams"]) == len(made["beams"])
    assert {part.kind for part in made.left_out} <= {"stub", "base plate"}
    assert made.left_out

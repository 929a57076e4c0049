"""Panels in several layers: what tells them apart in names, tables, drawings and nests."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabkit import Built, Project, design
from fabkit.checking import violations
from fabkit.detailing import detail
from fabkit.errors import DetailingError, ProjectError
from fabkit.kinds import PANEL, PanelDetails, neighbour_names
from fabkit.parts import Assembly, Frame, Part, Parts
from fabkit.production import panel_drawings, piece_tables, share_equal_parts
from fabkit.project import load_project
from fabkit.rules import DetailingRules, LayerRules
from geometry import ParallelSpace
from geometry.arrays import FloatArray
from geometry.files import write_mesh
from geometry.gauss import Pair, SupportStructure
from geometry.mesh import Mesh
from geometry.mesh.shapes import dome

SIZES: dict[str, Any] = {"layers": [{"thickness_mm": 10, "joint_mm": 10}]}


@pytest.fixture(scope="module")
def built() -> Built:
    return design(Project(mesh=dome(4, 1), mean_edge_mm=1500, **SIZES))


@pytest.fixture(scope="module")
def doubled(built: Built) -> Assembly:
    """The assembly with each panel once more, 50 mm higher, as layer 1; but for the first one."""
    panels = list(built.assembly["panels"])
    again = [
        replace(
            part,
            mark=f"{part.mark}a",
            placement=Frame(part.placement.origin + 50 * part.placement.axes[2], part.placement.axes),
            details=replace(part.details, layer=np.int64(1)),
        )
        for part in panels[1:]
    ]
    return built.assembly.with_group(Parts.of(PANEL, [*panels, *again]))


def test_each_panel_has_the_neighbours_of_its_own_layer(doubled: Assembly) -> None:
    panels, n = doubled["panels"], len(doubled["panels"])
    names = neighbour_names(panels, [str(k) for k in range(n)], "left out", "-")
    row, across, layer = panels.details.neighbours.row, panels.details.neighbours.values, panels.details.layer
    assert {"left out"} == {name for k, name in enumerate(names) if layer[row[k]] == 1 and across[k] == 0}
    for k, name in enumerate(names):
        if name.isdigit():
            assert panels.elements[int(name)] == across[k]
            assert layer[int(name)] == layer[row[k]]


def test_equal_panels_of_two_layers_are_one_mark_with_names_of_their_own(doubled: Assembly) -> None:
    shared = share_equal_parts(doubled)
    panels = shared["panels"]
    assert len(set(panels.piece_names)) == len(panels) == 7
    assert "P001 f1.2" in panels.piece_names
    assert [drawing.name for drawing in panel_drawings(shared)] == list(panels.mark_names)
    edges = next(table for table in piece_tables(shared, None) if table.title == "panel_edges")
    own = {row[0]: row[-1] for row in edges.rows if row[-1]}
    assert own["P001 f2.2"].endswith(".2")
    assert not own["P001 f2"].endswith(".2")


def test_a_panel_that_a_layer_has_twice_is_named(doubled: Assembly) -> None:
    panels = doubled["panels"]
    twice = replace(panels, details=replace(panels.details, layer=np.zeros(len(panels), dtype=np.int64)))
    assert [each.finding for each in violations(doubled)] == []
    assert {each.finding for each in violations(doubled.with_group(twice))} == {
        f"face {face} has 2 panels, allowed 1" for face in (1, 2, 3)
    }


# --- layers that a project asks for

SHOP: dict[str, Any] = {
    "beams": {"section": "rhs 120x60x5"},
    "connection": {"kind": "welded"},
    "nodes": {"top": "trimmed"},
}
TWO: list[dict[str, Any]] = [
    {"build_up": "8/16Ar/44.2", "edges": "mitred"},
    {"thickness_mm": 12, "z_mm": -250, "joint_mm": 10},
]


def layered(layers: Any, **more: Any) -> Built:
    return design(Project(mesh=dome(6, 2), mean_edge_mm=1500, layers=layers, **{**SHOP, **more}))


@pytest.fixture(scope="module")
def two() -> Built:
    return layered(TWO)


def of_pane(built: Built, layer: int, pane: int = 0) -> Parts[PanelDetails]:
    panels = built.assembly["panels"]
    return panels.take((panels.details.layer == layer) & (panels.details.pane == pane))


def placed(panels: Parts[PanelDetails]) -> list[FloatArray]:
    """Corners of each panel, those of the lower side first."""
    return [part.placement.to_world(part.solid.vertices) for part in panels]


def test_layers_lie_where_the_project_says(two: Built) -> None:
    """Levels are measured on the placed solids, against the planes of the mesh."""
    mesh = two.structure.mesh
    at = mesh.vertices[mesh.combinatorics.corners[mesh.combinatorics.face_starts[:-1]]]
    lift = two.summary.underside_mm
    for (layer, pane), low, high in (
        ((0, 0), lift + 24.76, lift + 32.76),
        ((0, 1), lift, lift + 8.76),
        ((1, 0), -250.0, -238.0),
    ):
        panels = of_pane(two, layer, pane)
        for face, corners in zip(panels.elements, placed(panels), strict=True):
            levels = (corners - at[face]) @ mesh.face_normals[face]
            n = len(levels) // 2
            assert np.abs(levels[:n] - low).max() < 1e-9  # of coordinates of 3 m
            assert np.abs(levels[n:] - high).max() < 1e-9
        assert np.abs(np.einsum("fk,fk->f", panels.axes[:, 2], mesh.face_normals[panels.elements]) - 1).max() < 1e-12
    assert np.array_equal(of_pane(two, 0).axes[:, 2], of_pane(two, 1).axes[:, 2])


def test_a_layer_on_a_parallel_mesh_lies_in_its_faces() -> None:
    built = layered([{"thickness_mm": 8, "distance_mm": 200}, {}])
    offset = built.structure.pair.offset_mesh(200.0)
    c = offset.combinatorics
    for face, corners in zip(of_pane(built, 0).elements, placed(of_pane(built, 0)), strict=True):
        at = offset.vertices[c.corners[c.face_starts[face]]]
        lower = corners[: len(corners) // 2]
        assert np.abs((lower - at) @ offset.face_normals[face]).max() < 1e-9


def test_masses_are_those_of_plies_and_foils(two: Built) -> None:
    inner = of_pane(two, 0, 1)
    volume = inner.volumes_mm3.sum() * 1e-9
    assert inner.masses_kg.sum() == pytest.approx(volume * (8 * 2500 + 0.76 * 1070) / 8.76, rel=1e-12)
    assert {part.material.name for part in inner} == {"glass 44.2"}
    assert {part.material.name for part in of_pane(two, 0)} == {"glass"}


def test_joints_between_mitred_panels_are_constant_through_the_thickness(two: Built) -> None:
    """Both long sides of each edge lie 10 mm from the central plane of its beam."""
    structure = two.structure
    for panels in (of_pane(two, 0), of_pane(two, 0, 1)):
        for details, corners in zip((part.details for part in panels), placed(panels), strict=True):
            n = len(corners) // 2
            for k, edge in enumerate(details.beams.tolist()):
                start = structure.mesh.vertices[structure.mesh.combinatorics.edges[edge, 0]]
                ends = corners[[k, (k + 1) % n, n + k, n + (k + 1) % n]] - start
                away = np.abs(ends @ structure.width_directions[edge])
                assert np.abs(away - 10.0).max() < 1e-9


def test_seats_and_steps_agree_with_the_solids() -> None:
    """The free height under each panel, above the corners of the top of each beam and of the rim of the panel itself;
    the step where the planes of two outer sides cut the central plane of their beam."""
    built = layered([{"lift": "each"}])
    structure, panels = built.structure, built.assembly["panels"]
    mesh, half = structure.mesh, 30.0
    for part in panels:
        normal = mesh.face_normals[part.element]
        level = part.details.underside_mm
        own, middle = part.details, part.placement.to_world(part.solid.vertices).mean(axis=0)
        for k, edge in enumerate(own.beams.tolist()):
            u, b = structure.height_directions[edge], structure.width_directions[edge]
            inwards = b * np.sign(b @ (middle - mesh.vertices[mesh.combinatorics.edges[edge, 0]]))
            free = [level - y * (inwards @ normal) for y in (half, _rim(part, k, structure, edge, inwards))]
            assert own.largest_seats_mm[k] == pytest.approx(max(free), abs=1e-9)
            assert own.least_seats_mm[k] <= min(free) + 1e-9
            across = own.neighbours[k]
            if across >= 0:
                other = panels[int(panels.find(np.array(across)))].details.underside_mm + 8.76
                heights = other / (u @ mesh.face_normals[across]), (level + 8.76) / (u @ normal)
                assert own.steps_mm[k] == pytest.approx(heights[0] - heights[1], abs=1e-9)
    assert np.nanmin(panels.details.least_seats_mm.values) == pytest.approx(12.0)
    assert np.nanmax(np.abs(panels.details.steps_mm.values)) > 1.0


def _rim(part: Part, k: int, structure: SupportStructure, edge: int, inwards: FloatArray) -> float:
    """Distance of edge k of the lower side of a panel from the central plane of the beam."""
    corner = part.placement.to_world(part.solid.vertices)[k]
    start = structure.mesh.vertices[structure.mesh.combinatorics.edges[edge, 0]]
    return float((corner - start) @ inwards)


def test_rim_edges_are_stepped() -> None:
    plain, stepped = (layered([{"rim_step_mm": step, "least_bearing_mm": -50}]) for step in (0.0, 15.0))
    for one, other in zip(plain.assembly["panels"], stepped.assembly["panels"], strict=True):
        at_rim = (one.details.neighbours < 0).any()
        assert (other.solid.volume_mm3 < one.solid.volume_mm3 - 1.0) == at_rim


def test_a_layer_may_lie_in_any_parallel_mesh(tmp_path: Path) -> None:
    mesh = dome(6, 2)
    element = ParallelSpace(mesh).elements(3, seed=1)[1]
    varied = mesh.with_vertices(1.06 * mesh.vertices + 0.02 * element.vertices / np.abs(element.vertices).max())
    write_mesh(tmp_path / "ceiling.obj", varied)
    built = layered([{"thickness_mm": 8, "parallel": tmp_path / "ceiling.obj"}, {}])
    scale, c = built.summary.scale_mm, mesh.combinatorics
    outer = of_pane(built, 0)
    assert np.ptp(outer.details.underside_mm) > 1.0
    for face, corners in zip(outer.elements, placed(outer), strict=True):
        lower = corners[: len(corners) // 2]
        at = varied.vertices[c.corners[c.face_starts[face]]] * scale
        assert np.abs((lower - at) @ varied.face_normals[face]).max() < 1e-6  # of a file with 16 digits, projected
    write_mesh(tmp_path / "other.obj", mesh.with_vertices(varied.vertices + 0.05 * np.sin(9 * varied.vertices)))
    with pytest.raises(ProjectError, match=r"layer 0 .* other.obj is not parallel to the mesh: its vertex"):
        layered([{"thickness_mm": 8, "parallel": tmp_path / "other.obj"}, {}])


@pytest.mark.parametrize(
    ("layers", "sentence"),
    [
        ([{"z_mm": 30}, {}], "layers 0 and 1 cross on 12 of 12 faces: on face"),
        ([{}, {"thickness_mm": 8, "z_mm": 200}], "layers 0 and 1 cross"),
        ([{}, {"z_mm": -60}], "in layer 1 share volume.* another z_mm or a wider joint_mm"),
        ([{}, {}], "layers 0 and 1 .* all lie at the lift"),
        ([], "layers is empty"),
        ([{"build_up": "8/16Xe/44.2"}], "XE is no gas.* write 8/16Ar/44.2"),
        ([{"build_up": "8", "thickness_mm": 8}], "take out one of the two"),
        ([{"thickness_mm": -8}], "thickness_mm is -8: input should be greater than 0"),
        ([{"z_mm": 40, "distance_mm": 40}], "z_mm and distance_mm are given"),
        ([{"z_mm": 40, "lift": "each"}], "lift is 'each', but z_mm says where"),
        ([{"material": "clay"}], "a layer of 'clay' needs its thickness_mm"),
        ([{"thickness_mm": 8, "material": "clay"}], "layers.0.material is 'clay', but densities_kg_m3 has only"),
        ([{"joint_mm": 3000}], "vanishes when cut back"),
    ],
)
def test_layers_that_cannot_be_made_get_one_sentence(layers: list[dict[str, Any]], sentence: str) -> None:
    with pytest.raises((ProjectError, DetailingError), match=sentence):
        layered(layers)


def test_concave_panels_are_not_mitred() -> None:
    corners = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2), (2, 2)]
    flat = Mesh.from_faces([(x - 1.0, y - 1.0, 1.0) for x, y in corners], [[0, 1, 2, 3, 4, 5], [3, 2, 6, 4]])
    structure = SupportStructure(Pair(flat * 1500, flat), 120.0)
    rules = DetailingRules(layers=(LayerRules(edges="mitred"),))
    with pytest.raises(DetailingError, match="face 0 is not convex, and its edges cannot be mitred"):
        detail(structure, rules, name="corner")


def test_panels_is_refused_with_its_new_spelling(tmp_path: Path) -> None:
    path = tmp_path / "old.toml"
    path.write_text('mesh = "roof.obj"\nunit = "m"\n[panels]\njoint_mm = 8\n')
    with pytest.raises(ProjectError, match=r"\[panels\] is now \[\[layers\]\]"):
        load_project(path, {})


def test_options_set_the_outermost_layer(tmp_path: Path) -> None:
    path = tmp_path / "roof.toml"
    path.write_text(
        'mesh = "roof.obj"\nunit = "m"\n[[layers]]\nbuild_up = "44.2"\njoint_mm = 8\n[[layers]]\nz_mm = -300\n'
    )
    layers = load_project(path, {"layers": [{"thickness_mm": 10, "z_mm": 40}]}).layers
    assert [(layer.thickness_mm, layer.build_up, layer.z_mm, layer.joint_mm) for layer in layers] == [
        (10.0, None, 40.0, 8.0),
        (None, "44.2", -300.0, 20.0),
    ]


def test_practice_is_told() -> None:
    bounds = {"corners_noted_deg": 80, "short_edges_noted_mm": 1500, "panel_masses_noted_kg": 40}
    found = {each.name: each for each in layered([{}], fitness=bounds).summary.fitness}
    assert found["corners"].value == pytest.approx(63.67, abs=0.01)  # of the triangles at the top
    assert found["short-edges"].value < 1500
    assert found["panel-masses"].value > 40
    assert not {"corners", "short-edges", "panel-masses"} & {each.name for each in layered([{}]).summary.fitness}

"""Supports: stubs from the bottoms of nodes to base plates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabkit import FabkitError, Project, build, design
from fabkit.checking import clashes
from fabkit.errors import DetailingError, ProjectError
from fabkit.kinds import BASE_PLATE, NODE, STUB
from fabkit.parts import BORE, Assembly
from fabkit.production import erection_order, piece_tables
from geometry.mesh import Mesh
from geometry.mesh.shapes import dome
from tests.fabkit.occt import HAS_KERNEL, read_step

SIZES: dict[str, Any] = {
    "beams": {"section": "rhs 120x60x5"},
    "connection": {"kind": "welded"},
    "nodes": {"top": "enclosing"},
    "nesting": {"mode": "off"},
}


LOWER, UPPER = sorted(map(sorted, map(np.ndarray.tolist, dome(6, 2).combinatorics.boundary_loops)))
"""Vertices of its two boundary loops."""


def project(mesh: Mesh | None = None, **supports: Any) -> Project:
    return Project(mesh=mesh or dome(6, 2), mean_edge_mm=1500, supports=supports, **SIZES)


@pytest.fixture(scope="module")
def rim() -> Assembly:
    return design(project(loop="rim", length_mm=160)).assembly


def test_each_node_of_the_rim_has_a_stub_and_a_plate(rim: Assembly) -> None:
    stubs, plates = rim.of(STUB), rim.of(BASE_PLATE)
    assert stubs.elements.tolist() == plates.elements.tolist() == sorted(LOWER + UPPER)
    assert clashes(rim) == []
    assert [len(group.mark_names) for group in (plates, stubs)] == [1, 2]


@pytest.mark.parametrize(("distance", "name"), [(-700.0, "lower node"), (700.0, "node")])
def test_supports_stand_under_the_inner_layer(distance: float, name: str) -> None:
    both = Project(
        mesh=dome(6, 2),
        mean_edge_mm=2500,
        supports={"vertices": LOWER, "length_mm": 200},
        second_layer={"distance_mm": distance},
        layers=[{"joint_mm": 140, "least_bearing_mm": -60}],
        **SIZES,
    )
    assembly = design(both).assembly
    stubs = assembly.of(STUB)
    (nodes,) = (group for group in assembly.groups if group.kind.name == name)
    own = nodes.find(stubs.elements)
    bottoms = nodes.solids.vertices.with_values(nodes.solids.vertices.values[:, 2])[nodes.shape].reduced(np.minimum)
    middles = nodes.origins[own] + bottoms[own, None] * nodes.axes[own, 2]
    assert stubs.elements.tolist() == LOWER
    assert np.abs(np.linalg.norm(stubs.origins - middles, axis=1) - 48.3 / 2).max() < 1e-6  # beside the axis, by half
    assert clashes(assembly) == []


def test_plates_are_level_up_to_60_degrees_and_square_to_the_axis_beyond(rim: Assembly) -> None:
    plates, nodes = rim.of(BASE_PLATE), rim.of(NODE)
    axes = nodes.axes[nodes.find(plates.elements), 2]
    upright = axes[:, 2] > 0.5
    assert 0 < upright.sum() < len(plates)
    assert np.abs(plates.axes[upright, 2] - [0, 0, 1]).max() == 0
    assert np.abs(plates.axes[~upright, 2] - axes[~upright]).max() == 0
    middles = plates.origins + 15 * plates.axes[:, 2]
    from_node = middles - nodes.origins[nodes.find(plates.elements)]
    assert np.linalg.norm(np.cross(from_node, axes), axis=1).max() < 1e-9


def test_stubs_touch_node_and_plate(rim: Assembly) -> None:
    stubs, plates, nodes = rim.of(STUB), rim.of(BASE_PLATE), rim.of(NODE)
    for k, stub in enumerate(stubs):
        world = stub.placement.to_world(stub.solid.vertices)
        in_plate = (world - plates.origins[k]) @ plates.axes[k].T
        assert np.abs(in_plate[4:, 2] - 15).max() < 1e-9 or np.abs(in_plate[[2, 3, 6, 7], 2] - 15).max() < 1e-9
        assert np.abs(in_plate[:, :2]).max() < 100
        node = nodes[int(nodes.find(np.array([stub.element]))[0])]
        bottom = node.solid.vertices[:, 2].min()
        levels = (world - node.placement.origin) @ node.placement.axes[2]
        assert levels.max() == pytest.approx(bottom, abs=1e-9)


def test_volumes_are_those_of_tubes_and_plates_with_holes(rim: Assembly) -> None:
    tube = np.pi * (24.15**2 - 19.15**2) * 160
    assert rim.of(STUB).volumes_mm3 == pytest.approx(tube, rel=1e-12)
    plate = 15 * (200**2 - 4 * np.pi * 9**2)
    assert rim.of(BASE_PLATE).volumes_mm3 == pytest.approx(plate, rel=1e-12)
    bores = rim.of(BASE_PLATE)[0].solid
    centres = bores.vertices[bores.topology.rounds[:, 0]]
    assert (bores.topology.rounds[:, 6] == BORE).all()
    assert sorted(map(tuple, centres[:, :2].tolist())) == [(-60, -60), (-60, 60), (60, -60), (60, 60)]


def test_nodes_are_chosen_by_number_height_and_loop() -> None:
    mesh = dome(6, 2) * 3000
    low = mesh.vertices[:, 2].min()
    lowest = np.flatnonzero(mesh.vertices[:, 2] < low + 1).tolist()
    mesh = mesh.with_vertices(mesh.vertices + np.array([7e6, 3e6, 400.0 - low]))
    own = {"mesh": mesh, "unit": "mm", **SIZES}

    def chosen(**supports: Any) -> list[int]:
        return design(Project(supports=supports, **own)).assembly.of(STUB).elements.tolist()

    assert chosen(below_mm=401) == lowest
    assert chosen(vertices=[4, 1], below_mm=401) == sorted({1, 4, *lowest})
    assert sorted([chosen(loop=0), chosen(loop=1)]) == [LOWER, UPPER]
    assert chosen(vertices=[8], stub="rhs 60x40x4") == [8]


def test_it_goes_up_from_its_supports_and_their_places_are_listed() -> None:
    built = design(project(vertices=[13, 15]))
    erection = erection_order(built.assembly)
    assert erection.n_fixed == 2
    assert erection.numbers["base plates"].tolist() == erection.numbers["stubs"].tolist() == [1, 2]
    assert min(erection.numbers["nodes"]) == 3
    (table,) = (each for each in piece_tables(built.assembly, None) if each.title == "supports")
    assert [row[0].split()[1] for row in table.rows] == ["v13", "v15"]
    plates = built.assembly.of(BASE_PLATE)
    places = [row[4:7] for row in table.rows]
    assert np.allclose(np.array(places, dtype=float), plates.origins + built.assembly.origin_mm, atol=1e-9)


@pytest.mark.parametrize(
    ("supports", "sentence"),
    [
        ({}, "supports are nowhere: choose nodes by vertices"),
        ({"vertices": [18]}, "vertex 18, at which there is no node: vertices are counted from 0 to 17"),
        ({"vertices": [-1]}, "greater than or equal to 0"),
        ({"loop": 2}, r"supports.loop is 2, .* the mesh has 2 boundary loops"),
        ({"loop": "edge"}, "a boundary loop is a number, counted from 0, or 'rim'"),
        ({"below_mm": -1e6}, r"chooses no vertex: the lowest one is \d+\.\d mm above it"),
        ({"loop": "rim", "stub": "tee 80x80x6x6"}, "stubs are closed"),
        ({"loop": "rim", "stub": "chs 48x30"}, "leaves nothing of the hollow inside"),
        ({"loop": "rim", "length_mm": 15}, r"would be .* mm long on its short side, .* supports.length_mm to \d+"),
        ({"loop": "rim", "plate_mm": 90}, "are under the stub"),
        ({"loop": "rim", "hole_edge_mm": 20}, "at least 21.6 mm from the axis of a hole of 18 mm"),
        ({"loop": "rim", "stub": "chs 168.3x5", "plate_mm": 300}, r"stub .* share volume, .* take a longer stub"),
        ({"loop": "rim", "material": "gold"}, "supports.material is 'gold', but densities_kg_m3 has only"),
    ],
)
def test_what_cannot_be_is_one_sentence_and_nothing_is_written(
    supports: dict[str, Any], sentence: str, tmp_path: Path
) -> None:
    with pytest.raises((ProjectError, DetailingError), match=sentence) as error:
        build(Project(mesh=dome(6, 2), mean_edge_mm=1500, supports=supports, out=tmp_path / "out", **SIZES))
    assert "\n" not in str(error.value)
    assert list(tmp_path.iterdir()) == []


def test_a_cure_is_a_cure() -> None:
    with pytest.raises(FabkitError, match=r"supports.length_mm to \d+ or more") as error:
        design(project(loop="rim", length_mm=15))
    longer = float(str(error.value).split("length_mm to ")[1].split()[0])
    with pytest.raises(DetailingError, match="take a longer stub"):  # between the two plates and a beam, no longer cut
        design(project(loop="rim", length_mm=longer))


@pytest.mark.kernel
@pytest.mark.skipif(not HAS_KERNEL, reason="neither build123d nor CadQuery is here")
@pytest.mark.parametrize("stub", ["chs 48.3x5", "rhs 60x40x4"])
def test_plates_and_stubs_are_valid_in_the_kernel(stub: str, tmp_path: Path) -> None:
    given = project(loop="rim", stub=stub)
    built = build(given.model_copy(update={"out": tmp_path / "out", "documents": ("step", "tables")}))
    leaves = [leaf for leaf in read_step(tmp_path / "out" / "model.step") if leaf.path[1] in ("stubs", "base plates")]
    volumes = [part.solid.volume_mm3 for kind in (BASE_PLATE, STUB) for part in built.assembly.of(kind)]
    assert len(leaves) == len(volumes) == 24
    assert all(leaf.body.valid and leaf.body.closed for leaf in leaves)
    assert [leaf.body.volume for leaf in leaves] == pytest.approx(volumes, rel=1e-9)

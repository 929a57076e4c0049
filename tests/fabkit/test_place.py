"""Where a mesh lies does not matter: the same parts to the last bit, and one placement that says where they stand."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from fabkit import Built, Project, build, design
from fabkit.commands.inspection import inspect_mesh, inspect_pair
from fabkit.designs import cmc_design, cmc_near_design, hexagons_design, write_design
from fabkit.formats.gltf import glb_bytes
from fabkit.formats.kernels import to_build123d, to_cadquery
from fabkit.formats.step.files import write_step
from geometry.arrays import FloatArray
from geometry.files import read_mesh, read_mesh_pair, write_mesh
from geometry.mesh import Mesh, shapes
from tests.fabkit.edge_offsets import revolved_pair
from tests.fabkit.gridshell import gridshell
from tests.fabkit.occt import HAS_KERNEL, measure, read_step, solids_in
from tests.fabkit.part21 import coordinates, written

FAR = np.array([2_600_000.0, -5_000_000.0, 1234.0])
PLACES = {"near": np.zeros(3), "far": FAR}
COARSE_MM = 1000 * np.spacing(5e6)
"""The distance of neighbouring doubles of coordinates in metres: what a copy at FAR does not tell."""


def dyadic(mesh: Mesh) -> Mesh:
    """With coordinates that are multiples of 2^-24: at FAR they are still doubles."""
    return mesh.with_vertices(np.round(mesh.vertices * 2.0**24) / 2.0**24)


def rough_dome() -> Mesh:
    """Of radius 4, off any symmetry; its faces are planar to a thousandth of an edge."""
    dome = shapes.dome(8, 3)
    noise = np.random.default_rng(3).uniform(-0.005, 0.005, dome.vertices.shape)
    return dyadic(dome.with_vertices(4 * dome.vertices + noise))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Built]]:
    """The same dome near and far, in folders of their own."""
    results = {}
    for place, move in PLACES.items():
        folder = tmp_path_factory.mktemp(place)
        write_mesh(folder / "dome.obj", rough_dome().translated(move))
        results[place] = (
            folder / "out",
            build(Project(mesh=folder / "dome.obj", unit="m", out=folder / "out")),
        )
    return results


def test_copies_moved_by_whole_numbers_give_the_same_files(made: dict[str, tuple[Path, Built]]) -> None:
    """But for those that say where the structure stands."""
    near, far = (made[place][0] for place in PLACES)
    names = {path.relative_to(near) for path in near.rglob("*") if path.is_file()}
    assert names == {path.relative_to(far) for path in far.rglob("*") if path.is_file()}
    different = {str(name) for name in names if (near / name).read_bytes() != (far / name).read_bytes()}
    places = {"placements.csv", "survey.csv"}
    assert different == {"M.obj", "model.step", "model.glb", "report.html", "cutlist.xlsx", "manifest.json"} | places
    lines = [(folder / "model.step").read_text().splitlines() for folder in (near, far)]
    changed = [pair for pair in zip(*lines, strict=True) if pair[0] != pair[1]]
    assert len(changed) == 1
    assert "CARTESIAN_POINT" in changed[0][0]


def test_copies_moved_by_whole_numbers_give_the_same_parts(made: dict[str, tuple[Path, Built]]) -> None:
    near, far = (made[place][1] for place in PLACES)
    np.testing.assert_array_equal(far.structure.mesh.vertices, near.structure.mesh.vertices)
    np.testing.assert_array_equal(far.structure.axes, near.structure.axes)
    for a, b in zip(near.assembly.parts(), far.assembly.parts(), strict=True):
        assert a.mark == b.mark
        np.testing.assert_array_equal(a.solid.vertices, b.solid.vertices)
        np.testing.assert_array_equal(a.placement.origin, b.placement.origin)
        np.testing.assert_array_equal(a.placement.axes, b.placement.axes)
    np.testing.assert_array_equal(far.assembly.origin_mm, near.assembly.origin_mm + 1000 * FAR)


def test_other_copies_differ_by_the_rounding_of_their_coordinates(made: dict[str, tuple[Path, Built]]) -> None:
    far = rough_dome().translated(FAR + np.array([0.1, 0.2, 0.3]))
    folder = made["far"][0].parent
    write_mesh(folder / "odd.obj", far)
    odd, near = design(Project(mesh=folder / "odd.obj", unit="m", nesting={"mode": "off"})), made["near"][1]
    for a, b in zip(near.assembly.parts(), odd.assembly.parts(), strict=True):
        assert np.abs(a.solid.vertices - b.solid.vertices).max() < 300 * COARSE_MM
    axes = np.abs(near.structure.axes - odd.structure.axes).max()
    assert axes < 300 * COARSE_MM / near.structure.mesh.mean_edge_length


def test_every_document_names_the_origin(made: dict[str, tuple[Path, Built]]) -> None:
    out, _ = made["far"]
    manifest = json.loads((out / "manifest.json").read_text())
    zero = [2_600_000.0, -5_000_000.0, 1236.0]
    assert manifest["origin"] == {"unit": zero, "mm": [1000 * each for each in zero]}
    assert "2600000, -5000000, 1236 in the unit of the mesh file" in (out / "report.html").read_text(encoding="utf-8")


def test_the_model_is_put_back_on_the_mesh_of_the_file(made: dict[str, tuple[Path, Built]]) -> None:
    out, built = made["far"]
    scene = trimesh.load_scene(io.BytesIO((out / "model.glb").read_bytes()), file_type="glb")
    mesh = read_mesh(out.parent / "dome.obj").mesh.vertices
    nodes = [name for name in scene.graph.nodes_geometry if name.startswith("N")]
    centres = np.array([scene.graph[name][0][:3, 3] for name in nodes])[:, [0, 2, 1]] * [1, -1, 1]
    apart = np.linalg.norm(centres[:, None] - mesh, axis=2).min(axis=1)
    assert apart.max() * 1000 < built.summary.largest_move_mm + 2 * COARSE_MM


# --- what says where it is, kind by kind


def placed(origin_mm: FloatArray = 1000 * FAR) -> Any:
    return replace(gridshell(3, 2), origin_mm=origin_mm)


def test_step_has_one_placement_for_the_structure() -> None:
    file = written(placed())
    far = [
        n for n, each in file.instances.items() if each.kind == "CARTESIAN_POINT" and np.abs(each.values[1]).max() > 1e6
    ]
    assert [coordinates(file, n).tolist() for n in far] == [(1000 * FAR).tolist()]
    (at,) = (n for n, each in file.instances.items() if each.kind == "AXIS2_PLACEMENT_3D" and each.values[1] == far[0])
    groups = 0
    for each in file.all("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
        leaves = dict(file[each.values[0]].values)
        end = file[leaves["REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"][0]].values[3]
        assert end in file[leaves["REPRESENTATION_RELATIONSHIP"][3]].values[1]
        groups += end == at
    assert groups == 3


def test_glb_has_it_on_its_root_alone_and_in_all_digits() -> None:
    origin = 1000 * FAR + [0.125, 0.25, 1e-6]
    near, far = (_document(glb_bytes(placed(each))) for each in (np.zeros(3), origin))
    x, y, z = origin / 1000
    assert far["nodes"][0].pop("translation") == [x, z, -y]
    assert "translation" not in near["nodes"][0]
    assert far == near


def _document(glb: bytes) -> dict[str, Any]:
    (length,) = struct.unpack_from("<I", glb, 12)
    document: dict[str, Any] = json.loads(glb[20 : 20 + length])
    return document


@pytest.mark.kernel
@pytest.mark.skipif(not HAS_KERNEL, reason="neither build123d nor CadQuery is here")
def test_occt_reads_the_parts_at_their_place(tmp_path: Path) -> None:
    assembly = placed()
    write_step(tmp_path / "model.step", assembly)
    check_centroids([leaf.body.centroid for leaf in read_step(tmp_path / "model.step")])


@pytest.mark.kernel
@pytest.mark.parametrize("package", ["build123d", "cadquery"])
def test_kernels_have_the_parts_at_their_place(package: str) -> None:
    pytest.importorskip(package)
    shape = to_build123d(placed()).wrapped if package == "build123d" else to_cadquery(placed()).toCompound().wrapped
    check_centroids([measure(solid).centroid for solid in solids_in(shape)])


def check_centroids(found: list[FloatArray]) -> None:
    expected = [part.placement.to_world(part.solid.centroid) + 1000 * FAR for part in placed().parts()]
    assert np.abs(np.array(found) - expected).max() < 4 * COARSE_MM  # a few sums of such numbers


# --- pairs and designs


@pytest.mark.parametrize("place", PLACES)
def test_a_pair_is_built_anywhere(place: str, tmp_path: Path) -> None:
    mesh, image = revolved_pair(8, 3, saddle=False)
    write_mesh(tmp_path / "M.obj", mesh.translated(PLACES[place]))
    write_mesh(tmp_path / "S.obj", image)
    made = design(Project(mesh=tmp_path / "M.obj", gauss_image=tmp_path / "S.obj", unit="m", nesting={"mode": "off"}))
    assert np.ptp(made.structure.heights) < 300 * COARSE_MM / made.structure.mesh.mean_edge_length
    assert made.summary.gauss_image is not None
    assert made.summary.gauss_image.largest_move < 300 * COARSE_MM / made.structure.mesh.mean_edge_length
    facts = dict(inspect_pair(tmp_path / "M.obj", tmp_path / "S.obj").facts())
    assert "unfit" not in facts


def test_inspection_says_the_same_anywhere(tmp_path: Path) -> None:
    facts = []
    for place, move in PLACES.items():
        write_mesh(tmp_path / f"{place}.obj", rough_dome().translated(move))
        facts.append(list(inspect_mesh(tmp_path / f"{place}.obj").facts()))
    assert facts[0] == facts[1]


def bump(folder: Path, move: FloatArray) -> Path:
    """The file of z = (x^2 + .7 y^2) / -20 over a square, in triangles."""
    grid = shapes.grid(24, 24)
    plan = grid.vertices[:, :2] * 10 / 12 - 10
    vertices = np.column_stack([plan, np.square(plan) @ [-1.0, -0.7] / 20])
    faces = [f for a, b, c, d in grid.combinatorics.faces for f in ([a, b, c], [a, c, d])]
    mesh = dyadic(Mesh.from_faces(vertices, faces))
    mesh = mesh if mesh.vertex_normals[0, 2] > 0 else mesh.reversed()
    write_mesh(folder / "surface.obj", mesh.translated(move))
    return folder / "surface.obj"


def test_hexagons_lie_on_the_surface_wherever_that_is(tmp_path: Path) -> None:
    """And boosted they do not fly away, nor does half a unit offset them."""
    found = {}
    for place, move in {**PLACES, "beside": np.array([0.375, 0.25, 0.4375])}.items():
        made = hexagons_design(bump(tmp_path, move), count=6, turn_deg=0.0).boosted([[0.0, 0.0, 0.1]])
        write_design(made, tmp_path / place)
        found[place] = read_mesh(tmp_path / place / "M.obj").mesh
        surface = read_mesh(tmp_path / "surface.obj").mesh.vertices
        assert (np.abs(found[place].vertices.mean(axis=0) - surface.mean(axis=0)) < 3).all()
    assert np.abs(found["far"].vertices - FAR - found["near"].vertices).max() < np.spacing(5e6)
    moves = found["beside"].vertices - found["near"].vertices
    assert np.ptp(moves, axis=0).max() < 1e-9  # found by closest points, then solved for
    folder = tmp_path / "far"
    built = design(Project(mesh=folder / "M.obj", gauss_image=folder / "S.obj", unit="m", nesting={"mode": "off"}))
    assert np.ptp(built.structure.heights) < 1e-8


def test_a_mesh_of_constant_mean_curvature_lies_where_its_start_does(tmp_path: Path) -> None:
    write_design(cmc_design(count=8, rows=3), tmp_path / "start")
    start, _ = read_mesh_pair(tmp_path / "start" / "M.obj", tmp_path / "start" / "S.obj")
    write_mesh(tmp_path / "far.obj", start.mesh.translated(FAR))
    made = cmc_near_design(tmp_path / "far.obj", tmp_path / "start" / "S.obj")
    write_design(made, tmp_path / "cmc")
    found = read_mesh(tmp_path / "cmc" / "M.obj").mesh
    expected = FAR + start.mesh.vertices.mean(axis=0)
    assert np.abs(found.vertices.mean(axis=0) - expected).max() < 4 * np.spacing(5e6)

"""`fabkit design`: pairs that are what they say, as files that build."""

from __future__ import annotations

import hashlib
import json
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from fabkit import Built, Project
from fabkit import design as built
from fabkit.commands.command_line import app
from fabkit.designs import (
    EdgeOffsetDesign,
    cmc_design,
    hexagons_design,
    koebe_design,
    minimal_design,
    write_design,
)
from fabkit.errors import OutputError, ProjectError
from fabkit.families import Bend, Faces, MinimalShape, Tiles
from geometry.curvature import face_curvatures
from geometry.errors import GeometryError
from geometry.files import read_mesh, read_mesh_pair, write_mesh
from geometry.gauss import Pair
from geometry.mesh import Mesh, shapes, solids
from geometry.mesh.intersections.meeting_faces import is_embedded

SVG = "{http://www.w3.org/2000/svg}"


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def refused(*arguments: str | Path) -> str:
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    lines = [line for line in result.stderr.splitlines() if line.startswith("fabkit:")]
    assert len(lines) == 1, result.stderr
    return lines[0]


def assert_exact(design: EdgeOffsetDesign, bound: float = 1e-12) -> None:
    """Parallel, planar and touching the sphere to what a build takes as it is; outwards."""
    measures = design.measures()
    assert measures["edges_of_s_off_distance_1"] < bound
    assert measures["edges_off_parallel"] < bound
    assert measures["faces_off_plane"] < bound


def surface(folder: Path, bends: tuple[float, float], n: int = 40) -> Path:
    """The file of z = (a x^2 + b y^2) / 2 over a square, in triangles, seen from above."""
    grid = shapes.grid(n, n)
    plan = grid.vertices[:, :2] * 2 / n - 1
    vertices = np.column_stack([plan, np.square(plan) @ bends / 2])
    mesh = Mesh.from_faces(vertices, [f for a, b, c, d in grid.combinatorics.faces for f in ([a, b, c], [a, c, d])])
    write_mesh(folder / "surface.obj", mesh if mesh.vertex_normals[0, 2] > 0 else mesh.reversed())
    return folder / "surface.obj"


def built_from(folder: Path, mean_edge_mm: float = 1500.0) -> Built:
    project = Project(mesh=folder / "M.obj", gauss_image=folder / "S.obj", mean_edge_mm=mean_edge_mm)
    return built(project)


DESIGNS = {
    "dome": "koebe",
    "saddle": "koebe --bend saddle",
    "pentagons": "koebe --tiles pentagons --count 8",
    "hexagons": "koebe --tiles hexagons --count 8",
    "catenoid": "minimal",
    "hexagonal catenoid": "minimal --faces hexagons",
    "enneper": "minimal --shape enneper --count 12",
    "cmc": "cmc",
    "cmc barrel": "cmc --folds 0 --rows 4",
    "cmc hexagons": "cmc --faces hexagons",
    "saddle of pentagons": "koebe --tiles pentagons --bend saddle",
    "saddle of fewer pentagons": "koebe --tiles pentagons --bend saddle --count 8",
    "bent saddle of pentagons": "koebe --tiles pentagons --bend saddle --coverage 0.4",
    "saddle of hexagons": "koebe --tiles hexagons --bend saddle",
    "boosted": "cmc --boost 0.1,0,0.1 --boost 0,0.1,0",
}


@pytest.mark.parametrize("name", DESIGNS)
def test_a_design_is_built_by_the_command_that_is_printed(name: str, tmp_path: Path) -> None:
    said = run("design", *DESIGNS[name].split(), "-o", tmp_path / "shell")
    assert said.exit_code == 0, said.output
    command = f"fabkit build {tmp_path / 'shell'}/M.obj --gauss-image {tmp_path / 'shell'}/S.obj --mean-edge "
    assert command in said.stdout
    assert "meets itself" not in said.stdout
    made = built_from(tmp_path / "shell", float(said.stdout.split(command)[1].split()[0]))
    assert made.nest is not None
    gauss_image = made.summary.gauss_image
    assert gauss_image is not None
    assert gauss_image.largest_move == 0.0
    assert made.summary.largest_move_mm == 0.0
    assert made.summary.mended == ()  # S points outwards already
    assert np.ptp(made.structure.heights) < 1e-12
    assert max(node.details.axis_misalignment_mm for node in made.assembly["nodes"]) < 1e-9 * 120
    assert len(made.assembly["beams"]) == made.structure.mesh.n_edges


def test_the_folder_holds_the_pair_the_picture_and_the_numbers(tmp_path: Path) -> None:
    design = minimal_design(count=12)
    measures = write_design(design, tmp_path / "a")
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == [
        "M.obj",
        "S.obj",
        "manifest.json",
        "picture.svg",
    ]
    file, image = read_mesh_pair(tmp_path / "a" / "M.obj", tmp_path / "a" / "S.obj")
    np.testing.assert_array_equal(file.mesh.vertices, design.mesh.vertices)
    np.testing.assert_array_equal(image.vertices, design.pair.gauss_image.vertices)
    manifest = json.loads((tmp_path / "a" / "manifest.json").read_text())
    assert manifest["measures"] == measures
    assert manifest["settings"] == {"shape": "catenoid", "faces": "quads", "count": 12, "turn_deg": 60.0}
    assert manifest["files"]["S.obj"] == hashlib.sha256((tmp_path / "a" / "S.obj").read_bytes()).hexdigest()
    write_design(design, tmp_path / "b")
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()


def test_the_picture_shows_every_face_and_every_reversed_edge_of_both(tmp_path: Path) -> None:
    design = cmc_design(count=8, rows=3, folds=2)
    write_design(design, tmp_path / "a")
    root = ET.parse(tmp_path / "a" / "picture.svg").getroot()
    _, _, width, height = map(float, root.attrib["viewBox"].split())
    faces = [path.attrib["d"] for path in root.iter(f"{SVG}path") if path.attrib["class"] == "f"]
    assert len(faces) == 2 * design.mesh.n_faces
    points = np.array([list(map(float, p.split())) for d in faces for p in d.strip("Mz").split("L")])
    assert (points >= 0).all()
    assert (points <= [width, height]).all()
    red = "".join(path.attrib["d"] for path in root.iter(f"{SVG}path") if path.attrib["class"] == "r")
    sides = design.pair.reversed_edges[design.mesh.combinatorics.corner_edge].sum()
    assert red.count("M") == 2 * sides > 0


# --- minimal and of constant mean curvature


@settings(max_examples=15, deadline=None)
@given(st.integers(6, 24), st.floats(40, 80), st.sampled_from(Faces))
def test_minimal_ones_have_no_mean_curvature(count: int, turn_deg: float, faces: Faces) -> None:
    design = minimal_design(count=count, turn_deg=turn_deg, faces=faces)
    assert_exact(design)
    mean = design.measures()["mean_curvature"]
    assert max(-mean["least"], mean["largest"]) * design.mesh.mean_edge_length < 1e-12
    normals = np.degrees(
        np.arcsin(
            np.abs(design.pair.gauss_image.vertices[:, 2] / np.linalg.norm(design.pair.gauss_image.vertices, axis=1))
        )
    )
    assert normals.max() < turn_deg + 360 / count  # vertices lie beyond the edges, by less than a face


@settings(max_examples=10, deadline=None)
@given(st.integers(8, 20), st.integers(2, 4), st.integers(1, 3))
def test_cmc_ones_have_one_mean_curvature_and_boosts_keep_the_edge_offset(count: int, rows: int, folds: int) -> None:
    design = cmc_design(count=count, rows=rows, folds=folds)
    assert_exact(design)
    mean = design.measures()["mean_curvature"]
    assert mean["least"] == pytest.approx(mean["largest"], rel=1e-9)
    assert mean["median"] == pytest.approx(-1.0, rel=1e-9)
    boosted = design.boosted([(0.1, 0.0, 0.1), (0.0, 0.1, 0.0)])
    assert_exact(boosted, 1e-10)  # where S is stretched most, its edges lose digits
    assert boosted.settings["boosts"] == [[0.1, 0.0, 0.1], [0.0, 0.1, 0.0]]


def test_a_dome_is_made_to_have_one_mean_curvature(tmp_path: Path) -> None:
    write_design(koebe_design(tiles=Tiles.HEXAGONS, count=6), tmp_path / "dome")
    files = ["--start", tmp_path / "dome" / "M.obj", "--gauss-image", tmp_path / "dome" / "S.obj"]
    for options, factor in (([], 1.0), (["--mean", "-0.2"], None)):
        said = run("design", "cmc", *files, *options, "-o", tmp_path / "even", "--force")
        assert said.exit_code == 0, said.output
        before, after = (
            json.loads((tmp_path / name / "manifest.json").read_text())["measures"]["mean_curvature"]
            for name in ("dome", "even")
        )
        wanted = before["median"] if factor else -0.2
        assert before["largest"] - before["least"] > 1e-3
        assert (after["least"], after["largest"]) == pytest.approx((wanted, wanted), rel=1e-8)
    assert_exact(EdgeOffsetDesign.of("cmc", _pair(tmp_path / "even"), {}))


def _pair(folder: Path) -> Pair:
    file, image = read_mesh_pair(folder / "M.obj", folder / "S.obj")
    return Pair(file.mesh, image)


def test_the_dual_of_a_koebe_polyhedron_of_ones_own(tmp_path: Path) -> None:
    enneper = minimal_design(shape=MinimalShape.ENNEPER, count=8)
    write_mesh(tmp_path / "K.ply", enneper.pair.gauss_image)
    said = run("design", "minimal", "--gauss-image", tmp_path / "K.ply", "-o", tmp_path / "out")
    assert said.exit_code == 0, said.output
    mesh = read_mesh(tmp_path / "out" / "M.obj").mesh
    same = mesh.edge_lengths / enneper.mesh.edge_lengths
    assert np.ptp(same) < 1e-9 * same.mean()  # quads have one dual up to size


# --- any combinatorics


@settings(max_examples=8, deadline=None)
@given(st.sampled_from(Tiles), st.integers(3, 7), st.floats(0.1, 0.6))
def test_domes_keep_the_sense_of_all_edges(tiles: Tiles, count: int, coverage: float) -> None:
    design = koebe_design(tiles=tiles, count=count, coverage=coverage)
    assert_exact(design)
    assert not design.pair.reversed_edges.any()
    assert design.mesh.edge_lengths.min() > 1 - 1e-6
    assert is_embedded(design.mesh)


@pytest.mark.parametrize(("tiles", "count"), [("hexagons", 9), ("pentagons", 8)])
def test_saddles_do_not_meet_themselves(tiles: str, count: int) -> None:
    design = koebe_design(tiles=Tiles(tiles), count=count, bend=Bend.SADDLE)
    assert_exact(design)
    assert face_curvatures(design.pair).gaussian.max() < 0
    assert is_embedded(design.mesh)
    assert bool(design.notes) == (tiles == "pentagons")  # of which some at the rim are cut off
    assert design.mesh.n_faces > 60


def test_combinatorics_of_ones_own_closed_or_dual(tmp_path: Path) -> None:
    solid = solids.truncated_icosahedron()
    bumpy = solid.with_vertices(solid.vertices * np.linspace(1, 1.3, solid.n_vertices)[:, None])
    write_mesh(tmp_path / "ball.off", bumpy)
    sphere = koebe_design(combinatorics=tmp_path / "ball.off", bend=Bend.SPHERE)
    assert_exact(sphere)
    assert np.ptp(sphere.mesh.edge_lengths) < 1e-9  # the Koebe polyhedron of an Archimedean solid is that solid
    dual = koebe_design(combinatorics=tmp_path / "ball.off", take_dual=True, bend=Bend.SPHERE)
    assert (dual.mesh.n_vertices, dual.mesh.n_faces) == (32, 60)
    saddle = koebe_design(count=6, bend=Bend.SADDLE)
    assert set(
        np.bincount(
            saddle.mesh.combinatorics.corner_face, saddle.pair.reversed_edges[saddle.mesh.combinatorics.corner_edge]
        )
    ) == {2}
    assert "closed polyhedron has no saddle" in refused(
        "design", "koebe", "--combinatorics", tmp_path / "ball.off", "--bend", "saddle", "-o", tmp_path / "out"
    )


# --- hexagons on a surface


@pytest.mark.parametrize("bends", [(-1.0, -0.7), (0.7, -0.8)], ids=["dome", "saddle"])
def test_planes_of_hexagons_touch_the_surface(tmp_path: Path, bends: tuple[float, float]) -> None:
    design = hexagons_design(surface(tmp_path, bends), count=10, turn_deg=15.0)
    assert_exact(design)
    assert f"{design.mesh.n_faces} of {design.mesh.n_faces} faces touch the surface" in design.notes[0]
    assert design.mesh.n_faces > 40
    normals = design.mesh.face_normals
    a, b = bends  # the plane with the normal n touches where the gradient (a x, b y) is -(n_x, n_y) / n_z
    touching = -normals[:, :2] / normals[:, 2:] / [a, b]
    heights = np.einsum("fi,fi->f", np.column_stack([touching, np.square(touching) @ bends / 2]), normals)
    c = design.mesh.combinatorics
    found = np.einsum("fi,fi->f", design.mesh.vertices[c.corners[c.face_starts[:-1]]], normals)
    assert np.abs(found - heights).max() < 1e-3  # edges of 1/20, to the third power
    assert np.abs(touching).max() < 1.1
    assert design.pair.reversed_edges.any() == (bends[0] > 0)


def test_hexagons_on_a_surface_are_built_in_its_unit(tmp_path: Path) -> None:
    file = surface(tmp_path, (-1.0, -0.7))
    said = run("design", "hexagons", file, "--count", "9", "-o", tmp_path / "out")
    assert said.exit_code == 0, said.output
    assert "--unit m" in said.stdout
    project = Project(mesh=tmp_path / "out" / "M.obj", gauss_image=tmp_path / "out" / "S.obj", mean_edge_mm=1000.0)
    made = built(project)
    assert max(node.details.top_step_mm for node in made.assembly["nodes"]) < 1e-9 * 120
    upside_down = hexagons_design(file, count=9, flip=True)
    assert upside_down.mesh.face_normals[:, 2].max() < 0


# --- refused


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["cmc", "--boost", "1,0,0"], "the velocity of the boost has length 1"),
        (["cmc", "--boost", "0,0,1e400"], "--boost is '0,0,1e400', and together its numbers have to be shorter than 1"),
        (["cmc", "--boost", "0.5,0"], "--boost is '0.5,0', but needs three numbers"),
        (["cmc", "--faces", "hexagons", "--folds", "1"], "hexagons cannot fold over itself, and 1 folds"),
        (["cmc", "--start", "M.obj"], "--start needs the files of both meshes"),
        (["cmc", "--start", "M.obj", "--gauss-image", "S.obj", "--rows", "6"], "so --rows would have no effect"),
        (["koebe", "--combinatorics", "M.obj", "--tiles", "quads"], "gives the faces, so --tiles would have no effect"),
        (["koebe", "--direction", "45"], "--bend dome has no direction, so --direction would have no effect"),
        (["minimal", "--gauss-image", "S.obj", "--turn", "60"], "decides the shape, so --turn would have no effect"),
        (["cmc", "--bulge", "0.7"], "it has to be at least 0.8357, or a neck of at most 0.1729"),
        (["cmc", "--folds", "0", "--bulge", "0.2"], "it has to be at least 0.8357"),
        (["cmc", "--count", "2"], "2 faces around are asked for, an integer from 3"),
        (["minimal", "--turn", "90"], "turn by 90 degrees: above 0 and below 90"),
        (["minimal", "--turn", "3", "--count", "6"], "6 faces around fits between the latitudes"),
        (["minimal", "--shape", "enneper", "--faces", "hexagons"], "made of quads"),
        (["minimal", "--gauss-image", "none.obj"], "none.obj: there is no such file"),
        (["koebe", "--coverage", "1.5"], "the coverage is 1.5"),
        (["koebe", "--bend", "saddle", "--direction", "nan"], "the direction is nan degrees"),
        (["koebe", "--count", "0"], "0 columns are asked for, an integer from 1"),
        (
            ["koebe", "--bend", "saddle", "--tiles", "pentagons", "--count", "8", "--direction", "0"],
            "another --direction",
        ),
        (["koebe", "--combinatorics", "none.obj"], "none.obj: there is no such file"),
        (["hexagons", "none.obj", "--turn", "nan"], "turned by nan degrees"),
        (["hexagons", "none.obj", "--count", "1"], "1 hexagons across were requested (--count), at least 2"),
        (["hexagons", "none.obj"], "none.obj: there is no such file"),
    ],
)
def test_impossible_designs_are_refused_and_leave_nothing(tmp_path: Path, arguments: list[str], sentence: str) -> None:
    assert sentence in refused("design", *arguments, "-o", tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


def test_spans_and_rises_are_met_and_built_in_mm(tmp_path: Path) -> None:
    for name, arguments in {
        "koebe": ["koebe", "--tiles", "hexagons", "--count", "6"],
        "minimal": ["minimal", "--shape", "enneper", "--count", "8"],
    }.items():
        out = tmp_path / name
        text = run("design", *arguments, "--span", "9000", "--rise", "1800", "-o", out).stdout
        assert "--unit mm" in text
        assert "rise 1800 mm" in text
        sizes = np.ptp(read_mesh(out / "M.obj").mesh.vertices, axis=0)
        np.testing.assert_allclose([sizes[:2].max(), sizes[2]], [9000, 1800], rtol=1e-6)
        settings = json.loads((out / "manifest.json").read_text())["settings"]
        assert (settings["span_mm"], settings["rise_mm"]) == (9000, 1800)
    run("design", "cmc", "--boost", "0.2,0,0", "--span", "9000", "-o", tmp_path / "cmc")
    assert np.ptp(read_mesh(tmp_path / "cmc" / "M.obj").mesh.vertices, axis=0)[:2].max() == pytest.approx(9000)
    pair = {"mesh": tmp_path / "koebe" / "M.obj", "gauss_image": tmp_path / "koebe" / "S.obj"}
    made = built(Project(unit="mm", nesting={"mode": "off"}, **pair))
    assert np.ptp(made.structure.mesh.vertices[:, 2]) == pytest.approx(1800)
    assert np.ptp(made.structure.heights) < 1e-9


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["koebe", "--span", "9000", "--rise", "9000"], "with these faces it can be between 53.04 and 7453 mm"),
        (["koebe", "--rise", "9000"], "--rise needs --span"),
        (["koebe", "--span", "0"], "the span is 0 mm: above 0 and at most 1e+09 mm is needed"),
        (["koebe", "--span", "inf"], "the span is inf mm"),
        (["koebe", "--span", "9000", "--rise", "-1"], "the rise is -1 mm"),
        (["koebe", "--span", "9000", "--rise", "900", "--bend", "saddle"], "and --bend saddle is asked for"),
        (["koebe", "--span", "9000", "--rise", "900", "--coverage", "0.3"], "so --coverage would have no effect"),
        (["koebe", "--span", "9000", "--rise", "900", "--boost", "0.1,0,0"], "--boost changes the rise"),
        (["minimal", "--span", "9000", "--rise", "900"], "and --shape catenoid is asked for"),
        (["minimal", "--shape", "enneper", "--span", "9000", "--rise", "9", "--turn", "20"], "so --turn would have no"),
        (["minimal", "--shape", "enneper", "--count", "4", "--span", "1000", "--rise", "900"], "between 0.8"),
    ],
)
def test_spans_and_rises_that_cannot_be_met_are_refused(tmp_path: Path, arguments: list[str], sentence: str) -> None:
    result = CliRunner().invoke(app, ["design", *arguments, "-o", str(tmp_path / "out")])
    assert result.exit_code == 2, result.output
    assert sentence in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_replaced_only_with_force(tmp_path: Path) -> None:
    assert run("design", "cmc", "--count", "8", "-o", tmp_path / "out").exit_code == 0
    assert "replace it with --force" in refused("design", "cmc", "--count", "9", "-o", tmp_path / "out")
    assert run("design", "cmc", "--count", "9", "-o", tmp_path / "out", "--force").exit_code == 0
    assert json.loads((tmp_path / "out" / "manifest.json").read_text())["settings"]["count"] == 9
    with pytest.raises(OutputError, match="exists already"):
        write_design(cmc_design(count=8), tmp_path / "out")
    with pytest.raises((GeometryError, ProjectError)):
        minimal_design(turn_deg=float("nan"))


def test_help_names_the_designs() -> None:
    overview = run("--help")
    assert "design" in overview.stdout
    for command in ("koebe", "minimal", "cmc", "hexagons"):
        assert command in run("design", "--help").stdout
        assert "--boost" in run("design", command, "--help").stdout

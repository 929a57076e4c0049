"""`fabkit planarise`, `offset` and `curvature` write what the library computes, where the mesh is and in its unit."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from fabkit.commands.command_line import app
from fabkit.errors import OutputError
from fabkit.formats import whole_file
from geometry import Mesh, face_curvatures, offset, planarise
from geometry.exact_offsets import exact_or_approximate_pair
from geometry.files import read_mesh, write_mesh
from geometry.mesh import shapes, solids
from tests.fabkit.edge_offsets import revolved_pair

PLACE = np.array([3e5, -4e5, 100.0])


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def printed(*arguments: str | Path) -> str:
    result = run(*arguments)
    assert result.exit_code == 0, result.output
    return " ".join(result.stdout.split())


def refused(*arguments: str | Path) -> str:
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    return result.stderr


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def bumpy() -> Mesh:
    dome = shapes.dome(14, 6)
    return dome.with_vertices(dome.vertices + 0.003 * np.sin(9 * dome.vertices[:, [1, 2, 0]]))


def test_faces_are_made_planar_where_the_mesh_is(folder: Path) -> None:
    write_mesh("rough.obj", bumpy().translated(PLACE))
    text = printed("planarise", "rough.obj", "-o", "planar.off")
    assert "planarised to" in text
    assert text.endswith("written to planar.off")
    file = read_mesh("planar.off").near_zero()
    assert file.mesh.planarity.max() < 1e-8 < bumpy().planarity.max()
    assert np.abs(read_mesh("planar.off").mesh.vertices - bumpy().vertices - PLACE).max() < 0.02
    write_mesh("cube.off", solids.cube())
    assert "nothing to do" in printed("planarise", "cube.off", "-o", "again.off")
    assert Path("again.off").read_bytes() == Path("cube.off").read_bytes()


def test_weights_of_planarising_and_flip_do_what_they_say(folder: Path) -> None:
    write_mesh("rough.obj", bumpy())
    for name, options in (
        ("plain", []),
        ("fair", ["--fairness", "30"]),
        ("kept", ["--keep-boundary"]),
        ("flip", ["--flip"]),
    ):
        printed("planarise", "rough.obj", "-o", f"{name}.obj", *options)
    plain, fair, kept, flip = (read_mesh(f"{name}.obj").mesh for name in ("plain", "fair", "kept", "flip"))
    assert np.abs(fair.vertices - plain.vertices).max() > 1e-5
    assert np.abs(kept.vertices - plain.vertices).max() > 1e-5
    np.testing.assert_allclose(flip.reversed().face_normals, plain.face_normals, atol=1e-6)


def test_what_a_build_would_refuse_is_reported_and_written(folder: Path) -> None:
    saddle = shapes.grid(8, 8)
    x, y = saddle.vertices[:, 0], saddle.vertices[:, 1]
    write_mesh("twisted.obj", saddle.with_vertices(np.column_stack((x, y, x * y / 4))))  # its lines are asymptotic
    text = printed("planarise", "twisted.obj", "-o", "planar.obj")
    assert "unfit moves: to make faces planar, 95 % of the vertices move by" in text
    assert "--accept" not in text
    assert read_mesh("planar.obj").mesh.planarity.max() < 1e-9


def test_a_mesh_that_folds_over_is_not_written(folder: Path) -> None:
    saddle = shapes.grid(8, 8)
    x, y = saddle.vertices[:, 0], saddle.vertices[:, 1]
    write_mesh("twisted.obj", saddle.with_vertices(np.column_stack((x, y, x * y / 8))))
    assert "unfit (folding)" in refused("planarise", "twisted.obj", "-o", "planar.obj")
    assert [path.name for path in folder.iterdir()] == ["twisted.obj"]


@pytest.mark.parametrize("kind", [None, "edge", "face"])
def test_offsets_are_those_of_the_library(folder: Path, kind: str | None) -> None:
    cube = solids.cube() * 500.0
    write_mesh("cube.obj", cube.translated(PLACE))
    options = [] if kind is None else ["--kind", kind]
    text = printed("offset", "cube.obj", "--distance", "20", "-o", "larger.ply", *options)
    layer = offset(cube, 20.0, kind)  # type: ignore[arg-type]
    np.testing.assert_allclose(read_mesh("larger.ply").mesh.vertices - PLACE, layer.mesh.vertices, atol=1e-9)
    assert f"{'edge lines' if kind != 'face' else 'face planes'} 20 apart" in text


def test_offsets_with_a_given_gauss_image(folder: Path) -> None:
    mesh, image = revolved_pair(12, 5, saddle=True)
    write_mesh("M.obj", mesh.translated(PLACE))
    write_mesh("S.obj", image)
    given = ["M.obj", "--gauss-image", "S.obj"]
    text = printed("offset", *given, "--distance", "-0.01", "-o", "inner.obj")
    inner = mesh.vertices - 0.01 * image.vertices
    np.testing.assert_allclose(read_mesh("inner.obj").mesh.vertices - PLACE, inner, atol=1e-8)
    assert "constant distance of the edge lines" in text
    assert "so --keep-boundary would have no effect" in refused(
        "offset", *given, "--distance", "1", "-o", "no.obj", "--keep-boundary"
    )


def test_curvatures_as_a_table_and_as_colours(folder: Path) -> None:
    rough = bumpy()
    write_mesh("rough.obj", rough.translated(PLACE))
    text = printed("curvature", "rough.obj", "-o", "curvatures.csv")
    assert "mean curvature -" in text
    near = read_mesh("rough.obj").near_zero()
    planar = planarise(near.mesh).mesh
    moved = float(np.linalg.norm(planar.vertices - near.mesh.vertices, axis=1).max())
    expected = face_curvatures(exact_or_approximate_pair(planar, moved=moved, rounding=near.rounding)[0])
    with Path("curvatures.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [int(row["Face"]) for row in rows] == list(range(rough.n_faces))
    np.testing.assert_array_equal([float(row["Mean curvature"]) for row in rows], expected.mean)
    np.testing.assert_array_equal([float(row["Gaussian curvature"]) for row in rows], expected.gaussian)
    np.testing.assert_array_equal([float(row["Principal curvature 2"]) for row in rows], expected.principal[:, 1])
    printed("curvature", "rough.obj", "-o", "mean.obj")
    printed("curvature", "rough.obj", "-o", "gaussian.ply", "--colour", "gaussian")
    assert "usemtl" in Path("mean.obj").read_text()
    assert Path("mean.mtl").is_file()
    assert f"values from {expected.gaussian.min():.6g}"[:18] in Path("gaussian.ply").read_text()
    np.testing.assert_array_equal(read_mesh("mean.obj").mesh.vertices, planar.vertices + near.origin)
    assert "no colours, so --colour would have no effect" in refused(
        "curvature", "rough.obj", "-o", "x.csv", "--colour", "mean"
    )


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["planarise", "cube.obj", "-o", "cube.obj", "--force"], "is an input of this run"),
        (
            ["planarise", "cube.obj", "-o", "there.obj"],
            "exists already; choose another name, or replace it with --force",
        ),
        (["planarise", "cube.obj", "-o", "none/planar.obj"], "none in which planar.obj should appear does not exist"),
        (["planarise", "cube.obj", "-o", "folder.obj", "--force"], "is not a file, so it is not replaced"),
        (["planarise", "cube.obj", "-o", "planar.stl"], "planar.stl ends in '.stl': one of .obj, .off, .ply is needed"),
        (["planarise", "none.obj", "-o", "planar.obj"], "none.obj: there is no such file"),
        (["planarise", "cube.obj", "-o", "planar.obj", "--fairness", "nan"], "fairness"),
        (["offset", "cube.obj", "--distance", "-900", "-o", "small.obj"], "choose a distance between -707"),
        (["offset", "cube.obj", "--distance", "nan", "-o", "small.obj"], "a finite number is needed"),
        (["offset", "cube.obj", "-o", "small.obj"], "Missing option '--distance'"),
        (["curvature", "cube.obj", "-o", "there.mtl"], "'.mtl': one of .csv, .obj, .off, .ply is needed"),
    ],
)
def test_what_cannot_be_written_is_one_sentence_and_leaves_nothing(
    folder: Path, arguments: list[str], sentence: str
) -> None:
    write_mesh("cube.obj", solids.cube() * 500.0)
    Path("there.obj").write_text("mine")
    Path("folder.obj").mkdir()
    before = {path.name: path.is_dir() or path.read_bytes() for path in folder.iterdir()}
    assert sentence in refused(*arguments)
    assert {path.name: path.is_dir() or path.read_bytes() for path in folder.iterdir()} == before


def test_existing_files_are_replaced_with_force(folder: Path) -> None:
    write_mesh("cube.obj", solids.cube())
    Path("mean.mtl").write_text("mine")
    assert "mean.mtl exists already" in refused("curvature", "cube.obj", "-o", "mean.obj")
    assert not Path("mean.obj").exists()
    printed("curvature", "cube.obj", "-o", "mean.obj", "--force")
    assert "newmtl" in Path("mean.mtl").read_text()
    assert sorted(path.name for path in folder.iterdir()) == ["cube.obj", "mean.mtl", "mean.obj"]


def test_a_file_that_fails_half_way_leaves_nothing(folder: Path) -> None:
    def write(text: str, others: str = "") -> None:
        with whole_file(Path("a.obj"), force=False) as draft:
            draft.write_text(text)
            if not others:
                raise ZeroDivisionError
            Path("a.obj").write_text(others)

    with pytest.raises(ZeroDivisionError):
        write("half")
    assert list(folder.iterdir()) == []
    with pytest.raises(OutputError, match="exists already"):
        write("ours", "of somebody else")
    assert [path.name for path in folder.iterdir()] == ["a.obj"]
    assert Path("a.obj").read_text() == "of somebody else"

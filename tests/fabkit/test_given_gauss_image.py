"""Building with a Gauss image that is given: taken as it is, mended together with the mesh, or refused."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from openpyxl import load_workbook
from typer.testing import CliRunner

from fabkit import Built, Project, build, design, load_project
from fabkit.commands.command_line import app
from fabkit.commands.inspection import inspect_pair
from fabkit.errors import ProjectError
from fabkit.project import project_from
from geometry.curvature import christoffel_dual
from geometry.errors import GeometryError, ParallelityError
from geometry.files import read_mesh, write_mesh
from geometry.gauss import nearest_parallel_pair
from geometry.mesh import Mesh, shapes
from geometry.meshing import planarise
from geometry.parallel import parallelity
from tests.fabkit.edge_offsets import revolved_pair
from tests.real_data.meshes import DATA, HEXAGONAL, needs_data

M, S = revolved_pair(12, 5, saddle=False)
OFF = {"mode": "off"}


def rounded(mesh: Mesh, digits: int) -> Mesh:
    return mesh.with_vertices(np.round(mesh.vertices, digits))


def built(folder: Path, mesh: Mesh = M, image: Mesh = S, **settings: Any) -> Built:
    write_mesh(folder / "M.obj", mesh)
    write_mesh(folder / "S.off", image)
    wanted: dict[str, Any] = {"unit": "m", "nesting": OFF, "gauss_image": folder / "S.off", **settings}
    return design(Project(mesh=folder / "M.obj", **wanted))


@pytest.mark.parametrize("saddle", [False, True], ids=["convex", "saddle"])
def test_an_exact_pair_is_built_as_it_is(tmp_path: Path, saddle: bool) -> None:
    mesh, image = revolved_pair(12, 5, saddle=saddle)
    made = built(tmp_path, mesh, image)
    np.testing.assert_array_equal(made.structure.gauss_image.vertices, image.vertices)  # no unit applies to S
    near, origin = mesh.near_zero()
    np.testing.assert_array_equal(made.structure.mesh.vertices, near.vertices * 1000)
    np.testing.assert_array_equal(made.assembly.origin_mm, origin * 1000)
    given = made.summary.gauss_image
    assert given is not None
    assert (given.file, given.largest_move, given.mean_move) == ("S.off", 0.0, 0.0)
    assert made.summary.largest_move_mm == 0.0
    assert max(node.details.axis_misalignment_mm for node in made.assembly["nodes"]) < 1e-9 * 120


def test_every_document_says_that_it_was_given(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write_mesh(tmp_path / "M.obj", M)
    write_mesh(tmp_path / "S.obj", S)
    command = ["build", tmp_path / "M.obj", "--gauss-image", tmp_path / "S.obj", "--mean-edge", "1000", "-o", out]
    said = CliRunner().invoke(app, [*map(str, command), "--nest", "off"])
    assert said.exit_code == 0, said.output
    assert "given by S.obj, exact as it is" in said.stdout
    sha256 = hashlib.sha256((tmp_path / "S.obj").read_bytes()).hexdigest()
    manifest = json.loads((out / "manifest.json").read_text())
    assert manifest["gauss_image"] == {"file": "S.obj", "sha256": sha256, "largest_move": 0.0, "mean_move": 0.0}
    assert manifest["settings"]["gauss_image"]["tolerance"] == 1e-3
    assert str(tmp_path) not in (out / "manifest.json").read_text()
    report = (out / "report.html").read_text(encoding="utf-8")
    assert "given by S.obj" in report
    assert sha256 in report
    cells = [cell.value for row in load_workbook(out / "cutlist.xlsx")["Summary"].iter_rows() for cell in row]
    assert any(isinstance(value, str) and value.startswith("given by S.obj") for value in cells)


@pytest.mark.parametrize("settings", [{"unit": "ft"}, {"unit": "m", "flip": True}], ids=str)
def test_a_build_folder_holds_the_pair_that_builds_the_same_parts(tmp_path: Path, settings: dict[str, Any]) -> None:
    """Faces are planarised and S computed in the first build only; M.obj stands where the mesh file has it."""
    move = [5e5, -2e5, 300.0]
    dome = 20.0 * shapes.dome(16, 6)
    bumpy = dome.with_vertices(dome.vertices + 0.02 * np.sin(2 * dome.vertices[:, [1, 2, 0]]))
    write_mesh(tmp_path / "mesh.obj", bumpy.translated(move))
    first, again = tmp_path / "first", tmp_path / "again"
    one = build(Project(mesh=tmp_path / "mesh.obj", out=first, nesting=OFF, **settings))
    assert np.abs(read_mesh(first / "M.obj").mesh.vertices - bumpy.vertices - move).max() < 0.1
    settings.pop("flip", None)  # faces are written as they were turned
    pair = {"mesh": first / "M.obj", "gauss_image": first / "S.obj"}
    two = build(Project(out=again, nesting=OFF, **pair, **settings))
    assert one.structure.mesh.planarity.max() < 1e-9 < bumpy.planarity.max()
    assert two.summary.largest_move_mm < 1e-5
    for here, there in zip(one.assembly.parts(), two.assembly.parts(), strict=True):
        assert (here.kind, here.element, here.mark) == (there.kind, there.element, there.mark)
        corners = [
            part.placement.to_world(part.solid.vertices) + made.assembly.origin_mm
            for part, made in ((here, one), (there, two))
        ]
        assert np.abs(corners[0] - corners[1]).max() < 1e-4  # doubles are 1e-7 mm apart there


@pytest.mark.parametrize("digits", [6, 4])
def test_a_pair_that_lost_digits_becomes_exact_again(tmp_path: Path, digits: int) -> None:
    made = built(tmp_path, rounded(M, digits), rounded(S, digits))
    structure, given = made.structure, made.summary.gauss_image
    assert given is not None
    assert parallelity(structure.mesh, structure.gauss_image).max() < 1e-12
    assert structure.mesh.planarity.max() < 1e-12
    assert 0 < given.mean_move < given.largest_move < 10 * 10.0**-digits
    assert 0 < made.summary.largest_move_mm < 10 * 10.0**-digits * 1000
    assert np.abs(structure.gauss_image.vertices - S.vertices).max() < 10 * 10.0**-digits
    if digits == 6:  # beams stay level by one setback a node, to what the digits say
        assert max(node.details.top_step_mm for node in made.assembly["nodes"]) < 1e-2
        assert all(len(set(node.details.setbacks_mm)) == 1 for node in made.assembly["nodes"])


def test_what_lost_its_last_digits_has_as_few_marks_as_the_shop_wants(tmp_path: Path) -> None:
    exact, rough, shared = (
        {part.mark for part in built(tmp_path, mesh, image, equal_within_mm=within).assembly.parts()}
        for mesh, image, within in (
            (M, S, 1e-7),
            (rounded(M, 5), rounded(S, 5), 1e-7),
            (rounded(M, 5), rounded(S, 5), 0.1),
        )
    )
    assert exact == shared
    assert len(rough) > 2 * len(exact)


@needs_data
def test_the_minimal_surface_of_hexagons(tmp_path: Path) -> None:
    """The file holds a Koebe polyhedron with edges at distance 1 to 3e-11; M is its Christoffel dual. P(S) has two
    dimensions more than counting says, so that rounded meshes are made exact only together."""
    image = planarise(read_mesh(DATA / HEXAGONAL).mesh).mesh
    mesh = christoffel_dual(image).mesh
    for digits, bound in ((17, 1e-9), (6, 1e-4)):
        made = built(tmp_path, rounded(mesh, digits), rounded(image, digits), unit=None, mean_edge_mm=700.0)
        assert np.abs(made.structure.heights - 1).max() < bound
        assert max(node.details.axis_misalignment_mm for node in made.assembly["nodes"]) < bound * 120
        assert len(made.assembly["beams"]) == 580


# --- refused


def broken(mesh: Mesh) -> Mesh:
    vertices = mesh.vertices.copy()
    vertices[7] += [0.05, 0.0, 0.0]
    return mesh.with_vertices(vertices)


def renumbered(mesh: Mesh) -> Mesh:
    """The same faces by their numbers, with other vertices: a mirrored and turned numbering."""
    return mesh.with_vertices(np.roll(mesh.vertices, 15, axis=0))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        pytest.param(
            broken,
            r"edge 7 from vertex 7 to vertex 8 \(counted from 0\) of S\.off is off the direction of its mesh edge by "
            r"4\.9e-02 of the unit sphere's radius, allowed 1e-03, and 4 of 108 edges",
            id="a vertex moved",
        ),
        pytest.param(renumbered, "the two meshes are not parallel; .* vertices in the same order", id="other numbers"),
        pytest.param(lambda s: s * 1000.0, "from the origin is 1e.03, .* scale and move it", id="in mm"),
        pytest.param(lambda s: s * 0.0, "from the origin is 0, ", id="a point"),
        pytest.param(lambda s: s.translated([30.0, 0, 0]), "scale and move it there", id="elsewhere"),
    ],
)
def test_images_of_other_meshes_are_refused(tmp_path: Path, change: Callable[[Mesh], Mesh], sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence):
        built(tmp_path, M, change(S))
    assert sorted(p.name for p in tmp_path.iterdir()) == ["M.obj", "S.off"]


def test_other_combinatorics_are_refused_on_the_command_line(tmp_path: Path) -> None:
    write_mesh(tmp_path / "M.obj", M)
    faces = [face.tolist() for face in S.combinatorics.faces]
    faces[3] = [faces[3][k] for k in (1, 0, 2, 3)]
    rows = [" ".join(map(repr, row)) for row in S.vertices.tolist()]
    lines = ["OFF", f"{len(rows)} {len(faces)} 0", *rows, *("4 " + " ".join(map(str, face)) for face in faces)]
    (tmp_path / "S.off").write_text("\n".join(lines))
    command = ["build", tmp_path / "M.obj", "--gauss-image", tmp_path / "S.off", "--unit", "m", "-o", tmp_path / "out"]
    said = CliRunner().invoke(app, list(map(str, command)))
    assert said.exit_code == 2
    assert "face 4 of the first" in said.stderr
    assert "is not in the second" in said.stderr
    assert not (tmp_path / "out").exists()
    (tmp_path / "S.off").unlink()
    said = CliRunner().invoke(app, list(map(str, command)))
    assert said.exit_code == 2
    assert "S.off: there is no such file" in said.stderr


def test_what_is_off_by_more_than_the_tolerance_is_refused_before_or_after_it_is_mended(tmp_path: Path) -> None:
    mesh, image = rounded(M, 3), rounded(S, 3)
    made = built(tmp_path, mesh, image, gauss_image={"file": tmp_path / "S.off", "tolerance": 1e-2})
    given = made.summary.gauss_image
    assert given is not None
    with pytest.raises(ParallelityError, match=r"of S\.off is off the direction of its mesh edge by"):
        built(tmp_path, mesh, image, gauss_image={"file": tmp_path / "S.off", "tolerance": 1e-5})
    tight = given.largest_move * 0.99
    with pytest.raises(ParallelityError, match=r"vertex \d+ .* of the Gauss image would have to move by"):
        nearest_parallel_pair(mesh, image, tolerance=tight)


# --- inspected


def inspected(folder: Path, mesh: Mesh, image: Mesh) -> dict[str, str]:
    write_mesh(folder / "M.obj", mesh)
    write_mesh(folder / "S.ply", image)
    return dict(inspect_pair(folder / "M.obj", folder / "S.ply").facts())


def test_an_inspection_says_how_a_pair_fits(tmp_path: Path) -> None:
    convex, saddle = (inspected(tmp_path, *revolved_pair(12, 5, saddle=saddle)) for saddle in (False, True))
    for facts in (convex, saddle):
        assert facts["made exact"] == "nothing to do"
        assert "an edge offset: beams of one height" in facts["edges of S"]
        assert "so not a vertex offset" in facts["vertices of S"]
        assert float(facts["alignment"].split("median ")[1].split()[0]) < 1e-12
    assert convex["reversed"].startswith("0 of 108 edges run against those of S; at 0 of 60")
    assert saddle["reversed"].startswith("60 of 108 edges run against those of S; at 60 of 60")
    tilted = inspected(tmp_path, M, S.translated([0.1, 0.0, 0.0]))
    assert "so not an edge offset" in tilted["edges of S"]
    assert float(tilted["alignment"].split("largest ")[1].split()[0]) > 1e-3
    lost = inspected(tmp_path, rounded(M, 5), rounded(S, 5))
    assert "of its mean edge length at most, of the Gauss image by" in lost["made exact"]
    other = inspected(tmp_path, M, renumbered(S))
    assert float(other["parallel"].split()[1]) > 0.1
    assert "so that a build refuses it" in other["made exact"]
    said = CliRunner().invoke(app, ["inspect", str(tmp_path / "M.obj"), "--gauss-image", str(tmp_path / "S.ply")])
    assert said.exit_code == 1  # a build refuses it
    assert "parallel" in said.stdout
    said = CliRunner().invoke(app, ["inspect", str(tmp_path / "M.obj"), "--gauss-image", str(tmp_path / "none.ply")])
    assert said.exit_code == 2
    assert "there is no such file" in said.stderr


# --- inside and outside


def test_the_image_says_which_side_is_outside(tmp_path: Path) -> None:
    up = built(tmp_path)
    turned = built(tmp_path, M.reversed(), S)
    assert turned.summary.mended[-1] == "all faces reversed to face the outside that S.off shows"
    for made in (up, turned):
        structure = made.structure
        np.testing.assert_array_equal(structure.gauss_image.vertices, S.vertices)
        assert np.einsum("ik,ik->i", structure.mesh.vertices[:, :2], structure.axes[:, :2]).min() > 0
    inwards = built(tmp_path, M, -1.0 * S)
    flipped = built(tmp_path, M, S, flip=True)
    for made in (inwards, flipped):
        np.testing.assert_array_equal(made.structure.gauss_image.vertices, -S.vertices)
    assert flipped.summary.mended == ("all faces reversed, as requested",)


# --- the project file


def test_a_project_file_names_it_from_its_own_folder(tmp_path: Path) -> None:
    write_mesh(tmp_path / "M.obj", M)
    write_mesh(tmp_path / "S.obj", S)
    file = tmp_path / "p.toml"
    for said in ('gauss_image = "S.obj"\n', '[gauss_image]\nfile = "S.obj"\ntolerance = 0.01\n'):
        file.write_text(f'mesh = "M.obj"\nunit = "m"\nout = "out"\n{said}')
        project = load_project(file, {})
        assert project.gauss_image.file == tmp_path / "S.obj"
    build(project)
    assert (tmp_path / "out" / "manifest.json").is_file()
    file.write_text('mesh = "M.obj"\nunit = "m"\n[gauss_image]\nedges = 1.0\n')
    other = load_project(file, {"gauss_image": {"file": Path("other.obj")}})  # the command line wins over weights
    assert (other.gauss_image.file, other.gauss_image.edges) == (Path("other.obj"), None)


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (
            {"gauss_image": {"file": "S.obj", "edges": 1.0}},
            "given by file, so there is nothing to compute: take out edges",
        ),
        ({"gauss_image": "S.obj", "planarise": {"fairness": 1.0}}, r"\[planarise\] says nothing"),
        ({"gauss_image": {"flie": "S.obj"}}, r"unknown key 'flie' in \[gauss_image\]; did you mean file\?"),
        ({"gauss_image": {"file": "S.obj", "tolerance": 0}}, "gauss_image.tolerance is 0"),
    ],
)
def test_wrong_settings_are_named(settings: dict[str, object], sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence):
        project_from({"mesh": "M.obj", "unit": "m", **settings})

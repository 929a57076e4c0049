"""A mesh with an exact offset is built with it, and every document says so."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from fabkit import Built, Project, design
from fabkit.commands.command_line import app
from fabkit.commands.inspection import inspect_mesh
from fabkit.production.summary import ExactGaussImage
from geometry.files import write_mesh
from geometry.mesh import Mesh, shapes
from tests.fabkit.edge_offsets import revolved_pair
from tests.geometry.box_meshes import turning
from tests.geometry.parallel_elements import solid

OFF = {"mode": "off"}


def built(folder: Path, mesh: Mesh, **settings: object) -> Built:
    write_mesh(folder / "M.obj", mesh)
    return design(Project.model_validate({"mesh": folder / "M.obj", "mean_edge_mm": 1500, "nesting": OFF} | settings))


@pytest.mark.parametrize("saddle", [False, True], ids=["convex", "saddle"])
def test_edge_offset_meshes_get_beams_of_one_height_without_their_image_given(tmp_path: Path, saddle: bool) -> None:
    mesh = revolved_pair(12, 5, saddle=saddle)[0]
    made = built(tmp_path, mesh)
    assert made.summary.gauss_image == ExactGaussImage("edge")
    np.testing.assert_allclose(made.summary.heights, 1, rtol=0, atol=1e-9)
    assert "an exact edge offset" in made.summary.gauss_image_origin
    weighted = built(tmp_path, mesh, gauss_image={"faces": 1.0})
    assert weighted.summary.gauss_image is None
    assert np.ptp(weighted.summary.heights) > 1e-3


@pytest.mark.parametrize("digits", [8, 7, 6])
@pytest.mark.parametrize("kind", ["revolved", "dodecahedron", "dome"])
def test_the_digits_of_a_drawing_program_do_not_hide_an_offset(tmp_path: Path, kind: str, digits: int) -> None:
    """With fewer digits, the same kind of offset, and the same heights but for them; inspect agrees."""
    meshes = {
        "revolved": revolved_pair(12, 5, saddle=False)[0],
        "dodecahedron": solid("dodecahedron", "edge"),
        "dome": shapes.dome(8, 3),
    }
    mesh = meshes[kind] * (3 / meshes[kind].mean_edge_length)
    exact = built(tmp_path, mesh)
    found = built(tmp_path, mesh.with_vertices(np.round(mesh.vertices, digits)))
    assert found.summary.gauss_image == exact.summary.gauss_image is not None
    np.testing.assert_allclose(found.summary.heights, exact.summary.heights, atol=1e3 * 10**-digits)
    offset = next(iter(vars(found.summary.gauss_image).values()))
    assert dict(inspect_mesh(tmp_path / "M.obj").facts())[f"{offset} offset"].startswith("yes")


@pytest.mark.parametrize("digits", [9, 7, 6])
def test_the_digits_of_a_drawing_program_do_not_decide_about_the_heights(tmp_path: Path, digits: int) -> None:
    """A stretched torus: its conditions depend on each other, but those of its rounded copies do not."""
    torus = shapes.torus(np.array([[3.0, -1.2], [4.4, -0.7], [4.4, 0.7], [3.0, 1.2], [2.0, 0.0]]), 12)
    mesh = torus.with_vertices(torus.vertices * [1.4, 1.0, 0.7])
    exact = built(tmp_path, mesh).summary
    for seed in range(2):
        turned = mesh.vertices @ turning(seed)
        found = built(tmp_path, mesh.with_vertices(np.round(turned, digits))).summary
        np.testing.assert_allclose(found.heights, exact.heights, atol=1e3 * 10**-digits)


def test_a_triangle_mesh_with_an_exact_image_is_built(tmp_path: Path) -> None:
    made = built(tmp_path, shapes.icosahedron())
    assert made.summary.gauss_image == ExactGaussImage("edge")
    assert len(made.assembly["beams"]) == 30
    assert len({part.mark for part in made.assembly["beams"]}) == 1


def test_of_vertex_and_face_offset_the_heights_decide(tmp_path: Path) -> None:
    made = built(tmp_path, shapes.rotational_mesh([[2, 0], [1.8, 1], [1.3, 1.9], [0.6, 2.5]], 12))
    assert made.summary.gauss_image in (ExactGaussImage("face"), ExactGaussImage("vertex"))
    faces = made.structure.pair.face_distances
    is_face = made.summary.gauss_image == ExactGaussImage("face")
    assert (np.abs(faces - 1).max() < 1e-9) == is_face


def test_every_document_and_inspect_say_so(tmp_path: Path) -> None:
    write_mesh(tmp_path / "M.obj", revolved_pair(12, 5, saddle=False)[0])
    out = tmp_path / "out"
    command = ["build", tmp_path / "M.obj", "--mean-edge", "1500", "-o", out, "--nest", "off"]
    said = CliRunner().invoke(app, list(map(str, command)))
    assert said.exit_code == 0, said.output
    assert "an exact edge offset" in " ".join(said.stdout.split())
    assert json.loads((out / "manifest.json").read_text())["gauss_image"] == {"offset": "edge"}
    assert "an exact edge offset" in (out / "report.html").read_text(encoding="utf-8")
    facts = dict(inspect_mesh(tmp_path / "M.obj").facts())
    assert facts["edge offset"].startswith("yes: beams of constant height")
    assert facts["beam heights"].startswith("1.000 to 1.000")


def test_inspect_judges_offsets_by_s_and_not_by_circles(tmp_path: Path) -> None:
    """Triangles are circular and have none; hexagons that are not circular may have one."""
    patch = shapes.hexagonal_paraboloid(3, 3)
    write_mesh(tmp_path / "hexagons.obj", patch)
    assert dict(inspect_mesh(tmp_path / "hexagons.obj").facts())["vertex offset"].startswith("yes")
    grid = shapes.grid(3, 3)
    bent = grid.vertices + np.stack(
        [0 * grid.vertices[:, 0]] * 2 + [0.1 * grid.vertices[:, 0] * grid.vertices[:, 1]], 1
    )
    triangles = [t for a, b, c, d in grid.combinatorics.faces for t in ([a, b, c], [a, c, d])]
    write_mesh(tmp_path / "triangles.obj", Mesh.from_faces(bent, triangles))
    facts = dict(inspect_mesh(tmp_path / "triangles.obj").facts())
    assert facts["circular"].startswith("yes")
    assert facts["vertex offset"].startswith("no")

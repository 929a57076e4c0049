"""A build in which the mesh and its Gauss image are optimised together, as only --optimise or [optimise] asks for."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from fabkit import Project, design
from fabkit.commands.command_line import app
from fabkit.commands.inspection import inspect_project
from fabkit.errors import FabkitError, ProjectError
from fabkit.production import OptimisedGaussImage
from fabkit.project import project_from
from geometry import write_mesh
from geometry.errors import GeometryError
from geometry.mesh import Mesh, shapes
from tests.fabkit.edge_offsets import revolved_pair
from tests.geometry.design_surfaces import disc

OFF = {"mode": "off"}


def run(*arguments: str | Path) -> Result:
    return CliRunner(env={"COLUMNS": "200"}).invoke(app, [str(argument) for argument in arguments])


def oblique_roof() -> Mesh:
    """Planar quads along lines that are not principal, so that heights vary and axes lean."""
    u = np.linspace(-1, 1, 7)[:, None]
    return shapes.translation_surface(u * [3, 0, 0.2] - u**2 * [0, 0, 1.2], u * [0.9, 2.6, 0] - u**2 * [0, 0, 0.7])


def project(mesh: Mesh | Path, **settings: object) -> Project:
    return project_from({"mesh": mesh, "mean_edge_mm": 1500, "nesting": OFF} | settings)


def spread(heights: np.ndarray) -> float:
    low, middle, high = np.quantile(heights, [0.025, 0.5, 0.975])
    return float((high - low) / middle)


def test_heights_become_even_where_it_is_asked_for_and_nowhere_else() -> None:
    plain, made = design(project(oblique_roof())), design(project(oblique_roof(), optimise={"targets": "heights"}))
    assert plain.summary.gauss_image is None
    image = made.summary.gauss_image
    assert isinstance(image, OptimisedGaussImage)
    before, after = image.height_spread
    assert before == pytest.approx(spread(plain.structure.heights), rel=1e-9)
    assert after == pytest.approx(spread(made.structure.heights), rel=1e-9)
    assert after < before / 3
    moves = np.linalg.norm(made.structure.mesh.vertices - plain.structure.mesh.vertices, axis=1)
    assert image.moves_mm == pytest.approx((np.median(moves), moves.max()), rel=1e-9)
    assert image.farthest_vertex == moves.argmax()
    assert made.structure.mesh.planarity.max() < 1e-12


def test_a_smaller_height_error_makes_heights_more_even() -> None:
    spreads = [
        design(project(oblique_roof(), optimise={"height_error": error})).summary.height_shares
        for error in (0.1, 0.005)
    ]
    widths = [each["p97_5"] - each["p2_5"] for each in spreads]
    assert widths[1] < widths[0] / 2


def test_report_terminal_and_manifest_have_before_and_after(tmp_path: Path) -> None:
    write_mesh(tmp_path / "M.obj", oblique_roof())
    (tmp_path / "roof.toml").write_text(
        "mesh = 'M.obj'\nmean_edge_mm = 1500\n[optimise]\nheight_error = 0.02\n[nesting]\nmode = 'off'\n"
    )
    done = run("build", tmp_path / "roof.toml", "--optimise", "heights,axes", "-o", tmp_path / "built")
    assert done.exit_code == 0, done.output
    manifest = json.loads((tmp_path / "built" / "manifest.json").read_text())
    assert manifest["settings"]["optimise"] == {
        "targets": ["heights", "axes"],
        "height_error": 0.02,
        "moves_refused": 1.0,
    }
    image = manifest["gauss_image"]
    before, after = image["height_spread"]
    report = (tmp_path / "built" / "report.html").read_text()
    for text in (done.stdout, report):
        assert f"{before:.4f} to {after:.4f}" in text
        assert "{:.1f} to {:.1f} degrees".format(*image["lean_p95_deg"]) in text
        assert "beams of nearly constant height and node axes near the normals" in text


def test_inspect_judges_the_optimised_pair(tmp_path: Path) -> None:
    write_mesh(tmp_path / "M.obj", oblique_roof())
    facts = dict(inspect_project(project(tmp_path / "M.obj", optimise={}), is_sized=True).facts())
    assert facts["optimised"].startswith("spread of beam heights")
    done = run("inspect", tmp_path / "M.obj", "--optimise", "heights")
    assert done.exit_code == 0, done.output
    assert "optimised" in done.stdout
    assert "not judged" in done.stdout  # it needs no size
    assert "optimised" not in run("inspect", tmp_path / "M.obj").stdout


def test_vertices_glide_on_the_design_surface_where_there_is_one() -> None:
    surface = disc(16, lambda x, y: x**2 / 2 - y**2 / 4).triangulated * 12.0
    laid = {"unit": "m", "surface": {"faces": 100}, "optimise": {}, "nesting": OFF, "skip_unbuildable": True}
    made = design(project_from({"mesh": surface, **laid}))
    image, on = made.summary.gauss_image, made.summary.surface
    assert isinstance(image, OptimisedGaussImage)
    assert on is not None
    assert image.height_spread[1] < image.height_spread[0]
    assert image.off_surface_p95_mm == pytest.approx(np.quantile(on.distances_mm, 0.95), rel=1e-6)


def test_what_was_found_of_the_mesh_before_is_judged_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the optimised mesh meets itself, the build is refused as any other."""
    seen = []

    def count(mesh: Mesh) -> tuple[()]:
        seen.append(mesh)
        return ()

    monkeypatch.setattr("fabkit.structure.crossings", count)
    made = design(project(oblique_roof(), optimise={}))
    assert seen == [made.structure.mesh]


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"targets": "heigths"}, "optimise.targets.0 is 'heigths': input should be 'heights' or 'axes'"),
        ({"targets": []}, "a target is needed: heights, axes or both"),
        ({"height_error": 0.001}, "optimise.height_error is 0.001: input should be greater than or equal to 0.002"),
        ({"moves_refused": 0}, "optimise.moves_refused is 0"),
        ({"moves": 1}, "unknown key 'moves' in [optimise]"),
    ],
)
def test_wrong_settings_are_one_sentence(settings: dict[str, object], sentence: str) -> None:
    with pytest.raises(ProjectError, match=re.escape(sentence)):
        project(oblique_roof(), optimise=settings)


def test_a_given_gauss_image_is_not_optimised() -> None:
    with pytest.raises(ProjectError, match=r"given by gauss_image.file .*, so that it cannot be optimised"):
        project(Path("M.obj"), optimise={}, gauss_image="S.obj")


@pytest.mark.parametrize(
    ("mesh", "settings", "sentence"),
    [
        (
            oblique_roof(),
            {"moves_refused": 0.01},
            "allowed 0.01: raise moves_refused or height_error in \\[optimise\\]",
        ),
        (revolved_pair(12, 5, saddle=False)[0], {}, "all its beams have one height already"),
    ],
    ids=["moves", "exact"],
)
def test_what_cannot_be_optimised_is_one_sentence(mesh: Mesh, settings: dict[str, object], sentence: str) -> None:
    with pytest.raises((FabkitError, GeometryError), match=sentence) as error:
        design(project(mesh, optimise=settings))
    assert "\n" not in str(error.value)

"""From a design surface to a folder of parts, and `fabkit mesh`."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np
import pytest
from typer.testing import CliRunner, Result

from fabkit import Project, design
from fabkit.commands.command_line import app
from fabkit.errors import ProjectError
from fabkit.formats.polylines import read_polylines, write_polylines
from fabkit.kinds import PANEL
from fabkit.project import project_from
from geometry import Surface, boundary_lengths, read_mesh, write_mesh
from geometry.arrays import FloatArray
from geometry.errors import FoldedError
from geometry.mesh import Mesh
from geometry.remeshing import RemeshedSurface, remesh, study_networks
from tests.fabkit.plain_bars import PLAIN_TABLES
from tests.geometry.design_surfaces import ball, chart, disc
from tests.geometry.topologies import together


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def shell() -> Mesh:
    """A saddle-shaped roof of 24 m, in metres."""
    return disc(16, lambda x, y: x**2 / 2 - y**2 / 4).triangulated * 12.0


@pytest.fixture
def roof(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_mesh("roof.obj", shell().translated([4.8e5, 5.6e6, 100.0]))
    return Path("roof.obj")


def test_a_build_begins_from_a_surface(roof: Path) -> None:
    done = run(
        "build", roof, "--unit", "m", "--edge-length", 2000, "-o", "built", "--nest", "off", "--skip-unbuildable"
    )
    assert done.exit_code == 0, done.output
    manifest = json.loads(Path("built/manifest.json").read_text())
    surface = manifest["surface"]
    assert surface["triangles"] == shell().n_faces
    assert surface["quad_percent"] > 70
    assert surface["distance_mm"]["p95"] < 0.03 * 2000
    assert surface["distance_mm"]["largest"] < 0.1 * 2000
    lengths = read_mesh("built/M.obj").mesh.edge_lengths
    assert np.median(lengths) == pytest.approx(2.0, rel=0.1)
    report = Path("built/report.html").read_text()
    assert report.count("Distance of the vertices from the surface") > 1  # a fact and a histogram
    assert "as laid" in report
    assert "as read" not in report
    assert manifest["settings"]["surface"]["edge_length_mm"] == 2000
    feet = np.linalg.norm(read_mesh("built/M.obj").mesh.vertices.mean(axis=0) - [4.8e5, 5.6e6, 100.0])
    assert feet < 5


def test_a_number_of_faces_needs_no_unit(roof: Path) -> None:
    built = design(project_from({"mesh": roof, "mean_edge_mm": 1500, "surface": {"faces": 150}, **PLAIN_TABLES}))
    assert built.structure.mesh.n_faces == pytest.approx(150, rel=0.15)
    assert built.structure.mesh.mean_edge_length == pytest.approx(1500, rel=0.01)
    assert len(built.assembly.of(PANEL)) == built.structure.mesh.n_faces


def test_a_project_file_says_the_same(roof: Path) -> None:
    Path("lines").mkdir()
    stroke = np.add([[-5, -5, 0], [5, 5, 0]], [4.8e5, 5.6e6, 100.0])
    write_polylines(Path("lines/strokes.obj"), [stroke])
    Path("roof.toml").write_text(
        "mesh = 'roof.obj'\nunit = 'm'\nskip_unbuildable = true\n[surface]\nfaces = 100\nboundary = ['aligned']\n"
        "strokes = 'lines/strokes.obj'\nfiner_where_curved = 2\nsmooth_mm = 500\n[nesting]\nmode = 'off'\n"
    )
    done = run("build", "roof.toml", "-o", "built")
    assert done.exit_code == 0, done.output
    manifest = json.loads(Path("built/manifest.json").read_text())
    assert manifest["surface"]["smoothing_mm"] > 0
    lengths = manifest["surface"]["edge_length_mm"]
    assert lengths["p5"] < lengths["median"] < lengths["p95"]
    assert manifest["settings"]["surface"]["finer_where_curved"] == 2
    assert manifest["settings"]["surface"]["strokes"] == "strokes.obj"  # and nothing of where it is


def test_a_network_that_folds_with_finer_faces_is_passed_over(roof: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    trials = study_networks(
        Surface(read_mesh(roof).near_zero().mesh), maps=[np.eye(3), np.diag([1, 1, 0.5])], n_faces=60
    )
    assert all(trial.pair is not None for trial in trials)
    tried: list[FloatArray] = []

    def folds_first(surface: Surface, **options: Any) -> RemeshedSurface:
        tried.append(options["affine"])
        if len(tried) == 1:
            raise FoldedError("face 3 folded over", "lay it otherwise", elements=[3], value=-1, bound=0)
        return remesh(surface, **options)

    monkeypatch.setattr("fabkit.surface.study_networks", lambda *_, **__: trials)
    monkeypatch.setattr("fabkit.surface.remesh", folds_first)
    done = run("mesh", roof, "--faces", 100, "--lines", "conjugate", "-o", "mesh.obj")
    assert done.exit_code == 0, done.output
    assert "face 3 folded over" in " ".join(done.stdout.split())
    assert np.array_equal(tried[0], trials[0].affine)
    assert np.array_equal(tried[1], trials[1].affine)


def test_inspect_judges_what_a_build_would_make(roof: Path) -> None:
    done = run("inspect", roof, "--unit", "m", "--faces", 100, "--skip-unbuildable")
    assert done.exit_code == 0, done.output
    assert "fit to build" in done.stdout


def test_a_triangle_mesh_without_a_size_names_the_options(roof: Path) -> None:
    done = run("build", roof, "--unit", "m", "-o", "built")
    assert done.exit_code == 2
    said = " ".join(done.stderr.split())
    assert "all faces are triangles" in said
    assert "--faces or --edge-length" in said


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"unit": "m", "surface": {}}, "neither is given: give faces (--faces) or edge_length_mm (--edge-length)"),
        ({"unit": "m", "surface": {"faces": 9, "edge_length_mm": 3}}, "both are given"),
        ({"mean_edge_mm": 9, "surface": {"edge_length_mm": 3}}, "is in mm, but the surface has no unit"),
        ({"unit": "m", "surface": {"faces": 9}, "gauss_image": "S.obj"}, "no Gauss image can be given for it"),
        ({"unit": "m", "surface": {"faces": 3}}, "surface.faces is 3"),
        ({"unit": "m", "surface": {"faces": 9, "finer_where_curved": 0.5}}, "surface.finer_where_curved is 0.5"),
        ({"unit": "m", "surface": {"faces": 9, "lines": "straight"}}, "surface.lines is 'straight'"),
        ({"unit": "m", "surface": {"faces": 9, "edges": 1}}, "unknown key 'edges' in [surface]"),
    ],
)
def test_wrong_settings_are_one_sentence(settings: dict[str, object], sentence: str) -> None:
    with pytest.raises(ProjectError, match=re.escape(sentence)):
        project_from({"mesh": "roof.obj", **settings})


def test_what_the_surface_does_not_allow_is_one_sentence(roof: Path) -> None:
    for options, sentence in (
        (["--edge-length", 50_000], "room for faces of at most 1.136e+04 mm"),
        (["--faces", 100, "--boundary", "open,open"], "2 boundaries are given for a surface with 1 boundary loops"),
        (["--faces", 100, "--strokes", "none.obj"], "none.obj cannot be read"),
    ):
        done = run("build", roof, "--unit", "m", *options, "-o", "built")
        assert done.exit_code == 2, done.output
        assert sentence in " ".join(done.stderr.split())
        assert not Path("built").exists()


def test_a_mesh_is_written_where_the_surface_is(roof: Path) -> None:
    done = run("mesh", roof, "--faces", 150, "-o", "mesh.ply", "--polylines", "lines.dxf")
    assert done.exit_code == 0, done.output
    mesh = read_mesh("mesh.ply").near_zero().mesh
    assert mesh.planarity.max() < 1e-8  # of map coordinates
    assert np.linalg.norm(read_mesh("mesh.ply").mesh.vertices.mean(axis=0) - [4.8e5, 5.6e6, 100.0]) < 5
    lines = read_polylines(Path("lines.dxf"))
    vertices = {tuple(point) for point in read_mesh("mesh.ply").mesh.vertices.round(6).tolist()}
    assert {tuple(point) for line in lines for point in line.round(6).tolist()} <= vertices
    assert run("mesh", roof, "--faces", 150, "-o", "mesh.ply").exit_code == 2  # it exists
    assert run("mesh", roof, "--edge-length", 2000, "-o", "other.ply").exit_code == 2  # no unit
    assert not Path("other.ply").exists()
    assert run("mesh", roof, "--edge-length", 2000, "--unit", "m", "-o", "other.ply").exit_code == 0


def test_the_study_is_a_page_that_shows_the_best_network_first(roof: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("geometry.remeshing.network_study.STRETCH_FACTORS", (0.5,))
    done = run("mesh", roof, "--study", "study.html")
    assert done.exit_code == 0, done.output
    page = Path("study.html").read_text()
    spreads = [float(each) for each in re.findall(r"Heights within ([\d.]+) %", page)]
    assert len(spreads) > 3
    assert not re.search(r"<code>[^<]*e-", page)  # zeros of affine maps are 0, and not what rounding left of them
    assert spreads == sorted(spreads)
    assert "lines of curvature: the identity" in page
    assert page.count("<svg") == len(spreads)


def test_nothing_to_write_is_reported(roof: Path) -> None:
    done = run("mesh", roof, "--faces", 100)
    assert done.exit_code == 2
    assert "give -o FILE" in " ".join(done.stderr.split())


def test_a_project_may_be_made_by_hand(roof: Path) -> None:
    project = Project.model_validate({"mesh": roof, "unit": "m", "surface": {"faces": 60}})
    assert project.surface is not None
    assert project.surface.boundary == "open"


def test_curves_are_written_without_a_mesh(roof: Path) -> None:
    done = run(
        "mesh", roof, "--unit", "m", "--edge-length", 2000, "--curves", "curves.dxf", "--asymptotic", "straight.obj"
    )
    assert done.exit_code == 0, done.output
    assert "principal curves" in done.stdout
    assert "asymptotic curves" in done.stdout
    surface = Surface(shell())
    for name in ("curves.dxf", "straight.obj"):
        points = np.concatenate(read_polylines(Path(name))) - [4.8e5, 5.6e6, 100.0]
        assert np.linalg.norm(surface.closest(points)[0] - points, axis=1).max() < 0.1  # between vertices 0.8 m apart
    layers = {each.dxf.layer for each in ezdxf.readfile("curves.dxf").modelspace()}
    assert layers == {"lines-1", "lines-2"}
    both = run("mesh", roof, "--faces", 100, "--lines", "conjugate", "-o", "mesh.obj", "--curves", "same.obj")
    assert both.exit_code == 0, both.output
    assert "conjugate curves" in both.stdout
    for options, sentence in (
        (["--curves", "x.obj"], "needs either its number of faces or their edge length"),
        (["--curves", "x.svg", "--faces", 100], "one of .obj, .dxf is needed"),
        (["--curves", "x.obj", "--faces", 100, "--boundary", "aligned"], "--boundary changes the lines of a mesh"),
        (["--polylines", "x.obj", "--faces", 100], "--polylines writes the lines of a mesh"),
        (["--curves", "x.obj", "--faces", 1], "faces is 1: input should be greater"),
    ):
        refused = run("mesh", roof, *options)
        assert refused.exit_code == 2, refused.output
        assert sentence in " ".join(refused.stderr.split())
        assert not Path("x.obj").exists()


def test_what_is_particular_about_a_surface_is_reported(roof: Path) -> None:
    flat = chart(40, 20, lambda u, v: (20 * u, 10 * v, 0 * u)).triangulated
    write_mesh("flat.obj", flat)
    done = run("mesh", "flat.obj", "--faces", 100, "-o", "mesh.obj")
    assert done.exit_code == 0, done.output
    assert "100 % of the area: any lines do there" in " ".join(done.stdout.split())
    mesh = read_mesh("mesh.obj").mesh
    along = np.abs(mesh.edge_directions[:, 0])
    assert np.isclose(along, 0, atol=1e-6).mean() + np.isclose(along, 1, atol=1e-6).mean() > 0.9  # its longer side
    holed = chart(48, 12, ring, rings="u").triangulated
    write_mesh("scan.obj", holed)
    first, second = boundary_lengths(Surface(holed)).tolist()
    done = run("mesh", "scan.obj", "--faces", 150, "-o", "scanned.obj")
    assert done.exit_code == 0, done.output
    said = " ".join(done.stdout.split())
    assert f"{first:.4g} and {second:.4g} long; all are kept" in said
    assert len(read_mesh("scanned.obj").mesh.combinatorics.boundary_loops) == 2
    built = design(project_from({"mesh": "scan.obj", "unit": "m", "surface": {"faces": 150}, "skip_unbuildable": True}))
    (fact,) = (fact for fact in built.facts.all if fact.name == "Boundary loops of the surface")
    assert fact.values == (f"{1000 * first:.0f} and {1000 * second:.0f} mm long; all are kept",)
    done = run("mesh", "scan.obj", "--faces", 5, "-o", "coarse.obj")
    assert done.exit_code == 2
    assert "hole" in done.stderr


def ring(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """A saddle-shaped roof of 24 m with a round hole of 6 m."""
    radius, turn = 12 - 9 * v, 2 * np.pi * u
    x, y = radius * np.cos(turn), radius * np.sin(turn)
    return x, y, x**2 / 24 - y**2 / 48


def test_a_closed_mesh_names_its_few_parallel_meshes_and_a_cure(roof: Path) -> None:
    write_mesh("ball.obj", ball(3, (3.0, 2.0, 1.2)).triangulated)
    Path("ball.toml").write_text(
        "mesh = 'ball.obj'\nmean_edge_mm = 1500\n[surface]\nfaces = 150\n[fitness]\nlean_refused_deg = 20\n"
        "[connection]\nkind = 'contact'\n[nodes]\ntop = 'enclosing'\n"
    )
    for options, says in (
        ([], "hardly any parallel meshes (about 6 dimensions, 4 of which scale and move it): leave a strip"),
        (["--optimise", "heights,axes"], "fit to build; nothing is unusual"),
    ):
        done = run("inspect", "ball.toml", *options)
        assert says in " ".join(done.stdout.split()), done.output


def test_a_surface_that_crosses_itself_is_one_sentence(roof: Path) -> None:
    write_mesh("both.obj", together(shell(), shell().translated([3, 1, 0.1])))
    done = run("mesh", "both.obj", "--faces", 100, "-o", "mesh.obj")
    assert done.exit_code == 2
    assert "the surface crosses, touches or covers itself: faces" in " ".join(done.stderr.split())
    assert not Path("mesh.obj").exists()

"""`fabkit inspect --picture`: what is drawn, and a file that appears whole or not at all."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from typer.testing import CliRunner, Result

from fabkit.commands.command_line import app
from fabkit.commands.inspection import inspect_mesh, inspect_project
from fabkit.commands.inspection_picture import draw_inspection
from fabkit.project import Project
from geometry.files import write_mesh
from geometry.mesh import shapes

RADIUS = 5.0
"""Of the dome, in metres."""


@pytest.fixture
def dome(tmp_path: Path) -> Path:
    path = tmp_path / "dome.obj"
    write_mesh(path, RADIUS * shapes.dome(8, 3))
    return path


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, ["inspect", *map(str, arguments)])


def drawn(found: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """The axes of the panels by their titles, and those of their bars by their labels."""
    figures: list[Figure] = []
    save = Figure.savefig
    monkeypatch.setattr(Figure, "savefig", lambda self, *a, **k: (figures.append(self), save(self, *a, **k)))
    draw_inspection(found, tmp_path / "drawn.png")
    (figure,) = figures
    return {axes.get_title() or axes.get_ylabel(): axes for axes in figure.axes}


def test_all_that_is_known_is_drawn_with_its_unit(tmp_path: Path, dome: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    axes = drawn(inspect_project(Project(mesh=dome, unit="m")), tmp_path, monkeypatch)
    assert list(axes) == [
        "dome.obj: 24 faces",
        "Planarity as read",
        "Mean curvature H",
        "Gaussian curvature K",
        "Beam heights",
        "Lean of node axes",
        "over the mean edge",
        "1 / m",
        "1 / m²",
        "over the nominal height",
        "degrees",
    ]
    low, high = axes["1 / m"].get_ylim()
    assert low <= -1 / RADIUS <= high < 0  # outwards on a sphere
    low, high = axes["1 / m²"].get_ylim()
    assert 0 < low <= 1 / RADIUS**2 <= high
    low, high = axes["over the nominal height"].get_ylim()
    assert 0.9 < low < high < 1.1
    for title in list(axes)[:6]:
        (image,) = axes[title].images
        assert np.asarray(image.get_array())[:, :, 3].mean() > 0.3  # the dome, and not a speck of it


def test_a_mesh_without_size_is_measured_by_its_mean_edge(
    tmp_path: Path, dome: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    axes = drawn(inspect_mesh(dome), tmp_path, monkeypatch)
    low, high = axes["1 / mean edge"].get_ylim()
    assert low <= -shapes.dome(8, 3).mean_edge_length <= high < 0


def test_triangles_have_no_gauss_image_and_a_picture_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "triangles.obj"
    quads = shapes.grid(3, 3)
    wavy = quads.vertices + np.outer(np.sin(3 * np.arange(16.0)), [0, 0, 0.1])
    halves = [half for a, b, c, d in quads.faces for half in ((a, b, c), (a, c, d))]
    write_mesh(path, (wavy, halves))
    axes = drawn(inspect_mesh(path), tmp_path, monkeypatch)
    assert list(axes)[:2] == ["triangles.obj: 18 faces, without Gauss image", "Planarity as read"]
    result = run(path, "--picture", tmp_path / "a.png")
    assert result.exit_code == 1  # unfit, as without a picture
    assert (tmp_path / "a.png").exists()


def test_the_command_writes_a_picture_that_is_not_blank(tmp_path: Path, dome: Path) -> None:
    result = run(dome, "--unit", "m", "--picture", tmp_path / "a.png")
    assert result.exit_code == 0, result.output
    assert "picture written to" in result.output
    assert "verdict" in result.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.png", "dome.obj"]
    image = imread(tmp_path / "a.png")[:, :, :3]
    assert min(image.shape[:2]) > 400
    assert 0.2 < (image == 1).all(axis=2).mean() < 0.9
    assert len(np.unique((image * 255).astype(int).reshape(-1, 3), axis=0)) > 1000


def test_what_exists_stays_unless_forced(tmp_path: Path, dome: Path) -> None:
    picture = tmp_path / "a.png"
    picture.write_bytes(b"mine")
    result = run(dome, "--picture", picture)
    assert result.exit_code == 2
    assert "exists already" in result.output
    assert picture.read_bytes() == b"mine"
    assert run(dome, "--picture", picture, "--force").exit_code == 0
    assert picture.read_bytes()[1:4] == b"PNG"


@pytest.mark.parametrize(("name", "words"), [("a.jpg", "ends in .png"), ("none/a.png", "does not exist")])
def test_a_path_that_cannot_be_is_one_sentence(tmp_path: Path, dome: Path, name: str, words: str) -> None:
    result = run(dome, "--picture", tmp_path / name)
    assert result.exit_code == 2
    assert words in " ".join(result.output.split())
    assert [path.name for path in tmp_path.iterdir()] == ["dome.obj"]


def test_without_matplotlib_it_says_what_to_install(
    tmp_path: Path, dome: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    result = run(dome, "--picture", tmp_path / "a.png")
    assert result.exit_code == 2
    assert "pip install 'fabkit[plot]'" in " ".join(result.output.split())
    assert [path.name for path in tmp_path.iterdir()] == ["dome.obj"]

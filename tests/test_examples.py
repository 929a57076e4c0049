"""Every example runs, and what it ships is what it makes."""

from __future__ import annotations

import importlib
import re
import runpy
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from matplotlib.image import imread

from fabkit import design, load_project
from geometry.arrays import FloatArray
from geometry.mesh import read_mesh

ROOT = Path(__file__).parents[1]
EXAMPLES, GALLERY = ROOT / "examples", ROOT / "docs" / "gallery"
FIGURES = sorted(path.stem for path in EXAMPLES.glob("figure_*.py"))

LARGEST_PICTURE = 400_000
"""Bytes: pictures are part of the repository."""


@pytest.fixture(autouse=True)
def _examples_importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)  # as it is for whoever runs one of them


def example(name: str) -> ModuleType:
    return importlib.import_module(name)


@cache
def numbers(figure: int) -> dict[str, float]:
    (name,) = (stem for stem in FIGURES if stem.startswith(f"figure_{figure:02}_"))
    found: dict[str, float] = example(name).main()
    return found


# --- the journey of the README


def test_the_roof_that_ships_is_the_roof_that_the_script_makes(tmp_path: Path) -> None:
    script = runpy.run_path(str(EXAMPLES / "roof.py"))
    script["write"](tmp_path / "roof.obj")
    assert (tmp_path / "roof.obj").read_bytes() == (EXAMPLES / "roof.obj").read_bytes()
    found = script["main"]()
    assert found["faces"] == 288
    assert found["planarity"] < 1e-13  # planes stay planes under a projective map
    shipped = read_mesh(EXAMPLES / "roof.obj")
    assert shipped.mended == ()
    assert shipped.mesh.face_normals[:, 2].min() > 0.5  # the outside is up
    assert np.abs(shipped.mesh.vertices - script["roof"]().vertices).max() <= 0.5e-4 + 1e-12  # four decimals


def test_the_project_file_that_ships_is_one() -> None:
    project = load_project(EXAMPLES / "roof.toml", {"nesting": {"mode": "off"}})
    built = design(project)
    assert built.assembly.name == "Freeform roof"
    assert {beam.section.name for beam in built.assembly.beams} == {"flat 40x140"}


# --- what the figures say, in numbers


def test_figure_3_shows_parallel_meshes_of_different_shape() -> None:
    found = numbers(3)
    assert found["dimension of P(M)"] > found["faces"]  # a face plane each, and the boundary
    assert found["largest sine between corresponding edges"] < 1e-10
    assert 0 < found["least edge factor"] < 0.7
    assert 1.5 < found["largest edge factor"] < 3


def test_figure_4_shows_one_node_with_an_axis_and_one_without() -> None:
    found = numbers(4)
    assert found["largest twist of a beam over M in degrees"] < 1e-9
    assert found["torsion of the node with axis in degrees"] < 1e-9
    assert 10 < found["torsion of the node of a triangle mesh in degrees"] < 20


def test_figure_5_shows_blends_that_are_parallel() -> None:
    found = numbers(5)
    # a factor for each of 15 rings, the 30 sides of the lowest ring but for their two closing conditions, translations
    assert found["dimension of P(M)"] == 15 + 30 - 2 + 3
    assert found["largest sine between corresponding edges"] < 1e-9


def test_figure_7_shows_beams_that_are_misaligned_though_not_twisted() -> None:
    found = numbers(7)
    assert found["least height over d"] < 0.8
    assert found["largest height over d"] > 1.2
    assert found["largest misalignment over the beam height"] > 0.3
    assert found["largest twist in degrees"] < 1e-9


def test_figure_8_shows_edges_at_constant_distance() -> None:
    found = numbers(8)
    assert found["largest deviation of an edge of S from distance 1"] < 1e-12  # a solid in closed form
    assert found["largest deviation of edges of M and M' from distance d, over d"] < 1e-9
    assert found["largest sine between corresponding edges"] < 1e-9
    assert found["least distance of a face of S"] > 0.5
    assert found["largest distance of a face of S"] < 1  # so that all faces cut the sphere


def test_figure_12_shows_a_thin_layer_and_both_signs_of_curvature() -> None:
    found = numbers(12)
    assert 0.2 < found["faces of negative curvature"] / found["faces"] < 0.8
    assert 0.96 < found["innermost radius of S"] < 1 < found["outermost radius of S"] < 1.05
    assert found["innermost radius of S"] <= found["least height over d"]
    assert found["largest height over d"] <= found["outermost radius of S"]


def test_figure_13_shows_that_conical_is_far_and_planar_is_near() -> None:
    found = numbers(13)
    assert found["sharpest angle in degrees"] < 60
    assert found["mean deviation, conical, in edge lengths"] > 1
    assert found["largest deviation, planar, in edge lengths"] < 0.1
    assert 0.8 < found["least beam height over d"] < 1 < found["largest beam height over d"] < 1.2
    assert found["largest twist in degrees"] < 1e-9


# --- the gallery


@pytest.mark.parametrize("name", FIGURES)
def test_each_figure_draws_a_picture(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(example("rendering"), "FINE", 1)  # coarser than what ships, since that is quicker
    example(name).draw(tmp_path / "picture.png")
    shipped, drawn = imread(GALLERY / f"{name[:9]}.png"), imread(tmp_path / "picture.png")
    assert drawn.shape == shipped.shape
    assert drawn.shape[1] >= 1000
    blank = (drawn[:, :, :3] == 1).all(axis=2).mean()
    assert 0.2 < blank < 0.9
    assert len(np.unique((drawn[::2, ::2, :3] * 255).astype(int).reshape(-1, 3), axis=0)) > 50  # shaded, not flat
    # the shipped one shows the same, through ground glass of 20 pixels: smooth and jagged edges then differ by 0.04
    assert np.abs(_coarse(drawn) - _coarse(shipped)).max() < 0.1


def test_what_is_nearer_hides_what_is_behind_and_shines_through_glass() -> None:
    drawing, rendering = example("drawing"), example("rendering")
    square = np.array([[[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]])
    low, high = drawing.polygons(square, "#ff0000"), drawing.polygons(square / 2 + [0, 0, 1], "#0000ff")
    glass = drawing.polygons(square / 2 + [0, 0, 1], "#0000ff", opacity=0.5)
    view = drawing.View(20, 90)  # from above
    camera = rendering.fit(view, square.reshape(-1, 3), 60, 60)
    for shapes in ([low, high], [high, low]):
        image = rendering.render(shapes, camera, 60, 60)
        assert image[30, 30, 2] > 0.5 > image[30, 30, 0] == 0
        assert image[30, 14, 0] > 0.5 > image[30, 14, 2] == 0
    image = rendering.render([glass, low], camera, 60, 60)
    assert image[30, 30, 3] == 1
    assert image[30, 30, 0] > 0.3
    assert image[30, 30, 2] > 0.3
    assert image[0, 30, 3] == pytest.approx(0)
    points = np.random.default_rng(0).normal(size=(20, 3))
    assert camera.unproject(camera.project(points)) == pytest.approx(points, abs=1e-12)  # sizes are about 1


def _coarse(image: FloatArray) -> FloatArray:
    rows, columns = image.shape[0] // 20, image.shape[1] // 20
    tiles = image[: rows * 20, : columns * 20, :3].reshape(rows, 20, columns, 20, 3)
    return np.asarray(tiles.mean(axis=(1, 3)))


def test_the_gallery_has_a_picture_and_an_entry_for_each_figure() -> None:
    gallery = example("gallery")
    text = (GALLERY / "README.md").read_text(encoding="utf-8")
    expected = gallery.page({name[:9]: numbers(int(name[7:9])) for name in FIGURES})
    number = re.compile(r"(?<=\| )-?\d[\d.e+-]*(?= \|)")
    assert number.sub("", text) == number.sub("", expected)
    stated, found = ([float(value) for value in number.findall(page)] for page in (text, expected))
    assert stated == pytest.approx(found, rel=1e-2)  # three digits are printed, and the last may differ by rounding
    assert sorted(path.stem for path in GALLERY.glob("*.png")) == [name[:9] for name in FIGURES]
    assert max(path.stat().st_size for path in GALLERY.glob("*.png")) < LARGEST_PICTURE

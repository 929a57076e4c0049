"""`geometry.plot`: what is drawn, in which colours, and what it says where it cannot."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import matplotlib.pyplot
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread

from geometry import GeometryError, plot
from geometry.arrays import FloatArray
from geometry.colours import ColourScale
from geometry.mesh import Mesh, shapes
from geometry.pictures import default_view

FROM_ABOVE = (-90.0, 90.0)

matplotlib.use("agg")


def axes_of(pixels: int = 200) -> Axes:
    """Axes that fill a picture of so many pixels in both directions."""
    return Figure((pixels / 100, pixels / 100), dpi=100).add_axes((0, 0, 1, 1))


def pixels_of(axes: Axes) -> FloatArray:
    (image,) = axes.images
    return np.asarray(image.get_array())


def hues(rgb: FloatArray) -> FloatArray:
    """Colours without their lightness, which the light changes."""
    return np.asarray(rgb / rgb.max(axis=-1, keepdims=True))


@pytest.mark.parametrize("n", [2, 5])
def test_every_face_is_drawn_in_its_own_colour(n: int) -> None:
    mesh = shapes.grid(n, n)
    colours = np.random.default_rng(1).permutation(
        np.stack(np.meshgrid(*3 * [np.linspace(0.2, 0.9, 3)]), axis=-1).reshape(-1, 3)
    )[: mesh.n_faces]
    image = pixels_of(plot(mesh, colours=colours, view=FROM_ABOVE, edges=False, axes=axes_of()))
    rows, columns = image.shape[:2]
    assert abs(rows - columns) <= 1  # equal scales
    middles = (np.arange(n) + 0.5) / n
    order = mesh.vertices[mesh.combinatorics.corners].reshape(-1, 4, 3).mean(axis=1)
    places = (order - mesh.vertices.min(axis=0)) / np.ptp(mesh.vertices, axis=0).max()
    seen = image[(rows * (1 - places[:, 1])).astype(int), (columns * places[:, 0]).astype(int)]
    assert np.unique(places[:, 0].round(6)) == pytest.approx(middles)
    assert (seen[:, 3] == 1).all()
    assert hues(seen[:, :3]) == pytest.approx(hues(colours), abs=0.01)


def test_values_of_faces_vertices_and_edges_have_the_colours_of_the_scale() -> None:
    mesh = shapes.grid(1, 1)
    mesh = mesh.translated(-mesh.vertices.min(axis=0))  # from 0 to 1
    scale = ColourScale(0.0, 1.0)
    for on, values, at in (
        ("faces", [0.3], [(0.5, 0.5, 0.3), (0.25, 0.7, 0.3)]),
        ("vertices", mesh.vertices[:, 0], [(0.5, 0.5, 0.5), (0.03, 0.5, 0.03), (0.97, 0.5, 0.97)]),
        ("edges", [0.0, 0.25, 0.5, 1.0], []),
    ):
        axes = plot(mesh, values, on=on, value_range=(0, 1), view=FROM_ABOVE, axes=axes_of(), edges=on == "edges")
        image = pixels_of(axes)
        for x, y, value in at:
            seen = image[int(y * len(image)), int(x * image.shape[1]), :3]
            assert hues(seen) == pytest.approx(hues(scale.colours([value])[0]), abs=0.03)
        if on == "edges":
            middle, last = len(image) // 2, len(image) - 3
            lines = [image[middle, 2], image[middle, image.shape[1] - 3], image[2, middle], image[last, middle]]
            c = mesh.combinatorics
            ends = mesh.vertices[c.edges].mean(axis=1)
            sides = [ends[:, 0].argmin(), ends[:, 0].argmax(), ends[:, 1].argmax(), ends[:, 1].argmin()]
            expected = scale.colours(np.array(values)[sides])
            assert np.array(lines)[:, :3] == pytest.approx(expected, abs=0.05)


def test_the_nearer_of_two_squares_hides_the_other() -> None:
    low, high = [[0, 0, 0], [4, 0, 0], [4, 4, 0], [0, 4, 0]], [[1, 1, 1], [3, 1, 1], [3, 3, 1], [1, 3, 1]]
    mesh = Mesh.from_faces([*high, *low], [[0, 1, 2, 3], [4, 5, 6, 7]])
    image = pixels_of(plot(mesh, colours=[[255, 0, 0], [0, 0, 255]], view=FROM_ABOVE, axes=axes_of()))
    middle, side = image[len(image) // 2, len(image) // 2], image[len(image) // 2, len(image) // 10]
    assert middle[0] > 0.5 > middle[2]
    assert side[2] > 0.5 > side[0]


def test_a_bar_names_range_and_what_is_missing() -> None:
    mesh = shapes.grid(2, 2)
    figure = plot(mesh, [0.0, 1.0, np.nan, 5.0], on="faces", value_range=(0, 2), label="mm", axes=axes_of()).figure
    (bar,) = [axes for axes in figure.axes if not axes.images]
    assert bar.get_ylabel() == "mm"
    assert bar.get_ylim() == pytest.approx((0, 2))
    assert bar.get_title(loc="left") == "grey: no value"
    assert len(plot(mesh, colours=np.ones((4, 3)), axes=axes_of()).figure.axes) == 1  # nothing to explain
    plot(mesh, np.full(4, 3.0), axes=axes_of())  # a range of one number


def test_a_file_is_a_picture_that_is_not_blank(tmp_path: Path) -> None:
    open_figures = matplotlib.pyplot.get_fignums()
    mesh = shapes.dome(12, 5)
    axes = plot(mesh, mesh.vertices[:, 2], title="height", path=tmp_path / "dome.png")
    assert axes.get_title() == "height"
    assert matplotlib.pyplot.get_fignums() == open_figures
    image = imread(tmp_path / "dome.png")[:, :, :3]
    assert image.shape[:2] == (600, 900)
    assert 0.2 < (image == 1).all(axis=2).mean() < 0.8
    assert len(np.unique((image * 255).astype(int).reshape(-1, 3), axis=0)) > 500  # shaded
    (picture,) = axes.images
    rows = picture.get_window_extent().height
    assert rows == pytest.approx(picture.get_array().shape[0], abs=1.5)  # a pixel for a pixel


def test_a_figure_of_its_own_is_one_that_pyplot_shows() -> None:
    axes = plot(shapes.grid(2, 2))
    assert axes.figure.number in matplotlib.pyplot.get_fignums()
    matplotlib.pyplot.close(axes.figure)


def test_a_face_of_many_corners_and_one_with_a_notch_are_filled() -> None:
    turn = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    disc = Mesh.from_faces(np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1), [range(400)])
    image = pixels_of(plot(disc, view=FROM_ABOVE, axes=axes_of()))
    assert image[:, :, 3].mean() == pytest.approx(np.pi / 4, abs=0.01)
    arrow = Mesh.from_faces([[-1, -1, 0], [0, 0, 0], [1, -1, 0], [0, 1, 0]], [[0, 1, 2, 3]])
    image = pixels_of(plot(arrow, view=FROM_ABOVE, axes=axes_of()))
    assert image[:, :, 3].mean() == pytest.approx(0.25, abs=0.01)


def test_small_faces_are_not_drowned_in_their_edges() -> None:
    mesh = shapes.grid(150, 150)  # just over a pixel each
    image = pixels_of(plot(mesh, mesh.vertices[:, 0], view=FROM_ABOVE, axes=axes_of()))
    scale = ColourScale.of(mesh.vertices[:, 0])
    inner = image[20:-20, 20:-20, :3]
    wanted = scale.colours(np.linspace(0, scale.high, image.shape[1]))[20:-20]
    assert np.abs(hues(inner) - hues(wanted)).mean() < 0.1


def test_views_look_from_above_and_at_facades_from_in_front() -> None:
    azimuth, elevation = default_view(shapes.grid(9, 3))
    assert -90 < azimuth < 0
    assert elevation > 0
    assert default_view(shapes.grid(3, 9))[0] - azimuth in (pytest.approx(90), pytest.approx(-90), pytest.approx(270))
    upright = shapes.grid(3, 3)
    upright = upright.with_vertices(upright.vertices[:, [0, 2, 1]])
    azimuth, elevation = default_view(upright)
    towards = np.array([np.cos(np.radians(azimuth)), np.sin(np.radians(azimuth)), 0])
    assert towards @ upright.face_normals[0] > 0.8
    assert elevation < 30


@pytest.mark.parametrize("vertices", [np.eye(3), np.eye(3) * 1e-12, np.eye(3) * [1, 1, 0] + 1e6])
def test_a_triangle_is_drawn_wherever_and_however_large_it_is(vertices: FloatArray) -> None:
    assert pixels_of(plot(Mesh.from_faces(vertices, [[0, 1, 2]]), axes=axes_of()))[:, :, 3].mean() > 0.2


def test_what_cannot_be_drawn_is_one_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mesh = shapes.grid(2, 2)
    with pytest.raises(GeometryError, match="5 values, but the mesh has 4 faces, 9 vertices, 12 edges"):
        plot(mesh, np.ones(5))
    with pytest.raises(GeometryError, match="cannot be written"):
        plot(mesh, path=tmp_path / "none" / "a.png")
    with pytest.raises(GeometryError, match="cannot be written"):
        plot(mesh, path=tmp_path / "a.unknown")
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(GeometryError, match=r"pip install 'fabkit\[plot\]'"):
        plot(mesh)

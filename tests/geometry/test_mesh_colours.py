"""Values as colours: the scale, the elements they belong to, and mesh files as programs that are not ours read them."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from geometry import GeometryError, MeshFileError, read_mesh, write_mesh
from geometry.colours import ColourScale, element_colours
from geometry.files.materials import COLOUR_STEPS
from geometry.mesh import Mesh, shapes

EIGHT_BITS = 0.5 / 255 + 1e-9
"""Colours in files are rounded to 8 bits."""

DOME = shapes.dome(8, 3)
AS_MANY_FACES_AS_VERTICES = Mesh.from_faces(np.eye(4)[:, :3], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def triangles() -> Mesh:
    return Mesh.from_faces(DOME.vertices, [part for face in DOME.faces for part in fan(face)])


def fan(face: list[int]) -> list[list[int]]:
    return [[face[0], *face[k : k + 2]] for k in range(1, len(face) - 1)]


def values_of(n: int) -> np.ndarray:
    values = np.linspace(-1.0, 2.0, n)
    values[n // 2] = np.nan
    return values


# --- the scale


def test_values_of_one_sign_run_through_viridis() -> None:
    """As matplotlib has it, whose 256 colours stand for ours: the tolerance is that of steps of 17 of them."""
    values = np.linspace(3.0, 7.0, 400)
    ours, theirs = ColourScale.of(values).colours(values), matplotlib.colormaps["viridis"]((values - 3) / 4)
    assert np.abs(ours - theirs[:, :3]).max() < 0.03


def test_values_of_both_signs_are_white_at_zero_and_as_dark_on_either_side() -> None:
    scale = ColourScale.of([-0.5, 0.1, 2.0])
    assert (scale.low, scale.high) == (-2.0, 2.0)
    colours = scale.colours(np.linspace(-2, 2, 81))
    assert colours[40].min() > 0.93
    assert (np.diff(colours[:41, 0]) > 0).all()  # red grows from blue to white,
    assert (np.diff(colours[40:, 2]) < 0).all()  # blue falls from white to red
    light = colours @ [0.2126, 0.7152, 0.0722]
    assert np.abs(light - light[::-1]).max() < 0.06
    shifted = ColourScale.of([0.0], (-1.0, 2.0))  # a range of one's own keeps white at zero
    np.testing.assert_array_equal(shifted.colours([0.0, 1.0]), scale.colours([0.0, 1.0]))


def test_rounding_below_zero_is_no_sign() -> None:
    assert ColourScale.of([-1e-17, 1.0]).name == "viridis"
    assert ColourScale.of([-1e-3, 1.0]).name == "blue to red"


def test_nan_is_grey_and_what_is_outside_takes_the_nearer_end() -> None:
    scale = ColourScale.of([0.0, np.nan, 1.0, np.inf])
    assert (scale.low, scale.high) == (0.0, 1.0)
    nan, below, low, above, high = scale.colours([np.nan, -5.0, 0.0, np.inf, 1.0])
    assert np.ptp(nan) == 0
    np.testing.assert_array_equal(below, low)
    np.testing.assert_array_equal(above, high)


def test_equal_values_have_one_colour() -> None:
    assert len(np.unique(ColourScale.of([4.0, 4.0]).colours([4.0, 4.0]), axis=0)) == 1


@given(st.lists(st.floats(-1e300, 1e300), min_size=1))
def test_colours_are_between_0_and_1(values: list[float]) -> None:
    colours = ColourScale.of(values).colours(values)
    assert colours.shape == (len(values), 3)
    assert colours.min() >= 0
    assert colours.max() <= 1


# --- what they belong to


@pytest.mark.parametrize(
    ("keywords", "sentence"),
    [
        ({"values": [1.0, 2.0]}, "there are 2 values, but the mesh has 24 faces, 32 vertices: give one for each"),
        ({"values": np.ones(24), "on": "vertices"}, "there are 24 values on vertices, but the mesh has 24 faces"),
        ({"values": np.ones(24), "on": "edges"}, "on='edges': give one of 'faces', 'vertices'"),
        ({"values": np.ones((24, 3))}, "values have shape (24, 3): give (n,), a number for each element"),
        ({"values": ["a"] * 24}, "the values are not all numbers"),
        ({"values": np.full(24, np.nan)}, "none of the values is a finite number"),
        ({"values": np.ones(24), "value_range": (1, 0)}, "a colour scale from 1 to 0"),
        ({"values": np.ones(24), "colours": np.ones((24, 3))}, "values and colours are both given"),
        ({"colours": np.ones(24)}, "colours have shape (24,): give (n, 3)"),
        (
            {"colours": np.full((24, 3), 2.0)},
            "colour 0 (counted from 0) is [2.0, 2.0, 2.0]: give integers from 0 to 255",
        ),
        ({"colours": np.ones((24, 3)), "value_range": (0, 1)}, "value_range is the range of values"),
    ],
)
def test_what_does_not_fit_is_one_sentence(tmp_path: Path, keywords: dict[str, object], sentence: str) -> None:
    with pytest.raises(GeometryError) as caught:
        write_mesh(tmp_path / "dome.ply", DOME, **keywords)
    assert caught.value.message.startswith(sentence)
    assert not list(tmp_path.iterdir())


def test_as_many_faces_as_vertices_asks_which_are_meant() -> None:
    with pytest.raises(GeometryError, match="may belong to faces or vertices: say on='faces' or on='vertices'"):
        element_colours(AS_MANY_FACES_AS_VERTICES, np.arange(4))
    assert element_colours(AS_MANY_FACES_AS_VERTICES, np.arange(4), on="vertices").on == "vertices"


# --- files, read by others


@pytest.mark.parametrize("suffix", [".obj", ".off", ".ply"])
@pytest.mark.parametrize("on", ["faces", "vertices"])
def test_the_mesh_comes_back_whatever_its_colours(tmp_path: Path, suffix: str, on: str) -> None:
    n = getattr(DOME, f"n_{on}")
    for k, colours in enumerate((np.zeros((n, 3), int), np.full((n, 3), 12), np.ones((n, 3)), np.full((n, 3), 0.4))):
        path = tmp_path / f"a {k}{suffix}"
        write_mesh(path, DOME, colours=colours)
        found = read_mesh(path)
        assert found.mended == ()
        np.testing.assert_array_equal(found.mesh.vertices, DOME.vertices)
        assert found.mesh.combinatorics.same_as(DOME.combinatorics)


def test_trimesh_finds_the_colours_of_faces_in_ply(tmp_path: Path) -> None:
    mesh, path = triangles(), tmp_path / "a.ply"
    values = values_of(mesh.n_faces)
    write_mesh(path, mesh, values=values, on="faces")
    found = trimesh.load(path, process=False).visual
    assert found.kind == "face"
    assert found.face_colors[:, :3] / 255 == pytest.approx(ColourScale.of(values).colours(values), abs=EIGHT_BITS)


@pytest.mark.parametrize("suffix", [".obj", ".ply"])
def test_trimesh_finds_the_colours_of_vertices(tmp_path: Path, suffix: str) -> None:
    path, values = tmp_path / f"a{suffix}", values_of(DOME.n_vertices)
    write_mesh(path, DOME, values=values)
    found = trimesh.load(path, process=False)
    np.testing.assert_array_equal(found.vertices, DOME.vertices)
    rgb = ColourScale.of(values).colours(values)
    assert found.visual.vertex_colors[:, :3] / 255 == pytest.approx(rgb, abs=EIGHT_BITS)


def test_trimesh_finds_the_colours_of_faces_in_materials(tmp_path: Path) -> None:
    mesh, values = triangles(), values_of(triangles().n_faces)
    write_mesh(tmp_path / "a.obj", mesh, values=values)
    scene = trimesh.load(tmp_path / "a.obj", process=False)
    found = {}
    for part in scene.geometry.values():
        for corners in part.triangles:
            found[tuple(corners.mean(axis=0).round(9))] = part.visual.material.main_color[:3] / 255
    centres = mesh.vertices[mesh.combinatorics.corners].reshape(-1, 3, 3).mean(axis=1).round(9)
    rgb = ColourScale.of(values).colours(values)
    step = np.abs(np.diff(ColourScale(-2, 2).colours(np.linspace(-2, 2, COLOUR_STEPS + 1)), axis=0)).max()
    assert np.array([found[tuple(centre)] for centre in centres]) == pytest.approx(rgb, abs=step / 2 + EIGHT_BITS)


def test_materials_are_named_by_what_they_show(tmp_path: Path) -> None:
    write_mesh(tmp_path / "a.obj", DOME, values=values_of(24), value_range=(0.0, 64.0))
    names = [line.split()[1] for line in (tmp_path / "a.mtl").read_text().splitlines() if line.startswith("newmtl")]
    assert names == ["without_value", "0_to_1", "1_to_2", "2_to_3"]  # in the order of the steps
    used = [line.split()[1] for line in (tmp_path / "a.obj").read_text().splitlines() if line.startswith("usemtl")]
    assert used == ["0_to_1", "without_value", "0_to_1", "1_to_2", "2_to_3"]
    write_mesh(tmp_path / "b.obj", DOME, colours=np.tile([[255, 0, 16]], (24, 1)))
    assert "newmtl colour_ff0010\nKd 1.000000 0.000000 0.062745" in (tmp_path / "b.mtl").read_text()


@pytest.mark.parametrize("on", ["faces", "vertices"])
def test_meshio_finds_the_colours_of_polygons_in_ply(tmp_path: Path, on: str) -> None:
    meshio = pytest.importorskip("meshio")
    n = getattr(DOME, f"n_{on}")
    write_mesh(tmp_path / "a.ply", DOME, values=values_of(n))
    found = meshio.read(tmp_path / "a.ply")
    data = found.point_data if on == "vertices" else {name: parts[0] for name, parts in found.cell_data.items()}
    rgb = np.stack([data[channel] for channel in ("red", "green", "blue")], axis=1) / 255
    assert rgb == pytest.approx(ColourScale.of(values_of(n)).colours(values_of(n)), abs=EIGHT_BITS)


def test_off_has_colours_where_its_grammar_puts_them(tmp_path: Path) -> None:
    """Geomview's: `COFF` has four numbers behind each vertex; three fractions stand behind the corners of a face."""
    rgb = np.tile([[1.0, 0.5, 0.0]], (32, 1))
    write_mesh(tmp_path / "a.off", DOME, colours=rgb)
    lines = (tmp_path / "a.off").read_text().splitlines()
    assert lines[0] == "COFF"
    assert {tuple(line.split()[3:]) for line in lines[2:34]} == {("255", "128", "0", "255")}
    write_mesh(tmp_path / "b.off", DOME, colours=rgb[:24])
    lines = (tmp_path / "b.off").read_text().splitlines()
    assert lines[0] == "OFF"
    assert {tuple(line.split()[5:]) for line in lines[-24:]} == {("1.000000", "0.500000", "0.000000")}


def test_a_folder_that_does_not_exist_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(MeshFileError, match="there is no folder"):
        write_mesh(tmp_path / "none" / "a.obj", DOME, values=values_of(24))

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

from docs.tools import drawing, gallery
from docs.tools.step_shapes import StepShapes
from fabkit import design, load_project
from geometry.arrays import FloatArray
from geometry.files import read_mesh
from geometry.mesh import Mesh
from geometry.pictures import rendering
from tests.fabkit.part21 import StepText

ROOT = Path(__file__).parents[1]
EXAMPLES, GALLERY = ROOT / "examples", ROOT / "docs" / "gallery"
FIGURES = sorted(path.stem for path in EXAMPLES.glob("figure_*.py"))

LARGEST_PICTURE = 400_000
"""Bytes: pictures are part of the repository."""


def example(name: str) -> ModuleType:
    return importlib.import_module(f"examples.{name}")


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
    assert {beam.details.section.name for beam in built.assembly["beams"]} == {"rhs 140x50x5"}


# --- what the figures say, in numbers


def test_figure_1_shows_fins_that_lean_for_more_shade() -> None:
    found = numbers(1)
    assert found["fins"] == 325  # one on each edge
    assert 0.6 < found["length of x"] < 0.7 + 1e-9  # at most what the project allows
    shares = (found["share of the panels in the shade, fins along S" + x] for x in ("", " + x"))
    assert next(shares) + 0.1 < next(shares) < 1
    assert found["area of the fins along S + x in m2"] > found["area of the fins along S in m2"]


def test_figure_2_shows_two_layers_of_parallel_beams() -> None:
    found = numbers(2)
    assert found["beams"] == found["lower beams"]
    assert found["largest sine between a beam and the one below it"] < 1e-12
    assert 1050 < found["least distance of two nodes in mm"] < found["largest distance of two nodes in mm"] < 1150
    assert found["longest strut in mm"] < found["least distance of two nodes in mm"] - 100  # both blocks are between


def test_shapes_of_a_step_file_lie_where_their_parts_are() -> None:
    assembly = example("figure_02_two_layers").built().assembly
    step = StepShapes.written(assembly)
    for parts in assembly.groups:
        assert step.count(parts.kind.group) == len(parts)
        drawn = np.concatenate([each.corners.reshape(-1, 3) for each in step.shapes(parts.kind.group, "#000000")])
        points = np.concatenate([batch.vertices.reshape(-1, 3) for batch in parts.placed()]) / 1000
        rim = 1e-6 if parts.kind.group != "struts" else 0.031  # tubes are drawn about their axes: a radius of 30.15 mm
        for extreme in (np.min, np.max):
            assert np.abs(extreme(drawn, axis=0) - extreme(points, axis=0)).max() < rim


def test_figure_15_shows_how_much_of_each_panel_is_in_the_shade() -> None:
    found = numbers(15)
    for letter in ("(a)", "(b)"):
        least, mean, most = (
            found[f"{what} {letter}"]
            for what in ("least share of a panel,", "share in the shade,", "largest share of a panel,")
        )
        assert 0 < least < mean < most <= 1 + 1e-9
    assert found["least share of a panel, (b)"] > found["least share of a panel, (a)"]


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


def test_figure_6_shows_beams_that_meet_exactly_and_takes_them_to_step(tmp_path: Path) -> None:
    found = numbers(6)
    for which in ("largest misalignment of their outer edges", "largest misalignment of their inner edges"):
        assert found[f"{which}, over the height"] < 1e-9
    assert found["misalignment of beams on node axes, over the height"] < 1e-9
    assert found["largest twist in degrees"] < 1e-9
    assert found["least angle over an edge in degrees"] > 10  # convex
    assert found["neighbouring beams"] > found["beams"]
    assert found["parts in the STEP file"] == found["beams"] + found["nodes"] + found["panels"]
    example("figure_06_exact_nodes").write(tmp_path / "dome.step")
    assert (tmp_path / "dome.step").stat().st_size == found["bytes of the STEP file"]
    read = StepText((tmp_path / "dome.step").read_text(encoding="ascii"))
    assert set(read.references()) <= set(read.instances)
    assert len(read.all("MANIFOLD_SOLID_BREP")) == found["different parts"]
    groups = 4  # the structure's beams, nodes and panels are instances too, and the structure is a product
    assert len(read.all("NEXT_ASSEMBLY_USAGE_OCCURRENCE")) == found["parts in the STEP file"] + groups - 1
    assert len(read.all("PRODUCT")) == found["different parts"] + groups


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


def test_figure_9_shows_circles_that_touch_and_cross_at_right_angles() -> None:
    found = numbers(9)
    assert found["vertices"] - found["edges"] + found["faces"] == 2
    assert found["largest deviation of an edge from distance 1"] < 1e-9
    for kind in ("faces", "vertices"):
        assert found[f"largest distance of points of tangency from the circles of {kind}"] < 1e-9
        assert found[f"largest sine between circles of neighbouring {kind}"] < 1e-9
    assert found["largest cosine between circles of faces and vertices"] < 1e-9
    assert found["largest radius of a face circle"] > 1.5 * found["least radius of a face circle"]


def test_figure_10_shows_edge_offsets_before_and_after() -> None:
    found = numbers(10)
    assert found["largest deviation of the mean curvature of M from -1"] < 1e-9
    assert 0.4 < found["faces of M with negative Gaussian curvature"] / found["faces"] < 0.5  # S runs over itself once
    for image in ("S", "S'"):
        assert found[f"largest deviation of an edge of {image} from distance 1"] < 1e-9
    for offset in ("M and M + d S", "M' and M' + d S'"):
        assert found[f"largest deviation of edges of {offset} from distance d, over d"] < 1e-9
    assert found["largest sine between edges of M' and S'"] < 1e-9
    assert found["faces of M' that cross themselves or others"] == 0
    pictured = example("figure_10_laguerre")
    m, moved = pictured.original().mesh, pictured.transformed().mesh
    turned = m.vertices @ _turn(2 * np.pi / pictured.AROUND).T  # M has an axis, M' has lost it
    assert _farthest(turned, m.vertices) < 1e-9
    turned = moved.vertices @ _turn(2 * np.pi / pictured.AROUND).T
    assert _farthest(turned, moved.vertices) > moved.mean_edge_length / 2


def _turn(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _farthest(points: FloatArray, others: FloatArray) -> float:
    """The largest distance of a point from the nearest of the others."""
    return float(np.linalg.norm(points[:, None] - others, axis=2).min(axis=1).max())


def test_figure_11_shows_negative_curvature_and_reversed_edges() -> None:
    found = numbers(11)
    assert found["largest Gaussian curvature"] < -0.1
    assert 0.4 < found["reversed edges"] / found["edges"] < 0.6
    assert found["largest deviation of an edge of S from distance 1"] < 1e-9
    assert found["largest deviation of edges of M and M + d S from distance d, over d"] < 1e-9
    assert found["largest sine between corresponding edges"] < 1e-9
    assert found["least absolute edge factor"] > 1 - 1e-9
    assert found["largest absolute edge factor"] < 10
    assert found["faces of M that cross themselves or others"] == 0


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


def test_figure_14_goes_from_a_surface_to_beams() -> None:
    found = numbers(14)
    assert [found[f"singular points of ({letter})"] for letter in "abc"] == [2, 4, 0]
    assert found["crossing angle in degrees that 5 % of (a) are below"] == pytest.approx(90)
    assert 75 < found["crossing angle in degrees that 5 % of (c) are below"] < 85
    assert found["share of quads"] > 0.95
    assert found["largest planarity as laid"] < 0.01
    assert found["largest planarity of M"] < 1e-12
    assert found["95 % of the moves in edge lengths"] < 0.08
    assert found["95 % of the distances from the surface in edge lengths"] < 0.03
    assert 0.95 < found["5 % of the beam heights over d"] < found["95 % of the beam heights over d"] < 1.05
    assert found["95 % of the leans of node axes in degrees"] < 20
    assert found["largest twist in degrees"] < 1e-9


def test_figure_17_shows_parallel_diagonals_and_a_minimal_mesh() -> None:
    found = numbers(17)
    assert found["largest mean curvature, times the waist radius"] < 1e-9
    assert found["largest Gaussian curvature, times its square"] < -0.01
    assert found["largest sine between 13 and 2*4*"] < 1e-9
    assert found["largest sine between 24 and 1*3*"] < 1e-9
    assert found["largest sine between corresponding edges"] < 1e-9
    assert found["reversed edges"] == found["faces"]  # the meridians: one a face, as rows are closed
    assert found["least radius of S"] < 0.95 < 1.05 < found["largest radius of S"]  # no sphere
    assert found["faces of M that cross themselves or others"] == 0


def test_figure_18_shows_a_minimal_mesh_with_edge_offsets() -> None:
    found = numbers(18)
    assert found["largest mean curvature, times the waist radius"] < 1e-9
    assert found["largest Gaussian curvature, times its square"] < -0.1
    assert found["largest deviation of an edge of S from distance 1"] < 1e-9
    assert found["largest sine between corresponding edges"] < 1e-9
    assert found["reversed edges"] == found["faces"]  # one side of each hexagon, as rows are closed
    assert found["faces of M that cross themselves or others"] == 0


def test_figure_19_joins_pieces_with_one_gauss_image_and_one_mean_curvature() -> None:
    found = numbers(19)
    assert found["largest deviation of the mean curvature from -1"] < 1e-11
    assert -1.03 < found["mean curvature of 95 % of the faces, S from M alone, from"] < found["to"] < -0.97
    assert found["plane deviation, in mean edge lengths"] < 1e-12
    assert found["lean of 95 % of the axes, at most, in degrees"] < 3
    assert found["least distance of vertices of S from the origin"] > 0.95
    assert found["largest distance of vertices of S from the origin"] < 1.05
    assert found["largest deviation of edges of the bulges from distance 1"] < 0.02


# --- the gallery


@pytest.mark.parametrize("name", FIGURES)
def test_each_figure_draws_a_picture(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rendering, "OVERSAMPLING", 1)  # coarser than what ships, since that is quicker
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


def test_a_face_with_a_notch_is_drawn_without_it() -> None:
    arrow = np.array([[-1.0, -1, 0], [0, 0.5, 0], [1, -1, 0], [0, 1, 0]])
    for turn in range(4):
        shapes = drawing.faces(Mesh.from_faces(np.roll(arrow, turn, axis=0), [[0, 1, 2, 3]]), "#ff0000", width=0.0)
        camera = rendering.fit(drawing.View(-90, 90), arrow, 60, 60)
        image = rendering.render(shapes, camera, 60, 60)
        column, row = camera.project(np.array([0.0, 0.75, 0.0]))[:2].astype(int)
        assert image[row, column, 3] == 1
        column, row = camera.project(np.array([0.0, 0.0, 0.0]))[:2].astype(int)
        assert image[row, column, 3] == 0


def _coarse(image: FloatArray) -> FloatArray:
    rows, columns = image.shape[0] // 20, image.shape[1] // 20
    tiles = image[: rows * 20, : columns * 20, :3].reshape(rows, 20, columns, 20, 3)
    return np.asarray(tiles.mean(axis=(1, 3)))


def test_the_gallery_has_a_picture_and_an_entry_for_each_figure() -> None:
    text = (GALLERY / "README.md").read_text(encoding="utf-8")
    expected = gallery.page({name[:9]: numbers(int(name[7:9])) for name in FIGURES})
    number = re.compile(r"(?<=\| )-?\d[\d.e+-]*(?= \|)")
    assert number.sub("", text) == number.sub("", expected)
    stated, found = ([float(value) for value in number.findall(page)] for page in (text, expected))
    assert stated == pytest.approx(found, rel=1e-2)  # three digits are printed, and the last may differ by rounding
    assert sorted(path.stem for path in GALLERY.glob("*.png")) == ["connections", *(name[:9] for name in FIGURES)]
    assert max(path.stat().st_size for path in GALLERY.glob("*.png")) < LARGEST_PICTURE

"""`fabkit design` with files of one's own: pairs of few digits, pairs that are none, surfaces with too many normals."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import numpy as np
import pytest

from fabkit.designs import (
    EdgeOffsetDesign,
    cmc_near_design,
    hexagons_design,
    koebe_design,
    minimal_design,
    write_design,
)
from fabkit.errors import ProjectError
from fabkit.families import Faces, MinimalShape, Tiles
from geometry.edge_offset.buildability import (
    LEAST_FACE_WIDTH,
    largest_buildable_patch,
    least_face_widths,
    without_unbuildable_rim,
)
from geometry.errors import GeometryError
from geometry.files import write_mesh
from geometry.gauss import Pair
from geometry.mesh import Mesh, shapes
from geometry.mesh.intersections.meeting_faces import is_embedded
from tests.fabkit.test_designs import refused, run, surface
from tests.real_data.meshes import DATA, HEXAGONAL, needs_data


def rounded(folder: Path, digits: int, **meshes: Mesh) -> Path:
    folder.mkdir()
    for name, mesh in meshes.items():
        write_mesh(folder / f"{name}.obj", mesh.with_vertices(np.round(mesh.vertices, digits)))
    return folder


# --- few digits


def test_pairs_of_few_digits_are_made_exact_before_they_are_designed_with(tmp_path: Path) -> None:
    dome = koebe_design(tiles=Tiles.HEXAGONS, count=6)
    files = rounded(tmp_path / "dome", 6, M=dome.mesh, S=dome.pair.gauss_image)
    even = cmc_near_design(files / "M.obj", files / "S.obj").measures()
    assert even["edges_off_parallel"] < 1e-12
    assert 1e-12 < even["edges_of_s_off_distance_1"] < 1e-6  # six digits say no more
    assert even["mean_curvature"]["largest"] - even["mean_curvature"]["least"] < 1e-8


def test_hexagons_have_a_dual_even_with_few_digits_and_quads_say_that_they_need_more(tmp_path: Path) -> None:
    catenoid = minimal_design(faces=Faces.HEXAGONS, count=12)
    files = rounded(tmp_path / "hexagons", 7, S=catenoid.pair.gauss_image)
    found = minimal_design(gauss_image=files / "S.obj").measures()
    assert abs(found["mean_curvature"]["largest"]) < 1e-12
    enneper = minimal_design(shape=MinimalShape.ENNEPER, count=6)
    files = rounded(tmp_path / "quads", 7, S=enneper.pair.gauss_image)
    with pytest.raises(
        ProjectError, match=r"no Christoffel dual.*S\.obj is off the unit sphere by .*e-0. .*more digits"
    ):
        minimal_design(gauss_image=files / "S.obj")


@needs_data
def test_the_dual_of_a_real_file(tmp_path: Path) -> None:
    said = run("design", "minimal", "--gauss-image", DATA / HEXAGONAL, "-o", tmp_path / "out")
    assert said.exit_code == 0, said.output
    measures = json.loads((tmp_path / "out" / "manifest.json").read_text())["measures"]
    assert measures["faces"] == 180
    assert abs(measures["mean_curvature"]["least"]) < 1e-12


# --- no pairs, or none near


def test_what_has_no_common_height_of_beams_is_not_written(tmp_path: Path) -> None:
    dome = koebe_design(count=4)
    write_design(dome, tmp_path / "dome")
    m, s, out = tmp_path / "dome" / "M.obj", tmp_path / "dome" / "S.obj", tmp_path / "out"
    swapped = refused("design", "cmc", "--start", s, "--gauss-image", m, "-o", out)
    assert "of the Gauss image is off the unit sphere by" in swapped
    assert "(counted from 0)" in swapped
    assert "allowed 1e-05" in swapped
    assert "give a Koebe polyhedron" in refused("design", "minimal", "--gauss-image", m, "-o", out)
    assert not out.exists()


@pytest.mark.parametrize("mean", [0.0, 5.0])
def test_a_mesh_that_shrinks_to_a_point_is_none(tmp_path: Path, mean: float) -> None:
    write_design(koebe_design(count=8), tmp_path / "dome")
    with pytest.raises(GeometryError, match=rf"shrunk to a point, .* mean curvatures are nearer to {mean:g}$"):
        cmc_near_design(tmp_path / "dome" / "M.obj", tmp_path / "dome" / "S.obj", mean=mean)


def test_an_edge_that_has_shrunk_is_named(tmp_path: Path) -> None:
    cube = shapes.cube() * 0.5**0.5
    flat = cube.with_vertices(cube.vertices * [1.0, 1.0, 1e-7])  # parallel, with four edges that are nearly points
    edge = int(flat.edge_lengths.argmin())
    i, j = flat.combinatorics.edges[edge]
    with pytest.raises(ProjectError, match=rf"edge {edge} from vertex {i} to vertex {j} of the mesh has shrunk to"):
        EdgeOffsetDesign.of("koebe", Pair(flat, cube), {}).measures()


def test_counts_beyond_memory_get_a_sentence(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def too_much(**_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("fabkit.designs.cmc_design", too_much)
    assert "not enough memory" in refused("design", "cmc", "-o", tmp_path / "out")


# --- faces that can be built


def test_necks_are_distances_of_corners_from_edges_across() -> None:
    flat = [[0, 0, 0], [4, 0, 0], [4, 3, 0], [2, 1, 0], [0, 3, 0]]  # a notch that leaves 1 at the bottom
    assert least_face_widths(Mesh.from_faces(np.array(flat, float), [[0, 1, 2, 3, 4]])) == pytest.approx([1.0])
    assert least_face_widths(shapes.grid(2, 3)) == pytest.approx(np.full(6, 1.0))


def test_rims_come_off_until_all_that_is_left_can_be_built() -> None:
    grid = shapes.grid(7, 7)
    vertices = grid.vertices.copy()
    vertices[0] = [2.5, 2.5, 0.0]  # the corner far beyond its face
    bent = grid.with_vertices(vertices)
    assert not is_embedded(bent)
    assert len(without_unbuildable_rim(bent)) == 25
    assert sorted(largest_buildable_patch(bent, np.arange(49))) == list(range(1, 49))
    thin = grid.with_vertices(grid.vertices * [1.0, LEAST_FACE_WIDTH / 3, 1.0])
    assert len(without_unbuildable_rim(thin)) == 49  # none is wide enough: all are left


# --- hexagons on surfaces


def test_hexagons_turn_to_where_their_edges_are_longest(tmp_path: Path) -> None:
    file = surface(tmp_path, (0.7, -0.8))
    with pytest.raises(ProjectError, match=r"hexagons that touch .* turn them by another angle"):
        hexagons_design(file, count=10, turn_deg=0.0)
    fit = hexagons_design(file, count=10)
    assert fit.settings["turn_deg"] in (15.0, 45.0)
    assert fit.mesh.edge_lengths.min() > 0.5 * fit.mesh.mean_edge_length
    assert fit.mesh.n_faces > 70


def test_for_a_surface_with_repeated_normals_their_number_is_reported(tmp_path: Path) -> None:
    n = 60
    grid = shapes.grid(n, n)
    x, y = (grid.vertices[:, :2] * 4 / n - 2).T
    write_mesh(tmp_path / "waves.obj", grid.with_vertices(np.column_stack([x, y, 0.4 * np.cos(3 * x) * np.cos(3 * y)])))
    _, note = hexagons_design(tmp_path / "waves.obj").notes
    assert 20 < float(note.split("normal of waves.obj occurs ")[1].split()[0]) < 40  # some 15 waves, up and down
    (only,) = hexagons_design(surface(tmp_path, (-1.0, -0.7)), count=9).notes
    assert "normals" not in only


@needs_data
@pytest.mark.parametrize(("name", "times"), [("dome", 2.2), ("botanic-garden-bubble", 2.0)])
def test_surfaces_that_hexagons_do_not_cover_are_refused(tmp_path: Path, name: str, times: float) -> None:
    file = DATA / f"directional/{name}.off"
    sentence = refused("design", "hexagons", file, "-o", tmp_path / "out")
    assert f"hexagons that touch {name}.off can be built together" in sentence
    assert float(sentence.split(f"normal of {name}.off occurs ")[1].split()[0]) == pytest.approx(times, abs=0.2)
    assert list(tmp_path.iterdir()) == []


def test_cmc_barrels_stand_between_inflections_and_a_sphere(tmp_path: Path) -> None:
    for faces in ("quads", "hexagons"):
        out = tmp_path / faces
        said = run("design", "cmc", "--folds", "0", "--faces", faces, "-o", out)
        assert said.exit_code == 0, said.output
        manifest = json.loads((out / "manifest.json").read_text())
        assert 0.83 < manifest["settings"]["bulge"] < 1.0
        assert manifest["measures"]["mean_curvature"]["median"] == pytest.approx(-1.0, rel=1e-9)
        assert manifest["measures"]["edge_lengths"]["least"] > 0.6 * manifest["measures"]["edge_lengths"]["mean"]


# --- what is printed


@pytest.mark.parametrize("name", ["-", "-o", "two words", "it's", "$HOME"])
def test_what_to_type_next_can_be_typed(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    said = run("design", "koebe", "--count", "2", f"--out={name}")
    assert said.exit_code == 0, said.output
    program, *arguments = shlex.split(said.stdout.splitlines()[-1])
    assert program == "fabkit"
    result = run(*arguments, "--nest", "off")
    assert result.exit_code == 0, result.output
    assert (tmp_path / f"{name}-built" / "manifest.json").is_file()

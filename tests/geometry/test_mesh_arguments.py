"""What is taken where a mesh is asked for, and the sentence for what is not: natural mistakes, one by one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import geometry
from geometry import (
    Combinatorics,
    GeometryError,
    Guides,
    Mesh,
    MeshError,
    Pair,
    ParallelSpace,
    SupportStructure,
    Surface,
    approximate_pair,
    as_mesh,
    christoffel_dual,
    edge_offset_mesh,
    exact_pairs,
    face_curvatures,
    koebe,
    planarise,
    read_mesh,
    tangent_mesh,
    write_mesh,
)
from geometry.arrays import short_repr
from geometry.functionals import laplacian
from geometry.mesh import shapes, solids, tilings
from geometry.mesh.polygons import face_centroids

GRID = shapes.grid(3, 3)
DOME = shapes.dome(8, 3)
OPEN = koebe(tilings.quad_patch(3, 3))


class Held:
    """Anything that has a mesh."""

    def __init__(self, mesh: Mesh) -> None:
        self.mesh = mesh


# --- accepted


def test_a_mesh_stays_the_same_object_and_so_does_one_inside_another() -> None:
    for given in (DOME, Held(DOME), Pair(DOME, DOME), Surface(DOME), ParallelSpace(DOME), planarise(DOME)):
        assert as_mesh(given) is DOME


def test_what_holds_a_mesh_is_taken_where_a_mesh_is(tmp_path: Path) -> None:
    write_mesh(tmp_path / "dome.obj", Held(DOME))
    file = read_mesh(tmp_path / "dome.obj")
    optimised = planarise(file)
    pair = approximate_pair(optimised)
    assert pair.mesh is optimised.mesh
    assert set(exact_pairs(Held(DOME))) == set(exact_pairs(DOME))
    assert ParallelSpace(optimised).contains(optimised)
    assert Pair(Held(DOME), Held(DOME)).gauss_image is DOME  # type: ignore[arg-type]
    assert koebe(DOME).mesh.combinatorics is DOME.combinatorics


def test_koebe_polyhedra_are_gauss_images() -> None:
    S = OPEN.mesh
    assert (christoffel_dual(OPEN).mesh - christoffel_dual(S).mesh).vertices.any() == np.False_
    np.testing.assert_array_equal(
        edge_offset_mesh(OPEN, signs=1, lengths=(1.0, 9.0)).vertices,
        edge_offset_mesh(S, signs=1, lengths=(1.0, 9.0)).vertices,
    )
    hexagons = koebe(tilings.hexagon_patch(2, 2))
    ball = Surface(solids.truncated_icosahedron())
    assert tangent_mesh(hexagons, ball).mesh.n_faces == 4


def test_of_a_pair_the_gauss_image_is_taken_where_one_is_asked_for() -> None:
    pair = christoffel_dual(OPEN)
    np.testing.assert_array_equal(christoffel_dual(pair).mesh.vertices, pair.mesh.vertices)
    np.testing.assert_array_equal(geometry.vertex_distances(pair), pair.vertex_distances)


def test_what_holds_a_pair_is_taken_where_a_pair_is() -> None:
    pair = Pair(DOME, DOME)
    structure = SupportStructure(pair, 0.1)
    assert SupportStructure(structure, 0.2).pair is pair  # type: ignore[arg-type]
    np.testing.assert_array_equal(face_curvatures(structure).mean, face_curvatures(pair).mean)


def test_positions_and_faces_are_taken_together() -> None:
    assert planarise((GRID.vertices, np.array(GRID.faces))).mesh.combinatorics.same_as(GRID.combinatorics)


# --- making meshes


@pytest.mark.parametrize(("closed", "faces"), [((False, False), 12), ((True, False), 16), ((True, True), 20)])
def test_grids_of_points_become_quads(closed: tuple[bool, bool], faces: int) -> None:
    points = np.random.default_rng(0).random((4, 5, 3))
    mesh = Mesh.from_grid(points, closed=closed)
    assert mesh.n_faces == faces
    np.testing.assert_array_equal(mesh.vertices.reshape(4, 5, 3), points)
    assert mesh.faces[0].tolist() == [0, 5, 6, 1]
    assert mesh.combinatorics.euler_characteristic == (0 if any(closed) else 1)


def test_rows_along_x_and_columns_along_y_are_seen_from_above() -> None:
    x, y = np.meshgrid([0.0, 1.0], [0.0, 2.0], indexing="ij")
    assert Mesh.from_grid(np.stack([x, y, 0 * x], axis=2)).vector_areas.tolist() == [[0, 0, 2]]


@pytest.mark.parametrize(
    ("shape", "closed"), [((4, 3), (False, False)), ((1, 5, 3), (False, False)), ((2, 5, 3), (True, False))]
)
def test_grids_with_too_few_points_are_refused(shape: tuple[int, ...], closed: tuple[bool, bool]) -> None:
    with pytest.raises(MeshError, match=r"a grid \(m, n, 3\) is needed, with m and n from 2 upwards"):
        Mesh.from_grid(np.zeros(shape), closed=closed)


def test_faces_come_as_rows_of_an_array_too() -> None:
    rows = np.array(GRID.faces, dtype=np.int32)
    assert Mesh.from_faces(GRID.vertices, rows).combinatorics.same_as(GRID.combinatorics)
    with pytest.raises(MeshError, match=r"face 1 names vertex 0\.5"):
        Mesh.from_faces(GRID.vertices, [[0, 1, 2], [0.5, 1, 2]])  # type: ignore[list-item]


def test_faces_are_read_only_and_pick_their_corners() -> None:
    means = np.array([GRID.vertices[face].mean(axis=0) for face in GRID.faces])
    np.testing.assert_array_equal(means, face_centroids(GRID.vertices, GRID.combinatorics))
    with pytest.raises(ValueError, match="read-only"):
        GRID.faces[0][0] = 5


# --- the vector space


def test_meshes_are_added_up_negated_and_divided() -> None:
    M, S = DOME, DOME.translated([1, 2, 3])
    np.testing.assert_array_equal(sum([M, S]).vertices, M.vertices + S.vertices)  # type: ignore[union-attr]
    np.testing.assert_array_equal((-M / 2).vertices, -M.vertices / 2)
    np.testing.assert_array_equal((np.float64(2) * M).vertices, 2 * M.vertices)
    np.testing.assert_array_equal((M - Held(M)).vertices, np.zeros_like(M.vertices))  # type: ignore[operator]


# --- refused in a sentence

ARRAY = r"not an array of shape \(16, 3\): positions become one by Mesh.from_faces\(vertices, faces\)"
TO_ADD = "only a mesh with the same faces can be added to a mesh, not "
TO_SCALE = "a mesh is multiplied by or divided by a number, not "

MISTAKES: list[tuple[str, Callable[[], Any], str]] = [
    ("planarise(array)", lambda: planarise(GRID.vertices), ARRAY),  # type: ignore[arg-type]
    ("approximate_pair(array)", lambda: approximate_pair(GRID.vertices), ARRAY),  # type: ignore[arg-type]
    ("project(array)", lambda: ParallelSpace(GRID).project(GRID.vertices), ARRAY),  # type: ignore[arg-type]
    ("ParallelSpace(array)", lambda: ParallelSpace(GRID.vertices), ARRAY),  # type: ignore[arg-type]
    ("Pair(M, array)", lambda: Pair(GRID, GRID.vertices), ARRAY),  # type: ignore[arg-type]
    ("koebe(array)", lambda: koebe(GRID.vertices), ARRAY),  # type: ignore[arg-type]
    ("planarise(path)", lambda: planarise("roof.obj"), "not the path roof.obj: read the file by read_mesh"),  # type: ignore[arg-type]
    ("planarise(Path)", lambda: planarise(Path("roof.obj")), "not the path roof.obj"),  # type: ignore[arg-type]
    ("planarise(c)", lambda: planarise(GRID.combinatorics), "not a Combinatorics: give it vertices by Mesh"),  # type: ignore[arg-type]
    ("planarise(None)", lambda: planarise(None), "not a value of type NoneType: give a Mesh"),  # type: ignore[arg-type]
    ("planarise(Mesh)", lambda: planarise(Mesh), "not the class Mesh: give a Mesh"),  # type: ignore[arg-type]
    ("planarise((M, S))", lambda: planarise((GRID, GRID)), "coordinates are numbers in an array"),  # type: ignore[arg-type]
    ("face_curvatures(M)", lambda: face_curvatures(GRID), "a Pair is needed, not a value of type Mesh: make one"),  # type: ignore[arg-type]
    ("SupportStructure(M)", lambda: SupportStructure(GRID, 1.0), "a Pair is needed, not a value of type Mesh"),  # type: ignore[arg-type]
    ("Mesh(V, F)", lambda: Mesh(GRID.vertices, GRID.faces), r"from faces by Mesh.from_faces\(vertices, faces\)"),  # type: ignore[arg-type]
    ("from_faces(F, V)", lambda: Mesh.from_faces(GRID.faces, GRID.vertices), "vertices and faces are exchanged"),  # type: ignore[arg-type]
    ("from_faces(V, 5)", lambda: Mesh.from_faces(GRID.vertices, 5), "faces are sequences of the numbers"),  # type: ignore[arg-type]
    ("from_faces(V, flat)", lambda: Mesh.from_faces(GRID.vertices, [0, 1, 2]), "faces are sequences"),  # type: ignore[list-item]
    ("from_faces(V, text)", lambda: Mesh.from_faces(GRID.vertices, ["abc"]), "faces are sequences"),  # type: ignore[list-item]
    ("from_faces(dict, F)", lambda: Mesh.from_faces({0: 1}, GRID.faces), "coordinates are numbers in an array"),
    ("from_faces(V2, F)", lambda: Mesh.from_faces(GRID.vertices[:, :2], GRID.faces), "vertices have shape"),
    ("M + 3", lambda: GRID + 3, f"{TO_ADD}a value of type int"),  # type: ignore[operator]
    ("3 + M", lambda: 3 + GRID, f"{TO_ADD}a value of type int"),
    ("M - array", lambda: GRID - GRID.vertices, f"{TO_ADD}an array of shape"),  # type: ignore[operator]
    ("array - M", lambda: GRID.vertices - GRID, f"{TO_ADD}an array of shape"),  # type: ignore[operator]
    ("M * M", lambda: GRID * GRID, f"{TO_SCALE}a value of type Mesh"),  # type: ignore[operator]
    ("array * M", lambda: np.ones(3) * GRID, f"{TO_SCALE}an array of shape"),  # type: ignore[operator]
    ("M / 0", lambda: GRID / 0, "a mesh is divided by 0"),
    ("write_mesh(M, path)", lambda: write_mesh(GRID, "a.obj"), r"the path comes first, write_mesh\(path, mesh\)"),  # type: ignore[arg-type]
    ("read_mesh(M)", lambda: read_mesh(GRID), "a path is needed, not a value of type Mesh"),  # type: ignore[arg-type]
    (
        "Guides(fixed=mask)",
        lambda: planarise(shapes.hexagonal_paraboloid(2, 2), Guides(fixed=np.ones(16, bool))),
        "mask",
    ),  # type: ignore[arg-type]
    (
        "minimise(fixed=array)",
        lambda: _minimise(fixed=GRID.vertices),
        r"dict\(zip\(vertices, mesh.vertices\[vertices\]\)",
    ),
    (
        "minimise((1, f))",
        lambda: _minimise((1, laplacian(GRID.combinatorics))),
        "term 0 of `quadratic` is a value of type int",
    ),
    ("minimise([f])", lambda: _minimise([laplacian(GRID.combinatorics)]), "pairs of a weight and a linear functional"),
    ("minimise(f)", lambda: _minimise(laplacian(GRID.combinatorics)), "pairs of a weight and a linear functional"),
    ("minimise([(1, g)])", lambda: _minimise([(1, laplacian)]), "pairs of a weight and a linear functional"),
    ("minimise([('1', f)])", lambda: _minimise([("1", laplacian(GRID.combinatorics))]), "for its weight: a number"),
    ("edge_offset_mesh(near=array)", lambda: edge_offset_mesh(OPEN, near=OPEN.mesh.vertices), "a dict from vertices"),  # type: ignore[arg-type]
]


def _minimise(quadratic: Any = (), **options: Any) -> Mesh:
    return ParallelSpace(GRID).minimise(quadratic or [(1.0, laplacian(GRID.combinatorics))], **options)


@pytest.mark.parametrize(("call", "sentence"), [pytest.param(*m[1:], id=m[0]) for m in MISTAKES])
def test_natural_mistakes_are_answered_in_a_sentence(call: Callable[[], Any], sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence) as error:
        call()
    assert "\n" not in error.value.message
    assert len(error.value.message) < 300


def test_faces_that_make_no_mesh_either_way_are_not_called_exchanged() -> None:
    with pytest.raises(MeshError, match="face 0 names vertex 99, but there are 16 vertices"):
        Mesh.from_faces(GRID.vertices, [[0, 1, 99]])


# --- reprs


def values() -> list[Any]:
    pair = Pair(DOME, DOME)
    return [
        *(DOME, DOME.combinatorics, pair, planarise(DOME), OPEN, ParallelSpace(DOME), Surface(DOME)),
        *(SupportStructure(pair, 0.1), face_curvatures(pair), geometry.Curvature.of(DOME), geometry.offset(pair, 0.1)),
        *(Guides(fairness=0.01, fixed=np.arange(10_000), curves=[[0, 1]] * 500), OPEN.face_circles),
    ]


@pytest.mark.parametrize("value", values(), ids=lambda value: type(value).__name__)
def test_reprs_are_one_short_line(value: Any) -> None:
    text = repr(value)
    assert text.startswith(type(value).__name__)
    assert "\n" not in text
    assert len(text) < 100


def test_reprs_say_how_large_a_mesh_is() -> None:
    assert repr(shapes.grid(8, 8)) == "Mesh(81 vertices, 64 faces, 144 edges)"
    assert repr(Combinatorics.from_faces(3, [[0, 1, 2]])) == "Combinatorics(3 vertices, 1 faces, 3 edges)"
    assert repr(Guides()) == "Guides()"
    assert repr(OPEN.face_circles) == "SphereCircles(normals (9, 3), distances (9,))"


def test_public_dataclasses_that_hold_arrays_have_a_short_repr() -> None:
    plain = {"Effort", "PairTargets"}  # numbers and words only
    public = {name: getattr(geometry, name) for name in geometry.public.__all__}
    assert {name for name, value in public.items() if is_dataclass(value) and value.__repr__ is not short_repr} <= plain

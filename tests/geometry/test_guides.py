"""Optimised meshes that keep what they are asked to keep: fixed vertices, curves, a surface, convex faces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError, MeshError
from geometry.mesh import Mesh, shapes
from geometry.meshing import Effort, Guides, make_circular, planarise
from geometry.meshing.vertex_guides import MeshGuides
from geometry.optimise.solution import ConvergenceError
from geometry.surface.curve import Curve
from geometry.surface.surface import Surface
from tests.geometry.bent_meshes import graph, out_of_plane, shaken, vault

seeds = st.integers(0, 2**32 - 1)


# --- fixed vertices


@given(seeds, st.lists(st.integers(0, vault().n_vertices - 1), max_size=3), st.floats(-100, 100))
@settings(max_examples=15)
def test_fixed_vertices_stay_to_the_last_bit(seed: int, fixed: list[int], shift: float) -> None:
    bent = shaken(vault(), 0.02, seed)
    bent = bent.with_vertices(bent.vertices + shift)
    result = planarise(bent, Guides(fixed=fixed), Effort(tolerance=1e-11))  # coordinates up to 100 round by 1e-14
    np.testing.assert_array_equal(result.mesh.vertices[fixed], bent.vertices[fixed])
    assert out_of_plane(result.mesh) <= 1e-11


def test_fixing_what_would_not_move_changes_nothing() -> None:
    bent = shaken(vault(), 0.02, 1)
    free = planarise(bent)
    held = planarise(bent, Guides(fixed=np.flatnonzero(bent.combinatorics.is_boundary_vertex)))
    assert held.largest_move > 0
    assert held.mesh.vertices.tolist() != free.mesh.vertices.tolist()
    again = planarise(free.mesh, Guides(fixed=[0, 1, 2]))
    assert again.mesh is free.mesh


def test_faces_that_cannot_move_are_named() -> None:
    bent = shaken(vault(), 0.02, 1)
    for fixed in (bent.combinatorics.face(7), range(bent.n_vertices)):
        with pytest.raises(
            ConvergenceError, match=r"face \d+ is off its plane by .*all its vertices are fixed"
        ) as raised:
            planarise(bent, Guides(fixed=fixed))
        if len(fixed) == 4:
            assert raised.value.elements == (7,)


def test_where_no_vertex_is_free_nothing_is_returned() -> None:
    plane = shapes.grid(3, 2)  # planar, but not on the surface
    surface = Surface(shapes.grid(3, 2).translated([0, 0, 0.5]))
    everything = range(plane.n_vertices)
    with pytest.raises(ConvergenceError, match=r"cannot change, since all its vertices are fixed.* before planarising"):
        planarise(plane, Guides(surface=surface, fixed=everything))
    assert planarise(plane, Guides(fixed=everything)).mesh is plane  # as it is asked for
    kite = Mesh.from_faces([[0, 0, 0], [2, 0, 0], [1, 1, 0], [0, 1, 0], [5, 5, 5]], [[0, 1, 2, 3]])
    with pytest.raises(ConvergenceError, match=r"cannot change.* before making the mesh circular"):
        make_circular(kite, Guides(fixed=range(4)))  # vertex 4 belongs to no face


@given(st.integers(2, 6), st.integers(2, 6), seeds)
def test_the_expected_dimension_is_the_number_of_coordinates_less_that_of_equations(
    nx: int, ny: int, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    mesh = shaken(shapes.grid(nx, ny), 0.1, seed)  # in general position
    fixed = np.flatnonzero(rng.random(mesh.n_vertices) < rng.random())
    free = np.repeat(~np.isin(np.arange(mesh.n_vertices), fixed), 3)
    c = mesh.combinatorics
    a, b, d, e = mesh.vertices[c.corners.reshape(-1, 4)].swapaxes(0, 1)
    # the derivatives of the volumes of the tetrahedra of the faces
    gradients = np.zeros((mesh.n_faces, mesh.n_vertices, 3))
    faces = np.arange(mesh.n_faces)
    for corner, vectors in enumerate([np.cross(e - b, d - b), np.cross(d - a, e - a), np.cross(e - a, b - a)]):
        gradients[faces, c.corners.reshape(-1, 4)[:, corner]] = vectors
    gradients[faces, c.corners.reshape(-1, 4)[:, 3]] = np.cross(b - a, d - a)
    rows = gradients.reshape(mesh.n_faces, -1)[:, free]
    found = Guides(fixed=fixed).expected_dimension(mesh)
    assert found == free.sum() - np.abs(rows).max(axis=1, initial=0.0).astype(bool).sum()


def test_too_few_free_vertices_are_the_reason() -> None:
    bent = shaken(shapes.grid(2, 2), 0.1, 0)
    guides = Guides(fixed=np.flatnonzero(bent.combinatorics.is_boundary_vertex))
    assert guides.expected_dimension(bent) == -1
    with pytest.raises(
        ConvergenceError, match="make 1 more equations than the 1 free vertices have coordinates: fix fewer"
    ):
        planarise(bent, guides)
    vaulted = vault()
    loose, kept = (Guides(keep_boundary=keep).expected_dimension(vaulted) for keep in (False, True))
    c = vaulted.combinatorics
    corners = MeshGuides.of(vaulted, Guides(keep_boundary=True)).is_fixed.sum()
    assert loose - kept == 3 * corners + 2 * (c.is_boundary_vertex.sum() - corners)


def test_corners_next_to_each_other_are_attracted_where_there_is_a_surface() -> None:
    grid = shapes.grid(6, 6)
    zigzag = np.where((grid.vertices[:, 1] == 0) & (grid.vertices[:, 0] % 2 == 0), -0.9, 0.0)
    jagged = grid.with_vertices(grid.vertices + zigzag[:, None] * [0, 1, 0])
    far_corners = np.flatnonzero(np.isin(grid.vertices[:, 0], [0, 6]) & (grid.vertices[:, 1] == 6)).tolist()
    with_surface = MeshGuides.of(jagged, Guides(surface=Surface(jagged), keep_boundary=True))
    assert np.flatnonzero(with_surface.is_fixed).tolist() == far_corners
    assert sum(len(vertices) for _, vertices in with_surface.boundary) == 24 - 2
    assert MeshGuides.of(jagged, Guides(keep_boundary=True)).is_fixed.sum() == 2 + 7


# --- curves


def arch(n: int = 8) -> Mesh:
    """A shell with a round boundary without corners: n x 3 quads of an ellipsoid."""
    dome = shapes.dome(n, 3)
    return dome.with_vertices(dome.vertices * [1.0, 1.3, 0.7])


def ring(mesh: Mesh, number: int) -> list[int]:
    """The vertices at one height of a rotational mesh with 4 points on each meridian, once around."""
    loop = list(range(number, mesh.n_vertices, 4))
    return [*loop, loop[0]]


@given(seeds, st.floats(-5, 5))
@settings(max_examples=10)
def test_boundaries_glide_along_themselves(seed: int, decades: float) -> None:
    bent = shaken(arch(12), 0.02, seed)
    bent = bent.with_vertices(bent.vertices * 10**decades)
    result = planarise(bent, Guides(keep_boundary=True)).mesh
    assert out_of_plane(result) <= 1e-12
    moves = np.linalg.norm(result.vertices - bent.vertices, axis=1) / bent.mean_edge_length
    for loop in bent.combinatorics.boundary_loops:
        curve = Curve.through(bent.vertices[loop], closed=True)
        feet, _ = curve.closest(result.vertices[loop])
        np.testing.assert_allclose(result.vertices[loop], feet, atol=1e-9 * bent.mean_edge_length)
        assert moves[loop].max() > 1e-4  # they do glide
    free = planarise(bent).mesh
    loop = bent.combinatorics.boundary_loops[0]
    off = free.vertices[loop] - Curve.through(bent.vertices[loop], closed=True).closest(free.vertices[loop])[0]
    assert np.abs(off).max() > 1e-6 * bent.mean_edge_length  # and would not stay by themselves


def test_corners_ends_and_crossings_stay() -> None:
    bent = shaken(vault(6, 6), 0.02, 3)
    first, second = [[7 * 3 + j for j in range(7)], [7 * i + 2 for i in range(7)]]  # lines i = 3 and j = 2
    result = planarise(bent, Guides(curves=[first, second], keep_boundary=True)).mesh
    corners, crossing = [0, 6, 42, 48], [7 * 3 + 2]
    ends = [first[0], first[-1], second[0], second[-1]]  # they lie on the boundary too
    stay = corners + crossing + ends
    np.testing.assert_array_equal(result.vertices[stay], bent.vertices[stay])
    for path in (first, second):
        feet, _ = Curve.through(bent.vertices[path], closed=False).closest(result.vertices[path])
        np.testing.assert_allclose(result.vertices[path], feet, atol=1e-9)
        assert np.abs(result.vertices[path] - bent.vertices[path]).max() > 1e-4
    assert out_of_plane(result) <= 1e-12


def test_closed_curves_have_no_ends() -> None:
    bent = shaken(arch(12), 0.02, 4)
    path = ring(bent, 1)
    closed, opened = (planarise(bent, Guides(curves=[p])).mesh.vertices for p in (path, path[:-1]))
    curve = Curve.through(bent.vertices[path[:-1]], closed=True)
    np.testing.assert_allclose(closed[path], curve.closest(closed[path])[0], atol=1e-9)
    assert np.abs(closed - bent.vertices)[path].min() > 0
    np.testing.assert_array_equal(opened[[path[0], path[-2]]], bent.vertices[[path[0], path[-2]]])


@pytest.mark.parametrize(
    ("curves", "sentence"),
    [
        ([[0, 99]], "curve 0 names 99, but vertices have the numbers 0 to 47"),
        ([[0, 1], [-1, 0]], "curve 1 names -1"),
        ([[0, 1, 2, 7]], "curve 0 runs from vertex 2 to vertex 7, which no edge joins"),
        ([[0, 1, 2, 1]], "curve 0 passes vertex 1 twice"),
        ([[0]], "curve 0 has 1 vertices"),
        ([[]], "curve 0 has 0 vertices"),
        ([[0, 1, 0]], "curve 0 has 2 vertices"),
        ([[0.0, 1.0]], r"curve 0 is \[0.0, 1.0\]: vertices are given by their numbers"),
        ([0, 1], "curve 0 is 0"),
    ],
)
def test_paths_that_are_none_are_refused(curves: list[list[int]], sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence):
        planarise(arch(12), Guides(curves=curves))


@pytest.mark.parametrize(
    ("name", "values", "sentence"),
    [
        ("fixed", [48], "fixed names 48, but vertices have the numbers 0 to 47"),
        ("fixed", [-1], "fixed names -1"),
        ("fixed", [0.5], r"fixed is \[0.5\]: vertices are given by their numbers"),
        ("fixed", [True, False], "fixed is"),
        ("fixed", "all", "fixed is 'all'"),
        ("convex", [36], "convex names 36, but faces have the numbers 0 to 35"),
        ("convex", "some", "convex is 'some'"),
        ("surface", shapes.cube(), r"the surface is a Mesh, not a Surface: make one by Surface\(mesh\)"),
    ],
)
def test_what_does_not_exist_is_refused(name: str, values: object, sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence):
        planarise(arch(12), Guides(**{name: values}))


def test_an_edge_without_length_is_refused_before_curves_are_laid() -> None:
    vertices = arch().vertices.copy()
    vertices[4] = vertices[0]
    with pytest.raises(MeshError, match=r"edge \d+ from vertex \d+ to vertex \d+ has no length"):
        planarise(arch().with_vertices(vertices), Guides(keep_boundary=True))


# --- a surface


def off_sphere(mesh: Mesh) -> float:
    """Mean distance from the unit sphere, over the mean edge length."""
    return float(np.abs(np.linalg.norm(mesh.vertices, axis=1) - 1).mean()) / mesh.mean_edge_length


def test_vertices_glide_on_a_sphere() -> None:
    sphere = Surface(shapes.rotational_mesh(_meridian(60), 120))
    bent = shaken(shapes.dome(18, 8), 0.05, 1)
    without, result = planarise(bent), planarise(bent, Guides(surface=sphere))
    assert out_of_plane(result.mesh) <= 1e-12
    assert off_sphere(result.mesh) < 0.6 * off_sphere(without.mesh)
    assert without.surface_distance is None
    distances = np.linalg.norm(result.mesh.vertices - sphere.closest(result.mesh.vertices)[0], axis=1)
    assert result.surface_distance == pytest.approx(distances.max() / bent.mean_edge_length)


def _meridian(n: int) -> np.ndarray:
    latitudes = np.radians(np.linspace(-89.5, 89.5, n))
    return np.stack([np.cos(latitudes), np.sin(latitudes)], axis=1)


def paraboloid(n: int) -> Mesh:
    mesh = graph(n, lambda x, y: 0.2 * x**2 + 0.34 * y**2 + 0.1 * x**2 * y)
    return mesh.with_vertices(mesh.vertices * 20 / n)


def test_a_mesh_beside_a_surface_is_attracted_to_it() -> None:
    surface = Surface(paraboloid(60))
    below = paraboloid(12)
    above = below.with_vertices(below.vertices + np.array([0, 0, 1.0]))
    distances = [
        np.abs(surface.distances(made.mesh.vertices)[0]).mean()
        for made in (planarise(above), planarise(above, Guides(surface=surface)))
    ]
    assert distances[1] < 0.2 * distances[0]


@given(seeds, st.floats(-4, 4))
@settings(max_examples=4)
def test_the_unit_of_a_surface_does_not_matter(seed: int, decades: float) -> None:
    surface, bent = paraboloid(30), shaken(paraboloid(8), 0.02, seed)
    scale, shift = 10**decades, np.array([3.0, -2.0, 5.0])
    moved, under = (m.with_vertices((m.vertices + shift) * scale) for m in (bent, surface))
    one, other = planarise(bent, Guides(surface=Surface(surface))), planarise(moved, Guides(surface=Surface(under)))
    # the surface is made of triangles; a vertex near an edge may take either, which differ by an angle of some 1e-2
    np.testing.assert_allclose(other.mesh.vertices / scale - shift, one.mesh.vertices, atol=1e-3)
    assert other.surface_distance == pytest.approx(one.surface_distance, rel=1e-2)


def test_a_planar_mesh_on_its_own_surface_stays() -> None:
    mesh = vault()
    result = planarise(mesh, Guides(surface=Surface(mesh)))
    assert result.mesh is mesh
    assert result.surface_distance == pytest.approx(0.0, abs=1e-12)
    beside = mesh.with_vertices(mesh.vertices + np.array([0, 0, 0.1]))
    drawn = planarise(beside, Guides(surface=Surface(mesh)))
    assert drawn.mesh is not beside
    # planar as it is, so all it has to do is to come nearer: 10 against 1 where it is free to
    assert np.abs(Surface(mesh).distances(drawn.mesh.vertices)[0]).mean() < 0.02


# --- convex faces


def dented(amount: float) -> tuple[Mesh, int]:
    """A vault with an inner vertex pushed across the middle of a face from 0.5 on, and that face."""
    mesh = vault()
    c = mesh.combinatorics
    vertex = 12
    face = int(c.corner_face[np.flatnonzero(c.corners == vertex)[0]])
    vertices = mesh.vertices.copy()
    vertices[vertex] += 2 * amount * (vertices[c.face(face)].mean(axis=0) - vertices[vertex])
    return mesh.with_vertices(vertices), face


def least_turn(mesh: Mesh, face: int) -> float:
    """The least turning angle at the corners of a face, seen along its normal, in radians."""
    corners = mesh.vertices[mesh.combinatorics.face(face)]
    edges = np.roll(corners, -1, axis=0) - corners
    before = np.roll(edges, 1, axis=0)
    turns = np.arctan2(np.cross(before, edges) @ mesh.face_normals[face], np.einsum("ni,ni->n", before, edges))
    return float(turns.min())


@pytest.mark.parametrize("amount", [0.3, 0.55, 0.7, 0.9])
def test_faces_come_out_convex_where_asked(amount: float) -> None:
    mesh, face = dented(amount)
    free = planarise(mesh).mesh
    assert (least_turn(free, face) < 0) == (amount > 0.5)
    for convex in ([face], "all"):
        result = planarise(mesh, Guides(convex=convex)).mesh
        assert out_of_plane(result) <= 1e-12
        assert least_turn(result, face) > 0.005  # 0.01 of l is asked between edges of up to twice that
        if convex == "all":
            assert min(least_turn(result, other) for other in range(mesh.n_faces)) > 0.005


def test_convex_faces_cost_nothing_where_they_are_so_anyway() -> None:
    mesh, _ = dented(0.3)
    np.testing.assert_array_equal(planarise(mesh, Guides(convex="all")).mesh.vertices, planarise(mesh).mesh.vertices)


def test_a_planar_face_that_is_not_convex_is_not_left_as_it_is() -> None:
    mesh = planarise(dented(0.7)[0]).mesh
    face = dented(0.7)[1]
    assert planarise(mesh).mesh is mesh
    assert least_turn(planarise(mesh, Guides(convex=[face])).mesh, face) > 0


def test_a_face_that_cannot_become_convex_is_named() -> None:
    mesh, face = dented(0.7)
    with pytest.raises(ConvergenceError, match=f"face {face} is not convex: a corner turns by -") as raised:
        planarise(mesh, Guides(convex="all", fixed=mesh.combinatorics.face(face)))
    assert raised.value.elements == (face,)
    assert raised.value.value is not None
    assert raised.value.value < 0

"""Curvatures of faces with respect to a Gauss image: what Steiner's formula and Minkowski's inequality promise."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from geometry.arrays import FloatArray
from geometry.curvature import FaceCurvatures, face_curvatures, steiner_area, steiner_areas
from geometry.errors import GeometryError, MeshError, ParallelityError
from geometry.gauss import Pair
from geometry.mesh import Combinatorics, Mesh, shapes, solids
from geometry.mesh.polygons import face_centroids

ROUNDING = 1e-13
"""Sizes from 0.1 to 10 and a few dozen operations; areas of faces at least a tenth of their edges squared."""

seeds = st.integers(0, 2**32 - 1)
numbers = st.floats(0.1, 10)


def polygons(rng: np.random.Generator, k: int, n: int, *, convex: bool) -> tuple[FloatArray, FloatArray]:
    """Corners (n, k, 3) of polygons in planes of their own, and of others parallel to them, turned over or not."""
    angles = np.sort(rng.dirichlet(np.full(k, 20.0), n).cumsum(axis=1) * 2 * np.pi, axis=1)
    radii = np.ones((n, k)) if convex else rng.uniform(0.2, 1, (n, k))
    first = np.stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros((n, k))], axis=2)
    edges = np.roll(first, -1, axis=1) - first
    second = np.zeros_like(first)
    for polygon, along in zip(second, edges, strict=True):
        factors = null_space(along[:, :2].T) @ rng.uniform(-1, 1, k - 2)  # the edges must close
        polygon[1:] = np.cumsum(factors[:, None] * along, axis=0)[:-1]
    turns = Rotation.random(n, rng=rng).as_matrix()
    moves = rng.uniform(-1, 1, (2, n, 1, 3))
    return tuple(pair @ turns.transpose(0, 2, 1) + move for pair, move in zip((first, second), moves, strict=True))


def separate(corners: FloatArray) -> Mesh:
    """A mesh of polygons (n, k, 3) that have nothing to do with each other."""
    n, k, _ = corners.shape
    return Mesh(corners.reshape(-1, 3), Combinatorics(n * k, np.arange(n * k), np.arange(0, n * k + 1, k)))


@st.composite
def parallel_faces(draw: st.DrawFn, *, convex: bool = False) -> tuple[Mesh, Mesh]:
    rng, k = np.random.default_rng(draw(seeds)), draw(st.integers(3, 8))
    first, second = polygons(rng, k, 10, convex=convex)
    mesh = separate(first)
    areas = np.linalg.norm(mesh.vector_areas, axis=1)
    assume(areas.min() > 0.1)
    return mesh, mesh.with_vertices(second.reshape(-1, 3))


def ring(radii: object, heights: object, n: int) -> FloatArray:
    """Vertices of a rotational mesh, numbered as `rotational_mesh`; radii may be negative."""
    angles = 2 * np.pi / n * np.arange(n)[:, None]
    x, y = np.cos(angles) * np.asarray(radii), np.sin(angles) * np.asarray(radii)
    return np.stack([x, y, np.broadcast_to(np.asarray(heights), x.shape)], axis=2).reshape(-1, 3)


def assert_equal(found: FaceCurvatures, expected: FaceCurvatures, atol: float = ROUNDING) -> None:
    for name in ("areas", "mean", "gaussian"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=0, atol=atol, err_msg=name)
    # a root takes half the digits where the principal curvatures are nearly equal
    np.testing.assert_allclose(found.principal, expected.principal, rtol=0, atol=atol**0.5, equal_nan=True)


@given(parallel_faces(), st.floats(-10, 10))
def test_offsets_have_the_areas_that_the_curvatures_say(pair: tuple[Mesh, Mesh], d: float) -> None:
    """For every d, faces that turn over in the offset counted negative."""
    mesh, image = pair
    offset = mesh + d * image
    normals = mesh.vector_areas / np.linalg.norm(mesh.vector_areas, axis=1, keepdims=True)
    signed = np.einsum("fk,fk->f", offset.vector_areas, normals)
    size = 1 + abs(d) * (1 + np.abs(image.vertices).max())
    np.testing.assert_allclose(steiner_areas(Pair(mesh, image), d), signed, rtol=0, atol=ROUNDING * size**2)
    assert steiner_area(Pair(mesh, image), d) == pytest.approx(signed.sum(), abs=10 * ROUNDING * size**2)


def test_some_of_these_offsets_do_turn_over() -> None:
    mesh = solids.dodecahedron()
    assert (
        steiner_areas(Pair(mesh, -1 * mesh), 3.0) > 0
    ).all()  # through the centre, to the size 2: turned by half a turn
    assert steiner_area(Pair(mesh, -1 * mesh), 1.0) == pytest.approx(0, abs=ROUNDING)
    catenoid, image = catenoid_and_image(8, 4)
    assert (steiner_areas(Pair(catenoid, image), 30.0) < 0).all()


@given(st.sampled_from(solids.__all__), numbers)
def test_solids_are_spheres_with_respect_to_themselves(name: str, radius: float) -> None:
    solid = getattr(solids, name)()
    curvatures = face_curvatures(Pair(radius * solid, solid))
    np.testing.assert_allclose(curvatures.mean, -1 / radius, rtol=ROUNDING)
    np.testing.assert_allclose(curvatures.gaussian, 1 / radius**2, rtol=ROUNDING)
    np.testing.assert_allclose(curvatures.principal, -1 / radius, rtol=ROUNDING**0.5)
    assert len(curvatures.without_principal) == 0


@given(numbers, st.lists(numbers, min_size=1, max_size=5), st.integers(3, 12))
def test_cylinders(radius: float, rises: list[float], n: int) -> None:
    heights = np.concatenate([[0], np.cumsum(rises)])
    mesh = shapes.rotational_mesh(np.stack([np.full(len(heights), radius), heights], axis=1), n)
    image = mesh.with_vertices(mesh.vertices * [1 / radius, 1 / radius, 0])
    curvatures = face_curvatures(Pair(mesh, image))
    np.testing.assert_allclose(curvatures.mean, -1 / (2 * radius), rtol=10 * ROUNDING)
    np.testing.assert_allclose(curvatures.gaussian, 0, atol=ROUNDING / radius)
    np.testing.assert_allclose(curvatures.principal, [[0, -1 / radius]] * mesh.n_faces, atol=10 * ROUNDING / radius)


@given(st.floats(0.1, 1.4), st.floats(0.5, 5), numbers, st.integers(3, 12))
def test_cones(slope: float, radius: float, length: float, n: int) -> None:
    """A cone whose generators rise by the angle `slope` outwards: one principal curvature is 0."""
    radii, heights = radius + np.array([0, length]) * np.cos(slope), np.array([0, length]) * np.sin(slope)
    mesh = shapes.rotational_mesh(np.stack([radii, heights], axis=1), n)
    normal = np.sin(slope), -np.cos(slope)  # of the generators, outwards
    image = mesh.with_vertices(ring([normal[0]] * 2, [normal[1]] * 2, n))
    curvatures = face_curvatures(Pair(mesh, image))
    kappa = -normal[0] / radii.mean()
    np.testing.assert_allclose(curvatures.gaussian, 0, atol=ROUNDING)
    np.testing.assert_allclose(curvatures.mean, kappa / 2, rtol=10 * ROUNDING)
    np.testing.assert_allclose(curvatures.principal, [[0, kappa]] * n, atol=100 * ROUNDING)


@given(st.floats(0.2, 2), st.integers(3, 9), st.integers(3, 9))
def test_tori(radius: float, m: int, n: int) -> None:
    """About a core of radius 3: curvature 1 / radius along the meridians, and cos t / (3 + radius cos t) across."""
    t = 2 * np.pi / m * np.arange(m)
    mesh = shapes.torus(np.stack([3 + radius * np.cos(t), radius * np.sin(t)], axis=1), n)
    curvatures = face_curvatures(Pair(mesh, mesh.with_vertices(ring(np.cos(t), np.sin(t), n))))
    cosines = (np.cos(t) + np.cos(np.roll(t, -1))) / 2
    along, across = np.full(m, -1 / radius), -cosines / (3 + radius * cosines)
    expected = np.tile(np.stack([across, along], axis=1), (n, 1))
    np.testing.assert_allclose(curvatures.principal, expected, rtol=0, atol=100 * ROUNDING)
    np.testing.assert_allclose(curvatures.mean, expected.mean(axis=1), rtol=0, atol=10 * ROUNDING)
    np.testing.assert_allclose(curvatures.gaussian, expected.prod(axis=1), rtol=0, atol=100 * ROUNDING)
    if m % 2 == 0:  # then the inner faces match the outer ones: 2 pi times the Euler characteristic
        assert (curvatures.gaussian * curvatures.areas).sum() == pytest.approx(0, abs=1e-11)


def catenoid_and_image(n: int, rings: int) -> tuple[Mesh, Mesh]:
    mesh = shapes.catenoid(n, rings)
    t = np.radians(np.linspace(-60, 60, rings + 1))
    return mesh, mesh.with_vertices(ring(np.cos(t), -np.sin(t), n))


@given(st.integers(3, 9), st.integers(1, 9))
def test_catenoids_are_minimal(n: int, rings: int) -> None:
    mesh, image = catenoid_and_image(n, rings)
    curvatures = face_curvatures(Pair(mesh, image))
    cosines = np.cos(np.radians(np.linspace(-60, 60, rings + 1)))
    product = np.tile(cosines[1:] * cosines[:-1], n)
    np.testing.assert_allclose(curvatures.mean, 0, atol=10 * ROUNDING)
    np.testing.assert_allclose(curvatures.gaussian, -(product**2), rtol=100 * ROUNDING)
    np.testing.assert_allclose(curvatures.principal, np.stack([product, -product], axis=1), rtol=100 * ROUNDING)


@given(parallel_faces(), seeds)
def test_curvatures_do_not_see_where_the_meshes_are(pair: tuple[Mesh, Mesh], seed: int) -> None:
    mesh, image = pair
    rng = np.random.default_rng(seed)
    turn, (by, image_by) = Rotation.random(rng=rng).as_matrix(), rng.uniform(-3, 3, (2, 3))
    moved = face_curvatures(
        Pair(mesh.with_vertices(mesh.vertices @ turn.T + by), image.with_vertices(image.vertices @ turn.T + image_by))
    )
    assert_equal(moved, face_curvatures(Pair(mesh, image)), atol=1e-11 * (1 + np.abs(image.vertices).max()) ** 2)


@given(parallel_faces(), numbers, numbers, st.booleans())
def test_curvatures_scale(pair: tuple[Mesh, Mesh], c: float, s: float, turned: bool) -> None:
    """cM has H / c and K / c^2; sS has s H and s^2 K, and where s < 0 the principal curvatures change places."""
    mesh, image = pair
    s = -s if turned else s
    was, found = face_curvatures(Pair(mesh, image)), face_curvatures(Pair(c * mesh, s * image))
    factor = s / c
    principal = factor * (was.principal if s > 0 else was.principal[:, ::-1])
    expected = FaceCurvatures(c**2 * was.areas, factor * was.mean, factor**2 * was.gaussian, principal)
    size = (1 + abs(factor)) ** 2 * (1 + c) ** 2 * (1 + np.abs(image.vertices).max()) ** 2
    assert_equal(found, expected, atol=10 * ROUNDING * size)


@given(parallel_faces())
def test_curvatures_do_not_depend_on_the_side_of_the_meshes(pair: tuple[Mesh, Mesh]) -> None:
    """Each face is oriented such that its area is positive, so S alone says where outside is."""
    mesh, image = pair
    atol = ROUNDING * (1 + np.abs(image.vertices).max()) ** 2
    assert_equal(
        face_curvatures(Pair(mesh.reversed(), image.reversed())), face_curvatures(Pair(mesh, image)), atol=10 * atol
    )


@given(parallel_faces())
def test_principal_curvatures_are_the_roots(pair: tuple[Mesh, Mesh]) -> None:
    mesh, image = pair
    curvatures = face_curvatures(Pair(mesh, image), negative=0.0)
    none = curvatures.mean**2 < curvatures.gaussian
    np.testing.assert_array_equal(np.flatnonzero(none), curvatures.without_principal)
    np.testing.assert_array_equal(np.isnan(curvatures.principal), np.stack([none, none], axis=1))
    first, second = curvatures.principal[~none].T
    assert (first >= second).all()
    size = 1 + np.abs(curvatures.principal[~none]).max(initial=0)
    np.testing.assert_allclose((first + second) / 2, curvatures.mean[~none], rtol=0, atol=ROUNDING * size)
    np.testing.assert_allclose(first * second, curvatures.gaussian[~none], rtol=0, atol=ROUNDING * size**2)


@given(parallel_faces(convex=True), st.booleans())
def test_principal_curvatures_exist_where_faces_or_their_images_are_convex(pair: tuple[Mesh, Mesh], swap: bool) -> None:
    """Minkowski's first inequality: area(P, Q)^2 >= area(P) area(Q) if P is convex, and Q parallel to it."""
    mesh, image = pair
    if swap:
        areas = np.linalg.norm(image.vector_areas, axis=1)
        assume(areas.min() > 0.01 and np.linalg.norm(image.edge_vectors, axis=1).min() > 0.01)
        mesh, image = image, mesh
    assert len(face_curvatures(Pair(mesh, image)).without_principal) == 0


@given(st.floats(-2, 2))
def test_faces_that_are_not_convex_may_have_none(x: float) -> None:
    """Darts whose notches are of different depth: H^2 - K = -(x - 1)^2 / 8, by (4) and (7)."""
    assume(abs(x - 1) > 1e-3)
    dart = [[0, 0, 0], [4, 0, 0], [1, 1, 0], [0, 4, 0]]
    square = [[5, 5, 0], [6, 5, 0], [6, 6, 0], [5, 6, 0]]
    mesh = Mesh.from_faces(dart + square, [[0, 1, 2, 3], [4, 5, 6, 7]])
    image = mesh.with_vertices([[0, 0, 0], [3 + x, 0, 0], [x, 1, 0], [0, 1 + 3 * x, 0], *square])
    curvatures = face_curvatures(Pair(mesh, image))
    assert curvatures.mean[0] ** 2 - curvatures.gaussian[0] == pytest.approx(-((x - 1) ** 2) / 8, abs=ROUNDING)
    assert curvatures.without_principal.tolist() == [0]
    np.testing.assert_allclose(curvatures.principal, [[np.nan, np.nan], [-1, -1]], rtol=ROUNDING**0.5)


def test_rounding_below_zero_passes_for_zero() -> None:
    """Where all directions are principal, H^2 - K is zero, and comes out at either side of it."""
    mesh = solids.snub_dodecahedron()
    rotated = mesh.with_vertices(mesh.vertices @ Rotation.from_rotvec([1, 2, 3]).as_matrix().T + 10)
    exact = face_curvatures(Pair(rotated, mesh.with_vertices((rotated.vertices - 10) / 3)), negative=0.0)
    assert len(exact.without_principal) > 0  # else this test says nothing
    curvatures = face_curvatures(Pair(rotated, mesh.with_vertices((rotated.vertices - 10) / 3)))
    assert len(curvatures.without_principal) == 0
    np.testing.assert_allclose(curvatures.principal, -1 / 3, rtol=1e-6)  # roots of rounding of 1e-13


def test_faces_that_shrink_to_a_point_or_a_line_are_flat_there() -> None:
    mesh = shapes.box(1, 2, 3)
    curvatures = face_curvatures(Pair(mesh, mesh * 0.0))
    for values in (curvatures.mean, curvatures.gaussian, curvatures.principal):
        np.testing.assert_array_equal(values, 0)


def test_meshes_that_are_not_parallel_are_refused() -> None:
    mesh = solids.truncated_octahedron()
    bent = mesh.vertices / 2
    bent[7, 2] += 1e-3
    with pytest.raises(ParallelityError, match=r"edge \d+ from vertex .* of the Gauss image .* not parallel") as caught:
        face_curvatures(Pair(mesh, mesh.with_vertices(bent)))
    assert 7 in mesh.combinatorics.edges[caught.value.elements[0]]
    with pytest.raises(MeshError, match="do not have the same faces"):
        face_curvatures(Pair(mesh, solids.cube()))


def test_faces_that_are_not_planar_are_refused() -> None:
    bent = shapes.grid(2, 2)
    vertices = bent.vertices.copy()
    vertices[0, 2] = 0.1
    with pytest.raises(GeometryError, match=r"face 0 is off its plane by .*planarise"):
        face_curvatures(Pair(bent.with_vertices(vertices), bent.with_vertices(vertices)))


def test_faces_without_area_are_refused() -> None:
    """A bow tie and a sliver, beside sound faces."""
    grid = shapes.grid(2, 1)
    tie = grid.vertices.copy()
    tie[[4, 5]] = tie[[5, 4]]
    with pytest.raises(MeshError, match=r"face 1 has an area of .* of its mean edge length squared") as caught:
        face_curvatures(Pair(grid.with_vertices(tie), grid.with_vertices(tie)))
    assert caught.value.elements == (1,)
    thin = grid.with_vertices(grid.vertices * [1, 1e-10, 1])
    with pytest.raises(MeshError, match="face 0 has an area"):
        face_curvatures(Pair(thin, thin))


def test_centroids_far_away_take_no_more_digits_than_the_coordinates_lost() -> None:
    mesh = solids.truncated_icosahedron()
    image = mesh * 0.5
    far = mesh.with_vertices(mesh.vertices + 1000.0)
    curvatures = face_curvatures(Pair(far, image.with_vertices(image.vertices - 5000.0)))
    assert np.abs(face_centroids(far.vertices, far.combinatorics)).min() > 900
    np.testing.assert_allclose(curvatures.mean, -0.5, rtol=1e-11)  # coordinates keep 1e-12
    np.testing.assert_allclose(curvatures.gaussian, 0.25, rtol=1e-11)

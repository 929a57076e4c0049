"""Christoffel duals: when there are some, that they are minimal, and what they converge to."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.linalg import null_space

from geometry.arrays import FloatArray
from geometry.curvature import ChristoffelDuals, christoffel_dual, face_curvatures, minimal_of_revolution
from geometry.edge_offset.enneper import enneper_koebe
from geometry.edge_offset.koebe_polyhedra import koebe
from geometry.edge_offset.rotational import BandTiling, rotational_koebe
from geometry.errors import GeometryError, MeshError
from geometry.gauss import Pair
from geometry.mesh import Combinatorics, Mesh, shapes, solids
from geometry.mesh.polygons import mixed_areas
from geometry.mesh.tilings import hexagon_patch
from geometry.parallel import ParallelSpace, edge_factors, parallelity
from tests.geometry.topologies import together, without

MINIMAL = 1e-10
"""|H| times the mean edge length of M: vertices are exact to 1e-13 or so, and faces have a hundredth of its square."""

seeds = st.integers(0, 2**32 - 1)
hexagonal = st.sampled_from([BandTiling.POINTY_TOP_HEXAGONS, BandTiling.FLAT_TOP_HEXAGONS])


def mean_curvature(mesh: Mesh, image: Mesh) -> float:
    return float(np.abs(face_curvatures(Pair(mesh, image)).mean).max()) * mesh.mean_edge_length


def moebius_image(mesh: Mesh, seed: int) -> Mesh:
    """Under the projective map of a boost in a random direction and a rotation: Koebe polyhedra stay such."""
    rng = np.random.default_rng(seed)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.linalg.det(turn)
    rapidity = rng.uniform(0, 0.4)
    boost = np.array([[np.cosh(rapidity), np.sinh(rapidity)], [np.sinh(rapidity), np.cosh(rapidity)]])
    homogeneous = np.insert(mesh.vertices @ turn, 3, 1.0, axis=1)
    homogeneous[:, 2:] = homogeneous[:, 2:] @ boost
    assume(homogeneous[:, 3].min() > 0.1)
    return mesh.with_vertices(homogeneous[:, :3] / homogeneous[:, 3:])


def similar(first: Mesh, second: Mesh) -> float:
    """How far the first is from a multiple of the second, up to translation, over its size."""
    p, q = (mesh.vertices - mesh.vertices.mean(axis=0) for mesh in (first, second))
    return float(np.abs(p - q * (p * q).sum() / (q * q).sum()).max() / np.abs(p).max())


def plane_quads(n: int, seed: int) -> Mesh:
    """An n x n grid of plane quads with nothing else in common: the fourth corner of each is anywhere in its plane."""
    rng = np.random.default_rng(seed)
    grid = shapes.grid(n, n)
    points = (grid.vertices + rng.uniform(-0.2, 0.2, grid.vertices.shape)).reshape(n + 1, n + 1, 3)
    for i in range(n):
        for j in range(n):
            a, b = rng.uniform(0.9, 1.1, 2)
            points[i + 1, j + 1] = (
                points[i, j] + a * (points[i + 1, j] - points[i, j]) + b * (points[i, j + 1] - points[i, j])
            )
    return grid.with_vertices(points.reshape(-1, 3))


# --- one quad [Pottmann2007, (8)]


def crosswise(first: FloatArray, second: FloatArray) -> float:
    """How far 13 is from parallel to 2*4*, and 24 to 1*3*, of quads (4, 3)."""
    pairs = [(first[2] - first[0], second[3] - second[1]), (first[3] - first[1], second[2] - second[0])]
    return max(float(np.linalg.norm(np.cross(p, q))) for p, q in pairs)


@given(seeds)
def test_mixed_area_vanishes_if_and_only_if_diagonals_are_parallel_crosswise(seed: int) -> None:
    rng = np.random.default_rng(seed)
    quad = np.zeros((4, 3))
    quad[:, :2] = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]) + rng.uniform(-0.3, 0.3, (4, 2))
    sides = (np.roll(quad, -1, axis=0) - quad)[:, :2]
    one = Combinatorics(4, np.arange(4), np.array([0, 4]))

    def parallel(factors: FloatArray) -> FloatArray:
        return np.insert(np.cumsum(factors[:, None] * sides, axis=0)[[3, 0, 1, 2]], 2, 0.0, axis=1)

    def area(other: FloatArray) -> float:
        return float(mixed_areas(quad, other, one, np.array([[0.0, 0.0, 1.0]]))[0])

    closing = null_space(sides.T)
    values = np.array([area(parallel(direction)) for direction in closing.T])
    dual = parallel(closing @ [values[1], -values[0]] / np.linalg.norm(values))
    assert abs(area(dual)) <= 1e-14
    assert crosswise(quad, dual) <= 1e-13
    other = parallel(closing @ rng.normal(size=2))
    assert abs(area(other)) <= 10 * crosswise(quad, other)
    assert crosswise(quad, other) <= 10 * abs(area(other)) * (1 + np.abs(other).max())


# --- Koenigs nets


@given(seeds, st.sampled_from(["equal circles", "rotational", "not a Koebe polyhedron"]))
def test_koenigs_nets_have_one_dual(seed: int, name: str) -> None:
    """Discs: Koebe polyhedra, and projective images of Koenigs nets."""
    koebe = {
        "equal circles": lambda: enneper_koebe(6),
        "rotational": lambda: without(rotational_koebe(BandTiling.QUADS, 9, 3), 0, 9, 18),
        "not a Koebe polyhedron": lambda: shapes.rotational_mesh([[1, 0], [1.3, 1], [0.8, 2]], 7, closed=False),
    }[name]()
    image = moebius_image(koebe, seed)
    duals = ChristoffelDuals(image)
    assert duals.dimension == 1
    dual = duals.fairest()
    assert parallelity(image, dual).max() <= 1e-12
    assert mean_curvature(dual, image) <= MINIMAL
    assert similar(christoffel_dual(dual).mesh, image) <= 1e-9
    assert similar(christoffel_dual(image, near=image + dual).mesh, dual) <= 1e-9


@given(seeds)
def test_other_plane_quads_have_none(seed: int) -> None:
    with pytest.raises(GeometryError, match=r"no Christoffel dual.*least singular value") as caught:
        christoffel_dual(plane_quads(4, seed))
    assert caught.value.bound == 1e-9
    assert caught.value.value is not None
    assert 1e-8 < caught.value.value < 0.5
    assert len(caught.value.elements) == 1


@given(seeds)
def test_a_dual_may_not_close_around_a_hole(seed: int) -> None:
    image = moebius_image(rotational_koebe(BandTiling.QUADS, 9, 3), seed)
    assume(np.abs(image.vertices.mean(axis=0)).max() > 0.01)
    with pytest.raises(GeometryError, match="no Christoffel dual"):
        christoffel_dual(image)


def test_the_edge_lengths_of_a_dual_of_a_koebe_polyhedron_sum_to_zero_around_each_face() -> None:
    image = rotational_koebe(BandTiling.QUADS, 12, 4, latitude=0.3)
    c = image.combinatorics
    lengths = edge_factors(image, christoffel_dual(image).mesh) * image.edge_lengths
    sums = np.add.reduceat(lengths[c.corner_edge], c.face_starts[:-1])
    np.testing.assert_allclose(sums, 0, atol=1e-13)


def test_large_meshes() -> None:
    image = enneper_koebe(60)
    assert mean_curvature(christoffel_dual(image).mesh, image) <= MINIMAL


# --- hexagons: many duals


@given(hexagonal, st.integers(8, 14), st.integers(3, 5), st.floats(-0.3, 0.3))
def test_hexagons_have_many_duals(tiling: BandTiling, around: int, rows: int, latitude: float) -> None:
    image = rotational_koebe(tiling, around, rows, latitude=latitude)
    duals = ChristoffelDuals(image)
    assert duals.dimension >= image.n_edges - 3 * image.n_faces - 3  # what closes, a loop, and the areas
    fairest = duals.fairest()
    assert mean_curvature(fairest, image) <= MINIMAL
    assert fairest.mean_edge_length == pytest.approx(image.mean_edge_length)
    near = duals.nearest(ParallelSpace(image).elements(1)[0])
    assert parallelity(image, near).max() <= 1e-12
    areas = mixed_areas(near.vertices, image.vertices, image.combinatorics, image.face_normals)
    np.testing.assert_allclose(areas, 0, atol=1e-13)
    assert np.abs(duals.nearest(fairest).vertices - fairest.vertices).max() <= 1e-12


def test_the_fairest_dual_of_a_band_of_standing_hexagons_is_a_catenoid() -> None:
    image = rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, 20, 9)
    assert (
        similar(christoffel_dual(image).mesh, minimal_of_revolution(image).mesh) <= 1e-6
    )  # half the digits of an eigenvalue


def test_each_piece_has_its_own_dual() -> None:
    one, other = enneper_koebe(5), enneper_koebe(4)
    duals = together(christoffel_dual(one).mesh, christoffel_dual(other).mesh)
    np.testing.assert_allclose(christoffel_dual(together(one, other)).mesh.vertices, duals.vertices, atol=1e-12)


def test_triangles_are_dual_to_points() -> None:
    with pytest.raises(GeometryError, match=r"has a length of .* of the mean edge length|no Christoffel dual"):
        christoffel_dual(shapes.cap(solids.rhombicosidodecahedron(), 0.5))
    for triangles in (solids.tetrahedron(), solids.icosahedron(), Mesh.from_faces(np.eye(3), [[0, 1, 2]])):
        with pytest.raises(GeometryError, match=r"no Christoffel dual.* passes for zero; the nearest"):
            christoffel_dual(triangles)


def test_other_meshes_are_refused() -> None:
    with pytest.raises(MeshError, match="does not have the faces"):
        christoffel_dual(enneper_koebe(3), near=shapes.grid(2, 2))
    with pytest.raises(GeometryError, match="is off its plane"):
        christoffel_dual(shapes.grid(3, 3).with_vertices(np.random.default_rng(0).normal(size=(16, 3))))


# --- rotational symmetry [Pottmann2007, Figs 17, 18]


@given(seeds, st.booleans())
def test_generalised_rotational_symmetry(seed: int, goes_round: bool) -> None:
    """Horizontal polylines that are scaled copies of each other, of any form, in any heights."""
    rng = np.random.default_rng(seed)
    around, rings = 7, 5
    angles = (np.arange(around) + rng.uniform(-0.3, 0.3, around)) * 2 * np.pi / around
    polyline = rng.uniform(0.7, 1.3, (around, 1)) * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    radii, heights = rng.uniform(0.5, 2, rings), np.cumsum(rng.uniform(0.2, 1, rings))
    flat = polyline[:, None] * radii[:, None]
    points = np.concatenate([flat, np.broadcast_to(heights[:, None], (around, rings, 1))], axis=2)
    plain = shapes.rotational_mesh(np.stack([radii, heights], axis=1), around, closed=goes_round)
    image = plain.with_vertices(points.reshape(-1, 3))
    mesh = minimal_of_revolution(image, waist=2.5).mesh
    assert np.linalg.norm(mesh.vertices[:, :2], axis=1).min() == pytest.approx(2.5)
    assert parallelity(image, mesh).max() <= 1e-13
    assert mean_curvature(mesh, image) <= MINIMAL
    assert similar(christoffel_dual(image).mesh, mesh) <= 1e-10
    corners = image.combinatorics.corners.reshape(-1, 4)
    for quad in corners:  # Fig. 17: the diagonals, and which edges are reversed
        assert crosswise(image.vertices[quad], mesh.vertices[quad]) <= 1e-12
    horizontal = np.abs(image.edge_vectors[:, 2]) < 1e-9
    assert (np.sign(edge_factors(image, mesh)) == np.where(horizontal, 1, -1)).all()


@given(st.sampled_from([BandTiling.QUADS, BandTiling.POINTY_TOP_HEXAGONS]), st.integers(3, 20), st.integers(1, 6))
def test_minimal_edge_offset_meshes_of_revolution(tiling: BandTiling, around: int, rows: int) -> None:
    image = rotational_koebe(tiling, around, min(rows, around // 2 + 1), latitude=0.2)
    mesh = minimal_of_revolution(image).mesh
    assert parallelity(image, mesh).max() <= 1e-12
    assert mean_curvature(mesh, image) <= MINIMAL
    assert (face_curvatures(Pair(mesh, image)).gaussian < 0).all()
    around_axis = np.cross(image.vertices, [0, 0, 1])[image.combinatorics.edges[:, 0]]
    meridian = np.abs((around_axis * image.edge_directions).sum(axis=1)) < 1e-9
    assert (np.sign(edge_factors(image, mesh)) == np.where(meridian, -1, 1)).all()


@pytest.mark.parametrize(
    ("image", "words"),
    [
        (solids.cube().translated([3, 0, 0]), "rings"),
        (enneper_koebe(4), "on the z axis"),
        (shapes.hexagonal_paraboloid(3, 3), "rings|axis"),
    ],
)
def test_meshes_without_rings_are_refused(image: Mesh, words: str) -> None:
    with pytest.raises(MeshError, match=words):
        minimal_of_revolution(image)


def test_rows_that_are_not_alike_are_refused() -> None:
    image = rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, 8, 3)
    moved = image.vertices.copy()
    moved[11] *= 1.01
    with pytest.raises(MeshError, match=r"face .* differs from others of its row"):
        minimal_of_revolution(image.with_vertices(moved))
    with pytest.raises(GeometryError, match="the waist is -1"):
        minimal_of_revolution(image, waist=-1.0)


# --- to the smooth surfaces


def order(errors: list[float]) -> FloatArray:
    """Of convergence, from meshes each twice as fine as the one before."""
    return np.log2(np.array(errors[:-1]) / errors[1:])


@pytest.mark.parametrize("tiling", list(BandTiling))
def test_to_the_catenoid(tiling: BandTiling) -> None:
    """R = a cosh(z / a), with a from the waist: second order."""
    errors = []
    for around, rows in [(12, 4), (24, 8), (48, 16), (96, 32)]:
        x, y, z = minimal_of_revolution(rotational_koebe(tiling, around, rows)).mesh.vertices.T
        errors.append(float(np.abs(np.hypot(x, y) - np.cosh(z)).max()))
    assert errors[-1] < 0.01
    np.testing.assert_allclose(order(errors), 2, atol=0.2)


def enneper(u: FloatArray, v: FloatArray) -> FloatArray:
    return np.stack([u - u**3 / 3 + u * v**2, v**3 / 3 - v - u**2 * v, u**2 - v**2], axis=1)


def test_to_the_surface_of_enneper() -> None:
    """The mesh over the grid of equal circles, scaled to the smooth surface over the same grid: second order."""
    errors = []
    for faces in (4, 8, 16, 32):
        mesh = christoffel_dual(enneper_koebe(faces)).mesh
        j, i = np.divmod(np.arange(mesh.n_vertices), faces + 1)
        smooth = mesh.with_vertices(enneper(2 * i / faces - 1, 2 * j / faces - 1))
        errors.append(similar(smooth, mesh))
    assert errors[-1] < 1e-3
    np.testing.assert_allclose(order(errors), 2, atol=0.2)


# --- where the fairest dual would let edges vanish


@pytest.mark.parametrize(
    ("nx", "ny"), [(3, 3), (4, 5), (8, 5), (12, 5), (4, 7), (7, 7), (12, 7), (2, 9), (20, 20), (1, 5)]
)
def test_edges_of_hexagonal_patches_do_not_vanish(nx: int, ny: int) -> None:
    """Every third edge of the fairest is shorter than 1e-5 in most of these; an equally fair one has none short."""
    image = koebe(hexagon_patch(nx, ny)).mesh
    dual = christoffel_dual(image).mesh
    assert parallelity(image, dual).max() <= 1e-12 * np.abs(dual.vertices).max()
    assert mean_curvature(dual, image) <= MINIMAL
    bound = 0.45 if min(nx, ny) > 1 else 0.1  # a single row has no inner vertex to be fair at
    assert dual.edge_lengths.min() > bound * dual.mean_edge_length


def test_an_edge_that_vanishes_in_all_of_them_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """The bound is raised, so that even the best is refused."""
    monkeypatch.setattr("geometry.curvature.christoffel_duals.VANISHING_DUAL_EDGE", 0.9)
    image = koebe(hexagon_patch(4, 5)).mesh
    with pytest.raises(
        GeometryError, match=r"edge \d+ from vertex \d+ to vertex \d+ vanishes in the fairest dual"
    ) as e:
        christoffel_dual(image)
    assert e.value.value is not None
    assert 0.5 < e.value.value < 0.9

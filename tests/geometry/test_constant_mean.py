"""Constant mean curvature: rotational meshes in closed form, others by Newton's method, and their parallel meshes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.curvature import (
    christoffel_dual,
    constant_mean,
    constant_mean_of_revolution,
    face_curvatures,
    minimal_of_revolution,
)
from geometry.curvature.constant_mean_curvature import ConstantMean
from geometry.edge_offset.enneper import enneper_koebe
from geometry.edge_offset.koebe_polyhedra import koebe
from geometry.edge_offset.rotational import BandTiling, rotational_koebe
from geometry.edge_offset.signed_meshes import edge_offset_mesh
from geometry.errors import GeometryError, MeshError
from geometry.gauss import Pair
from geometry.mesh import Mesh, shapes
from geometry.mesh.polygons import mixed_areas
from geometry.mesh.tilings import quad_patch
from geometry.optimise.solution import ConvergenceError, Reason
from geometry.parallel import ParallelSpace, edge_factors, parallelity
from geometry.parallel.edge_closure import EdgeClosure
from tests.geometry.topologies import MESHES

CONSTANT = 1e-10
"""Relative deviation of H: a few hundred operations, and areas that are differences of others ten times as large."""

seeds = st.integers(0, 2**32 - 1)
ringed = st.sampled_from([BandTiling.QUADS, BandTiling.POINTY_TOP_HEXAGONS])
means = st.sampled_from([-2.0, -0.5, 0.5, 1.0])


def assert_constant(mesh: Mesh, image: Mesh, mean: float, atol: float = CONSTANT) -> None:
    np.testing.assert_allclose(face_curvatures(Pair(mesh, image)).mean, mean, rtol=0, atol=atol * abs(mean))
    assert parallelity(image, mesh).max() <= 1e-12 * np.abs(mesh.vertices).max()


def perturbed(mesh: Mesh, image: Mesh, seed: int, size: float) -> Mesh:
    """By a random element of P(S), in mean edge lengths."""
    away = ParallelSpace(image).elements(1, seed=seed)[0]
    return mesh + away * (size * mesh.mean_edge_length * float(np.sqrt(mesh.n_vertices)))


# --- rotational, in closed form


@given(ringed, st.integers(4, 24), st.integers(1, 5), st.floats(-0.3, 0.3), means, st.floats(3, 8))
def test_meshes_of_revolution(
    tiling: BandTiling, around: int, rows: int, latitude: float, mean: float, relative: float
) -> None:
    """Nodoids: radius in units of the cylinder's, 1 / |2 H|, beyond 2 sqrt(2), twice the radius of S for 4 around."""
    image = rotational_koebe(tiling, around, min(rows, around // 2), latitude=latitude)
    radius = relative / (2 * abs(mean))
    mesh = constant_mean_of_revolution(image, mean, radius=radius).mesh
    assert_constant(mesh, image, mean)
    furthest = np.linalg.norm(image.vertices[:, :2], axis=1).argmax()
    assert np.linalg.norm(mesh.vertices[furthest, :2]) == pytest.approx(radius)


@given(ringed, means)
def test_the_sphere_is_one_of_them(tiling: BandTiling, mean: float) -> None:
    image = rotational_koebe(tiling, 12, 4, latitude=0.2)
    radius = float(np.linalg.norm(image.vertices[:, :2], axis=1).max()) / abs(mean)
    if mean < 0:  # S points outwards, so spheres bend away from it
        mesh = constant_mean_of_revolution(image, mean, radius=radius).mesh
        away = mesh.vertices + image.vertices / mean
        np.testing.assert_allclose(away, np.broadcast_to(away[0], away.shape), atol=1e-12)


def test_cylinders() -> None:
    """The sphere's part that is the image of a cylinder is its equator: S is an upright prism."""
    prism = shapes.rotational_mesh([[1, 0], [1, 1], [1, 3]], 7)
    flat = prism.with_vertices(prism.vertices * [1, 1, 1e-3])
    mesh = constant_mean_of_revolution(flat, -0.5, radius=1.2).mesh
    assert_constant(mesh, flat, -0.5)
    np.testing.assert_allclose(np.linalg.norm(mesh.vertices[:, :2], axis=1), 1.2, rtol=1e-12)


@pytest.mark.parametrize("mean", [1e-3, -1e-6, 1e-12, -1e-200])
def test_small_curvatures_lose_no_digits(mean: float) -> None:
    image = rotational_koebe(BandTiling.QUADS, 24, 4)
    mesh = constant_mean_of_revolution(image, mean, radius=0.8).mesh
    assert np.abs(face_curvatures(Pair(mesh, image)).mean - mean).max() <= CONSTANT
    catenoid = minimal_of_revolution(image, waist=float(np.linalg.norm(mesh.vertices[:, :2], axis=1).min())).mesh
    np.testing.assert_allclose(mesh.vertices, catenoid.vertices, rtol=0, atol=abs(mean) + 1e-14)


@given(st.integers(6, 20), st.integers(2, 6), st.integers(1, 3), st.sampled_from([-1.0, 0.5]))
def test_unduloids_have_their_inflections_where_the_gauss_image_folds(
    around: int, rows: int, folds: int, mean: float
) -> None:
    image = rotational_koebe(BandTiling.QUADS, around, min(rows, around // 2), folds=folds)
    mesh = constant_mean_of_revolution(image, mean).mesh
    assert_constant(mesh, image, mean)
    radii = np.linalg.norm(mesh.vertices.reshape(-1, around, 3)[:, 0, :2], axis=1)
    slopes = np.linalg.norm(image.vertices.reshape(-1, around, 3)[:, 0, :2], axis=1)
    integral = -abs(mean) * radii**2 + slopes * radii
    np.testing.assert_allclose(integral, integral[0], rtol=1e-10)
    assert radii.max() > 1 / (2 * abs(mean)) * slopes.max() > radii.min()  # bulges and necks


def test_delaunay_meridians_converge_to_the_smooth_ones() -> None:
    """H R^2 + R cos(slope) is constant on the smooth surface; here with slopes of edges, at their middles.

    Second order. 0.5 and 1.5: neck and bulge of an unduloid, S reaching to half the inflection; 3: a nodoid.
    """
    for radius, latitude in [(1.5, 0.25), (0.5, 0.25), (3.0, 0.8)]:
        errors = []
        for around in (40, 80, 160):
            rows = 2 * round(latitude * around / (2 * np.pi) / 2 * 2)
            mesh = constant_mean_of_revolution(
                rotational_koebe(BandTiling.QUADS, around, rows), -0.5, radius=radius
            ).mesh
            points = mesh.vertices.reshape(-1, around, 3)[:, 0]
            profile = np.stack([np.linalg.norm(points[:, :2], axis=1), points[:, 2]], axis=1)
            middles, steps = (profile[1:] + profile[:-1]) / 2, np.diff(profile, axis=0)
            integral = -(middles[:, 0] ** 2) / 2 + middles[:, 0] * np.abs(steps[:, 1]) / np.linalg.norm(steps, axis=1)
            errors.append(float(np.abs(integral - (radius - radius**2 / 2)).max()))
        assert errors[-1] < 0.01
        np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2, atol=0.35)


@given(st.integers(8, 16), st.integers(3, 6), st.floats(-0.2, 0.2))
def test_lying_hexagons(around: int, rows: int, latitude: float) -> None:
    image = rotational_koebe(BandTiling.FLAT_TOP_HEXAGONS, around, rows, latitude=latitude)
    minimal = minimal_of_revolution(image, waist=2.0).mesh
    assert np.abs(face_curvatures(Pair(minimal, image)).mean).max() <= CONSTANT
    assert np.linalg.norm(minimal.vertices[:, :2], axis=1).min() == pytest.approx(2.0)
    assert_constant(constant_mean_of_revolution(image, -0.5, radius=3.0).mesh, image, -0.5)


def test_a_folded_band_of_flat_top_hexagons() -> None:
    """Fig. 10: the faces on the inflection have images folded flat, hence K = 0."""
    image = rotational_koebe(BandTiling.FLAT_TOP_HEXAGONS, 12, 5, folds=1)
    mesh = constant_mean_of_revolution(image, -0.5).mesh
    assert_constant(mesh, image, -0.5)
    rows = face_curvatures(Pair(mesh, image)).gaussian.reshape(-1, 12)
    assert (rows[:5] > 0).all()
    np.testing.assert_allclose(rows[5], 0, atol=1e-12)
    assert (rows[6:] < 0).all()
    with pytest.raises(GeometryError, match="the folds determine the radius"):
        constant_mean_of_revolution(image, -0.5, radius=1.5)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda s: constant_mean_of_revolution(s, 0.0, radius=1.0), "for zero take `minimal_of_revolution`"),
        (lambda s: constant_mean_of_revolution(s, np.nan, radius=1.0), "the mean curvature is nan"),
        (lambda s: constant_mean_of_revolution(s, -0.5, radius=-1.0), "the radius is -1"),
        (lambda s: constant_mean_of_revolution(s, -0.5), "no fold"),
        (
            lambda _: constant_mean_of_revolution(rotational_koebe(BandTiling.QUADS, 9, 1, folds=1), -0.5),
            "infinitely long",
        ),
        (lambda s: constant_mean_of_revolution(s, -0.5, radius=1.5), "beyond the inflection of the mesh, most in ring"),
        (lambda s: constant_mean(s, np.inf, s), "the mean curvature is inf"),
        (lambda s: constant_mean(s, -1.0, s * 0), "the mesh to start from is a point"),
        (lambda s: constant_mean(s, -0.5, s, fairness=-1.0), "the fairness is -1"),
        (lambda s: constant_mean(s, -0.5, shapes.grid(2, 2)), "does not have the faces"),
    ],
)
def test_what_cannot_be_is_refused(call: object, words: str) -> None:
    with pytest.raises(GeometryError, match=words):
        call(rotational_koebe(BandTiling.QUADS, 12, 6))  # type: ignore[operator]


# --- by Newton's method


@given(st.sampled_from(["disc", "hexagons", "triangles among larger faces", "annulus"]), seeds)
def test_the_equations_have_the_right_derivatives(name: str, seed: int) -> None:
    closing = EdgeClosure(MESHES[name])
    functional = ConstantMean(closing, -0.7)
    rng = np.random.default_rng(seed)
    x, step = rng.normal(size=(2, closing.matrix.shape[1]))
    slope = (functional.residual(x + step) - functional.residual(x - step)) / 2  # exact: they are quadratic
    np.testing.assert_allclose(functional.jacobian(x) @ step, slope, rtol=1e-10, atol=1e-10)


@given(seeds)
def test_the_equations_say_what_mixed_areas_do(seed: int) -> None:
    image = shapes.hexagonal_paraboloid(3, 3)
    mesh = ParallelSpace(image).elements(1, seed=seed)[0]
    c, normals = image.combinatorics, image.face_normals
    areas = [mixed_areas(mesh.vertices, other.vertices, c, normals) for other in (mesh, image)]
    functional = ConstantMean(EdgeClosure(image), 2.0)
    residual = functional.residual(functional.lengths_of(mesh))
    size = float(np.abs(residual).max())
    ratio: FloatArray = residual / (2 * areas[0] + areas[1])
    assert size > 0
    lengths = [np.linalg.norm(np.roll(p, -1, axis=0) - p, axis=1).mean() for p in (image.vertices[f] for f in c.faces)]
    np.testing.assert_allclose(ratio, 1 / np.array(lengths), rtol=1e-8)


@given(seeds, st.sampled_from([-0.5, 0.5]))
def test_newtons_method_arrives_near_its_start(seed: int, mean: float) -> None:
    image = rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, 12, 4, latitude=0.1)
    start = perturbed(constant_mean_of_revolution(image, mean, radius=2.5).mesh, image, seed, 0.02)
    mesh = constant_mean(image, mean, start).mesh
    assert_constant(mesh, image, mean)
    away = mesh.vertices - start.vertices
    assert np.abs(away - away.mean(axis=0)).max() <= mesh.mean_edge_length


def test_a_rotational_mesh_of_quads_is_found_again() -> None:
    """Quads have few solutions: from nearby, one that is rotational too."""
    image = rotational_koebe(BandTiling.QUADS, 12, 4, latitude=0.1)
    mesh = constant_mean_of_revolution(image, -0.5, radius=3.0).mesh
    found = constant_mean(image, -0.5, perturbed(mesh, image, 0, 1e-3)).mesh
    assert_constant(found, image, -0.5)
    around = found.vertices.reshape(-1, 12, 3)[:, :, :2]  # ring after ring
    radii = np.linalg.norm(around - around.mean(axis=1, keepdims=True), axis=2)
    np.testing.assert_allclose(radii, np.broadcast_to(radii[:, :1], radii.shape), atol=1e-6)


@given(seeds)
def test_hexagons_that_are_not_rotational(seed: int) -> None:
    """About a large sphere there are many: this one stays near a random start in P(S)."""
    image = shapes.hexagonal_paraboloid(4, 4)
    mesh = constant_mean(image, 0.3, perturbed(image * -3.0, image, seed, 0.1)).mesh
    assert_constant(mesh, image, 0.3)
    assert np.ptp(edge_factors(image, mesh)) > 0.01


def test_no_curvature_is_the_christoffel_dual() -> None:
    image = enneper_koebe(5)
    dual = christoffel_dual(image).mesh
    found = constant_mean(image, 0.0, perturbed(dual, image, 1, 0.01)).mesh
    assert np.abs(face_curvatures(Pair(found, image)).mean).max() <= CONSTANT


def test_where_there_is_no_way_the_solver_says_so() -> None:
    """Halfway between the sphere -S / H and a point, which solve the equations both, they do not change at first."""
    image = shapes.hexagonal_paraboloid(3, 3)
    with pytest.raises(ConvergenceError, match=r"no mesh of this mean curvature is found .* in face") as caught:
        constant_mean(image, -0.5, image * 1.0)
    assert caught.value.solution.reason is not Reason.CONVERGED


def test_faces_must_be_the_same() -> None:
    with pytest.raises(MeshError, match="does not have the faces"):
        constant_mean(shapes.hexagonal_paraboloid(2, 2), 1.0, shapes.grid(2, 2))


# --- what is parallel to them


@given(ringed, means, st.floats(2.5, 5), st.floats(-3, 3))
def test_the_parallel_surface_at_distance_one_over_h(
    tiling: BandTiling, mean: float, relative: float, d: float
) -> None:
    """M + S / H has -H and is a Christoffel dual of M; halfway between, M + S / (2 H) has constant K = 4 H^2.

    And H_F of all of M + d S is (H - d K) / (1 - 2 d H + d^2 K), from Steiner's formula [Pottmann2007, (6)].
    """
    image = rotational_koebe(tiling, 11, 4)
    mesh = constant_mean_of_revolution(image, mean, radius=relative / (2 * abs(mean))).mesh
    other = mesh + image * (1 / mean)
    assert_constant(other, image, -mean)
    areas = mixed_areas(mesh.vertices, other.vertices, mesh.combinatorics, image.face_normals)
    np.testing.assert_allclose(areas, 0, atol=1e-12)
    middle = face_curvatures(Pair(mesh + image * (1 / (2 * mean)), image))
    np.testing.assert_allclose(middle.gaussian, 4 * mean**2, rtol=1e-8)
    curvatures = face_curvatures(Pair(mesh, image))
    growth = 1 - 2 * d * curvatures.mean + d**2 * curvatures.gaussian
    normals = mesh.vector_areas / curvatures.areas[:, None]
    offset = mesh + image * d
    mixed = mixed_areas(offset.vertices, image.vertices, mesh.combinatorics, normals)
    np.testing.assert_allclose(-mixed, (curvatures.mean - d * curvatures.gaussian) * curvatures.areas, atol=1e-9)
    areas = mixed_areas(offset.vertices, offset.vertices, mesh.combinatorics, normals)
    np.testing.assert_allclose(areas, growth * curvatures.areas, atol=1e-9)


@pytest.mark.parametrize("mean", [0.0, 1.0])
def test_a_point_is_no_solution(mean: float) -> None:
    image = koebe(quad_patch(8, 8), coverage=0.4).mesh
    dome = edge_offset_mesh(image, signs=1, lengths=(1.0, np.inf))
    with pytest.raises(GeometryError, match=rf"shrunk to a point, to .* nearer to {mean:g}$"):
        constant_mean(image, mean, dome)  # of H < 0

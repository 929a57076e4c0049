"""Proposition 1: a parallel mesh gives node axes and they give it back, and what stands in the way is named."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra

from geometry.arrays import FloatArray
from geometry.errors import GeometryError, MeshError, ParallelityError
from geometry.gauss.approximate_gauss_image import approximate_pair
from geometry.gauss.axes import node_axes, parallel_from_axes
from geometry.gauss.support_structure import SupportStructure
from geometry.mesh import Mesh, shapes
from geometry.mesh.spanning_forests import spanning_forest
from geometry.parallel.edge_parallelity import parallelity

seeds = st.integers(0, 2**32 - 1)

WINDOW = Mesh.from_faces(  # a 4 x 4 grid without the middle four: an annulus with vertices of valence 2
    shapes.grid(4, 4).vertices,
    [f for k, f in enumerate(shapes.grid(4, 4).combinatorics.faces) if k not in (5, 6, 9, 10)],
)
MESHES = {
    "disc": shapes.hexagonal_paraboloid(4, 3),
    "annulus": shapes.dome(9, 4),
    "closed": shapes.regular_prism(5),
    "flat, with an unused vertex": WINDOW,
}


def images(mesh: Mesh, seed: int) -> Mesh:
    """A mesh parallel to M without zero vertices."""
    rng = np.random.default_rng(seed)
    image = approximate_pair(mesh, faces=rng.uniform(0, 1), vertices=rng.uniform(0.1, 1)).gauss_image
    return image.translated(rng.uniform(-0.2, 0.2, size=3)) * rng.uniform(0.3, 3) * float(rng.choice([-1, 1]))


@pytest.mark.parametrize("mesh", MESHES.values(), ids=MESHES)
@given(seed=seeds)
def test_parallel_meshes_give_axes_and_axes_give_the_parallel_mesh_back(mesh: Mesh, seed: int) -> None:
    image = images(mesh, seed)
    axes = node_axes(mesh, mesh + image)
    # axes over an edge are coplanar with it: the determinant vanishes
    i, j = mesh.combinatorics.edges.T
    determinants = np.einsum("ek,ek->e", np.cross(axes[i], axes[j]), mesh.edge_directions)
    assert np.abs(determinants).max() < 1e-13  # rounding, over distances of 0.1 and more
    rng = np.random.default_rng(seed)
    start = int(rng.choice(np.flatnonzero(mesh.combinatorics.is_used)))
    stretched = axes * rng.choice([-1, 1], size=(len(axes), 1)) * 10 ** rng.uniform(-3, 3, size=(len(axes), 1))
    stretched[start] = axes[start]
    other = parallel_from_axes(mesh, stretched, start=start, distance=float(np.linalg.norm(image.vertices[start])))
    used = mesh.combinatorics.is_used
    np.testing.assert_allclose(other.vertices[used], (mesh + image).vertices[used], atol=1e-11)  # along 10 edges
    np.testing.assert_array_equal(other.vertices[~used], mesh.vertices[~used])
    assert parallelity(mesh, other).max() < 1e-11


def test_the_axes_of_a_support_structure_are_those_of_its_meshes() -> None:
    mesh = shapes.dome(9, 4)
    structure = SupportStructure(approximate_pair(mesh), 0.3)
    np.testing.assert_allclose(structure.axes, node_axes(mesh, structure.offset_mesh), atol=1e-14)


@given(seeds)
def test_the_sign_and_the_size_of_the_distance(seed: int) -> None:
    mesh = shapes.dome(7, 3)
    rng = np.random.default_rng(seed)
    axes = node_axes(mesh, mesh + images(mesh, seed))
    start, distance = int(rng.integers(mesh.n_vertices)), float(rng.uniform(-3, 3))
    moved = parallel_from_axes(mesh, axes, start=start, distance=distance) - mesh
    np.testing.assert_allclose(moved.vertices[start], distance * axes[start], atol=1e-14)
    there = parallel_from_axes(mesh, axes, start=start) - mesh
    np.testing.assert_allclose(moved.vertices, distance * there.vertices, atol=1e-12)


def test_each_component_starts_at_its_own_vertex() -> None:
    one, other = shapes.dome(7, 3), shapes.cube()
    faces = [face.tolist() for face in one.combinatorics.faces] + [
        [v + one.n_vertices for v in f] for f in other.combinatorics.faces
    ]
    both = Mesh.from_faces(np.concatenate([one.vertices, other.vertices + 9]), faces)
    axes = np.concatenate([one.vertices, other.vertices])
    moved = (parallel_from_axes(both, axes, start=3, distance=0.5) - both).vertices
    np.testing.assert_allclose(moved[: one.n_vertices], one.vertices / 2, atol=1e-13)
    np.testing.assert_allclose(moved[one.n_vertices :], other.vertices / 2 / np.sqrt(3), atol=1e-13)


@given(seeds, st.floats(1e-6, 0.3))
def test_the_edge_with_the_largest_twist_is_named(seed: int, angle: float) -> None:
    mesh = shapes.dome(9, 5)
    vertex = int(np.random.default_rng(seed).integers(mesh.n_vertices))
    axes = mesh.vertices.copy()  # a dome is its own Gauss image
    along = np.cross([0.0, 0.0, 1.0], axes[vertex])
    axes[vertex] = np.cos(angle) * axes[vertex] + np.sin(angle) * along / np.linalg.norm(along)
    with pytest.raises(
        ParallelityError, match=r"are not coplanar: .* differ by .* degrees, allowed 5\.7e-08"
    ) as raised:
        parallel_from_axes(mesh, axes)
    assert vertex in mesh.combinatorics.edges[raised.value.elements[0]]
    # the axis turns about the vertex by the angle, and its plane about the meridian edge by at least as much
    assert raised.value.value is not None
    assert raised.value.value == pytest.approx(angle, rel=0.1)


def around(growth: float) -> tuple[Mesh, FloatArray]:
    """The sides of a prism, and horizontal axes coplanar over each edge whose distances grow once around."""
    n, rng = 7, np.random.default_rng(0)
    prism = shapes.regular_prism(n)
    ring = Mesh.from_faces(prism.vertices, prism.combinatorics.faces[:n])
    steps = np.diff(np.concatenate([prism.vertices[:n], prism.vertices[:1]])[:, :2], axis=0)
    start = np.array([0.9, 0.7])
    factors = rng.uniform(0.5, 1.5, size=n)
    factors += np.linalg.lstsq(steps.T, (growth - 1) * start - steps.T @ factors, rcond=None)[0]
    vectors = start + np.concatenate([np.zeros((1, 2)), np.cumsum(factors[:-1, None] * steps[:-1], axis=0)])
    return ring, np.tile(np.insert(vectors, 2, 0.0, axis=1), (2, 1))


def test_around_a_hole_coplanar_axes_may_belong_to_no_parallel_mesh() -> None:
    ring, axes = around(1.0)
    moved = parallel_from_axes(ring, axes, distance=float(np.linalg.norm(axes[0]))) - ring
    np.testing.assert_allclose(moved.vertices, axes, atol=1e-13)
    ring, axes = around(1.3)
    with pytest.raises(ParallelityError, match=r"coplanar over each edge, but .* around a hole") as raised:
        parallel_from_axes(ring, axes)
    i, j = ring.combinatorics.edges[raised.value.elements[0]]
    along = ring.edge_directions[raised.value.elements[0]]
    sines = [np.linalg.norm(np.cross(axes[k], along)) / np.linalg.norm(axes[k]) for k in (i, j)]
    # of the two distances at one end, 1 and 1.3, the difference across the edge over the larger distance at its ends
    assert 0.2 / 1.3 * min(sines) < raised.value.value <= 0.3 / 1.3 * max(sines) + 1e-12
    # once the ring is cut open, there is one
    faces = [face.tolist() for face in ring.combinatorics.faces[:-1]]
    parallel_from_axes(Mesh.from_faces(ring.vertices, faces), axes)


@given(seeds, st.integers(1, 30), st.integers(0, 40))
def test_a_spanning_forest_reaches_each_vertex_by_a_shortest_way(seed: int, n: int, n_edges: int) -> None:
    rng = np.random.default_rng(seed)
    pairs = np.array(list(combinations(range(n), 2)), dtype=np.int64).reshape(-1, 2)
    edges = rng.permutation(pairs)[:n_edges]
    start = int(rng.integers(n))
    forest = spanning_forest(n, edges, start=start)
    steps = np.full(n, -1)
    steps[forest.roots] = 0
    for k, level in enumerate(forest.levels, start=1):
        np.testing.assert_array_equal(
            np.sort(edges[level.edges]), np.sort(np.stack([level.parents, level.children], 1))
        )
        assert (steps[level.parents] == k - 1).all()
        assert (steps[level.children] == -1).all()
        steps[level.children] = k
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(n, n))
    shortest = dijkstra(graph, directed=False, unweighted=True, indices=forest.roots).min(axis=0)
    np.testing.assert_array_equal(steps, shortest)
    assert start in forest.roots
    assert len(forest.roots) == len(np.unique(forest.components)) == connected_components(graph, directed=False)[0]


def test_vertices_of_both_meshes_in_one_place_are_named() -> None:
    cube = shapes.cube()
    with pytest.raises(GeometryError, match="vertex 5 is at the same place in both meshes"):
        node_axes(cube, cube + (cube * 1.5).translated(-1.5 * cube.vertices[5]))
    with pytest.raises(GeometryError, match="vertex 0 is at the same place"):
        node_axes(cube, cube)


def test_meshes_that_are_not_parallel_and_other_faces_are_refused() -> None:
    cube = shapes.cube()
    vertices = cube.vertices * 1.5
    vertices[2] += 1e-6
    with pytest.raises(ParallelityError, match=r"of the other mesh is off the direction .* by 1\.4e-06, allowed"):
        node_axes(cube, cube.with_vertices(vertices))
    assert node_axes(cube, cube.with_vertices(vertices), tolerance=1e-5).shape == (8, 3)
    # the bound is a part of the distance of the meshes
    dome = shapes.dome(7, 3)
    np.testing.assert_allclose(node_axes(dome, dome * (1 + 1e-6)), dome.vertices, atol=1e-9)
    crooked = dome.vertices * 1e6
    crooked[4] += 1.0
    with pytest.raises(ParallelityError, match=r"by 1\.\de\+00, allowed 1\.0e-03"):
        node_axes(dome, dome.with_vertices(crooked))
    with pytest.raises(MeshError, match="do not have the same faces"):
        node_axes(cube, shapes.octahedron())


def test_axes_in_edges_are_refused() -> None:
    cube = shapes.cube()
    with pytest.raises(GeometryError, match=r"the node axis at vertex \d lies in edge"):
        node_axes(cube, cube.translated([0.0, 0.0, 1.0]))
    with pytest.raises(GeometryError, match=r"lies in edge \d+ from vertex .* at least 5\.7e-05 is needed"):
        parallel_from_axes(cube, np.tile([1.0, 0.0, 0.0], (8, 1)))


def test_what_is_no_axis_is_refused() -> None:
    cube = shapes.cube()
    with pytest.raises(MeshError, match=r"axes have shape \(7, 3\)"):
        parallel_from_axes(cube, cube.vertices[:7])
    for wrong in ([0.0, 0.0, 0.0], [1.0, np.nan, 0.0]):
        axes = cube.vertices.copy()
        axes[4] = wrong
        with pytest.raises(GeometryError, match="the axis at vertex 4 is"):
            parallel_from_axes(cube, axes)
    with pytest.raises(GeometryError, match="no vertex 8"):
        parallel_from_axes(cube, cube.vertices, start=8)
    unused = int(np.flatnonzero(~WINDOW.combinatorics.is_used)[0])
    with pytest.raises(GeometryError, match=f"no vertex {unused} with a face"):
        parallel_from_axes(WINDOW, np.tile([0.0, 0.0, 1.0], (WINDOW.n_vertices, 1)), start=unused)
    for distance in (0.0, np.inf):
        with pytest.raises(GeometryError, match="must be a number other than 0"):
            parallel_from_axes(cube, cube.vertices, distance=distance)

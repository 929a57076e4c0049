"""Named blocks of unknowns, judged by dense linear algebra and by what a functional says of its unknowns alone."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array, eye_array

from geometry.errors import GeometryError
from geometry.functionals import ParallelEdges, PlanarFaces
from geometry.gauss import approximate_pair
from geometry.mesh import shapes
from geometry.optimise import Blocks, LinearFunctional, Reason, StackedFunctional, nearest_feasible

seeds = st.integers(0, 2**32 - 1)
sizes = st.lists(st.sampled_from([(), (3,), (1,), (0, 3), (2, 3), (4, 3), (5,)]), min_size=1, max_size=5)


def named(shapes_of_blocks: list[tuple[int, ...]]) -> Blocks:
    return Blocks({f"block_{k}": shape for k, shape in enumerate(shapes_of_blocks)})


@given(sizes, seeds)
def test_what_is_joined_is_split_again(shapes_of_blocks: list[tuple[int, ...]], seed: int) -> None:
    blocks, rng = named(shapes_of_blocks), np.random.default_rng(seed)
    values = {name: rng.standard_normal(shape) for name, shape in blocks.shapes.items()}
    x = blocks.join(**dict(reversed(values.items())))
    assert x.shape == (blocks.n_unknowns,)
    found = blocks.split(x)
    assert list(found) == list(blocks.shapes)
    for name, value in values.items():
        np.testing.assert_array_equal(found[name], value)
        np.testing.assert_array_equal(x[blocks.columns(name)], value.ravel())
    np.testing.assert_array_equal(blocks.join(**found), x)


@given(sizes, seeds)
def test_a_functional_of_some_blocks_is_one_of_all(shapes_of_blocks: list[tuple[int, ...]], seed: int) -> None:
    blocks, rng = named(shapes_of_blocks), np.random.default_rng(seed)
    names = rng.permutation(list(blocks.shapes))[: rng.integers(1, len(blocks.shapes) + 1)].tolist()
    x = rng.standard_normal(blocks.n_unknowns)
    parts = blocks.split(x)
    some = np.concatenate([parts[name].ravel() for name in names])
    matrix = rng.standard_normal((4, len(some))) * (rng.random((4, len(some))) < 0.5)
    linear = LinearFunctional(csr_array(matrix), rng.standard_normal(4))
    functional = blocks.of(linear, *names)
    np.testing.assert_allclose(functional.residual(x), linear.residual(some), rtol=1e-13, atol=1e-13)
    ends = np.cumsum([0, *(part.size for part in parts.values())])
    start_of = dict(zip(parts, ends, strict=False))
    expected, at = np.zeros((4, len(x))), 0
    for name in names:
        size = parts[name].size
        expected[:, start_of[name] : start_of[name] + size] = matrix[:, at : at + size]
        at += size
    np.testing.assert_array_equal(functional.jacobian(x).toarray(), expected)
    np.testing.assert_array_equal(blocks.rows(csr_array(matrix), *names).toarray(), expected)
    assert functional.jacobian(x).nnz == np.count_nonzero(matrix)


@given(sizes, seeds)
def test_the_longest_point_is_a_row_of_a_block(shapes_of_blocks: list[tuple[int, ...]], seed: int) -> None:
    blocks = named(shapes_of_blocks)
    x = np.random.default_rng(seed).standard_normal(blocks.n_unknowns)
    lengths = [0.0]
    for part in blocks.split(x).values():
        rows = part.reshape(-1, part.shape[-1] if part.ndim else 1) if part.size else np.zeros((0, 1))
        lengths += [float(np.sqrt((row**2).sum())) for row in rows]
    assert blocks.longest_point(x) == pytest.approx(max(lengths), rel=1e-14)


def test_meshes_that_stand_in_any_order_with_others_between_are_as_parallel() -> None:
    mesh = shapes.dome(6, 3)
    image, c = approximate_pair(mesh).gauss_image, mesh.combinatorics
    blocks = Blocks({"S": (mesh.n_vertices, 3), "shift": (3,), "M": (mesh.n_vertices, 3)})
    rng = np.random.default_rng(0)
    bent = mesh.vertices + 0.1 * rng.standard_normal(mesh.vertices.shape)
    x = blocks.join(S=image.vertices, shift=np.ones(3), M=bent)
    both, alone = np.concatenate([bent.ravel(), image.vertices.ravel()]), ParallelEdges(c)
    functional = blocks.of(alone, "M", "S")
    np.testing.assert_array_equal(functional.residual(x), alone.residual(both))
    n, given_jacobian = 3 * mesh.n_vertices, alone.jacobian(both).toarray()
    found = functional.jacobian(x).toarray()
    np.testing.assert_array_equal(found[:, n + 3 :], given_jacobian[:, :n])
    np.testing.assert_array_equal(found[:, :n], given_jacobian[:, n:])
    assert not found[:, n : n + 3].any()


def test_two_meshes_and_a_number_are_found_together() -> None:
    """M and S planar and parallel, and the height of S on average the unknown number."""
    mesh = shapes.dome(8, 3)
    image, n = approximate_pair(mesh).gauss_image, mesh.n_vertices
    blocks = Blocks({"height": (), "M": (n, 3), "S": (n, 3)})
    rng = np.random.default_rng(1)
    moved = [each.vertices + 1e-3 * rng.standard_normal((n, 3)) for each in (mesh, image)]
    start = blocks.join(height=2.0, M=moved[0], S=moved[1])
    mean = csr_array(np.concatenate([[-1.0], np.tile([0.0, 0.0, 1 / n], n)])[None])
    c = mesh.combinatorics
    asked = [
        blocks.of(ParallelEdges(c), "M", "S"),
        blocks.of(PlanarFaces(c), "M"),
        blocks.of(LinearFunctional(mean, np.zeros(1)), "height", "S"),
    ]
    solution = nearest_feasible(
        StackedFunctional(asked),
        start,
        csr_array(eye_array(len(start))),
        blocks=blocks,
        tolerance=1e-12,
        longest_step=0.25,
        anchored_steps=2,
        max_steps=30,
    )
    assert solution.reason is Reason.CONVERGED
    found = blocks.split(solution.x)
    assert float(found["height"]) == pytest.approx(found["S"][:, 2].mean(), abs=1e-11)
    assert np.abs(found["M"] - mesh.vertices).max() < 0.5


@pytest.mark.parametrize("target", [[3.0, 4.0, 0.0, 0.0], [0.0, 3.0, 0.0, 4.0], [0.0, 0.0, 0.0, -5.0]])
def test_no_point_of_a_block_moves_by_more_than_the_longest_step(target: list[float]) -> None:
    blocks = Blocks({"point": (3,), "number": ()})
    solution = nearest_feasible(
        LinearFunctional(csr_array(eye_array(4)), np.array(target)),
        np.zeros(4),
        csr_array(eye_array(4)),
        blocks=blocks,
        tolerance=1e-12,
        longest_step=0.5,
        anchored_steps=0,
        max_steps=1,
    )
    point, number = np.linalg.norm(target[:3]), abs(target[3])
    np.testing.assert_allclose(solution.x, np.array(target) * 0.5 / max(point, number), atol=1e-12)


@pytest.mark.parametrize(
    ("act", "sentence"),
    [
        (lambda blocks: blocks.join(M=np.zeros((2, 3))), "a value is missing for shift: give one for each block"),
        (
            lambda blocks: blocks.join(M=np.zeros(6), shift=np.zeros(3)),
            r"the value of block M has shape \(6,\), .* \(2, 3\)",
        ),
        (
            lambda blocks: blocks.join(M=np.zeros((2, 3)), shift=np.zeros(3), S=1.0),
            "no block S: the blocks are M and shift",
        ),
        (lambda blocks: blocks.columns("T"), "no block T: the blocks are M and shift"),
    ],
)
def test_blocks_that_are_not_there_or_of_another_shape_are_refused(act: object, sentence: str) -> None:
    with pytest.raises(GeometryError, match=sentence):
        act(Blocks({"M": (2, 3), "shift": (3,)}))  # type: ignore[operator]

"""The worst element, its value and the bound, in one place."""

from __future__ import annotations

import operator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geometry.arrays import FloatArray
from geometry.errors import FoldedError, GeometryError, MeshError, raise_worst
from geometry.optimise import ConvergenceError, Reason, Solution

HOLDS = {"<=": operator.le, ">=": operator.ge, ">": operator.gt}

numbers = st.lists(st.floats(width=16) | st.sampled_from([0.0, 1.0]), max_size=8).map(
    lambda v: np.array(v, dtype=float)
)
demands = st.sampled_from(sorted(HOLDS))


def said(values: FloatArray, demand: str, bound: float, **more: object) -> GeometryError | None:
    try:
        raise_worst(values, demand, bound, lambda element, value: f"{element}: {value}", **more)
    except GeometryError as error:
        return error
    return None


@given(numbers, demands, st.floats(allow_nan=False, width=16) | st.sampled_from([0.0, 1.0]))
def test_raises_where_one_value_is_not_as_demanded(values: FloatArray, demand: str, bound: float) -> None:
    holds = all(HOLDS[demand](value, bound) for value in values.tolist())
    assert (said(values, demand, bound) is None) == holds


@given(numbers, demands, st.floats(allow_nan=False, width=16))
def test_names_the_first_of_the_worst(values: FloatArray, demand: str, bound: float) -> None:
    error = said(values, demand, bound)
    if error is None:
        return
    (worst,) = error.elements
    if np.isnan(values).any():
        assert worst == int(np.flatnonzero(np.isnan(values))[0])
    else:
        extreme = values.max() if demand == "<=" else values.min()
        assert worst == values.tolist().index(extreme)
    np.testing.assert_equal(error.value, values[worst])
    assert error.bound == bound
    assert str(error) == error.message == f"{worst}: {float(values[worst])}"


@given(numbers, demands, st.permutations(range(8)))
def test_elements_are_those_that_the_values_belong_to(values: FloatArray, demand: str, order: list[int]) -> None:
    elements = np.array(order[: len(values)], dtype=np.int64)
    plain, named = said(values, demand, 0.5), said(values, demand, 0.5, elements=elements)
    assert (plain is None) == (named is None)
    if plain is not None and named is not None:
        (worst,) = plain.elements
        assert named.elements == (elements[worst],)
        assert named.message.startswith(f"{elements[worst]}: ")


def test_errors_are_of_the_class_asked_for_with_what_it_needs() -> None:
    values = np.array([1.0, 3.0])
    assert type(said(values, "<=", 2.0)) is GeometryError
    assert type(said(values, "<=", 2.0, error=MeshError)) is MeshError
    solution = Solution(values, np.zeros(0), 3.0, 5, Reason.STALLED)
    found = said(values, "<=", 2.0, error=ConvergenceError, solution=solution)
    assert isinstance(found, ConvergenceError)
    assert found.solution is solution
    folded = said(values, "<=", 2.0, error=FoldedError, advice="unfold it")
    assert isinstance(folded, FoldedError)
    assert (folded.problem, folded.message) == ("1: 3.0", "1: 3.0; unfold it")


def test_no_values_raise_nothing() -> None:
    raise_worst(np.zeros(0), ">", 1.0, lambda element, value: pytest.fail("there is nothing to speak of"))

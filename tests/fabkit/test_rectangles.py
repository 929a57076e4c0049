"""The smallest rectangles of outlines, and the free one that fits best, are those that a search over all finds."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from fabkit.parts import Ragged
from fabkit.production.nesting.guillotine import ORIENTATIONS, RECTANGLE_ROUNDING_MM, SPLITS, _fill, smallest_rectangles
from fabkit.production.nesting.nests import turned
from fabkit.production.nesting.remaining_rectangles import RemainingRectangles
from geometry.arrays import BoolArray, FloatArray


def best_of_all(
    sizes: FloatArray, is_free: BoolArray, length: float, width: float, orientations: tuple[bool, bool]
) -> tuple:
    lengths, widths = np.concatenate([sizes, sizes[:, ::-1]]).T
    strips = np.minimum(length - lengths, width - widths)
    strips[~(np.tile(is_free, 2) & np.repeat(orientations, len(sizes)) & (strips >= -RECTANGLE_ROUNDING_MM))] = np.inf
    choice = int(strips.argmin())
    return (strips[choice], choice) if strips[choice] < np.inf else (np.inf, -1)


def random_sizes(rng: np.random.Generator, m: int, values: int) -> FloatArray:
    """Whole numbers, so that sizes, strips and areas have no rounding; few values, so that there are ties."""
    return -np.sort(-rng.integers(1, values + 1, (m, 2)), axis=1).astype(float)


seeds, counts, ranges, both = (
    st.integers(0, 2**32 - 1),
    st.integers(1, 40),
    st.sampled_from([2, 6, 1000]),
    st.booleans(),
)


@given(seeds, counts, ranges, st.tuples(both, both))
def test_the_best_of_those_free_is_found(seed: int, m: int, values: int, orientations: tuple[bool, bool]) -> None:
    rng = np.random.default_rng(seed)
    sizes, is_free = random_sizes(rng, m, values), np.ones(m, dtype=bool)
    rectangles = RemainingRectangles(sizes, RECTANGLE_ROUNDING_MM)
    for _ in range(2 * m):
        k = int(rng.integers(m))
        (rectangles.put_back if rng.random() < 0.3 else rectangles.take)(k)
        is_free[k] = rectangles.is_free[k]
        section = rng.integers(0, values + 2, 2).astype(float).tolist()
        assert rectangles.best(*section, orientations) == best_of_all(sizes, is_free, *section, orientations)


@given(seeds, counts, ranges, st.sampled_from(SPLITS), st.sampled_from(ORIENTATIONS))
def test_a_sheet_is_filled_by_the_best_pair_of_all_sections_and_rectangles(
    seed, m, values, split, orientations
) -> None:
    rng = np.random.default_rng(seed)
    sizes, is_free = random_sizes(rng, m, values), np.ones(m, dtype=bool)
    inside = (2.0 * values + 1, 1.5 * values)
    sections, expected = [(0.0, 0.0, *inside)], []
    while True:
        pairs = [(*best_of_all(sizes, is_free, *section[2:], orientations), section) for section in sections]
        strip, choice, here = min(pairs, key=lambda pair: pair[0], default=(np.inf, -1, ()))
        if strip == np.inf:
            break
        length, width = sizes[choice % m][:: 1 if choice < m else -1]
        expected.append((choice, *here[:2]))
        is_free[choice % m] = False
        x, y, across = here[2] - length, here[3] - width, split(here[2] - length, here[3] - width, length, width)
        sections = [section for section in sections if section is not here]
        sections.append((here[0], here[1] + width, here[2] if across else length, y))
        sections.append((here[0] + length, here[1], x, width if across else here[3]))
    rectangles = RemainingRectangles(sizes, RECTANGLE_ROUNDING_MM)
    assert [(each.choice, each.x, each.y) for each in _fill(rectangles, inside, split, orientations)] == expected
    assert all(rectangles.is_free)


@given(st.integers(3, 60), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-9, 0.3]))
def test_the_smallest_rectangle_of_a_round_outline_is_as_all_edges_against_all_corners_say(n, seed, roughness) -> None:
    """Those along the edges of a regular outline are equal but for rounding."""
    rng = np.random.default_rng(seed)
    angles = 2 * np.pi * np.arange(n) / n + rng.uniform(0, 7)
    outline = 500 * (1 - roughness * rng.random(n))[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    corners = shapely.get_coordinates(shapely.convex_hull(shapely.Polygon(outline)))[:-1]
    along = np.roll(corners, -1, axis=0) - corners
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    extents = [np.ptp(corners @ axes.T, axis=0) for axes in (along, along[:, ::-1] * [-1, 1])]
    (angle,), (size,) = smallest_rectangles(Ragged.of([outline], shape=(2,)), (1e5, 1e5))
    # a matrix product rounds otherwise than a sum of two products
    assert size.prod() == pytest.approx(np.prod(extents, axis=0).min(), rel=1e-13)
    # 1e-9: coordinates of 500 mm, turned, are good to 1e-13
    assert np.ptp(turned(outline, angle), axis=0) == pytest.approx(size, abs=1e-9)


def test_the_smallest_rectangle_of_thousands_of_corners_takes_memory_in_proportion() -> None:
    n = 5000
    angles = 2 * np.pi * np.arange(n) / n
    outline = 1e5 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    tracemalloc.start()
    smallest_rectangles(Ragged.of([outline], shape=(2,)), (1e6, 1e6))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < n * 1e3  # some 60 numbers a corner; edges against corners would be 400 MB

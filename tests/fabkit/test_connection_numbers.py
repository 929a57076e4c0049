"""Setbacks, reach and tubes against brute force by another program."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given
from hypothesis import strategies as st

from fabkit.connections import (
    BOLT_SIZES,
    LEAST_EDGE_RATIO,
    LEAST_PITCH_RATIO,
    LEAST_WALL_MM,
    TUBE_DIAMETERS_MM,
    BoltGroup,
    BoltSize,
    bored_setbacks,
    largest_inclination,
    least_radius_for_end,
    next_tube,
    slot_setbacks,
)
from fabkit.errors import ProjectError

EXACT_MM = 1e-6
"""Distances of polygons in shapely are double precision: some 1e-12 of a metre."""

angles = st.floats(0.2, np.pi)


def strip(azimuth: float, start: float, end: float, width: float) -> shapely.Polygon:
    box = shapely.box(start, -width / 2, end, width / 2)
    return shapely.affinity.rotate(box, azimuth, origin=(0, 0), use_radians=True)


@given(angles, st.floats(5, 90), st.floats(1, 40))
def test_slots_are_as_wide_as_wanted_and_no_wider(gap: float, width: float, slot: float) -> None:
    start = slot_setbacks(np.array([gap]), width, slot).item()
    found = strip(0.0, start, 2000.0, width).distance(strip(gap, start, 2000.0, width))
    assert found == pytest.approx(slot, abs=EXACT_MM)


@given(st.lists(st.floats(0.3, 3.0), min_size=2, max_size=7), st.sampled_from(sorted(BOLT_SIZES)))
def test_bores_of_a_whole_ring_keep_the_wall(turns: list[float], name: str) -> None:
    """Each end has the setback that its own two neighbours ask; those further away follow."""
    size = BOLT_SIZES[name]
    gaps = np.array(turns) / sum(turns) * 2 * np.pi
    if gaps.min() < 0.2:  # no room for beams either
        return
    azimuths = np.concatenate([[0.0], np.cumsum(gaps)[:-1]])
    needed = bored_setbacks(gaps, size.diameter_mm, size.bore_depth_mm)
    setbacks = np.maximum(needed, np.roll(needed, 1))
    bores = [
        strip(azimuth, setback - size.bore_depth_mm, setback, size.diameter_mm)
        for azimuth, setback in zip(azimuths, setbacks, strict=True)
    ]
    for k, bore in enumerate(bores):
        for other in bores[:k]:
            assert bore.distance(other) >= LEAST_WALL_MM - EXACT_MM


@given(st.floats(0.1, 6.0), st.floats(4, 40))
def test_bores_keep_the_wall_to_one_along_the_axis(gap: float, axial: float) -> None:
    setback = bored_setbacks(np.array([gap]), 20.0, 39.0, axial_mm=axial).item()
    bore = strip(0.0, setback - 39.0, setback, 20.0)
    assert bore.distance(shapely.Point(0, 0)) >= axial / 2 + LEAST_WALL_MM - EXACT_MM


@given(st.sampled_from([0.0, 25.0]), st.floats(90, 200), st.floats(-1, 1))
def test_a_tool_that_reaches_its_bolt_is_inside_the_section(offset: float, height: float, part: float) -> None:
    radius, length = 19.0, 75.0
    limit = largest_inclination(height, offset, radius, length)
    # in the central plane: the end plate is upright, the hollow inside leans by the inclination
    tools = [shapely.box(0.0, z - radius, length, z + radius) for z in (offset, -offset)]

    def fits(inclination: float) -> bool:
        inside = shapely.affinity.rotate(shapely.box(-500, -height / 2, 500, height / 2), inclination, (0, 0), True)
        return all(inside.buffer(EXACT_MM).contains(tool) for tool in tools)

    assert fits(part * limit)
    if limit < 0.5:  # the formula takes a leaning tool as wide as an upright one, which is 1 - cos of its radius more
        spare = 2 * radius * (1 - np.cos(limit + 0.1)) / length
        assert not fits(limit + spare + 0.01)


def test_tools_lean_as_far_as_the_measured_table_says() -> None:
    assert np.degrees(largest_inclination(110.0, 25.0, 19.0, 75.0)) == pytest.approx(8.7, abs=0.2)
    assert np.degrees(largest_inclination(110.0, 0.0, 23.0, 85.0)) == pytest.approx(22, abs=0.2)
    assert largest_inclination(30.0, 0.0, 23.0, 85.0) < 0


@pytest.mark.parametrize("size", BOLT_SIZES.values(), ids=list(BOLT_SIZES))
def test_bolts_end_before_the_tip_of_their_bores(size: BoltSize) -> None:
    for grip in np.arange(5.0, 40.0, 0.5):
        depth = size.length(grip) - grip
        assert 1.25 * size.diameter_mm - EXACT_MM <= depth <= size.bore_depth_mm - 0.3 * size.core_mm
    assert size.spacing_mm >= LEAST_PITCH_RATIO * size.clearance_mm
    assert size.tool_radius_mm > size.head_diameter_mm / 2 > size.clearance_mm / 2
    assert LEAST_EDGE_RATIO * size.clearance_mm > size.diameter_mm / 2


@given(st.floats(1, 254))
def test_the_next_tube_is_the_smallest_of_the_table_that_is_large_enough(radius: float) -> None:
    assert next_tube(np.array([radius])).item() == min(d / 2 for d in TUBE_DIAMETERS_MM if d / 2 >= radius - 1e-9)


@given(st.floats(3, 80))
def test_the_rim_of_a_plane_end_is_near_the_tube(width: float) -> None:
    radius = least_radius_for_end(width)
    inside = np.sqrt(radius**2 - (width / 2) ** 2)
    assert radius - inside == pytest.approx(min(2.0, width / 2), abs=EXACT_MM)


@pytest.mark.parametrize("text", ["", "3xM16", "0xM16", "1xM5", "M20", "1xM20x40", "xM20" * 100])
def test_text_that_is_no_bolts_is_refused_in_one_sentence(text: str) -> None:
    with pytest.raises(ProjectError, match="like 1xM20") as refused:
        BoltGroup.of(text)
    assert len(str(refused.value)) < 200

"""Dots in nodes that could be mounted turned or upside down: which nodes, where, and what it does to their marks."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fabkit import Project, design
from fabkit.checking import violations
from fabkit.detailing import detail
from fabkit.kinds.look_alikes import look_alikes
from fabkit.parts import Assembly, Part, Ragged
from fabkit.pipeline import Built
from fabkit.production import share_equal_parts
from geometry.arrays import FloatArray
from geometry.mesh.shapes import dome, grid

HUB = {"beams": {"section": "tee 120x80x10x8"}, "connection": {"kind": "hub"}}
ROUNDING = 1e-9
"""Of coordinates of a block in mm."""


def built(**settings: Any) -> Built:
    return design(Project(mesh=dome(6, 2), mean_edge_mm=1500, nesting={"mode": "off"}, **settings))


@pytest.fixture(scope="module", params=["trimmed", "enclosing"])
def blocks(request: pytest.FixtureRequest) -> Built:
    return built(nodes={"top": request.param})


def dots(part: Part) -> FloatArray:
    """(k, 2, 3) ends of the axes of the blind bores in the outer end of a block or cap, in its own frame."""
    rounds = part.solid.topology.rounds
    own = rounds[(rounds[:, 4] == 1) & (rounds[:, 6] == -1)]
    return part.solid.vertices[own[:, [0, 2]]]


def before(made: Built) -> Assembly:
    detailed = detail(made.structure, made.project.rules, name="dome")
    return share_equal_parts(detailed.assembly)


def alike(azimuths: list[float], inclinations: list[float] | None = None) -> list[bool]:
    """Whether one node could be mounted turned, and upside down."""
    of_node = Ragged.of([azimuths])
    level = of_node.with_values(np.zeros(len(azimuths))) if inclinations is None else Ragged.of([inclinations])
    return [bool(found[0]) for found in look_alikes(of_node, level, of_node.with_values(np.full(len(azimuths), 50.0)))]


# --- which nodes


@pytest.mark.parametrize(
    ("azimuths", "inclinations", "expected"),
    [
        ([0, 90, 180, 270], [0, 0, 0, 0], [False, False]),  # as good in all eight positions
        ([0, 90, 180, 270], [-3, -3, -3, -3], [False, True]),  # beams would rise instead
        ([0, 90, 180, 270], [-3, 0, -3, 0], [True, True]),
        ([0, 91.9, 180, 270], [0, 0, 0, 0], [True, True]),
        ([0, 93.9, 180, 270], [0, 0, 0, 0], [False, True]),  # half a turn is 3.9 off, a mirror image 3.9 / 2
        ([0, 95, 180, 275], [0, 0, 0, 0], [False, False]),  # half a turn is harmless, as is the other side, mirrored
        ([0, 70, 150, 250], [0, 0, 0, 0], [False, False]),
        ([0, 80, 200], [1, 1, 1], [False, False]),
        ([0, 170], [0, 0], [False, False]),  # mirrored it is the same
        ([0, 170], [0, 2], [False, True]),
        ([0], [-5], [False, True]),
        ([0], [0], [False, False]),
    ],
)
def test_nodes_that_one_can_judge_by_hand(
    azimuths: list[float], inclinations: list[float], expected: list[bool]
) -> None:
    assert alike(azimuths, inclinations) == expected


@given(st.lists(st.floats(20, 120), min_size=3, max_size=6), st.integers(0, 5), st.floats(0, 360))
def test_what_looks_alike_is_found_by_turning_in_small_steps(gaps: list[float], start: int, turn: float) -> None:
    """Also wherever the ring of beams begins. Near the bound neither answer counts."""
    azimuths = np.cumsum([0.0, *gaps[:-1]]) * 360 / sum(gaps)
    own = np.exp(1j * np.radians(azimuths))
    angles = np.radians(np.arange(0, 360, 0.1))
    least = []
    for other, skipped in ((own, 5.0), (own.conj(), -1.0)):
        off = np.abs(np.angle(other[None, :, None] * np.exp(1j * angles)[:, None, None] / own)).min(axis=2).max(axis=1)
        off = np.degrees(off)[(np.degrees(angles) >= skipped) & (np.degrees(angles) <= 360 - skipped)]
        least.append(float(off.min()))
    rolled = np.roll(azimuths, start)
    found = alike(list(np.mod(rolled - rolled[0], 360)), [1.0] * len(azimuths))
    for value, answer in zip(least, found, strict=True):
        if not 1.8 < value < 2.2 and value > 0.1:  # steps, and nodes that are as good when turned
            assert answer == (value < 2.0)


# --- where the dots are


def test_each_of_these_blocks_has_a_dot_in_its_outer_end_beside_the_first_facet(blocks: Built) -> None:
    nodes, was = blocks.assembly["nodes"], before(blocks)["nodes"]
    assert np.logical_or(*nodes.details.look_alikes).all()
    assert nodes.mark_names == was.mark_names
    assert violations(blocks.assembly) == ()
    for node in nodes:
        ((top, bottom),) = dots(node)
        assert top[:2] == pytest.approx([node.details.setbacks_mm[0] - 10, 0], abs=ROUNDING)
        assert np.linalg.norm(top - bottom) == pytest.approx(2.0)
        assert bottom[2] < top[2] <= node.solid.vertices[:, 2].max()
        towards = np.linalg.norm(
            [top[:2] - node.details.setbacks_mm[k] * ray for k, ray in enumerate(rays(node))], axis=1
        )
        assert towards.argmin() == 0
    assert was.volumes_mm3 - nodes.volumes_mm3 == pytest.approx(np.full(len(nodes), np.pi * 2.5**2 * 2))


def rays(node: Part) -> FloatArray:
    angles = np.radians(node.details.azimuths_deg)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def test_stamped_blocks_keep_their_marks_when_they_are_marked_anew(blocks: Built) -> None:
    again = share_equal_parts(blocks.assembly)["nodes"]
    assert again.mark_names == blocks.assembly["nodes"].mark_names
    assert np.array_equal(again.mark, blocks.assembly["nodes"].mark)


def test_bolted_blocks_have_theirs_beside_their_bores() -> None:
    made = design(Project(mesh=dome(8, 2), mean_edge_mm=3000, connection={"kind": "bolted"}, nesting={"mode": "off"}))
    assert all(len(dots(node)) == 1 for node in made.assembly["nodes"])
    assert violations(made.assembly) == ()


def test_hubs_have_theirs_in_the_upper_cap_towards_the_first_beam() -> None:
    made = built(**HUB).assembly
    nodes, caps = made["nodes"], made["caps"]
    assert violations(made) == ()
    for cap in caps:
        node = nodes[int(nodes.find(np.array([cap.element]))[0])]
        is_upper = (cap.placement.origin - node.placement.origin) @ node.placement.axes[2] > -60  # half the beam
        assert len(dots(cap)) == is_upper
        if is_upper:
            top = node.placement.to_local(cap.placement.to_world(dots(cap)[:, 0]))[0]
            assert top[:2] == pytest.approx([cap.details.diameter_mm / 2 - 10, 0], abs=1e-6)  # beyond marks' rounding
    assert len(caps.mark_names) == 2 * len(np.unique(caps.details.diameter_mm))


def test_nodes_that_fit_in_any_position_have_none() -> None:
    made = design(Project(mesh=grid(3, 3), mean_edge_mm=1500, nesting={"mode": "off"})).assembly["nodes"]
    inner = made.details.beams.sizes == 4
    assert [len(dots(node)) for node in made.take(inner)] == [0, 0, 0, 0]


def test_where_there_is_no_room_there_is_none() -> None:
    narrow = {
        "beams": {"section": "flat 120x10"},
        "connection": {"kind": "contact"},
        "layers": [{"least_bearing_mm": -9}],
    }
    made = built(**narrow).assembly
    assert np.logical_or(*made["nodes"].details.look_alikes).all()
    assert all(len(dots(node)) == 0 for node in made["nodes"])
    assert violations(made) == ()


def test_another_layer_of_nodes_has_dots_too() -> None:
    made = built(second_layer={"distance_mm": -600.0}).assembly
    assert all(len(dots(node)) == 1 for node in made["lower nodes"])

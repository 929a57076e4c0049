"""Whether beams go in between two fixed nodes, against their motion in small steps, and in which order they go in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fabkit import Project, design
from fabkit.checking import clashing_pairs
from fabkit.detailing.ends import Ends
from fabkit.detailing.going_in import going_in_gaps
from fabkit.detailing.nodes import NodeShapes
from fabkit.detailing.shapes.bar_sections import BarSections
from fabkit.kinds import BEAM, NODE, BeamDetails
from fabkit.parts import Assembly, Parts, Section, SolidArray
from fabkit.production import erection_order
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh.shapes import dome

STEPS = 40
"""Positions of a beam on its way between two facets: its end passes a facet of 120 mm in steps of 3 mm."""


def random_ends(n: int, seed: int) -> tuple[Ends, NodeShapes]:
    """n beams of 120 mm, each between two nodes of its own whose axes lean by up to 35 degrees in its plane."""
    rng = np.random.default_rng(seed)
    ends = np.arange(2 * n)
    inclination = np.radians(rng.uniform(-35, 35, 2 * n))
    setback = rng.uniform(25, 160, 2 * n)
    zeros, empty = np.zeros(2 * n), np.zeros((2 * n, 3))
    levels = np.tile([-120.0, 0.0], (n, 1))
    bars = BarSections((Section("flat", (120.0, 50.0)),), np.zeros(n, dtype=np.int64), levels)
    made = Ends(
        ends, empty, empty, inclination, zeros, ends, np.arange(2 * n + 1), ends, zeros, setback, setback, setback, bars
    )
    above, below = rng.uniform(0, 40, 2 * n), rng.uniform(0, 40, 2 * n)
    nothing, level = np.zeros((0, 2)), np.zeros((2 * n, 2))
    blocks = NodeShapes(
        nothing, zeros, made.levels(-120.0) - below, made.levels(0.0) + above, level, level, zeros, zeros
    )
    return made, blocks


def gets_out(ends: Ends, blocks: NodeShapes, gap: FloatArray, psi: FloatArray, sign: float) -> BoolArray:
    """(E,) whether beams with a gap (E,) at each end leave to the outside (sign 1) or inside (-1) along a direction at
    psi (E,) from their normals. In the frame of an end, x away from the node and z along its axis, the block is all
    with x < 0 between two levels; the beam is seen as the polygon of its end's corners and points far along it."""
    free = np.ones(len(gap), dtype=bool)
    for end, side in ((0, 1.0), (1, -1.0)):
        phi = ends.inclination.reshape(-1, 2)[:, end]
        low, high = (ends.levels(level).reshape(-1, 2)[:, end] for level in (-120.0, 0.0))
        bottom, top = blocks.bottom.reshape(-1, 2)[:, end], blocks.top.reshape(-1, 2)[:, end]
        lean = psi * side - sign * phi  # of the way out, from the axis, towards the beam
        way = np.maximum(top - low, high - bottom) / np.cos(lean) + 1.0
        for s in np.linspace(0.0, 1.0, STEPS):
            x, z = gap + s * way * np.sin(lean), sign * s * way * np.cos(lean)
            inside = (x < -1e-9) & (low + z < top - 1e-9) & (high + z > bottom + 1e-9)
            free &= ~inside
    return free


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_side_of_2000_random_beams_is_that_of_their_motion(sign: float) -> None:
    ends, blocks = random_ends(2000, seed=5)
    gaps = going_in_gaps(ends, blocks)
    own = gaps[:, 0 if sign > 0 else 1]
    assert gaps.min(axis=1).max() == 0
    # the middle of the range of directions that the rule promises
    phi = ends.inclination.reshape(-1, 2)
    middle = sign * (phi[:, 0] - phi[:, 1]) / 2
    assert gets_out(ends, blocks, np.zeros(2000), middle, sign)[own == 0].all()
    # no direction whatever serves the others, neither without a gap nor with a little less than they need
    stuck, angles = own > 1, np.radians(np.linspace(-36, 36, 49))
    assert stuck.sum() > 900
    for gap in (np.zeros(2000), 0.95 * own - 0.2):  # steps of 3 mm hide a twentieth of the way
        out = [gets_out(ends, blocks, gap, np.full(2000, psi), sign) for psi in angles]
        assert not np.any(out, axis=0)[stuck].any()


def test_a_beam_with_the_gap_that_it_needs_goes_in_from_the_other_side() -> None:
    ends, blocks = random_ends(300, seed=6)
    gaps = going_in_gaps(ends, blocks)
    angles = np.radians(np.linspace(-36, 36, 181))
    for k, sign in ((0, 1.0), (1, -1.0)):
        own = gaps[:, k] + 0.7  # one direction is within 0.2 degrees of the best one: 0.7 mm on the way of 200 mm
        assert np.any([gets_out(ends, blocks, own, np.full(300, psi), sign) for psi in angles], axis=0).all()


def between(first: Parts[BeamDetails], second: SolidArray, moves: FloatArray) -> IntArray:
    """How many of these beams, moved by (n, 3), share volume with one of the nodes."""
    placed = [replace(each, vertices=each.vertices + moves[each.parts, None]) for each in first.placed()]
    pairs, _ = clashing_pairs([*placed, replace(second, parts=second.parts + len(first))])
    return np.unique(pairs[(pairs[:, 0] < len(first)) & (pairs[:, 1] >= len(first)), 0])


@pytest.fixture(scope="module")
def roof() -> Assembly:
    """A dome of bars in contact with blocks that enclose them."""
    rules = {"beams": {"width_mm": 50, "height_mm": 120}, "connection": {"kind": "contact"}}
    layers = [{"thickness_mm": 10, "joint_mm": 10}]
    return design(
        Project(mesh=dome(6, 3), mean_edge_mm=1500, nodes={"top": "enclosing"}, layers=layers, **rules)
    ).assembly


def test_the_solids_of_a_dome_leave_to_the_outside_and_to_no_other_side(roof: Assembly) -> None:
    beams, nodes = roof.of(BEAM), roof.of(NODE)
    assert set(beams.details.goes_in_from) == {"outside"}
    cuts = np.radians(beams.details.cut_angles_deg)
    psi = (cuts[:, 1] - cuts[:, 0]) / 2  # between the axes, which lean by -cut and cut from the normal
    out = np.cos(psi)[:, None] * beams.axes[:, 2] + np.sin(psi)[:, None] * beams.axes[:, 0]
    blocks = nodes.placed()
    assert len(blocks) > 1
    for step in (0.0, 5.0, 60.0, 130.0):
        assert sum(len(between(beams, block, step * out)) for block in blocks) == 0
    stuck = set(np.concatenate([between(beams, block, -30.0 * out) for block in blocks]).tolist())
    assert stuck == set(range(len(beams)))


# --- the order


def stands(assembly: Assembly, fixed: IntArray | None) -> None:
    """Each part goes in where it may, in the order given."""
    erection, beams, nodes = erection_order(assembly, fixed), assembly.of(BEAM), assembly.of(NODE)
    of_nodes, of_beams = (erection.numbers[group] for group in ("nodes", "beams"))
    closing = erection.is_closing["beams"]
    at_ends = of_nodes[nodes.find(beams.details.nodes)]
    assert len(np.unique(of_nodes)) == len(nodes)
    assert (of_beams >= at_ends.max(axis=1)).all()
    assert (of_beams[~closing] == at_ends.max(axis=1)[~closing]).all()
    assert len(np.unique(of_beams)) == len(beams)
    brought = np.isin(of_nodes, of_beams[~closing])
    assert (~brought).sum() == erection.n_fixed
    numbers = np.concatenate([of_nodes, of_beams[closing]])
    assert sorted(numbers.tolist()) == list(range(1, len(numbers) + 1))
    assert closing.sum() == len(beams) - (len(nodes) - erection.n_fixed)


def test_a_dome_begins_with_its_lowest_boundary(roof: Assembly) -> None:
    stands(roof, None)
    nodes, erection = roof.of(NODE), erection_order(roof)
    on_rim = nodes.origins[:, 2] < nodes.origins[:, 2].min() + 1e-6
    of_nodes = erection.numbers["nodes"]
    assert erection.n_fixed == 1
    assert on_rim.sum() == 6
    assert of_nodes[on_rim].max() < of_nodes[~on_rim].min()


@given(fixed=st.sets(st.integers(0, 23), min_size=1, max_size=24))
def test_it_goes_up_from_any_supports(roof: Assembly, fixed: set[int]) -> None:
    own = np.array(sorted(fixed))
    stands(roof, own)
    erection = erection_order(roof, own)
    assert erection.n_fixed == len(own)
    numbers = erection.numbers["nodes"][roof.of(NODE).find(own)].tolist()
    assert sorted(numbers) == numbers


def test_beams_with_the_largest_gaps_bring_their_nodes(roof: Assembly) -> None:
    beams, fixed = roof.of(BEAM), np.arange(6, 12)
    gaps = np.zeros((len(beams), 2))
    gaps[:, 0] = np.random.default_rng(3).permutation(len(beams)) + 1.0
    tight = roof.with_group(replace(beams, details=replace(beams.details, going_in_gaps_mm=gaps)))
    closing, ends = erection_order(tight, fixed).is_closing["beams"], beams.details.nodes
    ring = np.where(np.isin(np.arange(len(roof.of(NODE))), fixed), 0, 99)
    for _ in ring:
        for a, b in ends.tolist():
            ring[a], ring[b] = min(ring[a], ring[b] + 1), min(ring[b], ring[a] + 1)
    assert ring.max() > 1
    # Kruskal's way, ring by ring: the largest gap first, unless both nodes are joined to those of earlier rings already
    joined, brings = list(range(len(ring))), []
    for k in sorted(range(len(beams)), key=lambda k: (ring[ends[k]].max(), -gaps[k, 0])):
        own = ring[ends[k]].max()
        a, b = (-1 if ring[v] < own or own == 0 else joined[v] for v in ends[k])
        if a != b:
            brings.append(k)
            joined = [min(a, b) if one == max(a, b) else one for one in joined]
    assert sorted(brings) == np.flatnonzero(~closing).tolist()


def test_panels_follow_in_the_order_of_their_last_beams(roof: Assembly) -> None:
    erection, panels = erection_order(roof), roof["panels"]
    numbers = erection.numbers["panels"]
    assert sorted(numbers.tolist()) == list(range(numbers.min(), numbers.min() + len(panels)))
    assert numbers.min() == 1 + max(erection.numbers[group].max() for group in ("nodes", "beams"))
    beams = roof.of(BEAM)
    last = [erection.numbers["beams"][beams.find(around)].max() for around in panels.details.beams]
    assert [last[k] for k in np.argsort(numbers)] == sorted(last)

"""Which round bars share volume with other parts: exact gaps, contact with planes, bolts in bores."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fabkit.checking.clash import clashing_pairs
from fabkit.checking.convex import is_splittable
from fabkit.parts import (
    Measures,
    Solid,
    SolidArray,
    bore_vertices,
    prism_topology,
    prism_vertices,
    round_vertices,
    shaft_topology,
)
from geometry.arrays import FloatArray
from tests.fabkit.round_solids import SOLIDS, block, bolt, profile, regular, tube
from tests.fabkit.solids import frame
from tests.fabkit.test_clash import box, moved, random_prism

each_seed = settings(max_examples=40, deadline=None)
seeds = st.integers(0, 2**32 - 1)
FLAT, Z = np.zeros(3), np.array([0.0, 0.0, 1.0])


def depth(first: Solid, second: Solid, seed: int = 0) -> float:
    """Of the overlap of two solids, 0 without one; in any position."""
    place = frame(seed)
    solids = [Solid(place.to_world(solid.vertices), solid.topology) for solid in (first, second)]
    batches = [SolidArray(each.topology, np.array([k]), each.vertices[None]) for k, each in enumerate(solids)]
    assert all(is_splittable(batch).all() for batch in batches)
    return float(clashing_pairs(batches)[1].max(initial=0.0))


def random_bar(rng: np.random.Generator) -> Solid:
    radius, length = rng.uniform(5, 80), rng.uniform(10, 200)
    slopes = rng.uniform(-1, 1, 2) * min(1, length / radius / 2.1) * rng.integers(2)
    planes = [np.array([x, 0, slope]) for x, slope in zip((0.0, length), slopes, strict=True)]
    return Solid(round_vertices([radius], *planes), shaft_topology())


def furthest(solid: Solid, along: FloatArray) -> FloatArray:
    """The point of a bar or a prism furthest along a direction; of a bar by points of its edges."""
    if not solid.topology.is_convex_shaft:
        return solid.vertices[(solid.vertices @ along).argmax()]
    of = Measures(solid.topology, solid.vertices[None])
    minor = np.cross(of.round_axes[:, 0, 0], of.rims[0, :, 0, 0])
    minor *= of.radii[0, 0] / np.linalg.norm(minor)
    found = []
    for centre, rim in zip(solid.vertices[[0, 2]], of.rims[:, :, 0, 0], strict=True):
        angle = np.arctan2(minor @ along, rim @ along)
        found.append(centre + rim * np.cos(angle) + minor * np.sin(angle))
    return max(found, key=lambda point: point @ along)


@each_seed
@given(seeds, st.floats(0.5, 50.0), st.booleans())
def test_gap_and_overlap_along_any_direction(seed: int, gap: float, both_round: bool) -> None:
    """The nearest points of two pieces, set at this distance along a direction, or as deep in each other."""
    rng = np.random.default_rng(seed)
    first, second = random_bar(rng), random_bar(rng) if both_round else random_prism(rng)
    second, n = moved(second, np.zeros(3), Rotation.random(rng=rng)), Rotation.random(rng=rng).as_matrix()[0]
    touching = moved(second, furthest(first, n) - furthest(second, -n))
    assert depth(first, moved(touching, gap * n), seed % 999) == 0
    assert depth(first, moved(touching, -0.01 * n), seed % 999) > 1e-6


@each_seed
@given(seeds, st.floats(0, 2 * np.pi), st.floats(1e-3, 5.0))
def test_the_end_of_a_beam_on_a_tube(seed: int, angle: float, sunk: float) -> None:
    """It touches along a line: no overlap to 1e-6 mm whatever the direction, and the exact depth where it is sunk."""
    hub = tube(38.05, 31.75, FLAT, np.array([150.0, 0, 0]))
    turn = Rotation.from_rotvec([angle, 0, 0])
    square = profile("flat 120x12")
    own = Solid(square.vertices[:, [2, 1, 0]] * [1, -1, 1] + [75.0, 0, 38.05], square.topology)
    assert depth(hub, moved(own, np.zeros(3), turn), seed % 999) == 0
    deep = depth(hub, moved(moved(own, np.array([0, 0, -sunk])), np.zeros(3), turn), seed % 999)
    assert deep == pytest.approx(sunk, abs=1e-6)


def bolted(shift: FloatArray = FLAT, size: float = 8.0, length: float = 40.0) -> tuple[Solid, Solid, Solid]:
    """A block with blind bores, 30 deep and 8 in radius, a plate of 10 on one of its facets, and a bolt through it."""
    node = block()
    outline = regular(5, 80.0)
    middle, inward = (outline[0] + outline[1]) / 2, -(outline[0] + outline[1]) / np.linalg.norm(outline[0] + outline[1])
    at = np.array([*middle, 45.0])
    holes = bore_vertices(np.zeros(3), 10.0 * Z, 9.0, np.array([1.0, 0, 0]))
    square = np.concatenate([prism_vertices(regular(4, 50.0), 0.0, 10.0), holes])
    plate = Solid(square - 10 * Z, prism_topology(4).bored([(0, 1)]))
    disc = bore_vertices(-8 * Z, np.zeros(3), 12.0, np.array([1.0, 0, 0]))
    shank = bore_vertices(np.zeros(3), length * Z, size, np.array([1.0, 0, 0]))
    screw = Solid(np.concatenate([disc, shank]) - 10 * Z + shift, bolt(0).topology)
    basis = np.stack([[0.0, 0.0, 1.0], np.cross([*inward, 0.0], [0.0, 0.0, 1.0]), [*inward, 0.0]])
    return node, *(Solid(at + solid.vertices @ basis, solid.topology) for solid in (plate, screw))


@pytest.mark.parametrize("seed", range(5))
def test_a_bolt_in_its_bores(seed: int) -> None:
    node, plate, screw = bolted()
    assert depth(node, screw, seed) == depth(plate, screw, seed) == depth(node, plate, seed) == 0
    for wrong in (bolted(size=8.1), bolted(shift=np.array([0.5, 0, 0])), bolted(length=45.0)):
        assert depth(node, wrong[2], seed) > 1e-3
    assert depth(node, bolted(length=41.0)[2], seed) == pytest.approx(
        31.0, abs=1e-6
    )  # its tip is as far from the facet
    assert depth(plate, bolted(shift=np.array([0.5, 0, 0]))[2], seed) == 0  # a clearance of 1
    assert depth(plate, bolted(shift=np.array([1.5, 0, 0]))[2], seed) > 0.1
    assert depth(plate, bolted(shift=0.25 * Z)[2], seed) == pytest.approx(0.25, abs=1e-6)  # the head in the plate


def test_a_bolt_between_walls_is_free_in_them_alone() -> None:
    beam = SOLIDS["hand hole"]
    pin = bore_vertices(np.array([500.0, 40, 10]), np.array([500.0, 20, 10]), 9.0, np.array([1.0, 0, 0]))
    through = bore_vertices(np.array([500.0, 40, 10]), np.array([500.0, -40, 10]), 9.0, np.array([1.0, 0, 0]))
    assert depth(beam, Solid(pin, shaft_topology())) == 0
    assert depth(beam, Solid(through, shaft_topology())) > 1


def test_what_is_hollow() -> None:
    """A rod in a hollow section is free wherever it runs, as is one in a tube; the wall is not."""
    hollow = profile("rhs 120x60x5")
    pipe = tube(30.0, 26.0, FLAT, np.array([800.0, 0, 0]))
    rod = Solid(bore_vertices(np.array([-9.0, 0, 0]), np.array([900.0, 0, 0]), 8.0, Z), shaft_topology())
    assert depth(hollow, moved(rod, np.array([0, 16.9, 40.0]))) == 0
    assert depth(hollow, moved(rod, np.array([0, 17.1, 40.0]))) == pytest.approx(0.1, abs=1e-6)
    assert depth(pipe, moved(rod, np.array([0, 0, 17.9]))) == 0
    assert depth(pipe, moved(rod, np.array([0, 0, 18.1]))) > 0.05
    assert depth(hollow, box([100, -20, -50], [200, 20, 50])) == 0
    assert depth(hollow, box([100, -20, -50], [200, 26, 50])) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_plates_inside_a_tube(seed: int) -> None:
    """Inside its inner radius of 26 they are free, also where they stand out of an end."""
    pipe = tube(30.0, 26.0, FLAT, np.array([800.0, 0, 0.2]))
    assert depth(pipe, box([100, -10, -24], [200, 10, 24]), seed) == 0
    assert depth(pipe, box([-50, -10, -24], [900, 10, 24]), seed) == 0
    assert depth(pipe, box([100, -10, -24.1], [200, 10, 24.1]), seed) > 1e-3
    assert depth(pipe, profile("rhs 40x30x3", length=300.0), seed) == 0


def test_a_square_pin_in_a_blind_bore_ends_above_its_bottom() -> None:
    node, along = block(), np.array([np.cos(0.2 * np.pi), np.sin(0.2 * np.pi), 0])  # 30 deep
    pin = moved(box([-29.99, -5, -5], [10, 5, 5]), FLAT, Rotation.from_euler("z", 0.2 * np.pi))
    facet = 80 * np.cos(0.2 * np.pi) * along + [0, 0, 45.0]
    assert depth(node, moved(pin, facet)) == 0
    assert depth(node, moved(pin, facet - 0.02 * along)) > 1e-3

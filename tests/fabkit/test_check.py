"""What must always hold, on a small dome made by hand: it passes whole, and is refused when broken in any one way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from fabkit.checking.placed_parts import check_fit, violations
from fabkit.errors import DetailingError
from fabkit.parts import Assembly, Frame, Part, Solid, Topology, prism_topology, prism_vertices
from tests.fabkit.assemblies import altered, assembled, by_name, with_parts
from tests.fabkit.dome import CENTRE, LIFT, dome


def refused(assembly: Assembly, *words: str, **bounds: float) -> None:
    """check_fit says all these words, and violations names at least one part."""
    with pytest.raises(DetailingError) as caught:
        check_fit(assembly, **bounds)
    for word in words:
        assert word in str(caught.value)
    assert all(violation.parts for violation in violations(assembly, **bounds))


def change(assembly: Assembly, kind: str, position: int, alter: Callable[[Part], Part]) -> Assembly:
    group = list(assembly[kind])
    group[position] = alter(group[position])
    return with_parts(assembly, **{kind: group})


def moved(shift: list[float]) -> Callable[[Part], Part]:
    """Moved by mm along the axes of its own frame."""

    def alter(part: Part) -> Part:
        frame = part.placement
        return replace(part, placement=Frame(frame.to_world(np.array(shift)), frame.axes))

    return alter


def turned(axis: int, angle: float) -> Callable[[Part], Part]:
    """Turned by radians about an axis of its own frame."""

    def alter(part: Part) -> Part:
        turn = Rotation.from_rotvec(angle * np.eye(3)[axis]).as_matrix()
        return replace(part, placement=Frame(part.placement.origin, turn @ part.placement.axes))

    return alter


def scaled(factors: list[float]) -> Callable[[Part], Part]:
    return lambda part: replace(part, solid=Solid(part.solid.vertices * factors, part.solid.topology))


def with_corner(vertex: int, shift: list[float]) -> Callable[[Part], Part]:
    def alter(part: Part) -> Part:
        vertices = part.solid.vertices.copy()
        vertices[vertex] += shift
        return replace(part, solid=Solid(vertices, part.solid.topology))

    return alter


def inside_out(part: Part) -> Part:
    t = part.solid.topology
    return replace(
        part, solid=Solid(part.solid.vertices, Topology(t.n_vertices, t.corners[::-1], t.loop_starts, t.face_starts))
    )


def reversed_prism(part: Part) -> Part:
    """Bottom and top exchanged: inside out, in the same topology."""
    n = len(part.solid.vertices) // 2
    return replace(part, solid=Solid(np.roll(part.solid.vertices, n, axis=0), part.solid.topology))


@pytest.mark.parametrize("notched", [False, True])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_whole_dome_fits(n: int, notched: bool) -> None:
    assembly = dome(n, notched=notched)
    assert violations(assembly) == ()
    check_fit(assembly)


def test_nothing_fits() -> None:
    assert violations(assembled("nothing")) == ()


def test_beams_without_nodes_and_nodes_without_beams() -> None:
    whole = dome()
    refused(with_parts(whole, nodes=()), "which has no node")
    refused(with_parts(whole, beams=()), "at which no beam ends")
    assert violations(with_parts(whole, beams=(), nodes=())) == ()


# positions far from the origin cost digits: at 100 m a double has 1.5e-11 mm left, far below the 1e-6 mm asked
@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-1e5, 1e5), min_size=3, max_size=3), st.integers(0, 2**32 - 1), st.booleans())
def test_fit_does_not_depend_on_place(shift: list[float], seed: int, notched: bool) -> None:
    outer = Frame(np.array(shift), Rotation.random(rng=seed).as_matrix())
    whole = dome(notched=notched)
    groups = {
        name: tuple(replace(part, placement=outer.place(part.placement)) for part in group)
        for name, group in by_name(whole).items()
    }
    assert violations(with_parts(whole, **groups)) == ()
    off = change(with_parts(whole, **groups), "beams", 4, moved([1e-5, 0, 0]))
    assert len(violations(off)) >= 2


@pytest.mark.parametrize("shift", [1e-5, -1e-5])
def test_beam_shifted_along_its_axis_is_off_both_facets(shift: float) -> None:
    shifted = change(dome(), "beams", 4, moved([shift, 0, 0]))
    refused(
        shifted,
        "beam B4 (edge 4)",
        "end A is 9.99e-06 mm off the facet of node N4 (vertex 4), allowed 1e-06 mm",
        "end B",
    )
    check_fit(shifted, fit_mm=2e-5)


def test_beam_shifted_sideways_sticks_out_of_its_facets() -> None:
    refused(change(dome(), "beams", 4, moved([0, 1e-5, 0])), "B4", "sticks out 1e-05 mm over the facet", "as wide")
    refused(change(dome(), "beams", 4, moved([0, 0, 1e-5])), "B4", "sticks out 9.99e-06 mm over the facet", "as wide")


def test_facet_may_be_larger_than_the_end_of_its_beam() -> None:
    check_fit(change(dome(), "beams", 4, scaled([1.0, 0.9, 1.0])))


def test_beam_wider_than_its_facets() -> None:
    refused(change(dome(), "beams", 4, scaled([1.0, 1.1, 1.0])), "B4 (edge 4)", "sticks out 2.5 mm")


def test_beam_turned_about_its_axis() -> None:
    # a corner of the end is 25 mm off the axis: 1e-6 radians move it by 2.5e-5 mm and more
    refused(change(dome(), "beams", 4, turned(0, 1e-6)), "B4 (edge 4)", "facet of node")


def test_beam_bent_off_its_direction_opens_a_wedge() -> None:
    refused(change(dome(), "beams", 4, turned(2, 1e-6)), "B4 (edge 4)", "mm off the facet")


def test_beam_turned_end_for_end_does_not_look_at_its_nodes() -> None:
    found = violations(change(dome(), "beams", 4, turned(2, np.pi)))
    assert any("mm off the facet" in violation.sentence for violation in found)


@pytest.mark.parametrize("twist", [2e-6, -2e-6, float("nan")])
def test_twist(twist: float) -> None:
    twisted = change(dome(), "beams", 4, lambda beam: altered(beam, twist_deg=twist))
    refused(twisted, "beam B4 (edge 4) is twisted by", "allowed 1e-06", "parallel first")
    if np.isfinite(twist):
        check_fit(twisted, twist_deg=3e-6)


def test_dropped_node() -> None:
    whole = dome()
    dropped = with_parts(whole, nodes=[node for node in whole["nodes"] if node.element != CENTRE])
    refused(dropped, "at vertex 4, which has no node", "and 1 more like this", "make both or leave out both")
    assert all(("node", CENTRE) in violation.parts for violation in violations(dropped))


def test_dropped_beam() -> None:
    whole = dome()
    found = violations(with_parts(whole, beams=whole["beams"][1:]))
    assert [violation.parts for violation in found] == [
        (("node", whole["beams"][0].details.nodes[0]), ("beam", 0)),
        (("node", whole["beams"][0].details.nodes[1]), ("beam", 0)),
    ]


def test_node_that_does_not_know_its_beam() -> None:
    unknown = change(dome(), "nodes", CENTRE, lambda node: altered(node, beams=node.details.beams[1:]))
    refused(unknown, "has no facet for it", "node N4 (vertex 4)")


def test_beam_that_names_the_wrong_node_is_off_its_facet() -> None:
    whole = dome()
    a, b = whole["beams"][4].details.nodes
    swapped = change(whole, "beams", 4, lambda beam: altered(beam, nodes=(b, a)))
    refused(swapped, "B4 (edge 4)", "mm off the facet")


def test_beam_and_node_disagree_about_where_the_beam_ends() -> None:
    whole = dome()
    a, b = whole["beams"][4].details.nodes
    astray = change(whole, "beams", 4, lambda beam: altered(beam, nodes=(a, (b + 1) % 9)))
    sentences = [violation.sentence for violation in violations(astray)]
    assert any("beam B4 (edge 4) ends (end B)" in s and "which has no facet for it" in s for s in sentences)
    assert any(f"node N{b} (vertex {b}) has a facet for edge 4, at which no beam ends" in s for s in sentences)


@pytest.mark.parametrize("alter", [inside_out, reversed_prism, scaled([-1.0, 1.0, 1.0])])
@pytest.mark.parametrize("kind", ["beams", "nodes", "panels"])
def test_reversed_solid(kind: str, alter: Callable[[Part], Part]) -> None:
    refused(change(dome(), kind, 2, alter), "2 (", "has a volume of -", "must be positive")


def test_mirroring_and_stretching_placements() -> None:
    def placed(factors: list[float]) -> Assembly:
        axes = np.diag(factors) @ dome()["panels"][2].placement.axes
        return change(dome(), "panels", 2, lambda part: replace(part, placement=Frame(part.placement.origin, axes)))

    refused(placed([-1.0, 1.0, 1.0]), "panel P2 (face 2) has a volume of -")
    refused(placed([1.0, 1.0 + 1e-9, 1.0]), "panel P2 (face 2) has axes that are 2e-09 from orthonormal")


@pytest.mark.parametrize("kind", ["beams", "nodes", "panels"])
def test_not_a_number(kind: str) -> None:
    found = violations(change(dome(), kind, 2, with_corner(0, [float("nan"), 0, 0])))
    assert len(found) == 1
    assert "has a volume of nan mm3" in found[0].sentence


def test_face_out_of_plane() -> None:
    bent = change(dome(), "panels", 2, with_corner(5, [0, 0, 1e-5]))
    # best plane of a quad with one corner lifted: every corner is a quarter of the lift away
    refused(bent, "panel P2 (face 2) has a face that is off its plane by 2.51e-06 mm, allowed 1e-06 mm", "planarise")
    check_fit(bent, fit_mm=3e-6)


def test_short_edge() -> None:
    corner = dome()["panels"][2].solid.vertices
    shrunk = change(dome(), "panels", 2, with_corner(slice(1, None, 4), 0.9999999 * (corner[0] - corner[1])))
    refused(shrunk, "panel P2 (face 2) has an edge of 0.000146 mm, allowed 0.001 mm and more")
    check_fit(shrunk, shortest_edge_mm=1e-4)


def test_outline_that_crosses_itself() -> None:
    star = 1000 * np.array([[np.cos(k * 0.8 * np.pi), np.sin(k * 0.8 * np.pi)] for k in range(5)])
    pentagram = Solid(prism_vertices(star, 0.0, 10.0), prism_topology(5))
    refused(
        change(dome(), "panels", 2, lambda part: replace(part, solid=pentagram)),
        "panel P2 (face 2) is neither convex nor a prism whose outline does not cross itself",
    )


def test_panel_lowered_into_the_beams() -> None:
    lowered = change(dome(), "panels", 2, moved([0, 0, -LIFT - 1.0]))
    refused(lowered, "and panel P2 (face 2) share volume", "mm deep, allowed 1e-06 mm", "the seat or the joint")
    assert {("panel", 2)} <= {part for violation in violations(lowered) for part in violation.parts}


def test_the_cure_of_a_clash_is_in_the_mesh_for_distant_parts_and_in_sizes_for_neighbours() -> None:
    whole = dome()
    here = whole["panels"][0]
    corners = {vertex for beam in whole["beams"] if beam.element in here.details.beams for vertex in beam.details.nodes}
    far = next(beam for beam in whole["beams"] if not set(beam.details.nodes) & corners)
    middle = here.placement.to_world(here.solid.centroid)
    there = change(
        whole, "beams", far.element, lambda beam: replace(beam, placement=Frame(middle, beam.placement.axes))
    )
    clash = [v for v in violations(there) if set(v.parts) == {("panel", here.element), ("beam", far.element)}]
    assert "share no vertex of the mesh, which intersects itself" in clash[0].sentence
    assert "widen" not in clash[0].sentence
    near = violations(change(whole, "panels", 0, moved([0, 0, -LIFT - 1.0])))
    assert len(near) == 8  # four beams and four nodes
    assert all("increase the slot between beams" in violation.cure for violation in near)


def test_panel_widened_into_its_neighbours() -> None:
    widened = change(dome(), "panels", 2, scaled([1.05, 1.05, 1.0]))
    refused(widened, "panel P2 (face 2) and panel P3 (face 3) share volume")


def test_part_made_twice() -> None:
    whole = dome()
    twice = with_parts(whole, panels=(*whole["panels"], moved([0, 0, 1000.0])(whole["panels"][2])))
    refused(twice, "face 2 has 2 panels, allowed 1", "make each part once")
    assert len(violations(twice)) == 1


def test_an_invalid_part_is_not_checked_further() -> None:
    gone = change(dome(), "beams", 4, lambda beam: inside_out(moved([1.0, 0, 0])(beam)))
    assert [violation.parts for violation in violations(gone)] == [(("beam", 4),)]


def test_error_names_the_first_and_counts_the_rest() -> None:
    whole = dome()
    sunk = with_parts(whole, panels=tuple(inside_out(panel) for panel in whole["panels"]))
    sunk = change(sunk, "beams", 4, lambda beam: altered(beam, twist_deg=1.0))
    refused(sunk, "P0 (face 0)", "P2 (face 2)", "and 1 more like this", "(and 1 other finding)")
    with pytest.raises(DetailingError) as caught:
        check_fit(sunk)
    assert "P3" not in str(caught.value)

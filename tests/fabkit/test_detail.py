"""Detailing against closed forms: a flat grid, a cube, and structures in which something cannot be built."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.checking.placed_parts import violations
from fabkit.detailing.assembling import detail
from fabkit.errors import DetailingError
from fabkit.rules import BeamRules, LayerRules, NodeRules
from geometry.gauss import Pair
from geometry.gauss.support_structure import SupportStructure
from geometry.mesh import Mesh
from tests.fabkit.plain_bars import PLAIN_RULES

SIDE = 1500.0


def flat_grid(nx: int = 3, ny: int = 2) -> SupportStructure:
    """Square cells in the xy-plane; every axis is vertical, so the Gauss image is one point."""
    points = [(SIDE * x, SIDE * y, 0.0) for y in range(ny + 1) for x in range(nx + 1)]
    step = nx + 1
    faces = [
        [step * y + x, step * y + x + 1, step * (y + 1) + x + 1, step * (y + 1) + x]
        for y in range(ny)
        for x in range(nx)
    ]
    mesh = Mesh.from_faces(points, faces)
    return SupportStructure(Pair(mesh, mesh.with_vertices(np.tile([0.0, 0.0, 1.0], (len(points), 1)))), 120.0)


def cube() -> SupportStructure:
    """A cube with edges of 1500 mm whose Gauss image touches the unit sphere with its edges."""
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]) / np.sqrt(2)
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    sphere = Mesh.from_faces(corners, faces)
    return SupportStructure(Pair(sphere * (SIDE / np.sqrt(2)), sphere), 120.0)


def fan(angle_deg: float) -> SupportStructure:
    """One flat triangle and one quad about the origin, with an edge on either side of a small angle."""
    a = np.radians(angle_deg)
    points = [(0, 0, 0), (SIDE, 0, 0), (SIDE * np.cos(a), SIDE * np.sin(a), 0), (0, SIDE, 0), (SIDE, SIDE, 0)]
    mesh = Mesh.from_faces(points, [[0, 1, 2], [0, 2, 4, 3]])
    return SupportStructure(Pair(mesh, mesh.with_vertices(np.tile([0.0, 0.0, 1.0], (5, 1)))), 120.0)


def test_flat_grid_has_the_sizes_one_can_work_out_by_hand() -> None:
    assembly = detail(flat_grid(), PLAIN_RULES, name="grid").assembly
    assert (len(assembly["beams"]), len(assembly["nodes"]), len(assembly["panels"])) == (17, 12, 6)
    for beam in assembly["beams"]:  # right angles at both ends: (50 / 2) / tan(45) + 5 = 30 off each
        assert beam.details.long_point_mm == pytest.approx(SIDE - 60)
        assert beam.details.short_point_mm == pytest.approx(SIDE - 60)
        assert beam.details.cut_angles_deg == pytest.approx((0.0, 0.0))
        assert beam.solid.volume_mm3 == pytest.approx((SIDE - 60) * 50 * 120)
        assert beam.details.height_deviation_mm == pytest.approx(0.0)
    for panel in assembly["panels"]:  # nothing stands above the mesh: the panels lie on their seat
        assert panel.details.edge_lengths_mm == pytest.approx((SIDE - 10,) * 4)
        assert panel.details.corner_angles_deg == pytest.approx((90.0,) * 4)
        assert panel.details.underside_mm == pytest.approx(5.0)
        assert panel.placement.origin[2] == pytest.approx(5.0)
    areas = {len(node.details.beams): node.solid.volume_mm3 / node.details.height_mm for node in assembly["nodes"]}
    octagon = 60 * 60 - 4 * 5 * 5 / 2
    assert areas[4] == pytest.approx(octagon)
    assert areas[3] == pytest.approx(octagon - 50 * 5 - 2 * 5 * 5 / 2)  # straight across at half a width
    assert all(node.details.height_mm == pytest.approx(120.0) for node in assembly["nodes"])


def test_the_outer_side_of_a_corner_piece_still_holds_the_axis() -> None:
    corner = next(
        node for node in detail(flat_grid(), PLAIN_RULES, name="grid").assembly["nodes"] if len(node.details.beams) == 2
    )
    n = corner.solid.topology.n_vertices // 2
    section = corner.solid.vertices[:n, :2]
    following = np.roll(section, -1, axis=0)
    distances = (section[:, 0] * following[:, 1] - section[:, 1] * following[:, 0]) / np.linalg.norm(
        following - section, axis=1
    )
    assert n == 5
    assert distances.min() > 15.0


def test_cube_is_cut_at_the_angle_between_edge_and_diagonal() -> None:
    assembly = detail(cube(), PLAIN_RULES, name="cube").assembly
    angle = np.degrees(np.arcsin(1 / np.sqrt(3)))
    setback = 25 / np.tan(np.radians(60)) + 5
    for beam in assembly["beams"]:
        assert beam.details.cut_angles_deg == pytest.approx((angle, angle))
        assert beam.details.long_point_mm == pytest.approx(SIDE - 2 * setback / np.cos(np.radians(angle)))
        assert beam.details.long_point_mm - beam.details.short_point_mm == pytest.approx(
            2 * 120 * np.tan(np.radians(angle))
        )
        assert beam.details.dihedral_deg == pytest.approx(90.0)
    for node in assembly["nodes"]:  # an edge offset mesh: all outer edges at one level [Pottmann2007, Prop. 3]
        assert node.details.top_step_mm < 1e-9 * 120
        assert node.details.azimuths_deg == pytest.approx((0.0, 120.0, 240.0))


@pytest.mark.parametrize(("reference", "outer"), [("outer", 0.0), ("centre", 60.0), ("inner", 120.0)])
def test_the_reference_says_what_lies_on_the_mesh(reference: str, outer: float) -> None:
    rules = replace(PLAIN_RULES, beams=replace(PLAIN_RULES.beams, reference=reference))
    detailed = detail(flat_grid(), rules, name="grid")
    tops = [beam.placement.to_world(beam.solid.vertices)[:, 2].max() for beam in detailed.assembly["beams"]]
    assert tops == pytest.approx([outer] * len(tops))
    assert detailed.underside_mm == pytest.approx(outer + 5.0)


def test_parts_do_not_depend_on_where_the_structure_stands() -> None:
    here = cube()
    turn = np.linalg.qr(np.arange(9).reshape(3, 3) ** 2 + np.eye(3))[0]
    turn *= np.linalg.det(turn)
    moved = SupportStructure(
        Pair(
            here.mesh.with_vertices(here.mesh.vertices @ turn + [1e5, -2e4, 3e3]),
            here.gauss_image.with_vertices(here.gauss_image.vertices @ turn),
        ),
        120.0,
    )
    for old, new in zip(
        detail(here, PLAIN_RULES, name="a").assembly.parts(),
        detail(moved, PLAIN_RULES, name="b").assembly.parts(),
        strict=True,
    ):  # rounding of coordinates of 1e5 mm
        assert np.abs(np.sort(old.solid.vertices, axis=0) - np.sort(new.solid.vertices, axis=0)).max() < 1e-8


@settings(max_examples=25, deadline=None)
@given(
    width=st.floats(20, 120),
    height=st.floats(40, 300),
    clearance=st.floats(0.5, 40),
    thickness=st.floats(4, 60),
    joint=st.floats(2, 60),
    reference=st.sampled_from(["outer", "centre", "inner"]),
)
def test_any_reasonable_sizes_fit(
    width: float, height: float, clearance: float, thickness: float, joint: float, reference: str
) -> None:
    rules = replace(
        PLAIN_RULES,
        beams=BeamRules(width_mm=width, height_mm=height, reference=reference),
        nodes=NodeRules(clearance_mm=clearance, top="enclosing"),
        layers=(LayerRules(thickness_mm=thickness, joint_mm=joint, least_bearing_mm=-1e3),),
    )
    for structure in (flat_grid(), cube()):
        assembly = detail(structure, rules, name="sizes").assembly
        assert not violations(assembly)
        assert not assembly.left_out


def test_beams_without_room_are_an_error_that_names_beams_nodes_and_cure() -> None:
    with pytest.raises(DetailingError) as caught:
        detail(fan(1.5), PLAIN_RULES, name="fan")
    message = str(caught.value)
    for word in (
        "the beam on edge 0 from vertex 0 to vertex 1",
        "the beam on edge 2 from vertex 2 to vertex 0",
        "1.5 degrees apart",
        "--skip-unbuildable",
    ):
        assert word in message


def test_beams_without_room_can_be_left_out_and_the_rest_is_built() -> None:
    assembly = detail(fan(1.5), PLAIN_RULES, name="fan", skip_unbuildable=True).assembly
    left = {(part.kind, part.element) for part in assembly.left_out}
    assert {("beam", 0), ("beam", 2)} <= left
    assert {beam.element for beam in assembly["beams"]}.isdisjoint({0, 2})
    assert not violations(assembly)
    assert len(assembly["beams"]) + sum(kind == "beam" for kind, _ in left) == 6
    joined = {vertex for beam in assembly["beams"] for vertex in beam.details.nodes}
    assert {element for kind, element in left if kind == "node"} == set(range(5)) - joined == {1}


def test_a_node_may_keep_one_beam_only() -> None:
    """The short sides of a slim rectangle have no room; without them, nothing holds the long ones back."""
    mesh = Mesh.from_faces([(0, 0, 0), (SIDE, 0, 0), (SIDE, 60, 0), (0, 60, 0)], [[0, 1, 2, 3]])
    structure = SupportStructure(Pair(mesh, mesh.with_vertices(np.tile([0.0, 0.0, 1.0], (4, 1)))), 120.0)
    assembly = detail(structure, PLAIN_RULES, name="slim", skip_unbuildable=True).assembly
    assert {(part.kind, part.element) for part in assembly.left_out} == {("beam", 1), ("beam", 3)}
    assert [beam.details.long_point_mm for beam in assembly["beams"]] == pytest.approx([SIDE - 2 * 5.0] * 2)
    for node in assembly["nodes"]:
        assert len(node.details.beams) == 1
        assert node.solid.topology.n_vertices == 6  # a facet, and a corner behind the axis
    assert not violations(assembly)


def test_a_panel_cut_away_by_its_joint_is_an_error() -> None:
    rules = replace(PLAIN_RULES, layers=(LayerRules(joint_mm=1499.5),))
    with pytest.raises(
        DetailingError, match=r"the panel on face 0 vanishes when cut back by half the joint of 1499\.5 mm"
    ):
        detail(flat_grid(), rules, name="grid")


def test_an_underside_below_the_seat_is_kept() -> None:
    for given_mm in (3.0, 0.0):  # flat panels over level beams, with a seat of 12 where nothing is given
        rules = replace(PLAIN_RULES, layers=(LayerRules(z_mm=given_mm),))
        assert detail(flat_grid(), rules, name="grid").underside_mm == given_mm


def test_an_underside_that_is_too_low_is_an_error_that_names_the_parts() -> None:
    rules = replace(PLAIN_RULES, beams=BeamRules(reference="inner"), layers=(LayerRules(z_mm=100),))
    with pytest.raises(DetailingError, match="panel"):
        detail(flat_grid(), rules, name="grid")


def test_a_gauss_image_that_points_inwards_is_an_error() -> None:
    grid = flat_grid()
    upside_down = SupportStructure(Pair(grid.mesh, grid.gauss_image * -1), 120.0)
    with pytest.raises(DetailingError, match="does not point to the outside of face"):
        detail(upside_down, PLAIN_RULES, name="grid")


def test_every_one_of_many_beams_without_room_is_named() -> None:
    with pytest.raises(DetailingError) as caught:
        detail(flat_grid(), replace(PLAIN_RULES, nodes=NodeRules(clearance_mm=730.0)), name="grid")
    message = str(caught.value)
    assert message.startswith("17 beams cannot be built: the beam on edge 0 from vertex 0 to vertex 1 is too short")
    edges = flat_grid().mesh.combinatorics.edges.tolist()
    assert all(f"edge {edge} (vertices {i} and {j})" in message for edge, (i, j) in enumerate(edges[3:], start=3))
    assert len(message) < 2000

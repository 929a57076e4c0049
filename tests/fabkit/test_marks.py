"""Equal parts share a mark; what is shared still stands where it stood."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fabkit import Project, design
from fabkit.checking.placed_parts import violations
from fabkit.detailing.assembling import detail
from fabkit.parts import Assembly, Frame, Part, Solid, prism_topology, prism_vertices
from fabkit.production.marks import share_equal_parts
from fabkit.production.marks.kept import compared_points
from fabkit.rules import BeamRules, ConnectionKind, ConnectionRules, DetailingRules
from geometry.gauss import Pair
from geometry.gauss.support_structure import SupportStructure
from geometry.mesh import Mesh
from geometry.mesh.shapes import grid
from tests.fabkit.assemblies import altered, assembled, with_parts
from tests.fabkit.plain_bars import PLAIN_RULES


def barrel(n: int = 8, tilt: float = 0.0, rules: DetailingRules | None = None, upper_radius: float = 0.6) -> Assembly:
    """A ring of n equal trapezoids about the z-axis: a rotational structure, so there are few kinds of parts."""
    angle = 2 * np.pi * np.arange(n) / n + tilt
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    height = np.sqrt(1 - upper_radius**2)
    lower = np.pad(ring, ((0, 0), (0, 1)))
    upper = np.pad(upper_radius * ring, ((0, 0), (0, 1)), constant_values=height)
    faces = [[k, (k + 1) % n, (k + 1) % n + n, k + n] for k in range(n)]
    sphere = Mesh.from_faces(np.concatenate([lower, upper]), faces)
    structure = SupportStructure(Pair(sphere * 6000.0, sphere), 120.0)
    return detail(structure, rules or PLAIN_RULES, name="barrel").assembly


def world(part: Part) -> np.ndarray:
    points = part.placement.to_world(part.solid.vertices)
    return points[np.lexsort(points.round(3).T)]


def test_a_rotational_structure_has_one_mark_for_each_orbit() -> None:
    shared = share_equal_parts(barrel())
    assert {beam.mark for beam in shared["beams"]} == {"B001", "B002", "B003"}  # lower ring, upper ring, meridians
    assert {node.mark for node in shared["nodes"]} == {"N001", "N002"}
    assert {panel.mark for panel in shared["panels"]} == {"P001"}
    for group in shared.groups:
        assert np.array_equal(group.shape, group.mark)
        assert len(group.solids) == len(group.mark_names)


@pytest.mark.parametrize(
    ("kind", "section"),
    [("bolted", "rhs 120x60x5"), ("bolted", "rhs 120x60x5 rounded"), ("hub", "tee 120x80x10x8")],
)
def test_bores_do_not_tell_equal_parts_apart(kind: ConnectionKind, section: str) -> None:
    """Rims stand in any direction about their axes, those along a node axis too; what is bored stays bored in place."""
    beams = BeamRules(section=section)
    connection = ConnectionRules(kind=kind, axial_bore_mm=20.0)
    own = barrel(16, 0.1, replace(PLAIN_RULES, beams=beams, connection=connection), upper_radius=0.9)
    shared = share_equal_parts(own, within_mm=1e-7)
    assert len(own["nodes"].solids.topologies[0].rounds) > 1
    assert [len(shared[group].mark_names) for group in ("beams", "nodes", "panels")] == [3, 2, 1]
    if kind == "bolted":
        assert [len(shared[group].mark_names) for group in ("bolts", "dowels")] == [1, 1]
    for before, after in zip(own.groups, shared.groups, strict=True):
        for k in range(len(before)):
            points, moved = (
                place.to_world(compared_points(solids)[0])
                for place, (solids,) in (
                    (part[k].placement, part.take(np.array([k])).solids.by_topology()) for part in (before, after)
                )
            )
            assert np.abs(np.sort(points.round(3), axis=0) - np.sort(moved.round(3), axis=0)).max() < 2e-3
    assert not violations(shared)


@pytest.mark.parametrize("n", [3, 4, 5, 8])
def test_sharing_moves_nothing(n: int) -> None:
    own = barrel(n, tilt=0.3)
    shared = share_equal_parts(own)
    for before, after in zip(own.parts(), shared.parts(), strict=True):
        assert before.element == after.element
        # rounding of coordinates of a few metres in millimetres
        assert np.abs(world(before) - world(after)).max() < 2e-7
        assert np.linalg.det(after.placement.axes) == pytest.approx(1.0)
    assert not violations(shared)


def test_records_turn_with_their_frames() -> None:
    shared = share_equal_parts(barrel())
    for beam in shared["beams"]:
        first = next(other for other in shared["beams"] if other.mark == beam.mark)
        assert beam.details.cut_angles_deg == pytest.approx(first.details.cut_angles_deg)
        start = beam.placement.origin
        ends = [node.placement.origin for k in beam.details.nodes for node in shared["nodes"] if node.element == k]
        assert np.linalg.norm(start - ends[0]) < np.linalg.norm(start - ends[1])
    for node in shared["nodes"]:
        first = next(other for other in shared["nodes"] if other.mark == node.mark)
        assert node.details.azimuths_deg == pytest.approx(first.details.azimuths_deg)
        assert node.details.setbacks_mm == pytest.approx(first.details.setbacks_mm)
    for panel in shared["panels"]:
        first = next(other for other in shared["panels"] if other.mark == panel.mark)
        assert panel.details.edge_lengths_mm == pytest.approx(first.details.edge_lengths_mm)
        assert panel.details.dihedrals_deg == pytest.approx(first.details.dihedrals_deg, nan_ok=True)


def test_a_mirrored_panel_and_another_material_have_marks_of_their_own() -> None:
    own = barrel()
    panel = own["panels"][0]
    mirrored = replace(
        panel,
        element=1,
        solid=replace(panel.solid, vertices=panel.solid.vertices[[1, 0, 3, 2, 5, 4, 7, 6]] * [-1, 1, 1]),
    )
    skew = replace(
        panel.solid, vertices=panel.solid.vertices + np.tile([[0, 0, 0], [0, 0, 0], [40, 0, 0], [0, 0, 0]], (2, 1))
    )
    skew_mirrored = replace(skew, vertices=skew.vertices[[1, 0, 3, 2, 5, 4, 7, 6]] * [-1, 1, 1])
    timber = replace(panel.material, name="timber")

    def outlined(solid, element):
        return replace(panel, solid=solid, element=element)

    panels = (
        outlined(panel.solid, 0),
        outlined(mirrored.solid, 1),
        outlined(skew, 2),
        outlined(skew_mirrored, 3),
        replace(panel, material=timber, element=4),
    )
    shared = share_equal_parts(with_parts(own, panels=panels))
    marks = [part.mark for part in shared["panels"]]
    assert marks[0] == marks[1]  # a symmetric trapezoid is its own mirror image
    assert len({marks[0], marks[2], marks[3], marks[4]}) == 4


def test_a_panel_framed_on_another_edge_is_the_same_panel() -> None:
    """A kite has two longest edges: which one a frame stands on is a matter of rounding."""
    kite = np.array([[0.0, 0.0], [1200.0, 0.0], [1400.0, 500.0], [400.0, 1131.3708]])

    def plate(first: int, element: int) -> Part:
        """Beams and neighbours are numbered by the kite's own edges, wherever the frame stands."""
        order = (first + np.arange(4)) % 4
        x = kite[order[1]] - kite[order[0]]
        x /= np.linalg.norm(x)
        outline = (kite[order] - kite[order[0]]) @ np.array([x, [-x[1], x[0]]]).T
        return altered(
            barrel()["panels"][0],
            element=element,
            solid=Solid(prism_vertices(outline, 0.0, 10.0), prism_topology(4)),
            placement=Frame.world(),
            thickness_mm=10.0,
            edge_lengths_mm=tuple(np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1).tolist()),
            corner_angles_deg=tuple((10.0 * order).tolist()),
            dihedrals_deg=tuple((1.0 * order).tolist()),
            beams=tuple((100 + order).tolist()),
            neighbours=tuple((200 + order).tolist()),
        )

    for first in range(4):
        one, other = share_equal_parts(with_parts(barrel(), panels=(plate(0, 0), plate(first, 1))))["panels"]
        assert np.array_equal(one.solid.vertices, other.solid.vertices)
        assert other.details.beams.tolist() == one.details.beams.tolist() == [100, 101, 102, 103]
        for name in ("neighbours", "dihedrals_deg", "corner_angles_deg"):
            assert np.array_equal(getattr(other.details, name), getattr(one.details, name))
        assert other.details.edge_lengths_mm == pytest.approx(one.details.edge_lengths_mm)


def test_nothing_to_share() -> None:
    empty = assembled("none")
    assert list(share_equal_parts(empty).parts()) == []


def test_parts_are_as_equal_as_is_asked() -> None:
    """A barrel from a file with four digits has no two equal parts, unless a tenth of a millimetre does not matter."""
    own = barrel(12, tilt=0.3)
    rng = np.random.default_rng(3)

    def worn(part: Part) -> Part:
        before = part.solid.vertices[:4, :2]
        outline = before + rng.uniform(-0.02, 0.02, (4, 2)) * (before != 0)
        return replace(part, solid=Solid(prism_vertices(outline, 0.0, 10.0), part.solid.topology))

    rough = with_parts(own, panels=tuple(worn(panel) for panel in own["panels"]))
    assert len({panel.mark for panel in share_equal_parts(rough, within_mm=1e-7)["panels"]}) == 12
    shared = share_equal_parts(rough, within_mm=0.1)
    assert len({panel.mark for panel in shared["panels"]}) == 1
    for before, after in zip(rough["panels"], shared["panels"], strict=True):
        apart = np.linalg.norm(world(before)[:, None] - world(after), axis=2)
        assert apart.min(axis=0).max() < 0.1 * np.sqrt(3)
        assert apart.min(axis=1).max() < 0.1 * np.sqrt(3)


def test_of_parts_that_differ_step_by_step_those_near_to_one_of_them_share_its_mark() -> None:
    """Lengths 0, 1, ..., 9 steps longer, of which 2.5 are equal: the parts are linked, but not all are equal."""
    panel = barrel()["panels"][0]

    def longer(steps: int) -> Part:
        before = panel.solid.vertices[:4, :2]
        outline = before + np.outer(before[:, 0] > 0.1 * before[:, 0].max(), [0.004 * steps, 0.0])
        return replace(panel, element=steps, solid=Solid(prism_vertices(outline, 0.0, 10.0), panel.solid.topology))

    shared = share_equal_parts(with_parts(barrel(), panels=tuple(map(longer, range(10)))), within_mm=0.01)["panels"]
    marks = [part.mark for part in shared]
    assert marks == [f"P00{1 + k // 3}" for k in range(10)]
    for k, part in enumerate(shared):
        assert np.abs(part.solid.vertices - longer(k).solid.vertices).max() <= 0.01


TEE = [
    [40.0, 0.0],
    [-40.0, 0.0],
    [-40.0, -20.0],
    [-5.0, -20.0],
    [-5.0, -90.0],
    [5.0, -90.0],
    [5.0, -20.0],
    [40.0, -20.0],
]
HEXAGON = [[20.0, 0.0], [-20.0, 0.0], [-40.0, -40.0], [-20.0, -80.0], [20.0, -80.0], [40.0, -40.0]]


@pytest.mark.parametrize("section", [TEE, HEXAGON])
def test_bars_of_any_section_are_equal_end_for_end(section: list[list[float]]) -> None:
    """Bars along x with a slanted end and a square one; corners come in the order that half a turn about z reverses."""
    outline = np.roll(np.array(section), -1, axis=0)  # from beside the plane of symmetry, round to its other side
    assert np.array_equal(outline[::-1] * [-1, 1], outline)

    def bar(element: int, slant: float, other_slant: float) -> Part:
        ends = [
            np.column_stack([x - slope * outline[:, 1], outline]) for x, slope in ((0.0, slant), (1000.0, -other_slant))
        ]
        solid = Solid(np.concatenate(ends), prism_topology(len(outline)))
        assert solid.volume_mm3 > 0
        placement = Frame(np.array([0.0, 500.0 * element, 0.0]), np.eye(3))
        return altered(barrel()["beams"][0], element=element, solid=solid, placement=placement, nodes=(element, 9))

    own = with_parts(barrel(), beams=[bar(0, 0.1, 0.0), bar(1, 0.0, 0.1), bar(2, 0.1, 0.1)])["beams"]
    shared = share_equal_parts(Assembly("bars", (own,)))["beams"]
    assert shared.marks == ["B001", "B001", "B002"]
    assert shared.details.nodes.tolist() == [[0, 9], [9, 1], [2, 9]]
    for before, after in zip(own, shared, strict=True):
        assert np.abs(world(before) - world(after)).max() < 1e-9


def test_plates_of_different_stock_have_marks_of_their_own() -> None:
    thin, thick = ({"thickness_mm": each, "material": "S355", "z_mm": z} for each, z in ((8.0, 40.0), (8.4, -200.0)))
    built = design(Project(mesh=grid(2, 2), mean_edge_mm=1500, layers=[thin, thick], nesting={"mode": "off"}))
    panels = built.assembly["panels"]
    pairs = set(zip(panels.marks, panels.details.thickness_mm.tolist(), strict=True))
    assert len(pairs) == len(panels.mark_names)

"""Meshes of every kind go through detailing: closed, with holes, in pieces, pinched, with any number of corners."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fabkit.checking.placed_parts import violations
from fabkit.detailing.assembling import detail
from fabkit.errors import DetailingError
from fabkit.parts import Assembly
from fabkit.production.marks import share_equal_parts
from fabkit.rules import LayerRules
from geometry.gauss import SupportStructure, approximate_pair
from geometry.mesh import Mesh, shapes
from geometry.meshing import planarise
from tests.fabkit.assemblies import by_name
from tests.fabkit.plain_bars import PLAIN_RULES


def supported(mesh: Mesh) -> SupportStructure:
    """With edges of 1.5 m on average."""
    planar = planarise(mesh * (1500.0 / mesh.mean_edge_length)).mesh
    return SupportStructure(approximate_pair(planar), 120.0)


def built(mesh: Mesh) -> Assembly:
    return share_equal_parts(detail(supported(mesh), PLAIN_RULES, name="shape").assembly, within_mm=1e-7)


def marks(assembly: Assembly) -> list[int]:
    return [len({part.mark for part in group}) for group in by_name(assembly).values()]


@pytest.mark.parametrize(
    ("mesh", "n_marks"),
    [
        pytest.param(shapes.cube(), [1, 1, 1], id="cube"),
        pytest.param(shapes.dodecahedron(), [1, 1, 1], id="dodecahedron"),
        pytest.param(shapes.box(1, 2, 3), [3, 1, 3], id="box"),
        pytest.param(shapes.regular_prism(7), [2, 1, 2], id="prism over a heptagon"),
        pytest.param(shapes.grid(4, 5), [1, 3, 1], id="flat grid: nodes inside, on edges, at corners"),
        # 8 rings of panels, meridian beams and nodes, and 9 rings of beams; a beam is its own mirror image
        pytest.param(shapes.dome(24, 8), [8 + 9, 9, 8], id="dome, an annulus"),
    ],
)
def test_as_many_marks_as_orbits_under_rotation(mesh: Mesh, n_marks: list[int]) -> None:
    assembly = built(mesh)
    assert not violations(assembly)
    assert marks(assembly) == n_marks


def saddle() -> Mesh:
    line = np.linspace(-1, 1, 9)
    return shapes.translation_surface(
        np.stack([line, 0 * line, line**2 / 2], axis=1), np.stack([0 * line, line, -(line**2) / 2], axis=1)
    )


def pole(n: int) -> Mesh:
    """Two rings of quads and a fan of n triangles on a sphere."""
    turn = 2 * np.pi * np.arange(n) / n
    rings = [
        np.stack([np.sin(p) * np.cos(turn), np.sin(p) * np.sin(turn), np.cos(p) + 0 * turn], 1) for p in (0.3, 0.6, 0.9)
    ]
    fan = [[0, 1 + k, 1 + (k + 1) % n] for k in range(n)]
    quads = [
        [1 + n * ring + k, 1 + n * (ring + 1) + k, 1 + n * (ring + 1) + (k + 1) % n, 1 + n * ring + (k + 1) % n]
        for ring in range(2)
        for k in range(n)
    ]
    return Mesh.from_faces(np.concatenate([[[0.0, 0.0, 1.0]], *rings]), fan + quads)


def two(mesh: Mesh) -> Mesh:
    """Two copies beside each other."""
    faces = [face.tolist() for face in mesh.combinatorics.faces]
    beside = mesh.vertices + np.array([10.0, 0.0, 0.0])
    return Mesh.from_faces(
        np.concatenate([mesh.vertices, beside]), faces + [[v + mesh.n_vertices for v in face] for face in faces]
    )


PINCHED = Mesh.from_faces(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [-1, 0, 0], [-1, -1, 0], [0, -1, 0]], [[0, 1, 2, 3], [0, 4, 5, 6]]
)
NOT_CONVEX = Mesh.from_faces(
    [[0, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0], [1, 2, 0], [0, 2, 0], [2, 2, 0]], [[0, 1, 2, 3, 4, 5], [2, 6, 4, 3]]
)
STRAIGHT_CORNER = Mesh.from_faces(
    [[0, 0, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0], [0, -1, 0], [1, -1, 0], [2, -1, 0]],
    [[0, 1, 2, 3, 4], [0, 5, 6, 1], [1, 6, 7, 2]],
)


@pytest.mark.parametrize(
    "mesh",
    [
        pytest.param(saddle(), id="saddle"),
        pytest.param(saddle().reversed(), id="saddle from below"),
        pytest.param(pole(16), id="triangles among quads, a node with 16 beams"),
        pytest.param(two(shapes.dome(12, 3)), id="two pieces"),
        pytest.param(PINCHED, id="two faces that meet in a vertex"),
        pytest.param(NOT_CONVEX, id="a face that is not convex"),
        pytest.param(STRAIGHT_CORNER, id="a corner of 180 degrees"),
        pytest.param(shapes.grid(1, 1), id="one face"),
    ],
)
def test_everything_is_built_and_fits(mesh: Mesh) -> None:
    assembly = built(mesh)
    assert not violations(assembly)
    assert (len(assembly["beams"]), len(assembly["panels"])) == (mesh.n_edges, mesh.n_faces)
    assert len(assembly["nodes"]) == mesh.combinatorics.is_used.sum()


@pytest.mark.parametrize("mesh", [saddle(), saddle().reversed(), shapes.dome(12, 3).reversed()])
def test_panels_keep_half_a_joint_from_the_support_planes_through_their_thickness(mesh: Mesh) -> None:
    structure = supported(mesh)
    rules = PLAIN_RULES
    for panel in detail(structure, rules, name="joint").assembly["panels"]:
        corners = panel.placement.to_world(panel.solid.vertices)
        centre = structure.mesh.vertices[structure.mesh.combinatorics.face(panel.element)].mean(axis=0)
        for beam in panel.details.beams:
            normal = structure.width_directions[beam]
            start = structure.mesh.vertices[structure.mesh.combinatorics.edges[beam, 0]]
            distances = (corners - start) @ normal * np.sign((centre - start) @ normal)
            assert distances.min() == pytest.approx(rules.layers[0].joint_mm / 2, abs=1e-8)  # rounding at 10 m


def test_the_spread_of_tops_is_what_the_beams_show() -> None:
    assembly = built(saddle())
    ends: dict[int, list[np.ndarray]] = {}
    for beam in assembly["beams"]:
        tops = beam.solid.vertices[np.abs(beam.solid.vertices[:, 2]) < 1e-9]  # the outer side
        for node, at in zip(beam.details.nodes, (tops[:, 0].min(), tops[:, 0].max()), strict=True):
            ends.setdefault(node, []).append(beam.placement.to_world(np.array([at, 0.0, 0.0])))
    spreads = []
    for node in assembly["nodes"]:
        levels = node.placement.to_local(np.array(ends[node.element]))[:, 2]
        assert node.details.top_step_mm == pytest.approx(np.ptp(levels), abs=1e-7)
        assert node.solid.vertices[:, 2].max() == pytest.approx(levels.max(), abs=1e-7)
        spreads.append(node.details.top_step_mm)
    assert max(spreads) > 1.0


@pytest.mark.parametrize(
    "mesh",
    [
        pytest.param(shapes.dodecahedron(), id="dodecahedron"),
        pytest.param(shapes.dome(12, 3), id="dome"),
        pytest.param(shapes.rotational_mesh([(3.0, 0.0), (3.0, 1.0), (3.0, 2.0)], 9), id="barrel"),
        pytest.param(saddle(), id="saddle"),
        pytest.param(saddle().reversed(), id="saddle from below"),
        pytest.param(
            saddle().with_vertices(saddle().vertices @ np.array([[1.0, 0.0, 0.3], [0.4, 1.0, 0.0], [0.0, 0.0, 1.0]])),
            id="skew saddle",
        ),
    ],
)
def test_the_underside_is_the_lowest_that_clears_what_stands_under_the_panels(mesh: Mesh) -> None:
    structure = supported(mesh)
    rules = replace(PLAIN_RULES, layers=(LayerRules(seat_mm=0.0, joint_mm=0.02),))
    detailed = detail(structure, rules, name="lift")  # checks that nothing clashes
    lower = LayerRules(z_mm=detailed.underside_mm - 0.05, joint_mm=0.02)
    with pytest.raises(DetailingError, match="panel"):
        detail(structure, replace(PLAIN_RULES, layers=(lower,)), name="lower")


@pytest.mark.parametrize("mesh", [shapes.dodecahedron(), shapes.cube(), shapes.dome(7, 2), saddle()])
def test_what_a_record_names_stands_where_it_says(mesh: Mesh) -> None:
    """The k-th beam of a node lies in the direction of its k-th azimuth, that of a panel along its k-th edge."""
    shared = built(mesh)
    beams = {beam.element: beam for beam in shared["beams"]}
    middles = {k: beam.placement.to_world(beam.solid.vertices.mean(axis=0)) for k, beam in beams.items()}
    panels = {panel.element: panel for panel in shared["panels"]}
    for node in shared["nodes"]:
        towards = np.array([node.placement.to_local(middles[beam])[:2] for beam in node.details.beams])
        found = np.degrees(np.arctan2(towards[:, 1], towards[:, 0]))
        assert (found - node.details.azimuths_deg + 180) % 360 - 180 == pytest.approx(np.zeros(len(found)), abs=1e-6)
    for panel in shared["panels"]:
        outline = panel.solid.vertices[: len(panel.solid.vertices) // 2, :2]
        edge_middles = (outline + np.roll(outline, -1, axis=0)) / 2
        for k, (beam, neighbour) in enumerate(zip(panel.details.beams, panel.details.neighbours, strict=True)):
            distances = [
                np.linalg.norm(panel.placement.to_local(middles[b])[:2] - edge_middles[k]) for b in panel.details.beams
            ]
            assert panel.details.beams[int(np.argmin(distances))] == beam
            assert neighbour == -1 or beam in panels[neighbour].details.beams

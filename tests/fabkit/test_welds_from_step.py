"""Slots, contacts and walls of a welded structure, measured on the text of its STEP file."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
import shapely

from fabkit.detailing.assembling import detail
from fabkit.formats.step.files import instance_name
from fabkit.layer_rules import LayerRules
from fabkit.production import share_equal_parts
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, NodeRules
from geometry.arrays import FloatArray
from geometry.gauss import Pair
from geometry.gauss.support_structure import SupportStructure
from geometry.mesh.shapes import dome
from tests.fabkit.part21 import StepText, coordinates, written

SLOT, WALL = 25.0, 5.0


def placed_corners(file: StepText) -> dict[str, FloatArray]:
    """Corners (n, 3) of each part where it stands, by the name of its instance."""
    found = {}
    for link in file.all("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
        leaves = dict(file[link.values[0]].values)
        name = file[file[link.values[1]].values[2]].values[1]
        child = leaves["REPRESENTATION_RELATIONSHIP"][2]
        end = file[leaves["REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"][0]].values[3]
        origin, z, x = (coordinates(file, each) for each in file[end].values[1:])
        corners = corners_of(file, child)
        if len(corners):
            found[name] = origin + corners @ np.stack([x, np.cross(z, x), z])
    return found


def corners_of(file: StepText, representation: int) -> FloatArray:
    """(n, 3) the points of all vertices below an instance."""
    seen, todo, points = set(), [representation], []
    while todo:
        at = todo.pop()
        if at in seen:
            continue
        seen.add(at)
        if file[at].kind == "VERTEX_POINT":
            points.append(coordinates(file, file[at].values[1]))
        todo += file.references(file[at].values)
    return np.array(points).reshape(-1, 3)


@pytest.fixture(scope="module")
def welded() -> tuple[SupportStructure, StepText, dict[str, list[str]]]:
    structure = SupportStructure(Pair(dome(6, 2) * 3000, dome(6, 2)), 120.0)
    rules = DetailingRules(
        beams=BeamRules(section="rhs 120x60x5"),
        connection=ConnectionRules(kind="welded"),
        nodes=NodeRules(top="trimmed", setbacks="least"),
        layers=(LayerRules(joint_mm=20, seat_mm=12),),
    )
    made = share_equal_parts(detail(structure, rules, name="dome").assembly, within_mm=1e-7)
    return structure, written(made), {name: [instance_name(p) for p in made[name]] for name in ("beams", "nodes")}


def test_slots_are_as_asked_and_ends_lie_on_their_blocks_over_all_their_width(
    welded: tuple[SupportStructure, StepText, dict[str, list[str]]],
) -> None:
    structure, file, names = welded
    corners, mesh = placed_corners(file), structure.mesh
    slots, contacts = [], []
    for vertex in range(mesh.n_vertices):
        axis = structure.axes[vertex]
        x = np.cross(axis, [0.3, 0.5, -0.8])
        x /= np.linalg.norm(x)
        seen = np.stack([x, np.cross(axis, x)], axis=1)  # the view along the axis
        own = [corners[name] for name in names["beams"] if near(corners[name], mesh.vertices[vertex])]
        strips = [shapely.convex_hull(shapely.multipoints((each - mesh.vertices[vertex]) @ seen)) for each in own]
        slots += [a.distance(b) for a, b in combinations(strips, 2)]
        block = next(corners[name] for name in names["nodes"] if near(corners[name], mesh.vertices[vertex], 200.0))
        outline = shapely.convex_hull(shapely.multipoints((block - mesh.vertices[vertex]) @ seen))
        for strip in strips:
            touching = shapely.intersection(outline.boundary.buffer(1e-6, cap_style="flat"), strip.buffer(1e-6))
            contacts.append(touching.length / 2)
    assert min(slots) == pytest.approx(SLOT, abs=1e-6)
    assert min(contacts) == pytest.approx(60.0, abs=1e-3)  # each end lies flat on its block over all its width


def near(corners: FloatArray, point: FloatArray, within: float = 300.0) -> bool:
    return bool(np.linalg.norm(corners - point, axis=1).min() < within)


def test_hollow_sections_keep_their_walls(welded: tuple[SupportStructure, StepText, dict[str, list[str]]]) -> None:
    _, file, _ = welded
    beams = [each for each in file.all("MANIFOLD_SOLID_BREP") if each.values[0].startswith("B")]
    assert beams
    for beam in beams:
        section = np.unique(corners_of(file, beam.values[1])[:, 1:].round(6), axis=0)
        outer, inner = section[np.abs(section[:, 0]) > 29], section[np.abs(section[:, 0]) < 29]
        assert np.abs(outer[:, 0]) == pytest.approx(30.0)
        assert np.unique(outer[:, 1]).tolist() == [-120.0, 0.0]
        assert np.abs(inner[:, 0]) == pytest.approx(30.0 - WALL)
        assert np.unique(inner[:, 1]).tolist() == [WALL - 120.0, -WALL]

"""Slots, walls, edges of bores, contacts, counts and masses of each connection, measured on the text of STEP files."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import shapely

from fabkit.detailing.assembling import detail
from fabkit.parts import Assembly, Surroundings
from fabkit.production import share_equal_parts
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, LayerRules, NodeRules
from geometry.arrays import FloatArray
from geometry.gauss.support_structure import SupportStructure
from tests.fabkit.part21 import written
from tests.fabkit.placed_step import PlacedPart, across, apart, hull_volume, placed_parts
from tests.fabkit.test_trimmed_nodes import leaning_grid

SLOTS = {"welded": 25.0, "bolted": 10.0, "hub": 25.0}
SECTIONS = {"welded": "rhs 120x60x5", "bolted": "rhs 120x60x5", "hub": "tee 120x80x10x8"}
FILE_MM = 1e-6
"""Accuracy of measures from the coordinates of a file."""


@dataclass(frozen=True)
class Written:
    """A structure, its assembly, which of the parts of its STEP file are of which group, and those at each node."""

    structure: SupportStructure
    assembly: Assembly
    groups: dict[str, dict[str, PlacedPart]]

    def nodes(self) -> list[tuple[FloatArray, FloatArray, dict[str, list[PlacedPart]]]]:
        """Point and axis of each vertex, and the parts nearer than 350 mm, by group."""
        mesh = self.structure.mesh
        return [
            (
                point,
                axis,
                {
                    name: [part for part in parts.values() if distance(part, point) < 350.0]
                    for name, parts in self.groups.items()
                },
            )
            for point, axis in zip(mesh.vertices, self.structure.axes, strict=True)
        ]


def distance(part: PlacedPart, point: FloatArray) -> float:
    points = np.concatenate([part.corners, *(each.ends for each in part.cylinders)])
    return float(np.linalg.norm(points - point, axis=1).min())


def made(kind: Any) -> Written:
    structure = leaning_grid(0.1, 2, 2)
    rules = DetailingRules(
        BeamRules(section=SECTIONS[kind]),
        ConnectionRules(kind=kind),
        NodeRules(top="trimmed", setbacks="least"),
        (LayerRules(joint_mm=20, seat_mm=12),),
    )
    assembly = share_equal_parts(detail(structure, rules, name="grid").assembly, within_mm=1e-7)
    parts = placed_parts(written(assembly))
    names = {group.kind.group: group.piece_names for group in assembly.groups}
    assert sorted(parts) == sorted(name for own in names.values() for name in own)
    return Written(structure, assembly, {group: {name: parts[name] for name in own} for group, own in names.items()})


@pytest.fixture(scope="module")
def structures() -> dict[str, Written]:
    return {kind: made(kind) for kind in SLOTS}


def strip(part: PlacedPart, view: FloatArray, chosen: Any = slice(None)) -> shapely.Polygon:
    return shapely.convex_hull(shapely.multipoints(part.corners[chosen] @ view))


@pytest.mark.parametrize("kind", SLOTS)
def test_slots_are_as_asked(structures: dict[str, Written], kind: str) -> None:
    """Between beams, end plates, or the webs of tees, seen along the axis of their node."""
    slots, flanges = [], []
    for _, axis, near in structures[kind].nodes():
        own = near["end plates" if kind == "bolted" else "beams"]
        in_web = [np.abs(part.own[:, 1]) < 4.1 if kind == "hub" else slice(None) for part in own]
        strips = [strip(part, across(axis), chosen) for part, chosen in zip(own, in_web, strict=True)]
        slots += [one.distance(other) for one, other in combinations(strips, 2)]
        if kind == "hub":
            wide = [strip(part, across(axis), ~chosen) for part, chosen in zip(own, in_web, strict=True)]
            flanges += [one.distance(other) for one, other in combinations(wide, 2)]
    if kind == "welded":
        assert min(slots) == pytest.approx(25.0, abs=FILE_MM)  # exact where nothing else sets beams back
    assert min(slots) >= SLOTS[kind] - FILE_MM
    assert min(flanges, default=10.0) >= 10.0 - FILE_MM


@pytest.mark.parametrize("kind", ["welded", "bolted"])
def test_ends_lie_flat_on_their_blocks(structures: dict[str, Written], kind: str) -> None:
    for _, axis, near in structures[kind].nodes():
        view = across(axis)
        (block,) = [part for part in near["nodes"] if len(part.corners)]
        outline = shapely.convex_hull(shapely.multipoints(block.corners @ view))
        for part in near["beams" if kind == "welded" else "end plates"]:
            touching = shapely.intersection(
                outline.boundary.buffer(FILE_MM, cap_style="flat"), strip(part, view).buffer(FILE_MM)
            )
            assert touching.length / 2 == pytest.approx(60.0, abs=1e-3)


def test_webs_and_caps_touch_the_tubes_of_hubs(structures: dict[str, Written]) -> None:
    for point, axis, near in structures["hub"].nodes():
        (node,) = near["nodes"]
        outside, inside = sorted(node.cylinders, key=lambda each: -each.radius)
        assert (outside.is_bore, inside.is_bore) == (False, True)
        assert outside.radius - inside.radius == pytest.approx(8.0)
        assert np.abs(np.cross(outside.axis, axis)).max() < 1e-9
        for beam in near["beams"]:
            web = strip(beam, across(axis), np.abs(beam.own[:, 1]) < 4.1)
            assert web.distance(shapely.Point(point @ across(axis))) == pytest.approx(outside.radius, abs=FILE_MM)
        caps = [cap.cylinders[0] for cap in near["caps"]]
        assert [cap.radius for cap in caps] == pytest.approx([outside.radius] * 2)
        gaps = [np.linalg.norm(cap.ends[:, None] - outside.ends[None], axis=2).min() for cap in caps]
        assert max(gaps) < FILE_MM


def test_hollow_sections_keep_their_walls(structures: dict[str, Written]) -> None:
    for beam in structures["welded"].groups["beams"].values():
        section = np.unique(beam.own[:, 1:].round(6), axis=0)
        outer, inner = section[np.abs(section[:, 0]) > 29], section[np.abs(section[:, 0]) < 29]
        assert np.abs(outer[:, 0]) == pytest.approx(30.0)
        assert np.unique(outer[:, 1]).tolist() == [-120.0, 0.0]
        assert np.abs(inner[:, 0]) == pytest.approx(25.0)
        assert np.unique(inner[:, 1]).tolist() == [-115.0, -5.0]


def test_bores_keep_walls_and_edges(structures: dict[str, Written]) -> None:
    """6 mm between any two bores of a node; 1.2 diameters from the edges of the face in which a bore begins."""
    walls, edges = [], []
    for name in ("nodes", "end plates"):
        for part in structures["bolted"].groups[name].values():
            assert all(each.is_bore for each in part.cylinders)
            walls += [apart(one, other) for one, other in combinations(part.cylinders, 2)]
            edges += [ratio for each in part.cylinders for ratio in edge_ratios(each, part)]
    assert min(walls) >= 6.0 - FILE_MM
    assert len(edges) == 48 * 3  # each of 24 ends has two bores, with two ends in the plate and one in the block
    assert min(edges) >= 1.2 - 1e-9


def edge_ratios(bore: Any, part: PlacedPart) -> list[float]:
    """Distances of the centre of a bore from the outlines of the faces in which it ends, over its diameter."""
    found = []
    for centre in bore.ends:
        for outline in part.outlines:
            if np.abs((outline - centre) @ bore.axis).max() < FILE_MM:
                flat = shapely.LinearRing((outline - centre) @ across(bore.axis))
                found.append(flat.distance(shapely.Point(0, 0)) / (2 * bore.radius))
    return found


def test_each_end_has_one_bolt_and_one_dowel_in_its_bores(structures: dict[str, Written]) -> None:
    own = structures["bolted"]
    counts = {name: len(parts) for name, parts in own.groups.items()}
    assert counts == {"beams": 12, "nodes": 9, "panels": 4, "end plates": 24, "bolts": 24, "dowels": 24}
    for group in own.assembly.groups:
        rows = {c.title: c for c in group.kind.columns(group, Surroundings(own.assembly))}
        assert sum(rows["Count"].cells) == rows["Count"].total == counts[group.kind.group]
    bores = [(each, "block") for part in own.groups["nodes"].values() for each in part.cylinders]
    bores += [(each, "plate") for part in own.groups["end plates"].values() for each in part.cylinders]
    for name, clear in (("bolts", {"block": 0.0, "plate": 1.0}), ("dowels", {"block": 0.0, "plate": 0.0})):
        for pin in own.groups[name].values():
            shank = min(pin.cylinders, key=lambda each: each.radius)
            holes = [(bore, what) for bore, what in bores if is_inside(shank, bore)]
            assert Counter(what for _, what in holes) == {"block": 1, "plate": 1}
            for bore, what in holes:
                assert bore.radius - shank.radius == pytest.approx(clear[what], abs=FILE_MM)


def is_inside(pin: Any, bore: Any) -> bool:
    """Whether the axis of a pin runs along that of a bore, and they overlap along it."""
    off = np.linalg.norm(np.cross(pin.ends - bore.ends[0], bore.axis), axis=1).max()
    along = np.sort((pin.ends - bore.ends[0]) @ bore.axis)
    return bool(off < FILE_MM and along[1] > 1.0 and along[0] < bore.length - 1.0)


@pytest.mark.parametrize("kind", SLOTS)
def test_masses_are_those_of_the_solids_in_the_file(structures: dict[str, Written], kind: str) -> None:
    """Volumes by section and length, hulls and cylinders, times the density in the file."""
    own = structures[kind]
    for group in own.assembly.groups:
        parts = own.groups[group.kind.group]
        volumes = {name: measured_volume(part, group.kind.group) for name, part in parts.items()}
        for name, part in parts.items():
            assert part.stated_volume == pytest.approx(volumes[name], rel=1e-7)
        kilograms = sum(1e-9 * part.density * volumes[name] for name, part in parts.items())
        rows = {c.title: c for c in group.kind.columns(group, Surroundings(own.assembly))}
        assert rows["Mass (kg)"].total == pytest.approx(kilograms, rel=1e-7)


def measured_volume(part: PlacedPart, group: str) -> float:
    """Of parts of straight edges and cylinders, the latter bores or the whole part."""
    bars = sum(each.volume * (-1 if each.is_bore else 1) for each in part.cylinders)
    y, x = part.own[:, 1], part.own[:, 0]
    if group != "beams":  # node blocks, whose setbacks spread little, are convex
        return bars + (hull_volume(part.corners) if len(part.corners) else 0.0)
    if np.abs(y).max() == pytest.approx(40.0):  # a tee: the web and the flange are boxes
        return hull_volume(part.corners[np.abs(y) < 4.1]) + hull_volume(part.corners[np.abs(y) > 4.1])
    outside = part.own[(np.abs(y) > 29) & (np.isclose(part.own[:, 2], 0) | np.isclose(part.own[:, 2], -120))]
    middle = outside[:, 0] > (x.min() + x.max()) / 2
    length = outside[middle, 0].mean() - outside[~middle, 0].mean()
    holes = (len(part.corners) > 16) * 2 * (70 * 110 - 2 * 15 * 15) * 5
    return 1700.0 * float(length) - holes

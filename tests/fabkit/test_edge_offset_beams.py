"""Beams of one height on edge offset meshes: what aligns at the nodes, measured on the solids.

At a node all beams have one angle with the axis, up to its sign [Pottmann2007, Prop. 3]: positive where an edge of S
runs the other way than that of M, as in negatively curved areas.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fabkit.detailing.assembling import detail
from fabkit.parts import Assembly, Part
from geometry.arrays import FloatArray
from geometry.gauss import Pair, SupportStructure, edge_distances
from geometry.mesh import Mesh, solids
from geometry.parallel import ParallelSpace, edge_factors
from tests.fabkit.edge_offsets import revolved_pair
from tests.fabkit.plain_bars import PLAIN_RULES

HEIGHT = 120.0
ALIGNED = 1e-9 * HEIGHT
MEAN_EDGE = 1500.0


def irregular(solid: Mesh) -> tuple[Mesh, Mesh]:
    """A convex mesh parallel to an Archimedean solid, its edges half to one and a half times as long; and that."""
    image = solid * (1 / edge_distances(solid).mean())
    element = ParallelSpace(image).elements(1, seed=3)[0]
    return image + element * (0.5 / np.abs(edge_factors(image, element)).max()), image


def detailed(pair: tuple[Mesh, Mesh], **rules: str) -> Assembly:
    mesh, image = pair
    structure = SupportStructure(Pair(mesh * (MEAN_EDGE / mesh.mean_edge_length), image), HEIGHT)
    nodes = replace(PLAIN_RULES.nodes, **{k: v for k, v in rules.items() if k == "setbacks"})
    beams = replace(PLAIN_RULES.beams, **{k: v for k, v in rules.items() if k == "reference"})
    return detail(structure, replace(PLAIN_RULES, beams=beams, nodes=nodes), name="edge offset").assembly


def side_edges(beam: Part, vertex: int) -> FloatArray:
    """(2, 2, 2, 3) the bar's four long edges in space: side right or left as seen from the node, inner or outer; its
    end at the node, then the other."""
    corners = beam.solid.vertices
    edges = np.empty((2, 2, 2, 3))
    away = beam.details.nodes.tolist().index(vertex) == 0
    for side, y in enumerate(sorted(set(np.round(corners[:, 1], 9)), reverse=not away)):
        for level, z in enumerate(sorted(set(np.round(corners[:, 2], 9)))):
            on_edge = corners[(np.abs(corners[:, 1] - y) < 1e-6) & (np.abs(corners[:, 2] - z) < 1e-6)]
            edges[side, level] = on_edge[np.argsort(on_edge[:, 0] if away else -on_edge[:, 0])]
    world: FloatArray = beam.placement.to_world(edges.reshape(-1, 3)).reshape(edges.shape)
    return world


def around_nodes(assembly: Assembly) -> Iterator[tuple[FloatArray, FloatArray, list[bool]]]:
    """For each node: the side edges of its beams in its own frame, the azimuths, and which beams rise from it."""
    beams = {beam.element: beam for beam in assembly["beams"]}
    for node in assembly["nodes"]:
        edges = np.array([side_edges(beams[edge], node.element) for edge in node.details.beams])
        local = node.placement.to_local(edges.reshape(-1, 3)).reshape(edges.shape)
        yield local, np.array(node.details.azimuths_deg), [angle > 0 for angle in node.details.inclinations_deg]


def distance_of_lines(first: FloatArray, second: FloatArray) -> float:
    """Of two lines, each by two points (2, 3)."""
    u, v = first[1] - first[0], second[1] - second[0]
    normal = np.cross(u, v)
    return float(abs((second[0] - first[0]) @ normal) / np.linalg.norm(normal))


CONVEX = {
    "rhombicosidodecahedron": irregular(solids.rhombicosidodecahedron()),
    "truncated icosahedron": irregular(solids.truncated_icosahedron()),
    "rhombicuboctahedron": irregular(solids.rhombicuboctahedron()),
    "barrel": revolved_pair(12, 6, saddle=False),
}


@pytest.mark.parametrize("reference", ["outer", "centre", "inner"])
@pytest.mark.parametrize("pair", CONVEX.values(), ids=CONVEX)
def test_where_the_mesh_is_convex_tops_and_bottoms_are_level_and_their_edges_meet(
    pair: tuple[Mesh, Mesh], reference: str
) -> None:
    assembly = detailed(pair, reference=reference)
    for edges, azimuths, rising in around_nodes(assembly):
        assert not any(rising)
        assert np.ptp(edges[:, :, :, 0, 2], axis=(0, 1)).max() < ALIGNED  # inner and outer corners of the end faces
        gaps = np.diff([*azimuths, azimuths[0] + 360])
        for k, gap in enumerate(gaps):  # Fig. 6, red: left edge of a beam, right edge of the next
            if gap < 179:
                ahead = edges[(k + 1) % len(edges)]
                assert max(distance_of_lines(edges[k][1][z], ahead[0][z]) for z in (0, 1)) < ALIGNED
    assert max(node.details.top_step_mm for node in assembly["nodes"]) < ALIGNED
    assert max(node.details.axis_misalignment_mm for node in assembly["nodes"]) < ALIGNED
    assert max(abs(beam.details.height_deviation_mm) for beam in assembly["beams"]) < ALIGNED


def test_where_edges_reverse_sides_meet_on_the_axis_and_ends_have_two_levels() -> None:
    """Edges of the beams' sides meet between beams that both fall or both rise; here these are opposite each other."""
    assembly = detailed(revolved_pair(12, 6, saddle=True))
    for node, (edges, _, rising) in zip(assembly["nodes"], around_nodes(assembly), strict=True):
        assert sorted(set(rising)) == [False, True]
        middles = edges.mean(axis=1)  # of the outer and the inner side: (beam, level, end, 3)
        along = middles[:, :, 1] - middles[:, :, 0]
        on_axis = middles[:, :, 0] - along * (middles[:, :, 0, :1] / along[..., :1])
        on_axis_y = middles[:, :, 0] - along * (
            middles[:, :, 0, 1:2] / np.where(along[..., 1:2] == 0, 1, along[..., 1:2])
        )
        x_larger = np.abs(along[..., :1]) > np.abs(along[..., 1:2])
        met = np.where(x_larger, on_axis, on_axis_y)
        assert np.abs(met[..., :2]).max() < ALIGNED  # the middles of the sides do meet the axis
        assert np.ptp(met[..., 2], axis=0).max() < ALIGNED
        assert node.details.axis_misalignment_mm < ALIGNED
        levels = edges[:, :, :, 0, 2]
        up = np.array(rising)
        for same in (up, ~up):
            assert np.ptp(levels[same], axis=(0, 1)).max() < ALIGNED
        slope = np.tan(np.radians(max(node.details.inclinations_deg)))
        assert node.details.top_step_mm == pytest.approx(2 * node.details.setbacks_mm[0] * slope, abs=ALIGNED)
    assert max(node.details.top_step_mm for node in assembly["nodes"]) > 10


def test_one_setback_a_node_only_where_it_levels_the_ends() -> None:
    pair = CONVEX["rhombicosidodecahedron"]
    auto, least, equal = (detailed(pair, setbacks=rule) for rule in ("auto", "least", "equal"))
    for first, second, third in zip(auto["nodes"], least["nodes"], equal["nodes"], strict=True):
        assert first.details.setbacks_mm.tolist() == third.details.setbacks_mm.tolist()
        assert set(first.details.setbacks_mm) == {max(second.details.setbacks_mm)}
        assert second.details.top_step_mm > 1.0 > 1e6 * first.details.top_step_mm
    mesh, image = pair  # S translated is a Gauss image too, but not about the same cones
    tilted = (mesh, image.translated([0.1, 0.05, 0.0]))
    auto, least, equal = (detailed(tilted, setbacks=rule) for rule in ("auto", "least", "equal"))
    for first, second, third in zip(auto["nodes"], least["nodes"], equal["nodes"], strict=True):
        assert first.details.setbacks_mm.tolist() == second.details.setbacks_mm.tolist()
        assert len(set(third.details.setbacks_mm)) == 1
    assert min(node.details.axis_misalignment_mm for node in auto["nodes"]) > 1e-3
    assert any(a != b for a, b in pairwise(auto["nodes"][0].details.setbacks_mm))

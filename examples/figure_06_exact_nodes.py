"""Beams of constant height on an edge offset mesh meet exactly at the nodes [Pottmann2007, Prop. 3, Fig. 6].

The convex part of the mesh M' of figure 10, built of steel beams with rectangular sections, node blocks and glass
panels. At a node all beams have the same angle with the axis, so the outer edges (red) of neighbouring beams meet in
points, and so do the inner ones. All parts are written to a STEP file.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

from docs.tools.drawing import CLAY, GLASS, GOLD, STEEL, Panel, Shapes, View, balls, draw_page, polygons, tubes
from examples import figure_10_laguerre as figure_10
from fabkit.detailing.assembling import detail
from fabkit.formats.step.files import write_step
from fabkit.parts import Assembly, Part, Solid
from fabkit.production.marks import share_equal_parts
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules, NodeRules
from geometry import Pair, SupportStructure
from geometry.arrays import FloatArray

WIDTH, HEIGHT, MEAN_EDGE, SHOWN_MM = 120.0, 260.0, 1800.0, 480.0
"""In mm; the last one is how much of a beam is shown in the close-up."""

VIEW = View(-75, 22)


@cache
def support() -> SupportStructure:
    """Over the rows of M' below the fold, without the two uppermost, which have short edges."""
    below = np.arange(figure_10.AROUND * (figure_10.ROWS - 2))
    pair = figure_10.transformed().part(below)
    scaled = pair.mesh * (MEAN_EDGE / pair.mesh.mean_edge_length)
    return SupportStructure(Pair(scaled, pair.gauss_image), HEIGHT)


@cache
def assembly() -> Assembly:
    rules = DetailingRules(
        beams=BeamRules(WIDTH, HEIGHT),
        connection=ConnectionRules(kind="contact"),
        nodes=NodeRules(clearance_mm=1.0, top="enclosing"),
    )
    return share_equal_parts(detail(support(), rules, name="Leaning dome").assembly)


def write(path: Path) -> None:
    """All parts, placed, as STEP."""
    write_step(path, assembly())


def long_edges(beam: Part) -> FloatArray:
    """(2, 2, 2, 3) of the solid of a beam: right and left side, inner and outer level, from its tail to its head."""
    x, y, z = beam.solid.vertices.T
    ordered: FloatArray = beam.solid.vertices[np.lexsort((x, z, y))]
    return beam.placement.to_world(ordered).reshape(2, 2, 2, 3)


def nearest_points(first: FloatArray, second: FloatArray) -> FloatArray:
    """(2, 3) on two lines through points (2, 3)."""
    u, v = first[1] - first[0], second[1] - second[0]
    shares = np.linalg.lstsq(np.stack([u, -v], axis=1), second[0] - first[0], rcond=None)[0]
    return np.stack([first[0] + shares[0] * u, second[0] + shares[1] * v])


@cache
def meetings() -> tuple[FloatArray, FloatArray]:
    """(E, 2, 2, 2, 3) long edges as in `long_edges`, prolonged to where those of neighbours are nearest; and the
    gaps there, (k, 2) for each two neighbours, at the inner and the outer level."""
    beams = {beam.element: beam for beam in assembly()["beams"]}
    edges = np.array([long_edges(beam) for beam in assembly()["beams"]])
    place = {edge: n for n, edge in enumerate(beams)}
    ends, missed = edges.copy(), []
    for node in assembly()["nodes"]:
        around = [*node.details.beams, node.details.beams[0]]
        azimuths = [*node.details.azimuths_deg, 360.0]
        for (one, other), (start, end) in zip(pairwise(around), pairwise(azimuths), strict=True):
            if end - start >= 180:  # no neighbours: the outside of a boundary is between them
                continue
            at_one, at_other = (beams[edge].details.nodes.tolist().index(node.element) for edge in (one, other))
            left, right = (place[one], 1 - at_one), (place[other], at_other)
            gaps = []
            for level in range(2):
                points = nearest_points(edges[left][level], edges[right][level])
                ends[left][level, at_one], ends[right][level, at_other] = points
                gaps.append(float(np.linalg.norm(points[0] - points[1])))
            missed.append(gaps)
    return ends, np.array(missed)


def main() -> dict[str, float]:
    parts, beams, nodes = list(assembly().parts()), assembly()["beams"], assembly()["nodes"]
    with tempfile.TemporaryDirectory() as folder:
        write(Path(folder) / "dome.step")
        size = (Path(folder) / "dome.step").stat().st_size
    return {
        "beams": len(beams),
        "nodes": len(nodes),
        "panels": len(assembly()["panels"]),
        "neighbouring beams": len(meetings()[1]),
        "largest misalignment of their outer edges, over the height": float(meetings()[1][:, 1].max() / HEIGHT),
        "largest misalignment of their inner edges, over the height": float(meetings()[1][:, 0].max() / HEIGHT),
        "misalignment of beams on node axes, over the height": float(nodes.details.axis_misalignment_mm.max() / HEIGHT),
        "largest twist in degrees": float(beams.details.twist_deg.max()),
        "least angle over an edge in degrees": float(np.nanmin(beams.details.dihedral_deg)),
        "parts in the STEP file": len(parts),
        "different parts": len({each.mark for each in parts}),
        "bytes of the STEP file": size,
    }


def solids(parts: Iterable[Part], colour: str, *, width: float = 0.8) -> Shapes:
    """The faces of solids without holes, each in its place."""
    by_size: dict[int, list[FloatArray]] = {}
    for each in parts:
        vertices = each.placement.to_world(each.solid.vertices)
        for face in range(each.solid.topology.n_faces):
            corners = vertices[each.solid.topology.loops(face)[0]]
            by_size.setdefault(len(corners), []).append(corners)
    return [polygons(np.array(group), colour, width=width) for group in by_size.values()]


def towards_viewer(points: FloatArray) -> FloatArray:
    return np.asarray(points @ VIEW.axes[2])


def close_up(node: Part) -> tuple[Shapes, View]:
    """A node block and its beams, cut off at a distance, as seen nearly along the axis."""
    beams, ends, shapes, spots = {beam.element: beam for beam in assembly()["beams"]}, meetings()[0], [], []
    place = {beam.element: n for n, beam in enumerate(assembly()["beams"])}
    for edge in node.details.beams:
        beam = beams[edge]
        end = beam.details.nodes.tolist().index(node.element)
        vertices, length = beam.solid.vertices.copy(), beam.details.long_point_mm
        low, high = (-np.inf, SHOWN_MM) if end == 0 else (length - SHOWN_MM, np.inf)
        vertices[:, 0] = vertices[:, 0].clip(low, high)
        shapes += solids((replace(beam, solid=Solid(vertices, beam.solid.topology)),), STEEL, width=1.2)
        near, far = ends[place[edge]][:, 1, end], ends[place[edge]][:, 1, 1 - end]
        along = (far - near) / np.linalg.norm(far - near, axis=1, keepdims=True)
        shapes += tubes(np.stack([near, near + 1.04 * SHOWN_MM * along], axis=1), 5, CLAY)
        spots.append(near)
    shapes += solids((node,), GOLD, width=1.2)
    shapes += balls(np.concatenate(spots), 9, CLAY)
    x, y, z = node.placement.axes[2]
    return shapes, View(np.degrees(np.arctan2(y, x)) - 24, np.degrees(np.arcsin(z)) + 16)


def draw(path: Path) -> None:
    a, red = assembly(), meetings()[0][:, :, 1].reshape(-1, 2, 3)
    behind = tuple(panel for panel in a["panels"] if towards_viewer(panel.placement.axes[2]) < 0)
    whole = [*solids(a["beams"], STEEL), *solids(a["nodes"], STEEL), *solids(behind, GLASS)]
    inner = [node for node in a["nodes"] if not support().mesh.combinatorics.is_boundary_vertex[node.element]]
    node = max(inner, key=lambda each: float(towards_viewer(each.placement.axes[2])))
    shapes, view = close_up(node)
    panels = [
        Panel([*whole, *tubes(red, 14, CLAY, sides=6)], VIEW, (20, 20, 620, 560)),
        Panel(shapes, view, (700, 40, 680, 520)),
    ]
    draw_page(path, 1400, 600, panels)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_06.png")
    print(main())

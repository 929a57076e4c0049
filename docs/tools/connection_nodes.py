"""Draw one node of each connection, assembled and taken apart: `python -m docs.tools.connection_nodes`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from docs.tools.drawing import BLUE, CLAY, GOLD, SAGE, STEEL, Note, Panel, Shapes, View, draw_page, polygons
from fabkit import Project, design
from fabkit.formats.shown.triangles import facets
from fabkit.parts import Assembly, Part, Solid, Solids
from geometry.arrays import FloatArray
from geometry.mesh.shapes import dome

__all__ = ["draw_connections"]

PICTURE = Path(__file__).parents[1] / "gallery" / "connections.png"
COLOURS = {
    "beam": STEEL,
    "node": CLAY,
    "end plate": BLUE,
    "bolt": GOLD,
    "dowel": SAGE,
    "cap": GOLD,
    "stub": GOLD,
    "base plate": BLUE,
}
MOVES = {
    "node": 0.0,
    "dowel": 55.0,
    "end plate": 95.0,
    "beam": 230.0,
    "bolt": 170.0,
    "cap": 70.0,
    "stub": 60.0,
    "base plate": 120.0,
}
"""How far parts of each kind are moved from the node when it is taken apart, in mm."""

SHOWN_MM = 340.0
"""Length of the beams in the picture, in mm."""

VIEW = View(28.0, 38.0)
KINDS = {
    "welded": ("rhs 120x60x5 rounded", "welded: rhs 120x60x5, with a slot for the torch and a ledge for the seam"),
    "bolted": ("rhs 120x60x5 rounded", "bolted: rhs 120x60x5, an end plate, one M20 and a dowel"),
    "hub": ("tee 120x80x10x8", "hub: tee 120x80x10x8 on a tube, two caps"),
    "contact": ("flat 120x50", "contact: solid bars that end on the block"),
}
"""Section of the beams of each kind of connection, and what is written above its pictures."""


def parts_at(assembly: Assembly, vertex: int) -> Iterator[tuple[Part, FloatArray]]:
    """The parts at a node, and where each is moved when the node is taken apart, in mm."""
    node = assembly["nodes"][int(assembly["nodes"].find(np.array([vertex]))[0])]
    for part in assembly.parts():
        at = getattr(part.details, "nodes", part.element)
        if part.kind.name == "panel" or vertex not in np.atleast_1d(at).tolist():
            continue
        middle = node.placement.to_world(node.solid.vertices).mean(axis=0)
        away = part.placement.to_world(part.solid.vertices).mean(axis=0) - middle
        axis = node.placement.axes[2]
        out = axis * (away @ axis) if part.kind.name == "cap" else away - axis * (away @ axis)
        size = np.linalg.norm(out)
        yield part, MOVES[part.kind.name] * out / size if size > 1 else 0 * axis


def shapes(assembly: Assembly, vertex: int, share: float) -> Shapes:
    """The parts at a node in its own frame, taken apart by a share of their moves; beams are shown shorter."""
    drawn = []
    frame = assembly["nodes"][int(assembly["nodes"].find(np.array([vertex]))[0])].placement
    for part, move in parts_at(assembly, vertex):
        vertices = part.solid.vertices.copy()
        if part.kind.name == "beam":
            length = vertices[:, 0].max() + vertices[:, 0].min()
            far = vertices[:, 0] > length / 2
            vertices[far, 0] -= length - SHOWN_MM
            if part.details.nodes[1] == vertex:
                vertices[:, 0] += length - SHOWN_MM
        batch = facets(Solids.of([Solid(vertices, part.solid.topology)]), [part.mark])[0]
        points = (part.placement.to_world(batch.points[0]) + share * move - frame.origin) @ frame.axes.T
        triangles, normals = batch.triangles[0], batch.normals[0] @ part.placement.axes @ frame.axes.T
        drawn.append(polygons(points[triangles], COLOURS[part.kind.name], normals=normals[triangles]))
    return drawn


def draw_connections(path: Path = PICTURE) -> None:
    panels, notes = [], []
    for row, (kind, (section, note)) in enumerate(KINDS.items()):
        settings = {"beams": {"section": section}, "connection": {"kind": kind}}
        made = design(Project(mesh=dome(12, 4), mean_edge_mm=3000, **settings)).assembly
        vertex = int(made["nodes"].elements[made["nodes"].details.beams.sizes.argmax()])
        for column, share in enumerate((0.0, 1.0)):
            panels.append(Panel(shapes(made, vertex, share), VIEW, (750 * column + 10, 560 * row + 40, 730, 510)))
        notes.append(Note(750, 560 * row + 24, note))
    draw_page(path, 1500, 10 + 560 * len(KINDS), panels, notes)


if __name__ == "__main__":
    draw_connections()

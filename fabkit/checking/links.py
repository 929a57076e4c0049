"""Links between beams and nodes by their mesh elements, and the mesh vertices at which a part lies."""

from __future__ import annotations

import numpy as np

from fabkit.kinds import BEAM, NODE, PANEL, BeamDetails, NodeDetails
from fabkit.parts import Assembly, Part, Parts
from geometry.arrays import IntArray

__all__ = ["ElementVertices", "unlinked_ends", "unlinked_facets"]


def unlinked_ends(beams: Parts[BeamDetails], nodes: Parts[NodeDetails]) -> list[tuple[int, int, int]]:
    """Ends of beams without a facet for them: position of the beam, end 0 or 1, and position of the node there, -1 if
    there is none."""
    at = nodes.find(beams.details.nodes)
    ends = _pairs(beams.details.nodes, beams.elements[:, None])
    facets = _pairs(nodes.elements[nodes.details.beams.row], nodes.details.beams.values)
    beam, end = np.nonzero((at < 0) | ~np.isin(ends, facets))
    return list(zip(beam.tolist(), end.tolist(), at[beam, end].tolist(), strict=True))


def unlinked_facets(beams: Parts[BeamDetails], nodes: Parts[NodeDetails]) -> list[tuple[int, int]]:
    """Facets for beams that do not end at their node: position of the node, and mesh edge of the beam."""
    around = nodes.details.beams
    ends = _pairs(beams.details.nodes, beams.elements[:, None])
    unlinked = np.flatnonzero(~np.isin(_pairs(nodes.elements[around.row], around.values), ends))
    return list(zip(around.row[unlinked].tolist(), around.values[unlinked].tolist(), strict=True))


def _pairs(vertices: IntArray, edges: IntArray) -> IntArray:
    """One number for each pair of a vertex and an edge, both below 2^31."""
    return (vertices << 32) + edges


class ElementVertices:
    """The vertices of the mesh element of each part, as far as they are known from beams, nodes and panels."""

    def __init__(self, assembly: Assembly) -> None:
        beams, around = assembly.of(BEAM), assembly.of(NODE).details.beams
        edges = np.concatenate([np.repeat(beams.elements, 2), around.values])
        vertices = np.concatenate([beams.details.nodes.ravel(), assembly.of(NODE).elements[around.row]])
        order = np.argsort(edges, kind="stable")
        self._edges, self._vertices = edges[order], vertices[order]
        self._panels = assembly.of(PANEL)

    def of(self, part: Part) -> set[int]:
        if part.kind.element == "vertex":
            return {part.element}
        if part.kind.element == "edge":
            return self._of_edge(part.element)
        panel = int(self._panels.find(np.array(part.element)))
        edges = self._panels.details.beams[panel].tolist() if panel >= 0 else []
        return set().union(*map(self._of_edge, edges))

    def _of_edge(self, edge: int) -> set[int]:
        first, last = np.searchsorted(self._edges, [edge, edge + 1])
        return set(self._vertices[first:last].tolist())

"""Dots in nodes that could be mounted turned or upside down: in the outer end, near facet 1."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fabkit.checking.bore_distances import drilling_faults
from fabkit.detailing.shapes.drilling import BLIND, Bores, drilled
from fabkit.kinds import CAP, NODE, NodeDetails
from fabkit.kinds.look_alikes import OUTER_END
from fabkit.parts import Assembly, Parts, Solids
from geometry.arrays import FloatArray, IntArray

__all__ = ["drilled_dots", "stamped"]

DOT_DIAMETER_MM = 5.0
"""Diameter in mm of the dot in a node: seen from some metres, and with 1.2 diameters to each edge it has room beside a
web of 12 mm."""

DOT_DEPTH_MM = 2.0
"""Depth in mm of the dot in a node: it is still there after blasting, galvanising and painting."""

DOT_INSET_MM = 10.0
"""Distance in mm of the middle of the dot from facet 1, or from the rim of the cap of a hub: outside the seam, and
nearer to facet 1 than to any other."""

LEAST_OTHER_FACET_MM = 15.0
"""Minimum distance in mm of the middle of the dot from the planes of other facets than the first: half as much again
as from facet 1, so that nobody doubts which one it is."""


def stamped(assembly: Assembly) -> Assembly:
    """The assembly with a dot in the outer end, near facet 1, of each node block that could be mounted turned or upside
    down (`look_alikes`). Hubs have it in their upper caps, which are turned as their nodes are here.

    To be called when equal nodes share a solid, and so the facet that is the first one. Blocks without room for a dot
    stay as they are.

    >>> from fabkit import Project, design
    >>> from fabkit.detailing.shapes.dots import stamped
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.detailing import detail
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> plain = detail(built.structure, built.project.rules, name="dome").assembly
    >>> (plain["nodes"].volumes_mm3 - stamped(plain)["nodes"].volumes_mm3)[:2].round(1).tolist()
    [39.3, 39.3]
    """
    for nodes in assembly.of_layers(NODE):
        caps = assembly.beside(nodes, CAP)
        if len(caps):
            assembly = assembly.with_group(replace(caps, axes=nodes.axes[nodes.find(caps.elements)]))
        elif len(nodes):
            assembly = assembly.with_group(_with_dots(nodes))
    return assembly


def _with_dots(nodes: Parts[NodeDetails]) -> Parts[NodeDetails]:
    firsts = nodes.take(nodes.firsts)
    setbacks = firsts.details.setbacks_mm
    reach = setbacks.values[setbacks.starts[:-1]] - DOT_INSET_MM
    others = setbacks.values - reach[setbacks.row] * np.cos(np.radians(firsts.details.azimuths_deg.values))
    others = np.where(setbacks.place == 0, np.inf, others)
    has_room = (reach > 0) & (setbacks.with_values(others).reduced(np.minimum) >= LEAST_OTHER_FACET_MM)
    chosen = np.logical_or(*firsts.details.look_alikes) & has_room
    return replace(nodes, solids=drilled_dots(nodes.solids, firsts.shape[chosen], reach[chosen]))


def drilled_dots(solids: Solids, chosen: IntArray, reach: FloatArray) -> Solids:
    """Solids with dots in the outer ends of the chosen ones (k,), at the distances reach (k,) in mm along x from z, as
    far as there is room for them beside edges and bores.

    >>> from fabkit.detailing.shapes.dots import drilled_dots
    >>> from fabkit.parts import Solids, prism_topology, prism_vertices
    >>> square = np.array([[-30, -30], [30, -30], [30, 30], [-30, 30]])
    >>> blocks = Solids.alike(prism_vertices(np.stack([square, square]), 0.0, 100.0), prism_topology(4))
    >>> dotted = drilled_dots(blocks, np.array([0, 1]), np.array([20.0, 25.0]))
    >>> (blocks.volumes - dotted.volumes).round(1).tolist()
    [39.3, 0.0]
    """
    if not len(chosen):
        return solids
    made = drilled(solids, _dots(solids, chosen, reach))
    bad = [batch.parts[row] for batch in made.by_topology(chosen) for row, *_ in drilling_faults(batch)]
    if not bad:
        return made
    keep = np.delete(np.arange(len(chosen)), np.array(bad))
    return drilled(solids, _dots(solids, chosen[keep], reach[keep])) if len(keep) else solids


def _dots(solids: Solids, chosen: IntArray, reach: FloatArray) -> Bores:
    points, normals = np.empty((len(chosen), 3)), np.empty((len(chosen), 3))
    for batch in solids.by_topology(chosen):
        t = batch.topology
        loops = t.loops(OUTER_END)
        corner = loops[0][0] if loops else t.rounds[t.rounds[:, 5] == OUTER_END, 2][0]
        points[batch.parts], normals[batch.parts] = batch.vertices[:, corner], batch.normals[:, OUTER_END]
    starts = np.stack([reach, np.zeros(len(reach)), np.zeros(len(reach))], axis=1)
    starts[:, 2] = np.einsum("ki,ki->k", points - starts, normals) / normals[:, 2]
    return Bores(
        solids=chosen,
        faces=np.tile([OUTER_END, BLIND], (len(chosen), 1)),
        starts=starts,
        stops=starts - DOT_DEPTH_MM * normals,
        radii=np.full(len(chosen), DOT_DIAMETER_MM / 2),
        across=np.tile([0.0, 1.0, 0.0], (len(chosen), 1)),
    )

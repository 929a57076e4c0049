"""Names of faces of parts, as STEP files give them: ends, facets, edges, and the outer side."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.parts import Measures, Parts, SolidArray
from geometry.arrays import FloatArray

__all__ = ["FaceNames", "beam_faces", "node_faces", "panel_faces"]

FaceNames = npt.NDArray[Any]
"""(k, F) names of the faces of k solids of one topology, empty where there is none."""

FACET_DIRECTION = 1e-6
"""Largest distance of the unit normal of a facet from the direction of its beam about the axis: rounding."""


def beam_faces(beams: Parts[Any], solids: SolidArray) -> FaceNames:
    """END A, END B and OUTSIDE, the planar face that looks most along -x, +x and +z of the beam's own frame.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.kinds import beam_faces
    >>> beams = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly["beams"]
    >>> (solids,) = beams.solids.by_topology(beams.shape[:1])
    >>> sorted(beam_faces(beams[:1], solids)[0].tolist())[-3:]
    ['END A', 'END B', 'OUTSIDE']
    """
    names, shadows = _nothing(solids), _shadows(solids)
    for name, direction in (("OUTSIDE", shadows[..., 2]), ("END B", shadows[..., 0]), ("END A", -shadows[..., 0])):
        names[np.arange(len(names)), direction.argmax(axis=1)] = name
    return names


def node_faces(nodes: Parts[Any], solids: SolidArray) -> FaceNames:
    """OUTSIDE and FACET 1, 2, ..., numbered as in the table of facets.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.kinds import node_faces
    >>> nodes = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly["nodes"]
    >>> (solids,) = nodes.solids.by_topology(nodes.shape[:1])
    >>> [name for name in sorted(node_faces(nodes[:1], solids)[0].tolist()) if name]
    ['FACET 1', 'FACET 2', 'FACET 3', 'OUTSIDE']
    """
    names, shadows = _nothing(solids), _shadows(solids)
    names[np.arange(len(names)), shadows[..., 2].argmax(axis=1)] = "OUTSIDE"
    azimuths = nodes.details.azimuths_deg
    for place in range(int(azimuths.sizes.max(initial=0))):
        rows = np.flatnonzero(azimuths.sizes > place)
        angles = np.radians(azimuths.values[azimuths.starts[rows] + place])
        directions = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        areas = np.linalg.norm(shadows[rows], axis=2)
        turned = np.linalg.norm(shadows[rows] - areas[..., None] * directions[:, None], axis=2)
        fitting = np.where(turned <= FACET_DIRECTION * areas, areas, 0.0)
        found = fitting.max(axis=1) > 0
        names[rows[found], fitting[found].argmax(axis=1)] = f"FACET {place + 1}"
    return names


def panel_faces(panels: Parts[Any], solids: SolidArray) -> FaceNames:
    """OUTSIDE and, of prisms, EDGE 1, 2, ..., numbered as in the table of edges.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.kinds import panel_faces
    >>> panels = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly["panels"]
    >>> (solids,) = panels.solids.by_topology(panels.shape[:1])
    >>> sorted(panel_faces(panels[:1], solids)[0].tolist())
    ['', 'EDGE 1', 'EDGE 2', 'EDGE 3', 'EDGE 4', 'OUTSIDE']
    """
    names, t = _nothing(solids), solids.topology
    names[np.arange(len(names)), _shadows(solids)[..., 2].argmax(axis=1)] = "OUTSIDE"
    n, heads = t.n_vertices // 2, t.corners[t.next_corner]
    if t.n_faces == n + 2 and not len(t.rounds) and not len(t.fillets):
        for edge in range(n):
            names[:, t.corner_face[(t.corners == edge) & (heads == (edge + 1) % n)]] = f"EDGE {edge + 1}"
    return names


def _nothing(solids: SolidArray) -> FaceNames:
    return np.full((len(solids.parts), solids.topology.n_faces), "", dtype=object)


def _shadows(solids: SolidArray) -> FloatArray:
    """(k, F, 3) normals of the planar faces times their areas; zero for faces on fillets."""
    with np.errstate(invalid="ignore", divide="ignore"):  # of broken solids, which are refused with their numbers
        shadows: FloatArray = solids.normals * Measures(solids.topology, solids.vertices).areas[..., None]
    shadows[:, solids.topology.fillets[:, 0]] = 0.0
    return shadows

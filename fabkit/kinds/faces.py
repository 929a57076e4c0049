"""Names of faces of parts, as STEP files give them: ends, facets, edges, and the outer side."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.parts import Parts, SolidArray

__all__ = ["FaceNames", "beam_faces", "node_faces", "panel_faces"]

FaceNames = npt.NDArray[Any]
"""(k, F) names of the faces of k solids of one topology, empty where there is none."""

FACET_DIRECTION = 1e-6
"""Largest distance of the unit normal of a facet from the direction of its beam about the axis: rounding."""
TOWARDS = 0.5
"""Cosine of the angle between the normal of a face and a direction from which on the face looks that way: mitres are
below 60 degrees."""


def beam_faces(beams: Parts[Any], solids: SolidArray) -> FaceNames:
    """END A, END B and OUTSIDE: of the faces that look along -x, +x and +z of the beam's own frame, the outermost.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.kinds import beam_faces
    >>> beams = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly["beams"]
    >>> (solids,) = beams.solids.by_topology(beams.shape[:1])
    >>> sorted(beam_faces(beams[:1], solids)[0].tolist())[-3:]
    ['END A', 'END B', 'OUTSIDE']
    """
    names = _nothing(solids)
    for name, axis, sign in (("OUTSIDE", 2, 1), ("END B", 0, 1), ("END A", 0, -1)):
        _name_outermost(names, solids, name, axis, sign)
    return names


def node_faces(nodes: Parts[Any], solids: SolidArray) -> FaceNames:
    """OUTSIDE, which a trimmed block has several times, and FACET 1, 2, ..., numbered as in the table of facets.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.kinds import node_faces
    >>> nodes = design(Project(mesh=dome(6, 2), mean_edge_mm=1500)).assembly["nodes"]
    >>> (solids,) = nodes.solids.by_topology(nodes.shape[:1])
    >>> [name for name in sorted(node_faces(nodes[:1], solids)[0].tolist()) if name]
    ['FACET 1', 'FACET 2', 'FACET 3', 'OUTSIDE']
    """
    names, t = _nothing(solids), solids.topology
    names[(solids.normals[..., 2] > TOWARDS) & np.isin(np.arange(t.n_faces), t.polygonal)] = "OUTSIDE"
    azimuths, corners = nodes.details.azimuths_deg, solids.vertices[:, t.corners]
    counts = np.bincount(t.corner_face, minlength=t.n_faces)
    for place in range(int(azimuths.sizes.max(initial=0))):
        rows = np.flatnonzero(azimuths.sizes > place)
        angles = np.radians(azimuths.values[azimuths.starts[rows] + place])
        directions = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
        across = np.stack([-directions[:, 1], directions[:, 0]], axis=1)
        aside = np.abs(t.by_face(np.add, np.einsum("kci,ki->kc", corners[rows][..., :2], across), empty=np.inf))
        turned = np.linalg.norm(solids.normals[rows] - directions[:, None], axis=2)
        aside = np.where(turned <= FACET_DIRECTION, aside / np.maximum(counts, 1), np.inf)
        found = np.isfinite(aside.min(axis=1))
        names[rows[found], aside[found].argmin(axis=1)] = f"FACET {place + 1}"
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
    _name_outermost(names, solids, "OUTSIDE", 2, 1)
    n, heads = t.n_vertices // 2, t.corners[t.next_corner]
    if t.n_faces == n + 2 and not len(t.rounds) and not len(t.fillets):
        for edge in range(n):
            names[:, t.corner_face[(t.corners == edge) & (heads == (edge + 1) % n)]] = f"EDGE {edge + 1}"
    return names


def _nothing(solids: SolidArray) -> FaceNames:
    return np.full((len(solids.parts), solids.topology.n_faces), "", dtype=object)


def _name_outermost(names: FaceNames, solids: SolidArray, name: str, axis: int, sign: int) -> None:
    """Names the face that reaches farthest along an axis of those that look along it."""
    t = solids.topology
    reach = t.by_face(np.maximum, sign * solids.vertices[:, t.corners, axis], empty=-np.inf)
    reach = np.where(sign * solids.normals[..., axis] > TOWARDS, reach, -np.inf)
    found = np.isfinite(reach.max(axis=1))
    names[found, reach[found].argmax(axis=1)] = name

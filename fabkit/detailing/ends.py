"""The ends of the beams at the nodes: directions about the node axes, and setbacks that keep beams apart.

An *end* is one end of one beam; end 2e is at the tail of edge e, end 2e + 1 at its head. The ends at a node form a
*ring*, counter-clockwise seen from outside. Everything is computed for all ends at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.detailing.shapes.bar_sections import BarSections
from fabkit.detailing.shapes.setbacks import flange_setbacks, longest_setbacks, needed_setbacks, setbacks
from fabkit.rules import DetailingRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure

__all__ = ["Ends", "beam_ends"]


HALF_TURN_TOLERANCE = 1e-6
"""Angle in radians by which a gap between beams may exceed half a turn without an extra corner of the block. It is
above rounding at map coordinates, and a block without that corner deviates by a ten-thousandth of a millimetre."""

LEAST_FLANGE_STEP_MM = 5.0
"""Least distance in mm by which the flange of a tee ends before its web, so that the weld of the web runs through."""


@dataclass(frozen=True, eq=False)
class Ends:
    """Ends of all beams, two for each edge; ends of beams that are not made belong to no ring.

    vertex (2E,): the node. outward (2E, 3): unit direction of the beam away from the node. radial (2E, 3): its unit
    projection along the node axis. inclination (2E,): angle of the beam above the plane perpendicular to the axis.
    azimuth (2E,): angle in [0, 2 pi) about the axis from the first end of the ring.
    ring (R,): the ends that are made, node by node, counter-clockwise, from the one after a gap of more than half a
    turn or else from the one with the lowest number; ring_starts (N+1,): node i has
    ring[ring_starts[i]:ring_starts[i+1]]. following (2E,): the next end of the ring, -1 for ends in no ring.
    gap (2E,): angle to the next end of the ring, 2 pi where the ring has one end only; NaN for ends in no ring.
    setback (2E,): distance in mm of the facet from the node axis. cut (2E,): distance in mm of the beam's end from the
    axis: that of the facet, the gap between the two, and the end plate if there is one. flange_cut (2E,): the same of
    the flange of a tee on a hub, which is cut back further; of other beams as cut. bars: the sections of the beams.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import beam_ends
    >>> ends = beam_ends(built.structure, np.ones(30, dtype=bool), built.project.rules)
    >>> ends.vertex[:4].tolist(), np.diff(ends.ring_starts)[:4].tolist()
    ([0, 3, 3, 4], [3, 4, 3, 3])
    """

    vertex: IntArray
    outward: FloatArray
    radial: FloatArray
    inclination: FloatArray
    azimuth: FloatArray
    ring: IntArray
    ring_starts: IntArray
    following: IntArray
    gap: FloatArray
    setback: FloatArray
    cut: FloatArray
    flange_cut: FloatArray
    bars: BarSections

    def at(self, vertices: IntArray, edges: IntArray) -> IntArray:
        """(k,) the ends at these vertices of the beams on these edges (k,)."""
        return np.asarray(2 * edges + (self.vertex[2 * edges + 1] == vertices))

    def levels(self, height: float | FloatArray) -> FloatArray:
        """(2E,) levels along the node axes, in mm, of the beams' ends at this height, or these (2E,), above their
        edges."""
        return np.asarray((self.cut * np.sin(self.inclination) + height) / np.cos(self.inclination))


def beam_ends(structure: SupportStructure, made: BoolArray, rules: DetailingRules) -> Ends:
    """The ends of the beams on the edges `made` (E,).

    The setbacks are the least ones for which beams do not touch, and can be joined by the rules of the connection. In
    general each beam has its own setback. Where the beams of a node lie on one cone of revolution about its axis, as in
    all edge offset meshes [Pottmann2007, Prop. 3], the rules may give all of them the largest one. Then the end faces
    of all beams that descend from the node are at one level, and so are those of all beams that rise from it.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.detailing import beam_ends
    >>> ends = beam_ends(built.structure, np.ones(30, dtype=bool), built.project.rules)
    >>> ends.setback[:6].round(1).tolist()
    [52.0, 52.0, 52.0, 64.0, 64.0, 64.0]
    """
    edges = structure.mesh.combinatorics.edges
    vertex = edges.ravel()
    axis = structure.axes[vertex]
    outward = (structure.mesh.edge_directions[:, None, :] * np.array([1.0, -1.0])[:, None]).reshape(-1, 3)
    sine = np.einsum("ek,ek->e", outward, axis)
    flat = outward - sine[:, None] * axis
    cosine = np.linalg.norm(flat, axis=1)
    radial = flat / cosine[:, None]
    azimuth = _azimuths(vertex, axis, radial, np.repeat(made, 2), structure.mesh.n_vertices)
    made_ends = np.flatnonzero(np.repeat(made, 2))
    ring = made_ends[np.lexsort((azimuth[made_ends], vertex[made_ends]))]
    counts = np.bincount(vertex[ring], minlength=structure.mesh.n_vertices)
    starts = np.concatenate([[0], np.cumsum(counts)])
    following = np.full(len(vertex), -1, dtype=np.int64)
    place = np.arange(len(ring))
    is_last = place == starts[vertex[ring] + 1] - 1
    following[ring] = ring[np.where(is_last, starts[vertex[ring]], place + 1)]
    gap = np.full(len(vertex), np.nan)
    gap[ring] = np.mod(azimuth[following[ring]] - azimuth[ring], 2 * np.pi)
    gap[ring[counts[vertex[ring]] == 1]] = 2 * np.pi
    first = following[ring[gap[ring] > np.pi + HALF_TURN_TOLERANCE]]
    start = np.zeros(structure.mesh.n_vertices)
    start[vertex[first]] = azimuth[first]
    azimuth = np.mod(azimuth - start[vertex], 2 * np.pi)
    ring = ring[np.lexsort((azimuth[ring], vertex[ring]))]
    inclination = np.arctan2(sine, cosine)
    setback = np.full(len(vertex), np.nan)
    bars = BarSections.of(structure.mesh, rules.beams)
    needed = needed_setbacks(ring, following, gap, bars, rules)
    longest = longest_setbacks(structure.mesh.edge_lengths, rules)
    setback[ring] = setbacks(
        vertex[ring], inclination[ring], np.ptp(bars.levels, axis=1)[ring // 2], needed, longest[ring], rules
    )
    cut = setback + rules.connection.end_distance_mm
    flange_cut = cut.copy()
    if rules.connection.kind == "hub":
        apart, tees = flange_setbacks(ring, following, gap, bars), bars.are_tees[ring // 2]
        flange_cut[ring] = np.where(tees, np.maximum(cut[ring] + LEAST_FLANGE_STEP_MM, apart), cut[ring])
    return Ends(
        vertex=vertex,
        outward=outward,
        radial=radial,
        inclination=inclination,
        azimuth=azimuth,
        ring=ring,
        ring_starts=starts,
        following=following,
        gap=gap,
        setback=setback,
        cut=cut,
        flange_cut=flange_cut,
        bars=bars,
    )


def _azimuths(vertex: IntArray, axis: FloatArray, radial: FloatArray, made: BoolArray, n_vertices: int) -> FloatArray:
    """(2E,) angles in [0, 2 pi) about the axes, from the end with the lowest number that is made at the node."""
    reference = np.zeros((n_vertices, 3))
    made_ends = np.flatnonzero(made)[::-1]
    reference[vertex[made_ends]] = radial[made_ends]
    x = reference[vertex]
    y = np.cross(axis, x)
    angle = np.arctan2(np.einsum("ek,ek->e", radial, y), np.einsum("ek,ek->e", radial, x))
    angle[np.abs(angle) < 1e-14] = 0.0  # the first end itself: rounding must not send it to 2 pi
    azimuth: FloatArray = np.mod(angle, 2 * np.pi)
    return azimuth

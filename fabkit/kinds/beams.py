"""Beams: straight bars of constant section along the edges."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.kinds.columns import (
    LEFT_OUT,
    counted,
    files,
    marks_and_counts,
    marks_in,
    masses,
    materials,
    of_first,
    over_all,
)
from fabkit.kinds.faces import beam_faces
from fabkit.parts import Column, Details, Kind, Measure, Parts, Surroundings, Symmetry, Turns, other_end
from geometry.arrays import FloatArray, IntArray

__all__ = ["BEAM", "BeamDetails", "ends_glyphs"]

ANGLE_DECIMALS = 3
"""Decimals of cut angles in the list: over a height of 500 mm half of the last one is 0.004 mm."""
SQUARE_DEG = 0.005
"""Cut angle in degrees below which an end is drawn as cut square: no saw is more accurate."""
EITHER_SIDE_MM = 0.01
"""Gap in mm up to which a beam goes in from both sides: no saw is more accurate."""


@dataclass(frozen=True, eq=False)
class BeamDetails(Details):
    """Data of n beams.

    Own frame of a beam: origin in the outer middle of end A, at its cut; x from end A to end B, z outwards in the
    central plane; its corners are listed so that half a turn about z reverses their order.

    nodes (n, 2): mesh vertices at ends A and B. section (n,): of each, a `Section`. cut_angles_deg (n, 2): angle
    between each end's cut and a square cut, positive where the outer side is the longer one. end_gaps_mm (n, 2):
    distance of each end from the facet of its node. long_point_mm and short_point_mm (n,): longest and shortest
    extent along the axis; flange_points_mm (n, 2): those of the flange of a tee that is cut back further than its
    web, flange_backs_mm (n, 2): by how much at each end, along the axis; NaN of other beams. hand_holes_mm (n, 2):
    distance along the axis of the middle of the hand hole at each end, seen from which it is in the left side, from
    the long point there; NaN where there is none. dihedral_deg (n,): angle between the normals of the two faces,
    positive where the mesh is convex, NaN at the boundary. height_deviation_mm (n,): distance of the two parallel
    meshes at this edge minus the height of the section. twist_deg (n,): angle between the central planes at its two
    ends. going_in_gaps_mm (n, 2): gaps that it needs at either end to go straight in from outside and from inside,
    between two nodes that are fixed; one of the two is 0.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> beams = built.assembly["beams"].details
    >>> beams.nodes[0].tolist(), beams.cut_angles_deg[0].round(2).tolist(), round(beams.long_point_mm[0])
    ([0, 3], [29.45, 29.45], 2288)
    """

    nodes: IntArray
    section: npt.NDArray[Any]
    cut_angles_deg: FloatArray
    end_gaps_mm: FloatArray
    long_point_mm: FloatArray
    short_point_mm: FloatArray
    flange_points_mm: FloatArray
    flange_backs_mm: FloatArray
    hand_holes_mm: FloatArray
    dihedral_deg: FloatArray
    height_deviation_mm: FloatArray
    twist_deg: FloatArray
    going_in_gaps_mm: FloatArray

    @property
    def goes_in_from(self) -> list[str]:
        """The side from which each beam goes straight in between two nodes that are fixed: "outside", "inside", or
        "both"."""
        free = self.going_in_gaps_mm <= EITHER_SIDE_MM
        return [("outside", "inside", "both")[k] for k in np.where(free.all(axis=1), 2, ~free[:, 0]).tolist()]


def ends_glyphs(cut_angles_deg: FloatArray) -> list[str]:
    r"""Beams with cut angles (n, 2) in degrees seen from the side, as text: outer side up, end A on the left. In \_/
    the outer side is the longest, |_| is cut square."""
    signs = np.sign(np.where(np.abs(cut_angles_deg) < SQUARE_DEG, 0.0, cut_angles_deg)).astype(int)
    return ["/|\\"[first + 1] + "_" + "\\|/"[second + 1] for first, second in signs.tolist()]


def _turns(beams: Parts[BeamDetails], corners: FloatArray) -> Turns:
    """The turns of beams: as they are, and turned end for end."""
    near = np.hypot(corners[..., 0], corners[..., 2]).argmin(axis=1)
    length = corners[np.arange(len(corners)), corners.shape[1] - 1 - near, 0]
    starts = np.zeros((len(corners), 2, 2))
    starts[:, 1, 0] = length
    along = np.tile([[1.0, 0.0], [-1.0, 0.0]], (len(corners), 1, 1))
    return Turns(starts, along, other_end(corners.shape[1]))


def _columns(beams: Parts[BeamDetails], around: Surroundings) -> list[Column]:
    own = beams.details
    ends = marks_in(around, beams.kind.named("nodes"), own.nodes.ravel())
    return [
        *marks_and_counts(beams),
        Column("Section", None, [section.name for section in own.section[beams.firsts]]),
        materials(beams),
        of_first("Long point (mm)", 3, beams, own.long_point_mm),
        of_first("Short point (mm)", 3, beams, own.short_point_mm),
        of_first("Flange long point (mm)", 3, beams, own.flange_points_mm[:, 0]),
        of_first("Flange short point (mm)", 3, beams, own.flange_points_mm[:, 1]),
        of_first("Flange back at A (mm)", 3, beams, own.flange_backs_mm[:, 0]),
        of_first("Flange back at B (mm)", 3, beams, own.flange_backs_mm[:, 1]),
        of_first("Hand hole at A (mm)", 3, beams, own.hand_holes_mm[:, 0]),
        of_first("Hand hole at B (mm)", 3, beams, own.hand_holes_mm[:, 1]),
        of_first("End A (deg)", ANGLE_DECIMALS, beams, own.cut_angles_deg[:, 0]),
        of_first("End B (deg)", ANGLE_DECIMALS, beams, own.cut_angles_deg[:, 1]),
        Column("Ends", None, ends_glyphs(own.cut_angles_deg[beams.firsts])),
        counted("Nodes A B", beams, [f"{a} {b}" for a, b in zip(ends[::2], ends[1::2], strict=True)]),
        *over_all("Dihedral (deg)", 2, beams, own.dihedral_deg),
        *over_all("Height deviation (mm)", 3, beams, own.height_deviation_mm),
        Column("Goes in from", None, own[beams.firsts].goes_in_from),
        over_all("Gap from outside (mm)", 1, beams, own.going_in_gaps_mm[:, 0])[1],
        *masses(beams),
        files(beams, "parts/{}.step"),
    ]


def _measures(beams: Parts[BeamDetails]) -> list[Measure]:
    own, measure = beams.details, partial(Measure, beams.kind.group)
    return [
        measure("Long-point length", "mm", 1, own.long_point_mm),
        measure("Height deviation", "mm", 2, own.height_deviation_mm, signed=True),
        measure("Dihedral angle", "°", 2, own.dihedral_deg, signed=True),
        measure("Larger cut angle of the two ends", "°", 2, np.abs(own.cut_angles_deg).max(axis=1)),
        measure("Gap to go in from outside", "mm", 1, own.going_in_gaps_mm[:, 0]),
        measure("Mass of a beam", "kg", 2, beams.masses_kg),
    ]


def _stock(beams: Parts[BeamDetails]) -> list[str]:
    return [section.name for section in beams.details.section]


def _labels(beams: Parts[BeamDetails], around: Surroundings) -> list[str]:
    vertices = beams.details.nodes.ravel()
    marks = zip(marks_in(around, beams.kind.named("nodes"), vertices), vertices.tolist(), strict=True)
    ends = [f"vertex {vertex}" if mark == LEFT_OUT else mark for mark, vertex in marks]
    stock = [
        f"{section.name}, {beams.materials[material].name}"
        for section, material in zip(beams.details.section, beams.material.tolist(), strict=True)
    ]
    rows = zip(stock, beams.elements.tolist(), ends[::2], ends[1::2], strict=True)
    return [f"{made_of}; edge {edge}, {a} to {b}" for made_of, edge, a, b in rows]


BEAM = Kind(
    name="beam",
    group="beams",
    element="edge",
    letter="B",
    colour=(0.36, 0.42, 0.47),
    form="bar",
    frame="Origin in the outer middle of end A at its cut, x from end A to end B, z outwards in the central plane.",
    empty_details=BeamDetails(
        nodes=np.zeros((0, 2), dtype=np.int64),
        section=np.zeros(0, dtype=object),
        cut_angles_deg=np.zeros((0, 2)),
        end_gaps_mm=np.zeros((0, 2)),
        long_point_mm=np.zeros(0),
        short_point_mm=np.zeros(0),
        flange_points_mm=np.zeros((0, 2)),
        flange_backs_mm=np.zeros((0, 2)),
        hand_holes_mm=np.zeros((0, 2)),
        dihedral_deg=np.zeros(0),
        height_deviation_mm=np.zeros(0),
        twist_deg=np.zeros(0),
        going_in_gaps_mm=np.zeros((0, 2)),
    ),
    symmetry=Symmetry(("nodes", "cut_angles_deg", "end_gaps_mm", "flange_backs_mm", "hand_holes_mm"), (), _turns),
    columns=_columns,
    measures=_measures,
    labels=_labels,
    faces=beam_faces,
    stock=_stock,
)

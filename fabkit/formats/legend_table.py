"""The legend of the tables: signs, ends, frames and units, for whoever has nothing but the folder."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fabkit.kinds import BEAM, NODE, PANEL
from fabkit.parts import Frame, Kind
from fabkit.production import Table

__all__ = ["legend"]

_UNITS = ("Units", "Lengths in mm, areas in m2, angles in degrees, masses in kg. Directions are unit vectors.")
_SIGNS = (
    (
        "Piece",
        "Name of one physical piece: its mark, and the number of its edge (e), vertex (v) or face (f) of the mesh, "
        "counted from 0: B001 e7. Where several pieces of a mark have the same, the second is B001 e7.2. The instances "
        "in model.step have the same names.",
    ),
    ("left out", "In place of a piece that was not made."),
    ("Outside", "The side from which the faces of the mesh run counter-clockwise; node axes point outwards."),
    ("End A, end B", "The ends of a beam at node A and at node B."),
    ("Cut angle", "Angle of a saw cut at an end from a square cut, positive where the outer side is the longer one."),
    (
        "Ends",
        "Beam seen from the side, outer side up, end A on the left: \\_/ is longest outside, /_\\ longest inside, "
        "|_| is cut square.",
    ),
    (
        "Long point, short point",
        "Along the axis of a beam, from the point of end A that is furthest out to that of end B, and between the "
        "points that are furthest in.",
    ),
    (
        "Section",
        "Height first: flat 120x50 height x width; rhs 120x60x5 with its wall, r10 the outer radius of its corners; "
        "tee and i 120x80x10x8 height x width of the flange x flange x web, the flange of a tee outside; chs 60.3x4 "
        "diameter x wall; round 60 diameter.",
    ),
    ("Dihedral", "Angle between the outward normals of two faces, positive where the surface is convex."),
    ("Facet, edge, corner", "Counted from 1, counter-clockwise seen from outside. Corner k is the start of edge k."),
    ("Azimuth", "Direction of a beam about the node axis, from facet 1, counter-clockwise seen from outside."),
    ("Inclination", "Angle of a beam's axis above the plane perpendicular to the node axis."),
    ("Setback", "Distance of a facet from the node axis."),
    ("Facet top, facet bottom", "Levels of the middles of its upper and lower side, from the point on the mesh."),
    ("Top, bottom", "Heights of the ends of a node block along its axis, from the point on the mesh."),
    ("Sheet x, y, turn", "Place of a panel on its sheet: its own frame is turned counter-clockwise, then moved."),
    (
        "Turned over",
        "A panel that shares the mark of its mirror image: z of its own frame points inwards, and its edges count "
        "clockwise seen from outside.",
    ),
    (
        "Hidden",
        "Largest difference of a piece from the shape of its mark: of its corners in each coordinate, and of the far "
        "ends of the beams on it by the directions of its facets. All pieces of a mark are made alike.",
    ),
    ("least, largest", "Of all pieces of a mark, where a value depends on the place of a piece."),
)


_OWN_FRAME = (
    "The frame in which a piece is made and in which parts/MARK.step has it. Placements give its origin and two of its "
    "axes in the coordinates of the mesh file; the y axis is the cross product of z and x."
)


def legend(site: Frame | None = None, kinds: Sequence[Kind[Any]] = ()) -> Table:
    """What signs, ends, frames and units in the tables mean.

    site: the frame of the mesh file on the site; kinds: of the parts that there are, by default beams, nodes, panels.

    >>> from fabkit.formats import legend
    >>> table = legend()
    >>> table.columns, table.rows[1][0], table.rows[1][1][-24:]
    (('Sign', 'Meaning'), 'Mark', 'B beam, N node, P panel.')
    """
    shown = kinds or (BEAM, NODE, PANEL)
    letters = ", ".join(f"{kind.letter} {kind.name}" for kind in shown)
    mark = f"Name that equal pieces share, stamped on each of them. Its letters say the kind: {letters}."
    frames: dict[str, list[str]] = {}
    for kind in shown:
        if kind.frame:
            frames.setdefault(kind.frame, []).append(kind.group)
    of_kinds = [(f"Own frame of {', '.join(groups)}", frame) for frame, groups in frames.items()]
    rows = (_UNITS, ("Mark", mark), *_SIGNS, ("Own frame", _OWN_FRAME), *of_kinds, ("Site", _of_site(site)))
    return Table("legend", ("Sign", "Meaning"), (None, None), rows)


def _of_site(site: Frame | None) -> str:
    if site is None:
        return "Points to set out (survey) have the coordinates of the mesh file, in mm, as all others have."
    vectors = [", ".join(f"{number + 0.0:.9f}" for number in axis) for axis in site.axes]
    origin = ", ".join(f"{number + 0.0:.3f}" for number in site.origin)
    return (
        "Points to set out (survey), their axes and facets are in the coordinates of the site, all others in those of "
        f"the mesh file, in mm. Zero of the mesh file is at ({origin}) on the site, and its x, y and z axes run along "
        f"({vectors[0]}), ({vectors[1]}) and ({vectors[2]})."
    )

"""The legend of the tables: signs, ends, frames and units, for whoever has nothing but the folder."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fabkit.kinds import BEAM, NODE, PANEL
from fabkit.parts import Column, Frame, Kind
from fabkit.production import Table

__all__ = ["legend"]

_UNITS = ("Units", "Lengths in mm, areas in m2, angles in degrees, masses in kg. Directions are unit vectors.")
_FILES = (
    "Files",
    "parts/MARK.step: the solid of a mark in its own frame. drawings/MARK.dxf: beams and nodes, 1:1. panels, "
    "plates: contours to cut; sheets: those of panels, nested. model.step, model.glb, report.html: all "
    "pieces in place. CSV files: the tables of cutlist.xlsx, and those with a row for each piece, facet or edge.",
)
_SIGNS = (
    ("Not said here", "Welds, surface treatment and tolerances: see the specification of the project."),
    (
        "Piece",
        "Name of one physical piece: its mark, and the number of its edge (e), vertex (v) or face (f) of the mesh, "
        "counted from 0: B001 e7. Where several pieces of a mark have the same, the second is B001 e7.2. The instances "
        "in model.step have the same names.",
    ),
    ("Node, Beam, Panel, Neighbour", "Names of pieces: where it belongs, what stands there, the panel across an edge."),
    ("Node A, Facet A", "Where end A of a beam stands; of other pieces the node to which they belong."),
    ("Node B, Facet B, End", "Where end B of a beam stands; at a facet the end of the beam that meets it, A or B."),
    ("Element", "Number of the edge, vertex or face, counted from 0."),
    ("Kind, Group", "Of a piece: beam, node, panel and so on; of a second layer with lower or upper before it."),
    ("Count", "Number of pieces with this mark."),
    ("Mass, Area", "Of all pieces of a mark; each: of one of them."),
    ("Material", "Its name; glass as the trade writes it: 44.2 is 4 + 4 mm with two interlayers of 0.38 mm."),
    ("Build-up", "Of the glass of a layer, from outside to inside: 16Ar is a cavity of 16 mm with argon."),
    ("Edge work", "Of all edges of a panel, in the words of EN 12150-1; as they are cut where there is none."),
    ("Coating, Coated side", "Number of a coated surface, counted from outside, two a ply; on which side of the pane."),
    ("left out", "In place of a piece that was not made."),
    ("File", "Of the mark: its solid, or of a panel its contour."),
    ("Outside", "The side from which the faces of the mesh run counter-clockwise; node axes point outwards."),
    (
        "Section",
        "Height first, which stands along z: flat 120x50 height x width; rhs 120x60x5 with its wall, r10 the outer "
        "radius of its corners; tee and i 120x80x10x8 height x width of the flange x flange x web, "
        "the flange of a tee outside; chs 60.3x4 diameter x wall; round 60 diameter.",
    ),
    (
        "End A, End B",
        "The ends of a beam, at node A and at node B. In degrees: the saw cut there from a square cut, turned about y, "
        "positive where the outer side is the longer one.",
    ),
    (
        "Ends",
        "|_| is cut square, \\_/ is longest outside, /_\\ longest inside: the beam seen from the side, outer side up, "
        "end A on the left.",
    ),
    (
        "Long point, Short point",
        "Of a beam along x: from the point of end A that is furthest out to that of end B, to which stock is cut, and "
        "between the points that are furthest in.",
    ),
    ("Flange long point, Flange short point", "Of a tee on hubs the same lengths of its flange."),
    ("Flange back at A, Flange back at B", "How far that is cut back along x at either end."),
    (
        "Hand hole at A, Hand hole at B",
        "Middle of the hole along x from the long point at that end, seen from which it is in the left side.",
    ),
    ("Bevel", "Of a mitred edge of a panel, from the square cut, positive where the upper side reaches further."),
    ("Dihedral", "Angle between the outward normals of two faces, positive where the surface is convex."),
    ("Height deviation", "Distance of the two parallel meshes at a beam, less the height of its section."),
    (
        "Goes in from, Gap from outside",
        "Side from which a beam goes straight in between two nodes that stand; the gap that it needs at each end to go "
        "in from outside.",
    ),
    ("Origin, X axis, Z axis, Centre", "Of the own frame of a piece, and its centre of mass."),
    ("Valence", "Number of beams at a node."),
    ("Height, Thickness", "Of a node block along its axis; of a panel across edge 1, and of its plate."),
    (
        "Could be mounted",
        "Turned, or upside down, without looking wrong: such a node has a dot in its outer end, 10 mm from facet 1, "
        "5 mm wide and 2 mm deep, where there is room for it.",
    ),
    ("Step between tops", "Largest difference in level between the tops of the beams at a node, at their ends."),
    ("Axis misalignment", "Largest distance on the node axis between the points in which the beams' sides meet it."),
    (
        "Facet",
        "Side of a node, parallel to its axis, on which a beam stands; counted from 1, counter-clockwise seen from "
        "outside. Its middle lies at the setback from the axis in the direction of the azimuth; flats join neighbours.",
    ),
    ("Edge, Corner", "Of a panel, counted from 1, as facets are. Corner k is the start of edge k."),
    ("Azimuth", "Direction of a beam about the node axis, from facet 1, counter-clockwise seen from outside."),
    ("Inclination", "Angle of a beam's axis above the plane perpendicular to the node axis."),
    ("Setback", "Distance of a facet from the node axis."),
    (
        "Beam level",
        "Level in which the middle of a beam's outer side meets the facet, from the point on the mesh.",
    ),
    (
        "Facet top, Facet bottom, Facet width",
        "Levels of the middles of its upper and lower side, from the point on the mesh, and its width.",
    ),
    ("Top, Bottom", "Heights of the ends of a node block along its axis, from the point on the mesh."),
    (
        "Bolts, Bolt size",
        "Their number, and their thread and length. All bores are in parts/MARK.step and, 1:1, in drawings/MARK.dxf.",
    ),
    (
        "Point, Axis, Facet 1",
        "Of a node: its point on the mesh of the beams, its axis outwards, and the direction of facet 1.",
    ),
    ("Width, Diagonal 1, Diagonal 2", "Of a panel: along edge 1; from corner 1 to corner 3, and from 2 to 4."),
    (
        "Length, Diameter, Side",
        "Of an edge of a panel, a strut, stub, fin or dowel; of a dowel or cap; of a base plate.",
    ),
    ("Lean", "Angle between the plane of a fin and that of the beam at its edge."),
    ("Size, Bores", "Of a bolt: thread and length. Of a base plate: number and diameter of its holes."),
    (
        "Bolt bores, Bolt bore, Bolt pitch",
        "Of an end plate: number and diameter of the bores for bolts; distance of two, one on each side of its middle.",
    ),
    (
        "Dowel bore, Dowel below middle",
        "Of an end plate: diameter of the bore; how far inwards from the middle it lies.",
    ),
    ("Support, Stub", "Names of a base plate, and of the piece between it and its node."),
    ("Layer, Pane", "Of a panel: its layer, and its pane in the build-up of that, both counted from the outermost, 0."),
    ("Seat", "Free height between a panel and what stands highest under it along an edge."),
    ("Step", "How far the outer side of the neighbour stands above that of a panel at their joint."),
    ("Sheet", "Of stock on which a panel is nested, counted from 1."),
    ("Sheet x, Sheet y, Sheet turn", "Place of a panel there: its own frame is turned counter-clockwise, then moved."),
    ("CUT, MARK, SHEET, TITLE", "Layers of contours: to cut, without allowance for the kerf; to engrave; stock; text."),
    ("VISIBLE, HIDDEN, LABEL", "Layers of drawings: edges that are seen, and not; letters of ends, numbers of facets."),
    ("Arrow", "On panels: from corner 1 along edge 1."),
    (
        "Turned over",
        "A panel that shares the mark of its mirror image: z of its own frame points inwards, and its edges count "
        "clockwise seen from outside.",
    ),
    (
        "Order, Closing",
        "Number in the order of erection, the same for what goes up together; whether a beam comes last between two "
        "nodes that stand.",
    ),
    ("Zone", "Part of the structure; zones are put up one after the other. Between two of them: of the first one."),
    (
        "Hidden difference, Hidden at far ends",
        "Largest difference of a piece from the shape of its mark: of its corners in each coordinate, and of the far "
        "ends of the beams on it by the directions of its facets. All pieces of a mark are made alike.",
    ),
    ("Least, Largest", "Of all pieces of a mark, where a value depends on the place of a piece."),
    ("mark_points.csv", "Shapes of all marks, for a later build that keeps them; not for the workshop."),
)
_MARK = (
    "Name that equal pieces share, stamped on each of them; on the outer side of a beam beside end A, and on the outer "
    "end of a node beside facet 1, it also says which is which."
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
    >>> table.columns, table.rows[2][0], table.rows[2][1][:24]
    (('Sign', 'Meaning'), 'Mark', 'B beam, N node, P panel.')
    """
    shown = kinds or (BEAM, NODE, PANEL)
    letters = ", ".join(f"{kind.letter} {kind.name}" for kind in shown)
    mark = f"{letters}. {_MARK}"
    frames: dict[str, list[str]] = {}
    for kind in shown:
        if kind.frame:
            frames.setdefault(kind.frame, []).append(kind.group)
    of_kinds = [(f"Own frame of {', '.join(groups)}", frame) for frame, groups in frames.items()]
    rows = (_FILES, _UNITS, ("Mark", mark), *_SIGNS, ("Own frame", _OWN_FRAME), *of_kinds, ("Site", _of_site(site)))
    signs, meanings = zip(*rows, strict=True)
    return Table("legend", (Column("Sign", None, signs), Column("Meaning", None, meanings)))


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

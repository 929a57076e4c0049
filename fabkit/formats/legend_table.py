"""The legend of the tables: signs, ends, frames and units, for whoever has nothing but the folder."""

from __future__ import annotations

from fabkit.parts import Frame
from fabkit.production import Table

__all__ = ["legend"]

_ROWS = (
    ("Units", "Lengths in mm, areas in m2, angles in degrees, masses in kg. Directions are unit vectors."),
    ("Mark", "Name that equal pieces share: B001 a beam, N001 a node block, P001 a panel. Stamped on each of them."),
    (
        "Piece",
        "Name of one physical piece: its mark, and the number of its edge (e), vertex (v) or face (f) of the mesh, "
        "counted from 0: B001 e7. The instances in model.step have the same names.",
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
    ("Long point, short point", "Largest and smallest length of a beam along its axis."),
    ("Dihedral", "Angle between the outward normals of two faces, positive where the surface is convex."),
    (
        "Frame of a beam",
        "Origin in the outer middle of end A at its cut, x from end A to end B, z outwards in the central plane.",
    ),
    ("Frame of a node", "Origin at the vertex of the mesh, z along the node axis outwards, x towards facet 1."),
    (
        "Frame of a panel",
        "Origin at corner 1, x along edge 1, the longest; z outwards; the plate lies between z = 0 and its thickness.",
    ),
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


def legend(site: Frame | None = None) -> Table:
    """What signs, ends, frames and units in the tables mean. site: the frame of the mesh file on the site.

    >>> from fabkit.formats import legend
    >>> table = legend()
    >>> table.columns, table.rows[0][0]
    (('Sign', 'Meaning'), 'Units')
    """
    return Table("legend", ("Sign", "Meaning"), (None, None), (*_ROWS, ("Site", _of_site(site))))


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

"""Exact solids of the OCCT kernel, which build123d and CadQuery bring."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from fabkit.parts import SHAFT, Measures, Solid

if TYPE_CHECKING:
    from OCP.Geom import Geom_Curve, Geom_CylindricalSurface
    from OCP.Geom2d import Geom2d_Curve
    from OCP.gp import gp_Dir, gp_Pnt
    from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Solid, TopoDS_Wire

__all__ = ["occt_solid"]

OCCT_TOLERANCE_MM = 1e-7
"""Distance in mm up to which points are one for OCCT: its own default."""


def occt_solid(solid: Solid) -> TopoDS_Solid:
    """The solid with shared vertices and edges, on planes and cylinders through its faces; nothing is
    approximated or healed, but the angles and heights of oblique edges on cylinders, which OCCT keeps as splines."""
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Shell, TopoDS_Solid

    builder, made = BRep_Builder(), _OcctFaces(solid)
    shell, occt = TopoDS_Shell(), TopoDS_Solid()
    builder.MakeShell(shell)
    for face in np.setdiff1d(np.arange(solid.topology.n_faces), solid.topology.fillets[:, 0]).tolist():
        builder.Add(shell, made.plane_face(face))
    for k in range(len(solid.topology.rounds)):
        builder.Add(shell, made.round_face(k))
    for k in range(len(solid.topology.fillets)):
        builder.Add(shell, made.fillet_face(k))
    shell.Closed(True)
    builder.MakeSolid(occt)
    builder.Add(occt, shell)
    return occt


class _OcctFaces:
    """The faces of a solid with shared vertices and edges. circles: the edges of the first and second end of each
    round, counter-clockwise seen from outside their planar faces."""

    def __init__(self, solid: Solid) -> None:
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeVertex
        from OCP.gp import gp_Dir, gp_Pnt

        self.topology, of = solid.topology, Measures(solid.topology, solid.vertices[None])
        self.points: list[gp_Pnt] = [gp_Pnt(*point) for point in solid.vertices.tolist()]
        self.vertices = [BRepBuilderAPI_MakeVertex(point).Vertex() for point in self.points]
        self.normals: list[gp_Dir] = [gp_Dir(*normal) for normal in solid.normals.tolist()]
        self.axes: list[gp_Dir] = [gp_Dir(*axis) for axis in of.round_axes[:, 0].T.tolist()]
        self.across: list[gp_Dir] = [gp_Dir(*across) for across in of.round_across[:, 0].T.tolist()]
        self.radii, self.lengths = of.radii[0].tolist(), of.lengths[0].tolist()
        self.leans = of.leans[:, 0].T.tolist()
        self.half_axes = np.sqrt((of.rims[:, :, 0] ** 2).sum(axis=1)).T.tolist()
        self.edges: dict[tuple[int, int], TopoDS_Edge] = {}
        seams = self.topology.rounds[:, 1:4:2].tolist()
        for low, high in [*self.topology.edges.tolist(), *seams]:
            edge = BRepBuilderAPI_MakeEdge(self.vertices[low], self.vertices[high]).Edge()
            self.edges[low, high], self.edges[high, low] = edge, edge.Reversed()
        self.curves: dict[tuple[int, int], Geom_Curve] = {}  # of the end of each round
        self.circles = [(self._circle(k, 0), self._circle(k, 1)) for k in range(len(seams))]
        self.arcs: list[list[TopoDS_Edge]] = []  # of the ends of each fillet
        self._add_fillets(of)

    def _is_oblique(self, k: int, end: int) -> bool:
        return bool(abs(self.leans[k][end]) > OCCT_TOLERANCE_MM)

    def _circle(self, k: int, end: int) -> TopoDS_Edge:
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
        from OCP.Geom import Geom_Circle, Geom_Ellipse
        from OCP.gp import gp_Ax2

        centre, rim = self.topology.rounds[k, 2 * end : 2 * end + 2]
        place = gp_Ax2(self.points[centre], self.normals[self.topology.rounds[k, 4 + end]], self.across[k])
        if self._is_oblique(k, end):
            self.curves[k, end] = Geom_Ellipse(place, self.half_axes[k][end], self.radii[k])
        else:
            self.curves[k, end] = Geom_Circle(place, self.radii[k])
        return BRepBuilderAPI_MakeEdge(self.curves[k, end], self.vertices[rim], self.vertices[rim]).Edge()

    def _add_fillets(self, of: Measures) -> None:
        """The arcs of all fillets, counter-clockwise seen from outside the planar faces in which they lie."""
        from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
        from OCP.Geom import Geom_Circle, Geom_Ellipse
        from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt

        t, own = self.topology, of.fillets
        radii, leans = own.radii[0].tolist(), own.leans[:, 0].tolist()
        centres = (np.moveaxis(own.centres[:, :, 0], 1, 2) + of.middles[0]).tolist()
        self.fillet_places: list[tuple[gp_Ax3, float]] = []
        for k in range(len(t.fillets)):
            away = gp_Dir(*own.reference[:, 0, k].tolist())
            self.arcs.append([])
            for end in (0, 1):
                place = gp_Ax2(gp_Pnt(*centres[end][k]), self.normals[t.fillet_ends[k, end]], away)
                major = float(np.hypot(leans[end][k], radii[k]))
                is_oblique = leans[end][k] > OCCT_TOLERANCE_MM
                curve = Geom_Ellipse(place, major, radii[k]) if is_oblique else Geom_Circle(place, radii[k])
                tail, head = t.fillet_corners[k, 2 * end : 2 * end + 2][:: -t.fillets[k, 3]].tolist()
                edge = BRepBuilderAPI_MakeEdge(curve, self.vertices[tail], self.vertices[head]).Edge()
                self.edges[tail, head], self.edges[head, tail] = edge, edge.Reversed()
                self.arcs[k].append(edge)
            axis = gp_Dir(*own.axes[:, 0, k].tolist())
            self.fillet_places.append((gp_Ax3(gp_Pnt(*centres[0][k]), axis, away), radii[k]))

    def fillet_face(self, k: int) -> TopoDS_Face:
        """A quarter of a cylinder, with its arcs and straight sides laid on it."""
        from OCP.BRep import BRep_Builder, BRep_Tool
        from OCP.BRepAdaptor import BRepAdaptor_Curve
        from OCP.Geom import Geom_CylindricalSurface
        from OCP.GeomProjLib import GeomProjLib
        from OCP.TopLoc import TopLoc_Location
        from OCP.TopoDS import TopoDS_Face

        builder, made, place = BRep_Builder(), TopoDS_Face(), TopLoc_Location()
        surface = Geom_CylindricalSurface(*self.fillet_places[k])
        builder.MakeFace(made, surface, OCCT_TOLERANCE_MM)
        (loop,) = map(list, self.topology.loops(int(self.topology.fillets[k, 0])))
        sides = [self.edges[min(pair), max(pair)] for pair in ((loop[1], loop[2]), (loop[0], loop[3]))]
        for edge in [*self.arcs[k], *sides]:
            curve = BRepAdaptor_Curve(edge)
            first, last = curve.FirstParameter(), curve.LastParameter()
            laid = GeomProjLib.Curve2d_s(BRep_Tool.Curve_s(edge, first, last), first, last, surface)
            builder.UpdateEdge(edge, laid, surface, place, OCCT_TOLERANCE_MM)
        is_shaft = self.topology.fillets[k, 3] == SHAFT
        around = [*loop, loop[0]] if is_shaft else [loop[0], *loop[::-1]]  # seen against the normal of the cylinder
        builder.Add(made, _wire([self.edges[pair] for pair in pairwise(around)]))
        return made if is_shaft else made.Reversed()

    def plane_face(self, face: int) -> TopoDS_Face:
        from OCP.BRep import BRep_Builder
        from OCP.Geom import Geom_Plane
        from OCP.TopoDS import TopoDS_Face

        t, builder, made = self.topology, BRep_Builder(), TopoDS_Face()
        plane = Geom_Plane(self.points[t.face_vertex[face]], self.normals[face])
        builder.MakeFace(made, plane, OCCT_TOLERANCE_MM)
        for loop in map(list, t.loops(face)):
            builder.Add(made, _wire([self.edges[pair] for pair in pairwise([*loop, loop[0]])]))
        for k, end in np.argwhere(t.rounds[:, 4:6] == face).tolist():
            circle = self.circles[k][end]
            builder.Add(made, _wire([circle if t.outer_round[face] == k else circle.Reversed()]))
        return made

    def round_face(self, k: int) -> TopoDS_Face:
        """A cylinder, with its edges laid on it: round the first end, up the line of the rims, back round the second
        end, and down."""
        from OCP.BRep import BRep_Builder
        from OCP.Geom import Geom_CylindricalSurface
        from OCP.gp import gp_Ax3
        from OCP.TopLoc import TopLoc_Location
        from OCP.TopoDS import TopoDS_Face

        builder, made, place = BRep_Builder(), TopoDS_Face(), TopLoc_Location()
        first, first_rim, _, second_rim, *_, sense = self.topology.rounds[k].tolist()
        surface = Geom_CylindricalSurface(gp_Ax3(self.points[first], self.axes[k], self.across[k]), self.radii[k])
        builder.MakeFace(made, surface, OCCT_TOLERANCE_MM)
        loop = []
        for end in (0, 1):
            turn = 1 if self.normals[self.topology.rounds[k, 4 + end]].Dot(self.axes[k]) > 0 else -1
            circle = self.circles[k][end]
            builder.UpdateEdge(circle, self._on_cylinder(k, end, turn, surface), surface, place, OCCT_TOLERANCE_MM)
            loop.append(circle if turn == (1, -1)[end] else circle.Reversed())
        seam = self.edges[first_rim, second_rim]
        low, high = _line(0.0, self.leans[k][0], 0.0, 1.0), _line(2 * np.pi, self.leans[k][0], 0.0, 1.0)
        builder.UpdateEdge(seam, high, low, surface, place, OCCT_TOLERANCE_MM)
        builder.Add(made, _wire([loop[0], seam, loop[1], self.edges[second_rim, first_rim]]))
        return made if sense == SHAFT else made.Reversed()

    def _on_cylinder(self, k: int, end: int, turn: int, surface: Geom_CylindricalSurface) -> Geom2d_Curve:
        """The edge of an end in angle and height on its cylinder, turning with the angle (1) or against it (-1)."""
        from OCP.GeomProjLib import GeomProjLib

        if self._is_oblique(k, end):
            return GeomProjLib.Curve2d_s(self.curves[k, end], 0.0, 2 * np.pi, surface)
        return _line(0.0 if turn > 0 else 2 * np.pi, end * self.lengths[k], float(turn), 0.0)


def _line(u: float, v: float, along_u: float, along_v: float) -> Geom2d_Curve:
    from OCP.Geom2d import Geom2d_Line
    from OCP.gp import gp_Dir2d, gp_Pnt2d

    return Geom2d_Line(gp_Pnt2d(u, v), gp_Dir2d(along_u, along_v))


def _wire(edges: list[TopoDS_Edge]) -> TopoDS_Wire:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Wire

    builder, wire = BRep_Builder(), TopoDS_Wire()
    builder.MakeWire(wire)
    for edge in edges:
        builder.Add(wire, edge)
    wire.Closed(True)
    return wire

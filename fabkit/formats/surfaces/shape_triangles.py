"""Triangles on the faces of shapes of the OCCT kernel, which build123d and CadQuery bring: faces sewn together, edges
divided to one length, all vertices on the faces."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from fabkit.errors import FabkitError
from geometry.arrays import FloatArray, IntArray, floats

if TYPE_CHECKING:
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.TopoDS import TopoDS_Face, TopoDS_Shape

__all__ = ["VANISHING_TANGENT", "ShapeTriangles", "shape_triangles", "tangents"]

SEWING_SHARE = 1e-4
"""Gap between faces that are sewn together, over the size of the shape: what exporters leave of trimmed edges."""

ANGULAR_DEFLECTION = 0.5
"""Of the first triangles, in radians between normals; what is longer than wanted is divided afterwards."""

LONG_EDGE_RATIO = 1.3
"""Length of an edge over the wanted one, from which on it is divided: both halves are nearer to what is wanted."""

LONGEST_SIDE_SHARE = 0.7
"""Length of an edge over the longest one of its triangles, below which those are divided first."""

MAX_DIVISIONS = 40
"""Rounds of dividing edges; each takes at least the longest ones."""

VANISHING_TANGENT = 1e-7
"""Length of a derivative of a face over that of the other one, below which it is taken for zero: at a pole, where
lines of one parameter meet."""


@dataclass(frozen=True, eq=False)
class ShapeTriangles:
    """Triangles (T, 3) on the faces of a shape, with vertices (N, 3).

    faces: of the kernel. face (T,): of each triangle; parameters (T, 3, 2): of its corners on that face. sides (T,): 1
    where the normal of the face is outwards, -1 where inwards.
    """

    vertices: FloatArray
    triangles: IntArray
    faces: tuple[BRepAdaptor_Surface, ...]
    face: IntArray
    parameters: FloatArray
    sides: FloatArray


def shape_triangles(shape: TopoDS_Shape, edge_length: Callable[[float], float], name: str) -> ShapeTriangles:
    """The faces of a shape, sewn together and triangulated. edge_length: of the triangles, for the area of the shape.

    Raises FabkitError where there is no face.
    """
    points, triangles, face, parameters, adaptors, sides = _triangulated(_sewn(shape, name))
    vertices, triangles = _welded(points, triangles)
    kept = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)  # others were at the pole of a face
    triangles, face, parameters = triangles[kept], face[kept], _filled(parameters[kept])
    corners = vertices[triangles]
    doubled = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    length = edge_length(float(doubled.sum()) / 2)
    vertices, triangles, face, parameters = _divided(vertices, triangles, face, parameters, adaptors, length)
    used, numbered = np.unique(triangles, return_inverse=True)
    triangles = np.asarray(numbered).reshape(-1, 3)
    return ShapeTriangles(vertices[used], triangles, adaptors, face, floats(parameters), floats(sides[face]))


def tangents(faces: Sequence[BRepAdaptor_Surface], uv: FloatArray) -> FloatArray:
    """(3, n, 3) a point of each of n faces, and its derivatives."""
    from OCP.gp import gp_Pnt, gp_Vec

    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    found = []
    for face, (u, v) in zip(faces, uv.tolist(), strict=True):
        face.D1(u, v, point, du, dv)
        found.append((point.X(), point.Y(), point.Z(), du.X(), du.Y(), du.Z(), dv.X(), dv.Y(), dv.Z()))
    return np.array(found, dtype=np.float64).reshape(-1, 3, 3).swapaxes(0, 1).copy()


def _faces(shape: TopoDS_Shape) -> Iterator[TopoDS_Face]:
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    as_face = getattr(TopoDS, "Face_s", None) or TopoDS.Face  # its name before and since OCCT 8
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        yield as_face(explorer.Current())
        explorer.Next()


def _sewn(shape: TopoDS_Shape, name: str) -> TopoDS_Shape:
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Sewing

    faces = list(_faces(shape))
    if not faces:
        raise FabkitError(f"{name} has no faces: export the surface, not its curves or points")
    if len(faces) == 1:
        return faces[0]
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    sewing = BRepBuilderAPI_Sewing(SEWING_SHARE * float(np.sqrt(box.SquareExtent())))
    for face in faces:
        sewing.Add(face)
    sewing.Perform()
    return sewing.SewedShape()


def _triangulated(
    shape: TopoDS_Shape,
) -> tuple[FloatArray, IntArray, IntArray, FloatArray, tuple[BRepAdaptor_Surface, ...], FloatArray]:
    """Points (P, 3), triangles (T, 3), their faces (T,), parameters (T, 3, 2), the faces (n) and their sides (n,)."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_REVERSED
    from OCP.TopLoc import TopLoc_Location

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box)
    BRepMesh_IncrementalMesh(shape, 0.01 * float(np.sqrt(box.SquareExtent())), False, ANGULAR_DEFLECTION, True)
    points: list[tuple[float, float, float]] = []
    triangles, owner, parameters, adaptors, sides = [], [], [], [], []
    for number, face in enumerate(_faces(shape)):
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, location)
        if mesh is None:
            raise FabkitError(
                f"face {number} of the shape (counted from 0) cannot be triangulated; repair or remove it"
            )
        motion, first = location.Transformation(), len(points)
        nodes = [mesh.Node(k).Transformed(motion) for k in range(1, mesh.NbNodes() + 1)]
        points += [(node.X(), node.Y(), node.Z()) for node in nodes]
        uv = np.array([(mesh.UVNode(k).X(), mesh.UVNode(k).Y()) for k in range(1, mesh.NbNodes() + 1)])
        corners = np.array([mesh.Triangle(k).Get() for k in range(1, mesh.NbTriangles() + 1)]) - 1
        side = -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0
        corners = corners[:, ::-1] if side < 0 else corners
        adaptors.append(BRepAdaptor_Surface(face))
        triangles.append(first + corners)
        owner.append(np.full(len(corners), number))
        parameters.append(_without_poles(adaptors[-1], uv)[corners])
        sides.append(side)
    return (
        floats(points),
        np.concatenate(triangles),
        np.concatenate(owner),
        np.concatenate(parameters),
        tuple(adaptors),
        floats(sides),
    )


def _without_poles(face: BRepAdaptor_Surface, uv: FloatArray) -> FloatArray:
    """Parameters (P, 2), nan where it does not matter what they are: all of them stand for the same point."""
    _, du, dv = tangents([face] * len(uv), uv)
    sizes = np.stack([np.linalg.norm(du, axis=1), np.linalg.norm(dv, axis=1)], axis=1)
    return np.where(sizes < VANISHING_TANGENT * sizes[:, ::-1], np.nan, uv)


def _filled(parameters: FloatArray) -> FloatArray:
    """(T, 3, 2): where they do not matter, those in the middle of the two other corners."""
    others = (np.roll(parameters, 1, axis=1) + np.roll(parameters, -1, axis=1)) / 2
    return np.where(np.isnan(parameters), others, parameters)


def _welded(points: FloatArray, triangles: IntArray) -> tuple[FloatArray, IntArray]:
    """Points of neighbouring faces in one place are one."""
    distance = SEWING_SHARE * float(np.linalg.norm(np.ptp(points, axis=0)))
    pairs = KDTree(points).query_pairs(distance, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points), len(points)))
    count, label = connected_components(graph, directed=False)
    first = np.full(count, len(points))
    np.minimum.at(first, label, np.arange(len(points)))
    return points[first], np.asarray(label[triangles])


def _divided(
    vertices: FloatArray,
    triangles: IntArray,
    face: IntArray,
    parameters: FloatArray,
    adaptors: tuple[BRepAdaptor_Surface, ...],
    length: float,
) -> tuple[FloatArray, IntArray, IntArray, FloatArray]:
    """Edges that are too long are halved, in both of their triangles alike, by points of the exact faces."""
    for _ in range(MAX_DIVISIONS):
        ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
        edges, edge = np.unique(np.sort(ends.reshape(-1, 2), axis=1), axis=0, return_inverse=True)
        edge = edge.reshape(-1, 3)
        lengths = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
        longest = lengths[edge].max(axis=1)
        beside = np.zeros(len(edges))
        np.maximum.at(beside, edge, np.broadcast_to(longest[:, None], edge.shape))
        halved = (lengths > LONG_EDGE_RATIO * length) & (lengths >= LONGEST_SIDE_SHARE * beside)
        if not halved.any():
            break
        number = np.full(len(edges), -1)
        number[halved] = len(vertices) + np.arange(np.count_nonzero(halved))
        middle_uv = (parameters + np.roll(parameters, -1, axis=1)) / 2
        owner = np.full(len(edges), -1)
        owner[edge.ravel()[::-1]] = np.arange(edge.size)[::-1]  # the first side of each edge
        at = owner[halved]
        added = [
            _point(adaptors[f], u, v)
            for f, (u, v) in zip(face[at // 3].tolist(), middle_uv.reshape(-1, 2)[at].tolist(), strict=True)
        ]
        vertices = np.concatenate([vertices, floats(added)])
        triangles, face, parameters = _split(triangles, face, parameters, number[edge], middle_uv)
    return vertices, triangles, face, parameters


def _point(face: BRepAdaptor_Surface, u: float, v: float) -> tuple[float, float, float]:
    point = face.Value(u, v)
    return point.X(), point.Y(), point.Z()


def _split(
    triangles: IntArray, face: IntArray, parameters: FloatArray, middle: IntArray, middle_uv: FloatArray
) -> tuple[IntArray, IntArray, FloatArray]:
    """middle (T, 3): the new vertex on each side, -1 where there is none. Side k runs from corner k to the next one."""
    count = (middle >= 0).sum(axis=1)
    turn = np.where(count == 2, ((middle < 0).argmax(axis=1) + 1) % 3, (middle >= 0).argmax(axis=1))
    order = (turn[:, None] + np.arange(3)) % 3  # with one: its side is first; with two: the whole side is last
    rows = np.arange(len(triangles))[:, None]
    six = np.concatenate([triangles[rows, order], middle[rows, order]], axis=1)  # a b c, then on ab, bc, ca
    six_uv = np.concatenate([parameters[rows, order], middle_uv[rows, order]], axis=1)
    pieces = {0: [[0, 1, 2]], 1: [[0, 3, 2], [3, 1, 2]], 2: [[3, 1, 4], [0, 3, 4], [0, 4, 2]]}
    pieces[3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]]
    found = [(np.flatnonzero(count == n), corners) for n, parts in pieces.items() for corners in parts]
    return (
        np.concatenate([six[own][:, corners] for own, corners in found]),
        np.concatenate([face[own] for own, _ in found]),
        np.concatenate([six_uv[own][:, corners] for own, corners in found]),
    )

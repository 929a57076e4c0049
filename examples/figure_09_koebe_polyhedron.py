"""A Koebe polyhedron, its circles and a vertex cone [Pottmann2007, 3.2, Fig. 9].

The edges of S touch the unit sphere. Faces intersect it in circles (red), and the cones from the vertices touch it
along circles (blue); one cone is shown. Where an edge touches the sphere, the circles of its two faces touch each
other, the circles of its two vertices touch each other, and the two pairs are orthogonal. S has the combinatorics of
the dual of a snub cube, 24 pentagons; a Moebius transformation enlarged those on one side.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from docs.tools.drawing import (
    BLUE,
    CLAY,
    GOLD,
    INK,
    LINEN,
    Label,
    Panel,
    Shapes,
    View,
    balls,
    draw_page,
    polygons,
    sphere,
    tubes,
)
from geometry import edge_distances
from geometry.arrays import FloatArray, IntArray
from geometry.edge_offset.koebe_polyhedra import KoebePolyhedron, SphereCircles, koebe
from geometry.mesh import solids
from geometry.mesh.tilings import dual
from geometry.spheres.moebius import MoebiusTransformation

VIEW = View(-62, 24)
NEAR = 0.42
"""Radius of the close-up, in radians."""


@cache
def polyhedron() -> KoebePolyhedron:
    even = koebe(dual(solids.snub_cube().combinatorics)).mesh
    return KoebePolyhedron(even).mapped(MoebiusTransformation.boost((-0.16, 0.22, -0.12)))


def tangents(circles: SphereCircles, neighbours: IntArray) -> FloatArray:
    """(E, 2, 3) unit tangents of two circles for each edge at its point of tangency."""
    across = np.cross(circles.normals[neighbours], polyhedron().tangency_points[:, None])
    return np.asarray(across / np.linalg.norm(across, axis=2, keepdims=True))


def off_circles(circles: SphereCircles, neighbours: IntArray) -> float:
    """The largest distance of points of tangency from the planes of their two circles."""
    heights = np.einsum("ecx,ex->ec", circles.normals[neighbours], polyhedron().tangency_points)
    return float(np.abs(heights - circles.distances[neighbours]).max())


def main() -> dict[str, float]:
    k = polyhedron()
    c = k.mesh.combinatorics
    of_faces, of_vertices = tangents(k.face_circles, c.edge_faces), tangents(k.vertex_circles, c.edges)
    touching = [np.linalg.norm(np.cross(each[:, 0], each[:, 1]), axis=1).max() for each in (of_faces, of_vertices)]
    across = np.einsum("efx,evx->efv", of_faces, of_vertices)
    return {
        "vertices": k.mesh.n_vertices,
        "edges": k.mesh.n_edges,
        "faces": k.mesh.n_faces,
        "largest deviation of an edge from distance 1": float(np.abs(edge_distances(k.mesh) - 1).max()),
        "largest distance of points of tangency from the circles of faces": off_circles(k.face_circles, c.edge_faces),
        "largest distance of points of tangency from the circles of vertices": off_circles(k.vertex_circles, c.edges),
        "largest sine between circles of neighbouring faces": float(touching[0]),
        "largest sine between circles of neighbouring vertices": float(touching[1]),
        "largest cosine between circles of faces and vertices": float(np.abs(across).max()),
        "least radius of a face circle": float(k.face_circles.radii.min()),
        "largest radius of a face circle": float(k.face_circles.radii.max()),
    }


def rings(circles: SphereCircles, n: int = 96) -> FloatArray:
    """(k, n, 2, 3) segments of circles."""
    x = np.cross(circles.normals, np.eye(3)[np.abs(circles.normals).argmin(axis=1)])
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(circles.normals, x)
    angles = np.linspace(0, 2 * np.pi, n + 1)[:, None]
    ring = np.cos(angles) * x[:, None] + np.sin(angles) * y[:, None]
    points = circles.centres[:, None] + circles.radii[:, None, None] * ring
    return np.asarray(np.stack([points[:, :-1], points[:, 1:]], axis=2))


def cone(vertex: int) -> Shapes:
    """From a vertex to its circle."""
    k = polyhedron()
    circle = rings(k.vertex_circles)[vertex]
    apex = k.mesh.vertices[vertex]
    corners = np.stack([np.broadcast_to(apex, (len(circle), 3)), circle[:, 0], circle[:, 1]], axis=1)
    normals = circle.mean(axis=1, keepdims=True).repeat(3, axis=1)
    return [polygons(corners, GOLD, normals=normals, opacity=0.55)]


def towards(azimuth: float, elevation: float) -> FloatArray:
    return np.asarray(View(azimuth, elevation).axes[2])


def whole(vertex: int) -> Shapes:
    k = polyhedron()
    edges = k.mesh.vertices[k.mesh.combinatorics.edges]
    circles = [
        *tubes(rings(k.face_circles).reshape(-1, 2, 3), 0.009, CLAY, sides=6),
        *tubes(rings(k.vertex_circles).reshape(-1, 2, 3), 0.007, BLUE, sides=6),
    ]
    points = balls(k.tangency_points, 0.02, INK)
    return [*sphere(1.0, LINEN), *tubes(edges, 0.011, INK, sides=8), *circles, *points, *cone(vertex)]


def cap(centre: FloatArray, radius: float) -> Shapes:
    """The part of the unit sphere within an angle from a point."""
    x = np.cross(centre, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    y = np.cross(centre, x)
    away, around = np.meshgrid(np.linspace(0, radius, 13), np.linspace(0, 2 * np.pi, 97), indexing="ij")
    flat = np.cos(around)[..., None] * x + np.sin(around)[..., None] * y
    points = np.cos(away)[..., None] * centre + np.sin(away)[..., None] * flat
    corners = np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2).reshape(-1, 4, 3)
    return [polygons(corners, LINEN, normals=corners)]


def inside_circle(centre: FloatArray, touch: FloatArray) -> FloatArray:
    """A little inside a circle, on the way from one of its points to its centre."""
    inwards = centre - touch
    return np.asarray(touch + 0.24 * inwards / np.linalg.norm(inwards))


def close_up(edge: int) -> tuple[Shapes, list[Label]]:
    """About the point of tangency of an edge."""
    k = polyhedron()
    c = k.mesh.combinatorics
    touch = k.tangency_points[edge]
    ends, sides = c.edges[edge], c.edge_faces[edge]

    def near(segments: FloatArray) -> FloatArray:
        return np.asarray(segments[segments.mean(axis=1) @ touch > np.cos(NEAR)])

    shapes = cap(touch, NEAR)
    shapes += tubes(near(rings(k.face_circles, 360)[sides].reshape(-1, 2, 3)), 0.006, CLAY, sides=8)
    shapes += tubes(near(rings(k.vertex_circles, 360)[ends].reshape(-1, 2, 3)), 0.006, BLUE, sides=8)
    shapes += tubes(k.mesh.vertices[ends][None], 0.007, INK)
    shapes += balls(k.mesh.vertices[ends], 0.016, INK)
    shapes += balls(touch[None], 0.014, INK)
    labels = [Label(touch, r"$\mathbf{t}_e$", (-10, 44), size=25)]
    for vertex, n, beside in zip(ends, "ij", [(72, 60), (-26, -34)], strict=True):
        labels.append(Label(k.mesh.vertices[vertex], rf"$\mathbf{{s}}_{n}$", (0, 20), size=25))
        inside = inside_circle(k.vertex_circles.centres[vertex], touch)
        labels.append(Label(inside, rf"$c_{{\mathbf{{s}}_{n}}}$", beside, BLUE, 25))
    for face, n in zip(sides, "lr", strict=True):
        labels.append(
            Label(inside_circle(k.face_circles.centres[face], touch), rf"$c_{{F_{n}}}$", colour=CLAY, size=25)
        )
    return shapes, labels


def draw(path: Path) -> None:
    k = polyhedron()
    vertex = int((k.vertex_circles.normals @ towards(VIEW.azimuth + 66, 22)).argmax())
    edge = int((k.tangency_points @ towards(-48, 10)).argmax())
    shapes, labels = close_up(edge)
    x, y, z = k.tangency_points[edge]
    near = View(np.degrees(np.arctan2(y, x)), np.degrees(np.arcsin(z)) - 8)
    panels = [
        Panel(whole(vertex), VIEW, (20, 10, 700, 620)),
        Panel(shapes, near, (800, 70, 560, 500), labels),
    ]
    draw_page(path, 1400, 640, panels)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_09.png")
    print(main())

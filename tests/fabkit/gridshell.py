"""A small gridshell, made by hand: parts as they come from detailing, without detailing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
from scipy.spatial import ConvexHull

from fabkit.kinds import BEAM, NODE, PANEL, BeamDetails, NodeDetails, PanelDetails
from fabkit.parts import (
    Assembly,
    Finish,
    Frame,
    LeftOut,
    Material,
    Part,
    Section,
    Solid,
    prism_topology,
    prism_vertices,
)
from fabkit.production.summary import GivenGaussImage, Summary
from geometry.arrays import FloatArray, IntArray
from tests.fabkit.assemblies import assembled

__all__ = ["gridshell", "gridshell_summary"]

STEEL = Material("S355", 7850.0)
GLASS = Material("glass", 2500.0)
SECTION = Section("flat", (120.0, 50.0))
SETBACK = 45.0
THICKNESS = 12.0
LIFT = 8.0


class Marks:
    """Equal shapes share a mark and a solid."""

    def __init__(self, letter: str) -> None:
        self.letter = letter
        self.known: dict[bytes, tuple[str, Solid]] = {}

    def of(self, vertices: FloatArray) -> tuple[str, Solid]:
        key = np.round(vertices, 3).tobytes()
        if key not in self.known:
            topology = prism_topology(len(vertices) // 2)
            self.known[key] = (f"{self.letter}{len(self.known) + 1}", Solid(vertices, topology))
        return self.known[key]


def unit(vectors: FloatArray) -> FloatArray:
    lengths: FloatArray = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / lengths


def net(nx: int, ny: int, cell: float) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Vertices, normals, edges, faces of a translation surface: each quad is a parallelogram, so it is planar."""
    i, j = np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), indexing="ij")
    x, y = (i - nx / 2).ravel() * cell, (j - ny / 2).ravel() * cell
    bend = 0.9 / (max(nx, ny) * cell)
    vertices = np.stack([x, y, 4000 - bend * (x**2 + 0.6 * y**2)], axis=1)
    normals = unit(np.stack([2 * bend * x, 1.2 * bend * y, np.ones_like(x)], axis=1))
    number = (i * (ny + 1) + j).astype(np.int64)
    along = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    across = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    faces = np.stack([corner.ravel() for corner in corners], axis=1)
    return vertices, normals, np.concatenate([along, across]), faces


def beam(vertices: FloatArray, normals: FloatArray, marks: Marks, edge: int, ends: IntArray) -> Part:
    start, end = vertices[ends]
    t = unit(end - start)
    axes = normals[ends]
    u = unit(axes.mean(axis=0) - axes.mean(axis=0) @ t * t)
    slopes = (axes @ t) / (axes @ u)
    span = float(np.linalg.norm(end - start))
    height, half = SECTION.height_mm, SECTION.width_mm / 2
    bottom = np.array([SETBACK - slopes[0] * height, span - SETBACK - slopes[1] * height])
    side = np.array([[SETBACK, 0.0], [bottom[0], -height], [bottom[1], -height], [span - SETBACK, 0.0]])
    raised = prism_vertices(side - [SETBACK, 0.0], -half, half)
    mark, solid = marks.of(raised @ np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]))
    cuts = np.degrees(np.arctan(slopes)) * [-1, 1]
    top, low = span - 2 * SETBACK, float(bottom[1] - bottom[0])
    return Part(
        kind=BEAM,
        mark=mark,
        solid=solid,
        placement=Frame(start + SETBACK * t, np.stack([t, np.cross(u, t), u])),
        material=STEEL,
        element=edge,
        details=BeamDetails(
            nodes=(int(ends[0]), int(ends[1])),
            section=SECTION,
            cut_angles_deg=(float(cuts[0]), float(cuts[1])),
            end_gaps_mm=(0.0, 0.0),
            going_in_gaps_mm=(0.0, 0.0),
            long_point_mm=max(top, low),
            short_point_mm=min(top, low),
            flange_points_mm=(np.nan, np.nan),
            flange_backs_mm=(np.nan, np.nan),
            hand_holes_mm=(np.nan, np.nan),
            dihedral_deg=float(np.degrees(np.arccos(np.clip(axes[0] @ axes[1], -1, 1)))),
            height_deviation_mm=height * (float(np.mean(axes @ u)) - 1),
            twist_deg=0.0,
        ),
    )


def node(vertices: FloatArray, normals: FloatArray, marks: Marks, vertex: int, edges: dict[int, int]) -> Part:
    """edges: neighbouring vertex -> edge."""
    axis = normals[vertex]
    towards = {n: unit(vertices[n] - vertices[vertex]) for n in edges}
    x = unit(towards[min(edges)] - towards[min(edges)] @ axis * axis)
    frame = Frame(vertices[vertex], np.stack([x, np.cross(axis, x), axis]))
    azimuths = {n: float(np.arctan2(*(frame.axes[[1, 0]] @ t))) % (2 * np.pi) for n, t in towards.items()}
    order = sorted(edges, key=lambda n: round(azimuths[n], 9))
    half = SECTION.width_mm / 2
    corners = []
    for n in order:
        c, s = np.cos(azimuths[n]), np.sin(azimuths[n])
        corners += [[SETBACK * c + half * s, SETBACK * s - half * c], [SETBACK * c - half * s, SETBACK * s + half * c]]
    outline = np.array(corners)
    outline = outline[ConvexHull(outline).vertices]
    outline = np.roll(outline, -int(np.lexsort((outline[:, 1], -outline[:, 0]))[0]), axis=0)
    inclinations = [float(np.degrees(np.arcsin(towards[n] @ axis))) for n in order]
    mark, solid = marks.of(prism_vertices(outline, -SECTION.height_mm - 5.0, 5.0))
    return Part(
        kind=NODE,
        mark=mark,
        solid=solid,
        placement=frame,
        material=STEEL,
        element=vertex,
        details=NodeDetails(
            beams=tuple(edges[n] for n in order),
            azimuths_deg=tuple(float(np.degrees(azimuths[n])) for n in order),
            inclinations_deg=tuple(inclinations),
            setbacks_mm=(SETBACK,) * len(order),
            uncovered_percent=(0.0,) * len(order),
            height_mm=SECTION.height_mm + 10.0,
            axis_misalignment_mm=SECTION.height_mm * float(np.ptp(1 / np.cos(np.radians(inclinations)))),
            top_step_mm=SETBACK * float(np.ptp(np.sin(np.radians(inclinations)))),
        ),
    )


def panel(vertices: FloatArray, marks: Marks, face: int, corners: IntArray, edges: Sequence[int]) -> Part:
    ring = vertices[corners]
    centre = ring.mean(axis=0)
    inset = centre + (ring - centre) * (1 - 20.0 / np.linalg.norm(ring - centre, axis=1).mean())
    x = unit(inset[1] - inset[0])
    normal = unit(np.cross(ring[2] - ring[0], ring[3] - ring[1]))
    frame = Frame(inset[0] + LIFT * normal, np.stack([x, np.cross(normal, x), normal]))
    outline = frame.to_local(inset)[:, :2]
    ahead = np.roll(outline, -1, axis=0) - outline
    lengths = np.linalg.norm(ahead, axis=1)
    turn = np.degrees(np.arctan2(*np.roll(ahead, 1, axis=0).T[::-1]) - np.arctan2(*ahead.T[::-1]))
    mark, solid = marks.of(prism_vertices(outline, 0.0, THICKNESS))
    return Part(
        kind=PANEL,
        mark=mark,
        solid=solid,
        placement=frame,
        material=GLASS,
        element=face,
        details=PanelDetails(
            layer=0,
            pane=0,
            finish=Finish(),
            thickness_mm=THICKNESS,
            underside_mm=LIFT,
            area_mm2=solid.volume_mm3 / THICKNESS,
            edge_lengths_mm=tuple(lengths.tolist()),
            corner_angles_deg=tuple(((180 + turn) % 360).tolist()),
            dihedrals_deg=(5.0,) * 4,
            least_seats_mm=(np.nan,) * 4,
            largest_seats_mm=(np.nan,) * 4,
            steps_mm=(np.nan,) * 4,
            beams=tuple(edges),
            neighbours=(-1,) * 4,
        ),
    )


def gridshell(
    nx: int = 6, ny: int = 5, *, name: str = "Gridshell", cell: float = 1500.0, left_out: int = 0
) -> Assembly:
    """nx times ny cells. left_out: how many beams, taken from the end, are left out."""
    vertices, normals, edges, faces = net(nx, ny, cell)
    number = {tuple(sorted(pair)): edge for edge, pair in enumerate(edges.tolist())}
    neighbours: dict[int, dict[int, int]] = {}
    for (i, j), edge in number.items():
        neighbours.setdefault(i, {})[j] = edge
        neighbours.setdefault(j, {})[i] = edge
    made = edges[: len(edges) - left_out]
    one_beam = partial(beam, vertices, normals, Marks("B"))
    one_node = partial(node, vertices, normals, Marks("N"))
    one_panel = partial(panel, vertices, Marks("P"))
    around = [[number[tuple(sorted(p))] for p in zip(f, [*f[1:], f[0]], strict=True)] for f in faces.tolist()]
    return assembled(
        name=name,
        beams=tuple(one_beam(edge, ends) for edge, ends in enumerate(made)),
        nodes=tuple(one_node(vertex, neighbours[vertex]) for vertex in range(len(vertices))),
        panels=tuple(one_panel(face, corners, around[face]) for face, corners in enumerate(faces)),
        left_out=tuple(
            LeftOut("beam", edge, f"edge {edge}: no room beside its neighbour") for edge in range(len(made), len(edges))
        ),
    )


def left_out_lines(nx: int = 6, ny: int = 5, *, cell: float = 1500.0, left_out: int) -> FloatArray:
    """(left_out, 2, 3) ends of the edges whose beams `gridshell` leaves out."""
    vertices, _, edges, _ = net(nx, ny, cell)
    lines: FloatArray = vertices[edges[len(edges) - left_out :]]
    return lines


def gridshell_summary(nx: int = 6, ny: int = 5, *, name: str = "Gridshell", mended: tuple[str, ...] = ()) -> Summary:
    vertices, _, edges, faces = net(nx, ny, 1500.0)
    lengths = np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
    return Summary(
        name=name,
        source="roof.obj",
        scale_mm=1000.0,
        n_vertices=len(vertices),
        n_edges=len(edges),
        n_faces=len(faces),
        n_boundaries=1,
        mended=mended,
        planarity_before=2.4e-3,
        planarity_after=3.1e-12,
        largest_move_mm=4.7,
        mean_move_mm=0.9,
        farthest_vertex=17,
        edge_lengths_mm=lengths,
        heights=1 + 0.01 * np.sin(np.arange(len(edges))),
        leans_deg=2 + np.cos(np.arange(len(vertices))),
        twists_deg=np.zeros(len(edges)),
        underside_mm=LIFT,
        underside_reason="the widest beam under the sharpest fold, 5.8 mm, and a seat of 2 mm",
        gauss_image=GivenGaussImage("roof-gauss.obj", sha256=64 * "7", largest_move=2e-7, mean_move=1e-7),
    )

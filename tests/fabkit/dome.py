"""A dome made by hand, in which everything fits exactly: parts as they come from detailing, without detailing."""

from __future__ import annotations

import numpy as np

from fabkit.kinds import BEAM, NODE, PANEL, BeamDetails, NodeDetails, PanelDetails
from fabkit.parts import (
    Assembly,
    Finish,
    Frame,
    Material,
    Part,
    Section,
    Solid,
    prism_topology,
    prism_vertices,
)
from geometry.arrays import FloatArray, IntArray
from tests.fabkit.assemblies import assembled

__all__ = ["CENTRE", "LIFT", "dome"]

STEEL, GLASS = Material("steel", 7850.0), Material("glass", 2500.0)
WIDTH, HEIGHT, SETBACK, LIFT, THICKNESS = 50.0, 120.0, 45.0, 12.0, 10.0
CENTRE = 4
"""The vertex in the middle of `dome(2)`; its beams are 1, 4, 7 and 10."""


def net(n: int, cell: float) -> tuple[FloatArray, FloatArray, IntArray, IntArray]:
    """Vertices, axes, edges and faces of n times n cells between circles of longitude and latitude of a sphere: all
    faces are planar, and the sphere of radius 1 carries a parallel mesh."""
    step = min(0.1, 1.6 / n)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij"))
    east, north = (i - n / 2) * step, (j - n / 2) * step
    axes = np.stack([np.cos(north) * np.cos(east), np.cos(north) * np.sin(east), np.sin(north)], axis=1)
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    along = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    across = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    faces = np.stack([corner.ravel() for corner in corners], axis=1)
    return axes * cell / step, axes, np.concatenate([along, across]), faces


def unit(vector: FloatArray) -> FloatArray:
    length: FloatArray = np.linalg.norm(vector)
    return vector / length


def make_beam(edge: int, ends: IntArray, points: FloatArray, axes: FloatArray) -> tuple[Part, FloatArray]:
    """The beam, and the levels of its ends' corners along the axes of its two nodes (2, 2)."""
    start, end = points[ends]
    t = unit(end - start)
    u = unit(axes[ends[0]] - axes[ends[0]] @ t * t)
    slope = np.array([a @ t / (a @ u) for a in axes[ends]])
    reach = np.array([SETBACK / (a @ u) for a in axes[ends]])
    levels = np.array([0.0, -HEIGHT])
    length = float(np.linalg.norm(end - start))
    x = np.stack([reach[0] + slope[0] * levels, length - reach[1] + slope[1] * levels])
    side = np.array([[x[0, 0], 0.0], [x[0, 1], -HEIGHT], [x[1, 1], -HEIGHT], [x[1, 0], 0.0]]) - [x[0, 0], 0.0]
    prism = prism_vertices(side, -WIDTH / 2, WIDTH / 2)
    beam = Part(
        kind=BEAM,
        mark=f"B{edge}",
        solid=Solid(prism[:, [0, 2, 1]] * [1.0, -1.0, 1.0], prism_topology(4)),
        placement=Frame(start + x[0, 0] * t, np.stack([t, np.cross(u, t), u])),
        material=STEEL,
        element=edge,
        details=BeamDetails(
            nodes=(int(ends[0]), int(ends[1])),
            section=Section("flat", (HEIGHT, WIDTH)),
            cut_angles_deg=(0.0, 0.0),
            end_gaps_mm=(0.0, 0.0),
            going_in_gaps_mm=(0.0, 0.0),
            long_point_mm=float(np.ptp(x)),
            short_point_mm=float(np.ptp(x)),
            flange_points_mm=(np.nan, np.nan),
            flange_backs_mm=(np.nan, np.nan),
            hand_holes_mm=(np.nan, np.nan),
            dihedral_deg=0.0,
            height_deviation_mm=0.0,
            twist_deg=0.0,
        ),
    )
    from_nodes = np.stack([x[0], x[1] - length])
    along = axes[ends]
    return beam, from_nodes * (along @ t)[:, None] + levels * (along @ u)[:, None]


def make_node(
    vertex: int,
    edges: list[int],
    towards: FloatArray,
    point: FloatArray,
    axis: FloatArray,
    levels: FloatArray,
    notched: bool,
) -> Part:
    """With notches between the facets, or convex."""
    x = unit(towards[0] - towards[0] @ axis * axis)
    frame = Frame(point, np.stack([x, np.cross(axis, x), axis]))
    azimuths = np.mod(np.arctan2(towards @ frame.axes[1], towards @ x) + 1e-9, 2 * np.pi) - 1e-9
    order = np.argsort(azimuths)
    outline = []
    for k, azimuth in enumerate(azimuths[order]):
        ahead = np.array([np.cos(azimuth), np.sin(azimuth)])
        left = np.array([-ahead[1], ahead[0]])
        outline += [SETBACK * ahead - WIDTH / 2 * left, SETBACK * ahead + WIDTH / 2 * left]
        gap = azimuths[order[(k + 1) % len(order)]] - azimuth
        if notched and 0 < gap < 2:
            outline.append(WIDTH * 0.75 * np.array([np.cos(azimuth + gap / 2), np.sin(azimuth + gap / 2)]))
    return Part(
        kind=NODE,
        mark=f"N{vertex}",
        solid=Solid(prism_vertices(np.array(outline), levels.min(), levels.max()), prism_topology(len(outline))),
        placement=frame,
        material=STEEL,
        element=vertex,
        details=NodeDetails(
            beams=tuple(edges[k] for k in order),
            azimuths_deg=tuple(np.degrees(azimuths[order]).tolist()),
            inclinations_deg=(0.0,) * len(edges),
            setbacks_mm=(SETBACK,) * len(edges),
            uncovered_percent=(0.0,) * len(edges),
            height_mm=float(np.ptp(levels)),
            top_step_mm=0.0,
            axis_misalignment_mm=0.0,
        ),
    )


def make_panel(face: int, corners: FloatArray, beams: tuple[int, ...]) -> Part:
    centre = corners.mean(axis=0)
    z = unit(np.cross(corners[2] - corners[0], corners[3] - corners[1]))
    x = unit(corners[1] - corners[0])
    frame = Frame(centre + LIFT * z, np.stack([x, np.cross(z, x), z]))
    outline = (0.98 * (corners - centre) @ frame.axes.T)[:, :2]
    return Part(
        kind=PANEL,
        mark=f"P{face}",
        solid=Solid(prism_vertices(outline, 0.0, THICKNESS), prism_topology(4)),
        placement=frame,
        material=GLASS,
        element=face,
        details=PanelDetails(
            layer=0,
            pane=0,
            finish=Finish(),
            thickness_mm=THICKNESS,
            underside_mm=LIFT,
            area_mm2=0.0,
            edge_lengths_mm=(0.0,) * 4,
            corner_angles_deg=(0.0,) * 4,
            dihedrals_deg=(0.0,) * 4,
            least_seats_mm=(np.nan,) * 4,
            largest_seats_mm=(np.nan,) * 4,
            steps_mm=(np.nan,) * 4,
            beams=beams,
            neighbours=(-1,) * 4,
        ),
    )


def dome(n: int = 2, *, cell: float = 1500.0, notched: bool = False) -> Assembly:
    """n times n cells of a sphere, in which everything fits exactly."""
    points, axes, edges, faces = net(n, cell)
    made = [make_beam(edge, ends, points, axes) for edge, ends in enumerate(edges)]
    around: dict[int, list[tuple[int, int, FloatArray]]] = {}
    for edge, (i, j) in enumerate(edges.tolist()):
        around.setdefault(i, []).append((edge, j, made[edge][1][0]))
        around.setdefault(j, []).append((edge, i, made[edge][1][1]))
    nodes = []
    for vertex in range(len(points)):
        own = around[vertex]
        towards = np.array([unit(points[other] - points[vertex]) for _, other, _ in own])
        levels = np.array([level for _, _, level in own])
        own_edges = [edge for edge, _, _ in own]
        nodes.append(make_node(vertex, own_edges, towards, points[vertex], axes[vertex], levels, notched))
    number = {frozenset(ends): edge for edge, ends in enumerate(edges.tolist())}
    around_faces = [[number[frozenset((c[k], c[k - 3]))] for k in range(4)] for c in faces.tolist()]
    panels = tuple(make_panel(face, points[corners], tuple(around_faces[face])) for face, corners in enumerate(faces))
    return assembled("dome", tuple(beam for beam, _ in made), tuple(nodes), panels)

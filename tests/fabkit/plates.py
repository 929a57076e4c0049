"""Panels, beams and nodes made by hand, and random outlines, for nests, drawings and lists."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from hypothesis import strategies as st

from fabkit.kinds import BEAM, NODE, PANEL, BeamDetails, NodeDetails, PanelDetails
from fabkit.parts import (
    Finish,
    Frame,
    Material,
    Part,
    Parts,
    Section,
    Solid,
    prism_topology,
    prism_vertices,
)
from geometry.arrays import FloatArray
from tests.fabkit.assemblies import altered

__all__ = ["bar", "block", "outlines", "plate", "plates"]

GLASS = Material("glass", 2500.0)
STEEL = Material("S355", 7850.0)


def own_frame(outline: FloatArray) -> FloatArray:
    """The outline moved and turned so that its longest edge comes first and lies along x from the origin."""
    edges = np.roll(outline, -1, axis=0) - outline
    first = int(np.linalg.norm(edges, axis=1).argmax())
    c, s = edges[first] / np.linalg.norm(edges[first])
    return (np.roll(outline, -first, axis=0) - outline[first]) @ np.array([[c, -s], [s, c]])


def plate(
    mark: str,
    outline: FloatArray,
    *,
    element: int = 0,
    neighbours: Sequence[int] | None = None,
    thickness: float = 8.0,
    dihedrals: Sequence[float] | None = None,
) -> Part:
    n = len(outline)
    ahead = np.roll(outline, -1, axis=0) - outline
    directions = np.arctan2(ahead[:, 1], ahead[:, 0])
    corners = np.degrees(np.pi - (directions - np.roll(directions, 1))) % 360
    solid = Solid(prism_vertices(np.asarray(outline, dtype=float), 0.0, thickness), prism_topology(n))
    return Part(
        kind=PANEL,
        mark=mark,
        solid=solid,
        placement=Frame.world(),
        material=GLASS,
        element=element,
        details=PanelDetails(
            layer=0,
            pane=0,
            finish=Finish(),
            thickness_mm=thickness,
            underside_mm=10.0,
            area_mm2=solid.volume_mm3 / thickness,
            edge_lengths_mm=tuple(np.linalg.norm(ahead, axis=1).tolist()),
            corner_angles_deg=tuple(corners.tolist()),
            dihedrals_deg=tuple(dihedrals or [5.0] * n),
            least_seats_mm=(np.nan,) * n,
            largest_seats_mm=(np.nan,) * n,
            steps_mm=(np.nan,) * n,
            beams=tuple(range(n)),
            neighbours=tuple(neighbours or [-1] * n),
        ),
    )


def plates(some: Sequence[FloatArray]) -> Parts[PanelDetails]:
    return Parts.of(PANEL, [plate(f"P{k + 1:03d}", own_frame(outline), element=k) for k, outline in enumerate(some)])


@st.composite
def outlines(draw: st.DrawFn, least: float = 60.0, largest: float = 900.0) -> FloatArray:
    """Counter-clockwise polygons, star-shaped about the origin, convex or not, 3 to 9 corners, in millimetres."""
    n = draw(st.integers(3, 9))
    radii = np.array(draw(st.lists(st.floats(least, largest), min_size=n, max_size=n)))
    bends = np.array(draw(st.lists(st.floats(-0.3, 0.3), min_size=n, max_size=n)))
    angles = 2 * np.pi * (np.arange(n) + bends) / n + draw(st.floats(0, 6))
    return radii[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def bar(mark: str, element: int, nodes: tuple[int, int], **changes: object) -> Part:
    """A square bar of 50 x 120 x 1000 mm, but for the changes."""
    outline = np.array([[0.0, -25.0], [1000.0, -25.0], [1000.0, 25.0], [0.0, 25.0]])
    made = Part(
        kind=BEAM,
        mark=mark,
        solid=Solid(prism_vertices(outline, -120.0, 0.0), prism_topology(4)),
        placement=Frame.world(),
        material=STEEL,
        element=element,
        details=BeamDetails(
            nodes=nodes,
            section=Section("flat", (120.0, 50.0)),
            cut_angles_deg=(0.0, 0.0),
            end_gaps_mm=(0.0, 0.0),
            going_in_gaps_mm=(0.0, 0.0),
            long_point_mm=1000.0,
            short_point_mm=1000.0,
            flange_points_mm=(np.nan, np.nan),
            flange_backs_mm=(np.nan, np.nan),
            hand_holes_mm=(np.nan, np.nan),
            dihedral_deg=5.0,
            height_deviation_mm=0.0,
            twist_deg=0.0,
        ),
    )
    return altered(made, **changes)


def block(mark: str, element: int, beams: tuple[int, ...], **changes: object) -> Part:
    """A square block of 80 x 80 x 130 mm, but for the changes."""
    square = np.array([[-40.0, -40.0], [40.0, -40.0], [40.0, 40.0], [-40.0, 40.0]])
    n = len(beams)
    made = Part(
        kind=NODE,
        mark=mark,
        solid=Solid(prism_vertices(square, -125.0, 5.0), prism_topology(4)),
        placement=Frame.world(),
        material=STEEL,
        element=element,
        details=NodeDetails(
            beams=beams,
            azimuths_deg=tuple(360.0 * k / n for k in range(n)),
            inclinations_deg=(-2.5,) * n,
            setbacks_mm=(40.0,) * n,
            uncovered_percent=(0.0,) * n,
            height_mm=130.0,
            top_step_mm=0.5,
            axis_misalignment_mm=0.25,
        ),
    )
    return altered(made, **changes)

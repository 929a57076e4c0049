"""What can be measured on each part: for colours, histograms and facts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.parts import Assembly, Beam, Node, Panel
from geometry.arrays import FloatArray, floats

__all__ = ["Measure", "measures"]


@dataclass(frozen=True, eq=False)
class Measure:
    """One number for each part of a group, in the group's order.

    values (n,), NaN where there is none; decimals: how many are worth showing; signed: whether zero is the aim and
    both signs occur.
    """

    group: str
    title: str
    unit: str
    decimals: int
    values: FloatArray
    signed: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "values", floats(self.values))


def measures(assembly: Assembly) -> tuple[Measure, ...]:
    """The measures of all groups that have parts."""
    beams, nodes, panels = assembly.beams, assembly.nodes, assembly.panels
    return (
        *(_of_beams(beams) if beams else ()),
        *(_of_nodes(nodes) if nodes else ()),
        *(_of_panels(panels) if panels else ()),
    )


def _of_beams(beams: tuple[Beam, ...]) -> tuple[Measure, ...]:
    steepest = np.abs([beam.cut_angles_deg for beam in beams]).max(axis=1)
    deviation = floats([beam.height_deviation_mm for beam in beams])
    return (
        Measure("beams", "Long-point length", "mm", 1, floats([beam.long_point_mm for beam in beams])),
        Measure("beams", "Height deviation", "mm", 2, deviation, signed=True),
        Measure("beams", "Fold over a beam", "°", 2, floats([beam.dihedral_deg for beam in beams]), signed=True),
        Measure("beams", "Steeper end cut", "°", 2, steepest),
        Measure("beams", "Mass of a beam", "kg", 2, floats([beam.mass_kg for beam in beams])),
    )


def _of_nodes(nodes: tuple[Node, ...]) -> tuple[Measure, ...]:
    return (
        Measure("nodes", "Beam tops out of level", "mm", 2, floats([node.top_spread_mm for node in nodes])),
        Measure("nodes", "Beam sides apart on the axis", "mm", 2, floats([node.axis_spread_mm for node in nodes])),
        Measure("nodes", "Largest setback", "mm", 1, floats([max(node.setbacks_mm) for node in nodes])),
        Measure("nodes", "Least angle of beams", "°", 1, floats([_smallest_gap(node) for node in nodes])),
        Measure("nodes", "Height of a node", "mm", 1, floats([node.height_mm for node in nodes])),
        Measure("nodes", "Mass of a node", "kg", 2, floats([node.mass_kg for node in nodes])),
    )


def _of_panels(panels: tuple[Panel, ...]) -> tuple[Measure, ...]:
    folds = [max((abs(d) for d in panel.dihedrals_deg if not np.isnan(d)), default=np.nan) for panel in panels]
    return (
        Measure("panels", "Area", "m²", 3, floats([panel.area_mm2 for panel in panels]) / 1e6),
        Measure("panels", "Longest edge", "mm", 1, floats([max(panel.edge_lengths_mm) for panel in panels])),
        Measure("panels", "Smallest corner", "°", 1, floats([min(panel.corner_angles_deg) for panel in panels])),
        Measure("panels", "Sharpest fold", "°", 2, floats(folds)),
        Measure("panels", "Mass of a panel", "kg", 1, floats([panel.mass_kg for panel in panels])),
    )


def _smallest_gap(node: Node) -> float:
    """Degrees between neighbouring beams about the axis; NaN for fewer than two beams."""
    if len(node.azimuths_deg) < 2:
        return float("nan")
    return float(np.diff([*node.azimuths_deg, node.azimuths_deg[0] + 360.0]).min())

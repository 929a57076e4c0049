"""Cut lists: what to make of each kind, a row a mark, as data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from fabkit.parts import Assembly, Beam, Node, Panel, Part
from fabkit.production.neighbours import NOTHING, marks_by_element, neighbour_marks, panel_neighbours
from fabkit.production.nests import Nest

__all__ = ["Cell", "CutList", "Table", "cut_list", "ends_glyph"]

Cell = str | int | float | None

#: An end whose angle rounds to zero in the list is cut square.
ANGLE_DECIMALS = 2


@dataclass(frozen=True)
class Table:
    """Rows of cells. title: in one word, in small letters.

    columns: names with their units. decimals: to which the numbers of each column are to be shown; None for columns
    of text. totals: one cell a column, None where there is nothing to add up. left_out: sentences about the parts
    that are missing.
    """

    title: str
    columns: tuple[str, ...]
    decimals: tuple[int | None, ...]
    rows: tuple[tuple[Cell, ...], ...]
    totals: tuple[Cell, ...]
    left_out: tuple[str, ...]

    @cached_property
    def texts(self) -> tuple[tuple[str, ...], ...]:
        """The rows as text: numbers with the decimals of their column, nothing where there is none."""
        columns = zip(*self.rows, strict=True)
        return tuple(zip(*map(_texts, columns, self.decimals), strict=True))

    @cached_property
    def total_texts(self) -> tuple[str, ...]:
        """The totals as text."""
        return tuple(_texts([cell], decimals)[0] for cell, decimals in zip(self.totals, self.decimals, strict=True))


@dataclass(frozen=True)
class CutList:
    """One table for each kind of part; together their counts are the number of parts."""

    beams: Table
    nodes: Table
    panels: Table

    @property
    def tables(self) -> tuple[Table, ...]:
        return self.beams, self.nodes, self.panels


P = TypeVar("P", bound=Part)

#: A column: its name, the decimals of its numbers (None for text), and its cell for the equal parts of one mark.
Column = tuple[str, int | None, Callable[[Sequence[P]], Cell]]


def cut_list(assembly: Assembly, nest: Nest | None) -> CutList:
    """Beams, nodes and panels in the order of their marks' first parts.

    Equal parts share a row. What depends on where a part stands (its neighbours, its dihedral angles) is then given
    for all of them: a range of numbers, or one text for each place. The files named are those of the mark: its STEP,
    for panels its DXF.
    """
    beams = _table("beams", assembly, assembly.beams, _beam_columns(assembly))
    nodes = _table("nodes", assembly, assembly.nodes, _node_columns(assembly))
    panels = _table("panels", assembly, assembly.panels, _panel_columns(assembly, nest))
    return CutList(beams, nodes, panels)


def ends_glyph(cut_angles_deg: tuple[float, float]) -> str:
    r"""The beam seen from the side, its outer side up and end A on the left: \_/ is longest outside, |_| square."""
    first, second = (0.0 if abs(angle) < 0.5 * 10**-ANGLE_DECIMALS else angle for angle in cut_angles_deg)
    return "/|\\"[int(np.sign(first)) + 1] + "_" + "\\|/"[int(np.sign(second)) + 1]


def _table(title: str, assembly: Assembly, parts: Sequence[P], columns: Sequence[Column[P]]) -> Table:
    groups: dict[str, list[P]] = {}
    for part in parts:
        groups.setdefault(part.mark, []).append(part)
    names, decimals, cells = zip(*columns, strict=True)
    rows = tuple(tuple(cell(group) for cell in cells) for group in groups.values())
    totals: dict[str, Cell] = {"Mark": "Total", "Count": len(parts)}
    for name in ("Mass (kg)", "Area (m2)"):
        if name in names:
            totals[name] = float(sum(row[names.index(name)] for row in rows))
    left_out = tuple(f"left out: {part.reason}" for part in assembly.left_out if part.kind == title.removesuffix("s"))
    return Table(title, names, decimals, rows, tuple(totals.get(name) for name in names), left_out)


def _beam_columns(assembly: Assembly) -> list[Column[Beam]]:
    nodes = marks_by_element(assembly.nodes)
    return [
        ("Mark", None, _mark),
        ("Count", 0, len),
        ("Section", None, lambda beams: beams[0].section.name),
        ("Material", None, lambda beams: beams[0].material.name),
        ("Long point (mm)", 2, lambda beams: beams[0].long_point_mm),
        ("Short point (mm)", 2, lambda beams: beams[0].short_point_mm),
        ("End A (deg)", ANGLE_DECIMALS, lambda beams: beams[0].cut_angles_deg[0]),
        ("End B (deg)", ANGLE_DECIMALS, lambda beams: beams[0].cut_angles_deg[1]),
        ("Ends", None, lambda beams: ends_glyph(beams[0].cut_angles_deg)),
        ("Nodes A B", None, lambda beams: _places(" ".join(neighbour_marks(b.nodes, nodes)) for b in beams)),
        ("Dihedral (deg)", 2, lambda beams: _range([beam.dihedral_deg for beam in beams], 2)),
        ("Height deviation (mm)", 3, lambda beams: _range([beam.height_deviation_mm for beam in beams], 3)),
        ("Mass each (kg)", 3, lambda beams: beams[0].mass_kg),
        ("Mass (kg)", 3, lambda beams: len(beams) * beams[0].mass_kg),
        ("File", None, _step_file),
    ]


def _node_columns(assembly: Assembly) -> list[Column[Node]]:
    beams = marks_by_element(assembly.beams)
    return [
        ("Mark", None, _mark),
        ("Count", 0, len),
        ("Valence", 0, lambda nodes: len(nodes[0].beams)),
        ("Material", None, lambda nodes: nodes[0].material.name),
        ("Beams", None, lambda nodes: _places(" / ".join(neighbour_marks(node.beams, beams)) for node in nodes)),
        ("Azimuths (deg)", None, lambda nodes: _each(nodes[0].azimuths_deg, 2)),
        ("Inclinations (deg)", None, lambda nodes: _each(nodes[0].inclinations_deg, 2)),
        ("Setbacks (mm)", None, lambda nodes: _each(nodes[0].setbacks_mm, 2)),
        ("Height (mm)", 2, lambda nodes: nodes[0].height_mm),
        ("Top spread (mm)", 2, lambda nodes: _range([node.top_spread_mm for node in nodes], 2)),
        ("Axis spread (mm)", 2, lambda nodes: _range([node.axis_spread_mm for node in nodes], 2)),
        ("Mass each (kg)", 3, lambda nodes: nodes[0].mass_kg),
        ("Mass (kg)", 3, lambda nodes: len(nodes) * nodes[0].mass_kg),
        ("File", None, _step_file),
    ]


def _panel_columns(assembly: Assembly, nest: Nest | None) -> list[Column[Panel]]:
    across = dict(zip(map(id, assembly.panels), panel_neighbours(assembly), strict=True))
    sheets = {id(assembly.panels[at.panel]): at.sheet + 1 for at in nest.placements} if nest else {}

    def dihedrals(panels: Sequence[Panel]) -> str:
        by_edge = zip(*(panel.dihedrals_deg for panel in panels), strict=True)
        return " / ".join(text or NOTHING for text in _texts([_range(angles, 2) for angles in by_edge], 2))

    return [
        ("Mark", None, _mark),
        ("Count", 0, len),
        ("Material", None, lambda panels: panels[0].material.name),
        ("Thickness (mm)", 1, lambda panels: panels[0].thickness_mm),
        ("Area each (m2)", 4, lambda panels: panels[0].area_mm2 * 1e-6),
        ("Area (m2)", 4, lambda panels: len(panels) * panels[0].area_mm2 * 1e-6),
        ("Edges (mm)", None, lambda panels: _each(panels[0].edge_lengths_mm, 2)),
        ("Corners (deg)", None, lambda panels: _each(panels[0].corner_angles_deg, 2)),
        ("Dihedrals (deg)", None, dihedrals),
        ("Neighbours", None, lambda panels: _places(" / ".join(across[id(panel)]) for panel in panels)),
        ("Mass each (kg)", 3, lambda panels: panels[0].mass_kg),
        ("Mass (kg)", 3, lambda panels: len(panels) * panels[0].mass_kg),
        ("Sheets", None, lambda panels: _sheets(sheets[id(panel)] for panel in panels) if nest else ""),
        ("File", None, lambda panels: f"panels/{panels[0].mark}.dxf"),
    ]


def _mark(parts: Sequence[Part]) -> str:
    return parts[0].mark


def _step_file(parts: Sequence[Part]) -> str:
    return f"parts/{parts[0].mark}.step"


def _sheets(numbers: Iterable[int]) -> str:
    return ", ".join(map(str, sorted(set(numbers))))


def _places(texts: Iterable[str]) -> str:
    """Each text once, with how often it occurs where that is more than once."""
    counts: dict[str, int] = {}
    for text in texts:
        counts[text] = counts.get(text, 0) + 1
    return "; ".join(text if count == 1 else f"{text} (x{count})" for text, count in counts.items())


def _range(values: Sequence[float], decimals: int) -> Cell:
    """The value, if all are the same to these decimals; else from the least to the largest. None for NaN."""
    known = [value for value in values if not np.isnan(value)]
    if not known:
        return None
    least, largest = _texts([min(known), max(known)], decimals)
    return known[0] if least == largest else f"{least} to {largest}"


def _each(values: Sequence[float], decimals: int) -> str:
    return " / ".join(_texts(values, decimals))


def _texts(cells: Sequence[Cell], decimals: int | None) -> list[str]:
    """Each cell as text; what rounds to zero has no sign."""
    if decimals is None:
        return ["" if cell is None else str(cell) for cell in cells]
    form, zero = f"%.{decimals}f", f"{0:.{decimals}f}"
    texts = [cell if isinstance(cell, str) else "" if cell is None else form % cell for cell in cells]
    return [zero if text == "-" + zero else text for text in texts]

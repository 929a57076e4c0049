"""DXF files of drawings: 1:1 in millimetres, polylines on three layers, the same bytes for the same drawing.

ezdxf writes the head and the tables of a file once; the entities are set into that text, since writing the same
15 kB through ezdxf for each of a thousand panels would take fifty times as long.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from io import StringIO
from itertools import groupby, islice
from pathlib import Path
from textwrap import wrap
from typing import TextIO

import numpy as np
from ezdxf import options  # type: ignore[attr-defined]
from ezdxf.document import Drawing as Document

from fabkit.errors import OutputError
from fabkit.formats.drawings.dxf_entities import (
    ModelSpace,
    Version,
    bounds,
    circles,
    number_texts,
    polylines,
    texts,
)
from fabkit.parts import Curves, Ragged
from fabkit.production import CUT, HIDDEN, LABEL, MARK, SHEET, VISIBLE, Drawing
from geometry.arrays import FloatArray, IntArray

__all__ = ["shown_text", "write_dxf", "write_dxfs"]

TITLE = "TITLE"
COLOURS = {CUT: 1, MARK: 5, SHEET: 8, TITLE: 8, VISIBLE: 7, HIDDEN: 8, LABEL: 5}
"""AutoCAD colour numbers of the layers: red, blue, black and grey."""
DASHES = (4.5, 3.0, -1.5)
"""Length of the pattern of hidden edges, of its dash and of its gap, in mm."""
TITLE_SHARE = 0.015
"""Height of the letters of a title over the larger side of the drawing."""

TITLE_LETTERS, LETTER_WIDTH, LINE_SPACING = 66, 1.0, 1.6
"""Largest number of letters of a line of a title, so that it is no longer than the larger side of the drawing; width of
a letter over its height, as wide as any program draws them; distance of two lines over the height of their letters."""

VIEW_SHARE = 1.05
"""Height of the view with which a file opens, over the larger side of its extents."""

DXF_DECIMALS = 9
"""Decimals of coordinates in DXF files: 1e-9 mm, the precision of double numbers on a sheet of 10 m."""

DRAWINGS_PER_BATCH = 200
"""Number of drawings whose points are put into text together: some 10 MB."""

SLOTS = tuple(9e9 + k for k in range(7))
"""Numbers that stand in a template for the extents (low, high) and for the middle and height of the view."""
SEED, ENTITIES = "$HANDSEED\n  5\n", "  2\nENTITIES"
"""What stands before the first free handle, and before the entities."""
_CODE = re.compile(r"\\(?=[UM]\+)")
"""Begins a letter by its number; all other backslashes are themselves, and the signs of ends have them."""


def write_dxf(target: Path | TextIO, drawing: Drawing, *, version: Version = "R2010") -> None:
    """Write a drawing to a path or a text stream.

    R2010, R2018: LWPOLYLINE, $INSUNITS 4 (millimetres). R12: POLYLINE; that version knows no unit, so it belongs into
    the name of the file. The notes stand as comments at the head, and but for R12 also among the drawing's properties;
    the title is text on a layer of its own, below everything else. Raises OutputError for a drawing of nothing.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.drawings import write_dxf
    >>> from fabkit.production import panel_drawings
    >>> drawing = panel_drawings(built.assembly)[0]
    >>> write_dxf(Path("panel.dxf"), drawing)
    >>> drawing.name, Path("panel.dxf").read_text().count("LWPOLYLINE") > 10
    ('P001', True)
    """
    (text,) = _files([drawing], version)
    if isinstance(target, Path):
        target.write_bytes(text)
    else:
        target.write(text.decode())


def write_dxfs(folder: Path, drawings: Iterable[Drawing], *, version: Version = "R2010", suffix: str = ".dxf") -> None:
    """Write a file for each drawing, named like it, into an existing folder; otherwise as `write_dxf`.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.drawings import write_dxfs
    >>> from fabkit.production import panel_drawings
    >>> write_dxfs(Path(), panel_drawings(built.assembly))
    >>> sorted(path.name for path in Path().glob("*.dxf"))
    ['P001.dxf', 'P002.dxf']
    """
    left = iter(drawings)
    while batch := list(islice(left, DRAWINGS_PER_BATCH)):
        for drawing, text in zip(batch, _files(batch, version), strict=True):
            (folder / f"{drawing.name}{suffix}").write_bytes(text)  # buffered: a full disk ends a raw write early


def _files(drawings: Sequence[Drawing], version: Version) -> Iterator[bytes]:
    """The content of the file of each drawing."""
    for (notes, layers), alike in groupby(drawings, key=lambda drawing: (drawing.notes, tuple(drawing.layers))):
        yield from _filled(_template(version, notes, layers), list(alike))


def _filled(template: _Template, drawings: Sequence[Drawing]) -> Iterator[bytes]:
    """The content of the files of n drawings with the same notes and layers."""
    space, layers = template.space, tuple(drawings[0].layers)
    curves = Curves.joined(own for drawing in drawings for own in drawing.layers.values())
    curves = Curves(curves.values.round(DXF_DECIMALS) + 0.0, curves.starts)
    n_curves = np.array([[len(own) for own in drawing.layers.values()] for drawing in drawings])
    rings = np.concatenate([np.zeros((0, 3)), *(own for drawing in drawings for own in drawing.circles.values())])
    rings = rings.round(DXF_DECIMALS) + 0.0
    ring_layers = [layer for drawing in drawings for layer, own in drawing.circles.items() for _ in range(len(own))]
    n_rings = np.array([sum(map(len, drawing.circles.values())) for drawing in drawings])
    points = Ragged(curves.values, curves.starts[bounds(n_curves.sum(axis=1))])
    low, high = _extents(points, Ragged(rings, bounds(n_rings)))
    not_finite = np.flatnonzero(~np.isfinite([low, high]).all(axis=(0, 2)))
    if len(not_finite):
        name = drawings[not_finite[0]].name
        raise OutputError(f"the drawing {name} has no curves, or coordinates that are not finite; leave it out")
    first = np.full(len(drawings), template.first_handle)
    lines, first = polylines(space, layers, curves, n_curves, first)
    arcs, first = circles(space, ring_layers, rings, n_rings, first)
    titles, first, sizes = _titles(space, [drawing.title for drawing in drawings], low, high, first)
    entities = map("".join, zip(lines, arcs, titles, strict=True))
    for numbers, handle, own in zip(number_texts(sizes).tolist(), first.tolist(), entities, strict=True):
        yield template.fill([*numbers, f"{SEED}{handle:X}", f"{ENTITIES}{own}"]).encode()


def _extents(points: Ragged, rings: Ragged) -> tuple[FloatArray, FloatArray]:
    """(n, 2) twice, from where to where the points and the circles of n drawings reach."""
    lows = Ragged(rings.values[:, :2] - rings.values[:, 2:], rings.starts).reduced(np.minimum, np.inf)
    highs = Ragged(rings.values[:, :2] + rings.values[:, 2:], rings.starts).reduced(np.maximum, -np.inf)
    return (
        np.minimum(points.reduced(np.minimum, np.inf), lows),
        np.maximum(points.reduced(np.maximum, -np.inf), highs),
    )


def _titles(
    space: ModelSpace, titles: Sequence[Sequence[str]], low: FloatArray, high: FloatArray, first: IntArray
) -> tuple[list[str], IntArray, FloatArray]:
    """The titles below n drawings that reach from low to high (n, 2), and (n, 7) the numbers of the slots."""
    wrapped = [_wrapped(title) for title in titles]
    counts = np.array(list(map(len, wrapped)))
    letters = TITLE_SHARE * (high - low).max(axis=1)
    downwards = np.repeat([LINE_SPACING * letters], counts.max(), axis=0)
    levels = np.subtract.accumulate([low[:, 1], *downwards]).T
    y = levels[:, 1:][np.arange(counts.max()) < counts[:, None]]
    lines = _shown([line for lines in wrapped for line in lines], space.version)
    text, first = texts(space, TITLE, lines, (low[:, 0], y, letters), counts, first)
    longest = np.array([max(map(len, lines), default=0) for lines in wrapped])
    left, bottom = low[:, 0], levels[np.arange(len(low)), counts]
    right, top = np.maximum(high[:, 0], left + LETTER_WIDTH * letters * longest), high[:, 1]
    height = VIEW_SHARE * np.maximum(right - left, top - bottom)
    return text, first, np.stack([left, bottom, right, top, (left + right) / 2, (bottom + top) / 2, height], axis=1)


@dataclass(frozen=True)
class _Template:
    """The text of a file in pieces; in the place of each second one comes the value of the slot of that number: extents
    and view, the first free handle, and the entities."""

    text: tuple[str, ...]
    slots: tuple[int, ...]
    space: ModelSpace
    first_handle: int

    def fill(self, values: Sequence[str]) -> str:
        text = list(self.text)
        text[1::2] = map(values.__getitem__, self.slots)
        return "".join(text)


@lru_cache(maxsize=16)
def _template(version: Version, notes: tuple[str, ...], layers: tuple[str, ...]) -> _Template:
    """Written once for all drawings with the same notes and layers, without the time of writing."""
    fixed = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        document = _document(version, notes, layers)
        stream = StringIO()
        document.write(stream)
    finally:
        options.write_fixed_meta_data_for_testing = fixed
    comments = "".join(f"999\n{note}\n" for note in notes)
    text, first_handle = comments + stream.getvalue(), str(document.header["$HANDSEED"])
    marks = [*map(repr, SLOTS), f"{SEED}{first_handle}", ENTITIES]
    pieces = tuple(re.split("(" + "|".join(map(re.escape, marks)) + ")", text))
    slots = tuple(map(marks.index, pieces[1::2]))
    space = ModelSpace(version, document.modelspace().layout_key)
    return _Template(pieces, slots, space, int(first_handle, 16))


def _document(version: Version, notes: tuple[str, ...], layers: tuple[str, ...]) -> Document:
    document = Document.new(version)  # `ezdxf.new` logs for R12 that it has no unit
    for kind in sorted(document.entitydb.dxf_types_in_use()):
        document.classes.add_class(kind)  # else ezdxf adds them in the order of a set, another one in each process
    document.header["$MEASUREMENT"] = 1
    if version != "R12":
        document.header["$INSUNITS"] = 4
        for number, note in enumerate(notes, start=1):
            document.header.custom_vars.append(f"Note {number}", note)
    if HIDDEN in layers:
        document.linetypes.add(HIDDEN, DASHES, description="hidden edges")
    for layer in (*layers, TITLE):
        document.layers.add(layer, color=COLOURS[layer], linetype=HIDDEN if layer == HIDDEN else "Continuous")
    model = document.modelspace()
    low_x, low_y, high_x, high_y, middle_x, middle_y, height = SLOTS
    model.dxf.extmin, model.dxf.extmax = (low_x, low_y, 0.0), (high_x, high_y, 0.0)
    document.set_modelspace_vport(height, (middle_x, middle_y))
    return document


def _wrapped(title: Sequence[str]) -> Sequence[str]:
    if max(map(len, title), default=0) <= TITLE_LETTERS:
        return title
    return [part for line in title for part in (wrap(line, TITLE_LETTERS) if len(line) > TITLE_LETTERS else [line])]


def _shown(lines: list[str], version: Version) -> list[str]:
    together = "".join(lines)
    return lines if shown_text(together, version) == together else [shown_text(line, version) for line in lines]


def shown_text(line: str, version: str) -> str:
    """A line of text as it is written: without the codes of such texts; for R12, which has no UTF-8, what is not ASCII
    as \\U+00DF.

    >>> from fabkit.formats.drawings import shown_text
    >>> shown_text("50 %% gr\u00fcn", "R12")
    '50 % % gr\\\\U+00FCn'
    """
    plain = _CODE.sub("/", line.replace("%%", "% %").replace("^", "^ "))
    if plain.isascii() and plain.isprintable():
        return plain
    known = "".join(letter if letter.isprintable() and letter <= "\uffff" else "?" for letter in plain)
    return "".join(letter if letter.isascii() or version != "R12" else f"\\U+{ord(letter):04X}" for letter in known)

"""DXF files of drawings: 1:1 in millimetres, polylines on three layers, the same bytes for the same drawing.

ezdxf writes the head and the tables of a file once; the polylines are set into that text, since writing the same
15 kB through ezdxf for each of a thousand panels would take fifty times as long.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from io import StringIO
from itertools import islice
from pathlib import Path
from textwrap import wrap
from typing import Literal, TextIO

import numpy as np
from ezdxf import options  # type: ignore[attr-defined]
from ezdxf.document import Drawing as Document
from pydantic_core import to_json

from fabkit.errors import OutputError
from fabkit.parts import Curves, Ragged
from fabkit.production import CUT, HIDDEN, LABEL, MARK, SHEET, VISIBLE, Drawing
from geometry.arrays import FloatArray

__all__ = ["shown_text", "write_dxf", "write_dxfs"]

Version = Literal["R2018", "R2010", "R12"]

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
ENTITIES = "  2\nENTITIES\n"
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
            (folder / f"{drawing.name}{suffix}").write_bytes(text)


def _files(drawings: Sequence[Drawing], version: Version) -> Iterator[bytes]:
    """The content of the file of each drawing."""
    curves = Curves.joined(own for drawing in drawings for own in drawing.layers.values())
    curves = Curves(curves.values.round(DXF_DECIMALS) + 0.0, curves.starts)
    ends = np.cumsum([0, *(sum(len(own.values) for own in drawing.layers.values()) for drawing in drawings)])
    points, lines = Ragged(curves.values, ends), _texts(curves)
    write = _polyline if version == "R12" else _lwpolyline
    extents = zip(points.reduced(np.minimum, np.inf), points.reduced(np.maximum, -np.inf), strict=True)
    for drawing, (low, high) in zip(drawings, extents, strict=True):
        template = _template(version, drawing.notes, tuple(drawing.layers))
        owner, handles = template.owner, iter(range(template.first_handle, 2**62))
        entities = [
            write(layer, *next(lines), owner, handles) for layer, own in drawing.layers.items() for _ in range(len(own))
        ]
        for layer, circles in drawing.circles.items():
            for circle in circles.round(DXF_DECIMALS) + 0.0:
                entities.append(_circle(version, layer, circle, owner, handles))
                low, high = np.minimum(low, circle[:2] - circle[2]), np.maximum(high, circle[:2] + circle[2])
        if not np.isfinite([low, high]).all():
            raise OutputError(
                f"the drawing {drawing.name} has no curves, or coordinates that are not finite; leave it out"
            )
        letters = TITLE_SHARE * float((high - low).max())
        x, y = low.tolist()
        entity = _text(version, x, letters, owner)
        words = _wrapped(drawing.title)
        for line in words:
            y -= LINE_SPACING * letters
            entities.append(entity % (next(handles), y, shown_text(line, version)))
        right, top = high.tolist()
        right = max(right, x + LETTER_WIDTH * letters * max(map(len, words), default=0))
        yield template.fill("".join(entities), (x, y), (right, top), next(handles)).encode()


@dataclass(frozen=True)
class _Template:
    """The text of a file in pieces, between which come the values of the slots of that number: extents and view, the
    first free handle, and the entities. owner: handle of the model space."""

    pieces: tuple[str, ...]
    slots: tuple[int, ...]
    owner: str
    first_handle: int

    def fill(self, entities: str, low: Sequence[float], high: Sequence[float], seed: int) -> str:
        middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
        height = VIEW_SHARE * max(b - a for a, b in zip(low, high, strict=True))
        numbers = [*low, *high, *middle, height]
        values = [*(f"{value!r}\n" for value in numbers), f"$HANDSEED\n  5\n{seed:X}\n", ENTITIES + entities]
        filled = [piece + values[slot] for piece, slot in zip(self.pieces, self.slots, strict=False)]
        return "".join([*filled, self.pieces[-1]])


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
    marks = [*(f"{slot!r}\n" for slot in SLOTS), f"$HANDSEED\n  5\n{first_handle}\n", ENTITIES]
    pieces = re.split("(" + "|".join(map(re.escape, marks)) + ")", text)
    slots = tuple(map(marks.index, pieces[1::2]))
    return _Template(tuple(pieces[::2]), slots, document.modelspace().layout_key, int(first_handle, 16))


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


def _texts(curves: Curves) -> Iterator[tuple[list[str], int]]:
    """Of each curve the points to write, as text, and whether it is closed; of a closed one without the last point.

    pydantic's JSON writer is ten times as fast as repr."""
    numbers = to_json(curves.values.ravel().tolist()).decode()[1:-1].split(",")
    points = list(map("\n 20\n".join, zip(numbers[::2], numbers[1::2], strict=True)))
    starts, closed = curves.starts.tolist(), curves.is_closed.astype(int).tolist()
    for start, end, is_closed in zip(starts[:-1], starts[1:], closed, strict=True):
        yield points[start : end - is_closed], is_closed


def _text(version: Version, x: float, height: float, owner: str) -> str:
    """A line of text, but for its handle, y and words."""
    place = f" 10\n{x!r}\n 20\n%r\n 30\n0.0\n 40\n{height!r}\n  1\n%s\n"
    if version == "R12":
        return f"  0\nTEXT\n  5\n%X\n  8\n{TITLE}\n{place}"
    head = f"  0\nTEXT\n  5\n%X\n330\n{owner}\n100\nAcDbEntity\n  8\n{TITLE}\n100\nAcDbText\n"
    return f"{head}{place}100\nAcDbText\n"


def _wrapped(title: Sequence[str]) -> list[str]:
    return [part for line in title for part in (wrap(line, TITLE_LETTERS) if len(line) > TITLE_LETTERS else [line])]


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


def _circle(version: Version, layer: str, circle: FloatArray, owner: str, handles: Iterator[int]) -> str:
    x, y, radius = circle.tolist()
    place = f" 10\n{x!r}\n 20\n{y!r}\n 30\n0.0\n 40\n{radius!r}\n"
    head = f"  0\nCIRCLE\n  5\n{next(handles):X}\n"
    if version == "R12":
        return f"{head}  8\n{layer}\n{place}"
    return f"{head}330\n{owner}\n100\nAcDbEntity\n  8\n{layer}\n100\nAcDbCircle\n{place}"


def _lwpolyline(layer: str, points: list[str], closed: int, owner: str, handles: Iterator[int]) -> str:
    corners = "\n 10\n".join(points)
    return (
        f"  0\nLWPOLYLINE\n  5\n{next(handles):X}\n330\n{owner}\n100\nAcDbEntity\n  8\n{layer}\n"
        f"100\nAcDbPolyline\n 90\n{len(points)}\n 70\n{closed}\n 10\n{corners}\n"
    )


def _polyline(layer: str, points: list[str], closed: int, owner: str, handles: Iterator[int]) -> str:
    handle = f"  5\n{next(handles):X}\n  8\n{layer}\n"
    head = f"  0\nPOLYLINE\n{handle} 66\n1\n 10\n0.0\n 20\n0.0\n 30\n0.0\n 70\n{closed}\n"
    vertices = "".join(
        [f"  0\nVERTEX\n  5\n{next(handles):X}\n  8\n{layer}\n 10\n{point}\n 30\n0.0\n" for point in points]
    )
    return f"{head}{vertices}  0\nSEQEND\n  5\n{next(handles):X}\n  8\n{layer}\n"

"""Polylines in files: strokes that the lines of a mesh are to follow, and the lines of a mesh for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import ezdxf.filemanagement
import numpy as np
from ezdxf.lldxf.const import DXFError
from ezdxf.path import make_path

from fabkit.errors import FabkitError, OutputError
from fabkit.wording import echo, readable
from geometry.arrays import FloatArray, floats

__all__ = ["read_polylines", "write_polylines"]

CURVES = ("LINE", "LWPOLYLINE", "POLYLINE", "SPLINE", "ARC", "CIRCLE", "ELLIPSE")
"""Entities of a DXF file that are polylines or are converted to polylines."""

FLATTENING_TOLERANCE = 1e-3
"""Largest distance of a curve in a DXF file from the polyline that replaces it, over the extent of all curves."""

LAYER_COLOURS = (5, 1)
"""Numbers of the colours blue and red in AutoCAD, for the layers of families of lines."""


def read_polylines(path: Path) -> tuple[FloatArray, ...]:
    """The polylines (k, 3) of an OBJ file (`l` elements) or a DXF file (lines, polylines, arcs and splines).

    Raises FabkitError where the file cannot be read or holds no polyline.

    >>> Path("strokes.obj").write_text("v 0 0 0\\nv 1 0 0\\nv 1 1 0\\nl 1 2 3\\n")
    32
    >>> [line.tolist() for line in read_polylines(Path("strokes.obj"))]
    [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]]
    """
    suffix = path.suffix.lower()
    if suffix not in (".obj", ".dxf"):
        raise FabkitError(f"polylines are read from .obj and .dxf files, not {echo(path.name)}")
    try:
        data = path.read_bytes()
    except OSError as error:
        raise FabkitError(f"{readable(path.name)} cannot be read: {error.strerror or error}") from error
    lines = _of_obj(data, path) if suffix == ".obj" else _of_dxf(path)
    if not lines:
        what = "`l` elements" if suffix == ".obj" else "lines, polylines, arcs or splines"
        raise FabkitError(f"{readable(path.name)} contains no polyline: {what} are needed")
    return lines


def write_polylines(path: Path, *families: Sequence[FloatArray]) -> None:
    """Write families of polylines (k, 3) as OBJ or DXF, by suffix: each is a group or a layer, "lines-1" and so on.

    Raises OutputError for other suffixes and on write errors.
    """
    suffix = path.suffix.lower()
    if suffix not in (".obj", ".dxf"):
        raise OutputError(f"polylines are written to .obj and .dxf files, not {echo(path.name)}")
    try:
        if suffix == ".obj":
            path.write_text(_obj_text(families), encoding="ascii", newline="\n")
        else:
            document = ezdxf.filemanagement.new("R2010")
            for number, lines in enumerate(families):
                layer = document.layers.add(f"lines-{number + 1}", color=LAYER_COLOURS[number % len(LAYER_COLOURS)])
                for line in lines:
                    document.modelspace().add_polyline3d(line.tolist(), dxfattribs={"layer": layer.dxf.name})
            document.saveas(path)
    except OSError as error:
        raise OutputError(f"{readable(path.name)} cannot be written: {error.strerror or error}") from error


def _obj_text(families: Sequence[Sequence[FloatArray]]) -> str:
    rows = [f"v {x!r} {y!r} {z!r}" for lines in families for line in lines for x, y, z in line.tolist()]
    first = 1
    for number, lines in enumerate(families):
        rows.append(f"g lines-{number + 1}")
        for line in lines:
            rows.append("l " + " ".join(str(first + k) for k in range(len(line))))
            first += len(line)
    return "\n".join([*rows, ""])


def _of_obj(data: bytes, path: Path) -> tuple[FloatArray, ...]:
    points: list[list[float]] = []
    lines = []
    text = data.decode("utf-8", errors="replace").replace("\\\n", " ")
    for number, row in enumerate(text.splitlines(), start=1):
        word, *rest = row.split("#")[0].split() or [""]
        try:
            if word == "v":
                x, y, z = (float(each) for each in rest[:3])
                points.append([x, y, z])
            elif word == "l":
                lines.append([points[_place(each, len(points))] for each in rest])
        except (ValueError, IndexError):
            found = f"line {number} of {readable(path.name)} is {echo(row)}"
            raise FabkitError(f"{found}, which is not a valid {word} element") from None
    return tuple(floats(line) for line in lines if len(line) > 1)


def _place(word: str, count: int) -> int:
    """Number of a vertex, counted from 0, from an index such as 3, 3/1 or -1. Raises ValueError for an invalid
    index."""
    index = int(word.split("/")[0])
    place = index - 1 if index > 0 else count + index
    if index == 0 or place < 0:
        raise ValueError
    return place


def _of_dxf(path: Path) -> tuple[FloatArray, ...]:
    try:
        document = ezdxf.filemanagement.readfile(path)
    except (OSError, DXFError) as error:
        raise FabkitError(f"{readable(path.name)} is not a readable DXF file: {error}") from error
    curves = [make_path(entity) for entity in document.modelspace().query(" ".join(CURVES))]
    curves = [curve for curve in curves if len(curve)]
    if not curves:
        return ()
    corners = np.array([point.xyz for curve in curves for point in curve.control_vertices()])
    distance = FLATTENING_TOLERANCE * float(np.linalg.norm(np.ptp(corners, axis=0)))
    return tuple(floats([point.xyz for point in curve.flattening(distance)]) for curve in curves)

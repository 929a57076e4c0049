"""model.glb and report.html of a finished folder against each other and against the tables."""

from __future__ import annotations

import base64
import binascii
import json
import re
from collections.abc import Iterator
from html import unescape
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents
from fabkit.formats.report import report_values
from fabkit.production import table_file

__all__ = ["check_glb", "check_report", "same_text"]

GLB_TOLERANCE_MM = 0.0011
"""Largest difference in mm of a place in model.glb from that in the tables, whose coordinates have 3 decimals."""
NORMAL_TOLERANCE = 1e-6
"""Largest difference from 1 of the length of a normal in single precision."""
ROTATION_TOLERANCE = 3e-9
"""Largest difference of an axis in model.glb, of 12 decimals of a quaternion, from that in the tables, of 9."""


def same_text(text: str, cell: str) -> bool:
    """Whether a text of a CSV file is a text of a page, which needs no apostrophe before a formula."""
    return text == cell or text.lstrip("'") == cell


def check_glb(contents: Contents) -> Iterator[str]:
    """Names and places of the parts against the tables, extents against points, normals."""
    head, body = _glb(contents)
    points, normals = (body[slice(*_extent(view))].view("<f4").reshape(-1, 3) for view in head["bufferViews"][:2])
    if np.abs(np.linalg.norm(normals.astype(float), axis=1) - 1).max(initial=0.0) > NORMAL_TOLERANCE:
        yield "model.glb has a normal that is no unit vector"
    accessors = head["accessors"]
    children = [child for node in head["nodes"] for child in node.get("children", ())]
    if sorted(children) != list(range(1, len(head["nodes"]))):
        yield "model.glb has a node in no group, or in two"
    for mesh in head["meshes"]:
        (primitive,) = mesh["primitives"]
        accessor = accessors[primitive["attributes"]["POSITION"]]
        own = points[accessor["byteOffset"] // 12 :][: accessor["count"]]
        low, high = np.array(accessor["min"], "<f4"), np.array(accessor["max"], "<f4")
        if len(own) != accessor["count"] or (own.min(axis=0) != low).any() or (own.max(axis=0) != high).any():
            yield f"the extent of {mesh['name']} in model.glb is not that of its points"
        indices = accessors[primitive["indices"]]
        if indices["count"] % 3 or indices["type"] != "SCALAR" or accessor["type"] != "VEC3":
            yield f"{mesh['name']} in model.glb has no triangles"
    if not {"pieces.csv", "placements.csv"} <= contents.files.keys():
        return
    yield from _check_places(contents, [node for node in head["nodes"] if "extras" in node])


def _check_places(contents: Contents, nodes: list[dict[str, Any]]) -> Iterator[str]:
    pieces, placements = contents.table("pieces").rows, contents.table("placements").rows
    if len(nodes) != len(pieces):
        yield f"model.glb has {len(nodes)} parts, pieces.csv {len(pieces)}"
        return
    origin = np.array(contents.manifest["origin"]["mm"], dtype=float)
    places = np.array([[float(row[f"Origin {axis} (mm)"]) for axis in "xyz"] for row in placements]) - origin
    off = np.abs(1000 * np.array([node["translation"] for node in nodes]) - places).max(axis=1) > GLB_TOLERANCE_MM
    x, y, z, w = np.array([node["rotation"] for node in nodes], dtype=float).T
    axes = {
        "X": [1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
        "Z": [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)],
    }
    for name, found in axes.items():
        table = np.array([[float(row[f"{name} axis {axis}"]) for axis in "xyz"] for row in placements])
        off |= np.abs(np.transpose(found) - table).max(axis=1) > ROTATION_TOLERANCE
    for node, row, is_off in zip(nodes, pieces, off.tolist(), strict=True):
        if is_off or (node["name"], node["extras"]["element"]) != (row["Mark"], int(row["Element"])):
            yield f"{row['Piece']} is not where model.glb has it"


def _glb(contents: Contents) -> tuple[dict[str, Any], npt.NDArray[np.uint8]]:
    """What model.glb says, and its numbers. Raises FolderError."""
    data = contents.data("model.glb")
    size = int.from_bytes(data[12:16], "little")
    rest = int.from_bytes(data[20 + size : 24 + size], "little")
    names = (data[:4], data[16:20], data[24 + size : 28 + size])
    if int.from_bytes(data[8:12], "little") != len(data) or len(data) != 28 + size + rest or names != _NAMES:
        raise FolderError("model.glb is not complete")
    try:
        head = json.loads(data[20 : 20 + size])
    except ValueError:
        raise FolderError("model.glb is damaged") from None
    return head, np.frombuffer(data[28 + size :], np.uint8)


_NAMES = (b"glTF", b"JSON", b"BIN\0")


def _extent(view: dict[str, int]) -> tuple[int, int]:
    return view["byteOffset"], view["byteOffset"] + view["byteLength"]


def check_report(contents: Contents) -> Iterator[str]:
    """The tables of the page against the CSV files, its model against model.glb."""
    page, arrays = contents.report
    try:
        numbers = np.frombuffer(base64.b64decode(arrays, validate=True), np.uint8)
    except binascii.Error:
        yield "the model in report.html is damaged"
        return
    try:
        values = report_values(contents.text("report.html"))
    except ValueError:
        yield "the program, the style or a heading of report.html is not that of this version of fabkit"
        return
    yield from _check_facts(contents, values["key_facts"] + values["mesh_facts"])
    around = zip(("node_facets", "panel_edges"), (each[1] for each in page["around"]), strict=True)
    for name, table in [*page["tables"].items(), ("pieces", page["pieces"]), *around]:
        if table_file(name) in contents.files:
            yield from _check_cells(contents, name, table)
    counts = [layer["count"] for layer in page["model"]["layers"]]
    size = 36 * sum(counts) + 12 * page["model"]["points"] + 8 * page["model"]["shapes"]
    size += sum(12 * triangles + 8 * edges for triangles, edges in page["model"]["cuts"])
    if size != len(numbers):
        yield "the model in report.html is not complete"
    elif "model.glb" in contents.files:
        first = 36 * sum(counts)
        own = numbers[first : first + 12 * page["model"]["points"]]
        head, body = _glb(contents)
        drawn = _points(body[slice(*_extent(head["bufferViews"][0]))])
        yield from _check_arrays(contents, page["model"], numbers[: 36 * sum(counts)])
        if not drawn <= _points(own):  # the page also has the centres of rounds
            yield "the model in report.html is not that in model.glb"


def _check_arrays(contents: Contents, model: dict[str, Any], data: npt.NDArray[np.uint8]) -> Iterator[str]:
    """The places, turns, shapes and colours of the parts in the page against the table of placements."""
    at, places, turns, shapes = 0, [], [], []
    for layer in model["layers"]:
        n = layer["count"]
        own = data[at : at + 36 * n].view("<f4")
        numbers, at = own[7 * n :].view("<u4").reshape(2, n), at + 36 * n
        if numbers[1].max(initial=0) >= len(layer["colours"]):
            yield f"{layer['name']} in report.html have a colour that it does not know"
        if layer["name"] != "left out":
            places.append(own[: 3 * n].reshape(n, 3))
            turns.append(own[3 * n : 7 * n].reshape(n, 4))
            shapes.append(numbers[0])
    if not places or "placements.csv" not in contents.files:
        return
    rows = contents.table("placements").rows
    middle = np.array(contents.manifest["origin"]["mm"]) + model["middle_mm"]
    own = 1000 * np.concatenate(places).astype(float)
    if len(own) != len(rows):
        yield f"report.html shows {len(own)} parts, placements.csv has {len(rows)}"
        return
    wanted = np.array([[float(row[f"Origin {axis} (mm)"]) for axis in "xyz"] for row in rows]) - middle
    x, y, z, w = np.concatenate(turns).astype(float).T
    axis = np.transpose([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)])
    along = np.array([[float(row[f"X axis {axis}"]) for axis in "xyz"] for row in rows])
    off = np.abs(own - wanted).max(axis=1) > GLB_TOLERANCE_MM + NORMAL_TOLERANCE * np.abs(wanted).max()
    off |= np.abs(axis - along).max(axis=1) > NORMAL_TOLERANCE
    off |= np.abs(x * x + y * y + z * z + w * w - 1) > NORMAL_TOLERANCE
    for k in np.flatnonzero(off).tolist():
        yield f"{rows[k]['Piece']} is not where report.html shows it"
    if np.concatenate(shapes).max(initial=0) >= model["shapes"]:
        yield "report.html shows a shape that it does not have"


_FACT = re.compile(
    r"<div><dt>([^<]*)</dt><dd>([^<]*?)(?: <small>([^<]*)</small>)?</dd></div>"
    r"|<tr><th scope=\"row\">([^<]*)</th><td(?: class=\"text\")?>([^<]*)"
    r"(?:<br><small class='soft'>([^<]*)</small>)?</td></tr>"
)


def _check_facts(contents: Contents, html: str) -> Iterator[str]:
    """The facts of the page against the summary of the workbook."""
    if _FACT.sub("", html).strip():
        yield "report.html has a fact that cannot be read"
    if "cutlist.xlsx" not in contents.files:
        return
    summary = contents.workbook["Summary"]
    known = {row[0].partition(" (")[0]: (row[1], row[2]) for row in summary if len(row) == 3}
    for groups in _FACT.findall(html):
        name, text, note = map(unescape, groups[:3] if groups[0] else groups[3:])
        value, beside = known.get(name, ("", ""))
        if not (text.startswith(value) or _rounded(text, value)) or note != beside or not value:
            yield f"report.html says {name}: {text} {note}, the workbook {value} {beside}".replace("  ", " ")


def _rounded(text: str, value: str) -> bool:
    """Whether a text begins with a number that rounds the value."""
    try:
        shown = text.split()[0].replace(",", "")
        digits, _, power = shown.partition("e")
        half = 0.51 * 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))
        return abs(float(shown) - float(value)) <= half
    except (ValueError, IndexError):
        return False


def _points(data: npt.NDArray[np.uint8]) -> set[bytes]:
    return set(np.ascontiguousarray(data).view("V12").tolist())


def _check_cells(contents: Contents, name: str, table: dict[str, Any]) -> Iterator[str]:
    rows = contents.table(name)
    for column, cells in zip(table["columns"], table["cells"], strict=True):
        if column not in rows.columns:
            continue
        own = [row[column] for row in rows]
        if len(own) != len(cells) or not all(map(same_text, own, cells)):
            yield f"{column} in {table_file(name)} is not that in report.html"

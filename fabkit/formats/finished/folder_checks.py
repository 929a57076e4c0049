"""Whether a finished folder is as it was written: its hashes, and what its files say against each other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fabkit.errors import FolderError
from fabkit.formats.finished.contents import Contents, in_words
from fabkit.formats.finished.drawing_checks import check_drawings
from fabkit.formats.finished.part_geometry import PartSolid
from fabkit.formats.finished.picture_checks import check_glb, check_report, same_text
from fabkit.formats.finished.step_checks import (
    COORDINATE_TOLERANCE_MM,
    DIRECTION_TOLERANCE,
    MASS_TOLERANCE_KG,
    PartFile,
    check_centres,
    check_mark_points,
    check_model,
    check_part,
    part_file,
)
from fabkit.formats.finished.zone_checks import check_zones
from fabkit.formats.manifest import MANIFEST, foreign_files
from fabkit.production import table_file
from fabkit.rules import SiteRules
from fabkit.units import MM_PER_UNIT
from geometry.arrays import FloatArray

__all__ = ["check_folder"]

PARALLEL_OFFSET = 2e-9
"""Largest distance that an end of an edge of S.obj, which has unit size, may lie off the direction of its edge of
M.obj: twice that of a pair, since both are rounded; edges of S may vanish."""
PARALLEL_SINE = 1e-7
"""Largest sine of the angle between an edge of M.obj and that of S.obj, whose numbers have all their digits: far above
their rounding, far below what a changed digit does unless it is one of the last."""

EDGE_TOLERANCES = (COORDINATE_TOLERANCE_MM, 6e-7, 6e-5)
"""Largest differences of length, corner and bevel of an edge of a panel, in mm and degrees, which have 3, 6 and 4
decimals."""


def check_folder(folder: Path, *, hashes: bool = True) -> tuple[str, ...]:
    """What is wrong with a folder that `fabkit build` wrote, one sentence each; nothing where it is as it was written.

    Files are compared with their hashes, and with each other: solids with their stated volumes and areas and with the
    model, placements, masses and counts with the tables, contours with solids, the workbook with the tables. No CAD
    kernel is needed. hashes: False looks at what the files say only, for a folder of which a program has changed line
    ends or the like. Raises FolderError where the folder is not one of a build of this version.

    >>> from fabkit import Project, build
    >>> from geometry.mesh.shapes import dome
    >>> from fabkit.formats.finished import check_folder
    >>> _ = build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out="roof"))
    >>> check_folder(Path("roof"))
    ()
    >>> _ = Path("roof/beams.csv").write_text("Mark,Count")
    >>> check_folder(Path("roof"))[0]
    'beams.csv (edited) is not as it was written'
    """
    contents = Contents(folder)
    found = list(_of_files(contents, hashes))
    for what, check in _CHECKS.items():
        found += _caught(what, check(contents))
    return tuple(dict.fromkeys(found))


def _caught(what: str, found: Iterator[str]) -> Iterator[str]:
    """What a check finds, up to a file that cannot be read, or a cell that is none."""
    try:
        yield from found
    except FolderError as error:
        yield str(error)
    except (KeyError, ValueError, IndexError, TypeError) as error:
        yield f"{what} cannot be compared: {in_words(error)}"


def _of_files(contents: Contents, hashes: bool) -> Iterator[str]:
    yield from (f"{name} is missing" for name in contents.files if name not in contents.found)
    if hashes:
        foreign = list(foreign_files(contents.folder))
        if not any(name.startswith(f"{MANIFEST} (") for name in foreign):
            for name in foreign:
                is_ours = "(" in name or name in contents.files
                yield f"{name} is not as it was written" if is_ours else f"{name} was added"
            return
        yield f"{MANIFEST} is not as it was written, so that its hashes say nothing of other files"
    for name, is_file in sorted(contents.found.items()):
        if name not in contents.files and name != MANIFEST:
            yield f"{name} was added"
        elif not is_file:
            yield f"{name} is a link, a pipe or the like"


def _of_tables(contents: Contents) -> Iterator[str]:
    """Counts, masses and files of the tables of marks against the table of pieces and the manifest."""
    if "pieces.csv" not in contents.files:
        return
    pieces = contents.table("pieces")
    counts, masses = Counter(row["Mark"] for row in pieces), {row["Mark"]: row["Mass (kg)"] for row in pieces}
    if len({row["Piece"] for row in pieces}) != len(pieces.rows):
        yield "pieces.csv has a piece twice"
    listed: set[str] = set()
    for group, table in contents.tables_of_marks():
        file = table_file(group)
        listed |= {row["Mark"] for row in table}
        for row in table:
            mark, count, each = row["Mark"], int(row["Count"]), float(row["Mass each (kg)"])
            if count != counts[mark]:
                yield f"{file} has {count} of {mark}, pieces.csv {counts[mark]}"
            if each != float(masses.get(mark, "nan")):
                yield f"the masses of {mark} in {file} and pieces.csv differ"
            if abs(count * each - float(row["Mass (kg)"])) > (count + 1) * MASS_TOLERANCE_KG:
                yield f"the mass of {mark} in {file} is not that of one times {count}"
        for column, text in list(table.totals.items())[1:]:
            half = 0.51 * 10.0 ** -len(text.partition(".")[2])
            if text and abs(sum(float(row[column]) for row in table) - float(text)) > (len(table.rows) + 1) * half:
                yield f"the total of {column} in {file} is not the sum of its rows"
        if int(table.totals["Count"]) != contents.manifest["counts"][group]:
            yield f"{file} has {table.totals['Count']} parts, the manifest {contents.manifest['counts'][group]}"
    for mark in counts.keys() ^ listed:
        yield f"{mark} is in pieces.csv or in a table of marks, but not in both"
    for row in pieces:
        folder = row["File"].partition("/")[0]
        if folder in contents.manifest["folders"] and row["File"] not in contents.files:
            yield f"there is no {row['File']}, the file of {row['Piece']}"


def _of_workbook(contents: Contents) -> Iterator[str]:
    """Each table against its sheet."""
    if "cutlist.xlsx" not in contents.files:
        return
    sheets = contents.workbook
    for name in contents.files:
        title = name.removesuffix(".csv").capitalize().replace("_", " ")
        if not name.endswith(".csv") or title not in sheets:
            continue
        table, rows = contents.table(name.removesuffix(".csv")), sheets[title]
        shown = [list(table.columns), *(list(row.values()) for row in table)]
        for number, (one, other) in enumerate(zip(shown, rows, strict=False), start=1):
            if len(one) != len(other) or not all(map(_agree, one, other)):
                yield f"row {number} of {name} is not that of the workbook"
        below = len(table.left_out) + bool(table.totals)
        if len(rows) != len(shown) + below and (table.totals or not below):
            yield f"{name} has {len(shown) + below} rows, its sheet in the workbook {len(rows)}"


def _agree(text: str, cell: str) -> bool:
    """Whether a text of a table is the cell of the workbook, which has all digits of a number."""
    if same_text(text, cell):
        return True
    try:
        decimals = len(text.partition(".")[2])
        return abs(float(text) - float(cell)) <= 0.51 * 10.0**-decimals
    except ValueError:
        return False


def _of_shapes(contents: Contents) -> Iterator[str]:
    """Solids, the model, the contours of panels and sheets."""
    parts: dict[str, PartFile] = {}
    for name in [name for name in contents.files if name.startswith("parts/")]:
        try:
            part = part_file(contents, name)
            parts[part.mark] = part
        except FolderError as error:
            yield str(error)
    for usual, _ in Counter(part.header for part in parts.values()).most_common(1):
        yield from (f"the header of parts/{each.mark}.step differs" for each in parts.values() if each.header != usual)
    rows = {row["Mark"]: row for _, table in contents.tables_of_marks() for row in table}
    for mark, part in parts.items():
        if mark in rows:
            yield from check_part(contents, part, rows[mark])
    if "model.step" in contents.files and parts and "placements.csv" in contents.files:
        yield from _caught("model.step", check_model(contents, parts))
    if parts and "placements.csv" in contents.files:
        yield from _caught("placements.csv", check_centres(contents, parts))
    if parts and "mark_points.csv" in contents.files:
        yield from _caught("mark_points.csv", check_mark_points(contents, parts))
    yield from _caught("the drawings", check_drawings(contents, parts))
    yield from _of_panel_edges(contents, {mark: part.solid for mark, part in parts.items()})


def _of_panel_edges(contents: Contents, solids: dict[str, PartSolid]) -> Iterator[str]:
    """The table of edges of panels against the pieces, and the sides of their solids."""
    if not {"panel_edges.csv", "pieces.csv"} <= contents.files.keys():
        return
    edges: dict[str, list[list[float]]] = {
        row["Piece"]: [] for row in contents.table("pieces") if row["Kind"] == "panel"
    }
    for row in contents.table("panel_edges"):
        numbers = (row["Length (mm)"], row["Corner (deg)"], row["Bevel (deg)"] or 0.0)
        edges.setdefault(row["Panel"], []).append([float(number) for number in numbers])
    of_marks = {mark: _edges(solids[mark]) for mark in {piece.partition(" ")[0] for piece in edges} & solids.keys()}
    for piece, found in edges.items():
        wanted = of_marks.get(piece.partition(" ")[0])
        if wanted is not None and (len(wanted) != len(found) or (np.abs(wanted - found) > EDGE_TOLERANCES).any()):
            yield f"panel_edges.csv does not have the edges of {piece}"


def _edges(panel: PartSolid) -> FloatArray:
    """(k, 3) of each edge of the lower side the length in mm, and corner at its start and bevel in degrees."""
    sides = np.roll(panel.outline, -1, axis=0) - panel.outline
    x, y = np.roll(sides, 1, axis=0).T
    corners = np.pi - np.arctan2(x * sides[:, 1] - y * sides[:, 0], x * sides[:, 0] + y * sides[:, 1])
    lengths, off = np.linalg.norm(sides, axis=1), panel.upper - panel.outline
    reach = (off[:, 0] * sides[:, 1] - off[:, 1] * sides[:, 0]) / lengths
    bevels = np.arctan2(reach, np.ptp(panel.corners[:, 2]))
    return np.stack([lengths, np.degrees(corners), np.degrees(bevels)], axis=1)


def _of_meshes(contents: Contents) -> Iterator[str]:
    """M.obj against the points of the survey, S.obj against its axes."""
    if not {"M.obj", "S.obj", "survey.csv"} <= contents.files.keys():
        return
    survey = contents.table("survey")
    every = np.array([int(row["Node"].rpartition("v")[2]) for row in survey], dtype=np.int64)
    nodes, first = np.unique(every, return_index=True)  # those of the first layer
    points = np.array([[float(row[f"Point {axis} (mm)"]) for axis in "xyz"] for row in survey])[first]
    axes = np.array([[float(row[f"Axis {axis}"]) for axis in "xyz"] for row in survey])[first]
    if contents.manifest["settings"].get("site"):
        site = SiteRules(**contents.manifest["settings"]["site"]).frame
        points, axes = site.to_local(points), axes @ site.axes.T
    vertices, faces = _obj(contents, "M.obj")
    normals, faces_of_image = _obj(contents, "S.obj")
    if faces != faces_of_image or len(faces) != contents.manifest["counts"]["faces"]:
        yield "M.obj and S.obj do not have the same faces"
    if len(vertices) != len(normals) or len(vertices) != contents.manifest["counts"]["vertices"]:
        yield "M.obj and S.obj do not have the vertices that the manifest counts"
        return
    units = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    settings, given = contents.manifest["settings"], vertices[nodes]
    step = COORDINATE_TOLERANCE_MM + (1e-9 if settings["unit"] else 1e-6) * float(np.abs(points).max())
    meshes = [normals[nodes]] if settings["beams"]["reference"] == "glass" else []
    if settings["unit"]:
        points = points - MM_PER_UNIT[settings["unit"]] * given
    else:
        meshes.append(given)
    for node in nodes[(_apart(points, meshes, step) > step).any(axis=1)].tolist():
        yield f"vertex {node} (counted from 0) of M.obj is not where survey.csv has it"
    yield from _of_edges(vertices, normals, faces)
    for node in nodes[np.abs(units[nodes] - axes).max(axis=1) > DIRECTION_TOLERANCE].tolist():
        yield f"vertex {node} (counted from 0) of S.obj is not the axis in survey.csv"


def _apart(points: FloatArray, meshes: list[FloatArray], rounding: float) -> FloatArray:
    """(n, 3) differences of points (n, 3) from the sum of as many points of meshes that fits most of them best: of S at
    the depth of the beams below the glass, of M in its unit. Where all fit up to rounding, none is left out."""
    columns = np.array(meshes).reshape(len(meshes), points.size).T
    apart, fitting = np.abs(points), np.ones(points.shape, dtype=bool)
    for _ in range(2 if meshes else 0):
        factors = np.linalg.lstsq(columns[fitting.ravel()], points[fitting], rcond=None)[0]
        apart = np.abs((columns @ factors).reshape(points.shape) - points)
        fitting = apart <= max(rounding, np.median(apart))
    return apart


def _of_edges(vertices: FloatArray, normals: FloatArray, faces: list[str]) -> Iterator[str]:
    """Edges of M.obj are parallel to those of S.obj."""
    rings = [[int(word) - 1 for word in line.split()[1:]] for line in faces]
    pairs = np.array([pair for ring in rings for pair in zip(ring, [*ring[1:], ring[0]], strict=True)])
    along, image = (points[pairs[:, 1]] - points[pairs[:, 0]] for points in (vertices, normals))
    lengths = np.linalg.norm(along, axis=1)
    bounds = lengths * np.maximum(PARALLEL_SINE * np.linalg.norm(image, axis=1), PARALLEL_OFFSET)
    off = np.linalg.norm(np.cross(along, image), axis=1) > bounds
    for tail, head in pairs[off & (pairs[:, 0] < pairs[:, 1])].tolist():
        yield f"the edge from vertex {tail} to vertex {head} (counted from 0) of M.obj is not parallel to that of S.obj"


def _obj(contents: Contents, name: str) -> tuple[FloatArray, list[str]]:
    lines = contents.text(name).splitlines()
    vertices = [[float(word) for word in line.split()[1:]] for line in lines if line.startswith("v ")]
    return np.array(vertices).reshape(-1, 3), [line for line in lines if line.startswith("f ")]


def _of_pictures(contents: Contents) -> Iterator[str]:
    """model.glb and report.html."""
    if "model.glb" in contents.files:
        yield from _caught("model.glb", check_glb(contents))
    if "report.html" in contents.files:
        yield from _caught("report.html", check_report(contents))


_CHECKS = {
    "the tables": _of_tables,
    "the workbook": _of_workbook,
    "the parts": _of_shapes,
    "M.obj and S.obj": _of_meshes,
    "the pictures": _of_pictures,
    "the zones": check_zones,
}
"""The checks, by what they compare."""

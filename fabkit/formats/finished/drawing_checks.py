"""All DXF files of a finished folder: sheets, panels, plates, beams and nodes."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

from fabkit.errors import FolderError
from fabkit.formats.drawings import shown_text
from fabkit.formats.finished.contents import Contents
from fabkit.formats.finished.dxf_checks import (
    check_around,
    check_panel,
    check_plate,
    check_sheet,
    check_titles,
    marks_on,
)
from fabkit.formats.finished.dxf_files import DxfFile, dxf_file, stem_of
from fabkit.formats.finished.step_checks import PartFile
from fabkit.formats.finished.view_checks import check_views
from fabkit.rules import TitleBlock
from geometry.arrays import FloatArray

__all__ = ["check_drawings"]

_FOLDERS = ("sheets", "panels", "plates", "drawings")


def check_drawings(contents: Contents, parts: Mapping[str, PartFile]) -> Iterator[str]:
    """Each file alone, against the solid of its part, against the tables, and against the others of its folder."""
    known: list[tuple[str, ...]] = []
    tables = _Tables(contents)
    for folder in _FOLDERS:
        files: dict[str, DxfFile] = {}
        for name in [name for name in contents.files if name.startswith(f"{folder}/") and name.endswith(".dxf")]:
            try:
                files[name] = dxf_file(contents, name, known)
            except FolderError as error:
                yield str(error)
        yield from check_around(files)
        if folder == "sheets":
            yield from _of_sheets(files, tables, {mark: part.blank for mark, part in parts.items()})
        for name, file in files.items() if folder != "sheets" else ():
            mark = stem_of(name)
            if mark in parts:
                yield from _of_part(name, file, parts[mark], tables)
        if folder == "drawings":
            yield from _of_words(files, tables)
        if folder != "drawings" and tables.project:
            kinds = {name: tables.material[stem_of(name)] for name in files if stem_of(name) in tables.material}
            kinds |= {name: tables.on_sheet[stem_of(name)] for name in files if stem_of(name) in tables.on_sheet}
            yield from check_titles(files, kinds, shown_text(tables.project, tables.version))


@dataclass(frozen=True)
class _Tables:
    """What the tables say of the parts that are drawn."""

    contents: Contents

    @cached_property
    def version(self) -> str:
        return str(self.contents.manifest["settings"]["drawings"]["version"])

    @cached_property
    def labels(self) -> str:
        return str(self.contents.manifest["settings"]["drawings"]["labels"])

    @cached_property
    def project(self) -> str:
        """The first words of titles."""
        manifest = self.contents.manifest
        return TitleBlock(**manifest["settings"]["title_block"]).title_of(str(manifest["name"]))

    @cached_property
    def rows(self) -> dict[str, tuple[str, dict[str, str]]]:
        """The group and the row of each mark."""
        return {row["Mark"]: (group, row) for group, table in self.contents.tables_of_marks() for row in table}

    @cached_property
    def material(self) -> dict[str, str]:
        found = {}
        for mark, (group, row) in self.rows.items():
            thickness = next((text for column, text in row.items() if column.startswith("Thickness")), "")
            found[mark] = f"{group}, {row['Material']}, {thickness}"
        return found

    @cached_property
    def placed(self) -> dict[str, list[dict[str, str]]]:
        """The pieces on each sheet."""
        found: dict[str, list[dict[str, str]]] = defaultdict(list)
        for row in self.contents.table("pieces") if "pieces.csv" in self.contents.files else ():
            if row["Sheet"]:
                found[f"sheet-{int(row['Sheet']):03d}"].append(row)
        return found

    @cached_property
    def on_sheet(self) -> dict[str, str]:
        """Of what the pieces on each sheet are made."""
        return {
            sheet: "; ".join(sorted({self.material.get(row["Mark"], "") for row in rows}))
            for sheet, rows in self.placed.items()
        }

    @cached_property
    def neighbours(self) -> dict[str, set[str]]:
        """Of each mark of panels the marks across the edges of its pieces."""
        found: dict[str, set[str]] = defaultdict(set)
        if "panel_edges.csv" in self.contents.files:
            for row in self.contents.table("panel_edges"):
                found[row["Mark"]].add(row["Neighbour"].rpartition(" ")[0])
        return {mark: {name for name in names if name in self.rows} for mark, names in found.items()}

    @cached_property
    def words(self) -> dict[str, tuple[str, ...]]:
        """The lines below the drawing of each mark: its row in the report, without empty cells."""
        if "report.html" not in self.contents.files:
            return {}
        try:
            tables = self.contents.report[0]["tables"]
        except FolderError:
            return {}
        return {
            row[0]: tuple(f"{name}: {text}" for name, text in zip(table["columns"], row, strict=True) if text)
            for table in tables.values()
            for row in zip(*table["cells"], strict=True)
        }


def _of_part(name: str, file: DxfFile, part: PartFile, tables: _Tables) -> Iterator[str]:
    folder, mark = name.partition("/")[0], part.mark
    group, row = tables.rows.get(mark, ("", {}))
    if folder == "panels":
        texts = marks_on(mark, tables.labels, tables.neighbours.get(mark, ()), len(part.blank))
        yield from check_panel(name, file, part.blank, texts)
    elif folder == "plates":
        yield from check_plate(name, file, part.solid, ([mark],) if tables.labels != "none" else ())
    elif group:
        labels: tuple[str, ...] = ("A", "B")
        if group.endswith("nodes"):
            labels = tuple(map(str, range(1, int(row["Valence"]) + 1))) if group == "nodes" else ()
        yield from check_views(name, file, part.solid, labels)


def _of_words(files: Mapping[str, DxfFile], tables: _Tables) -> Iterator[str]:
    """The lines below a drawing begin with the project and the row of the mark, and end alike."""
    ends: dict[str, str] = {}
    for name, file in files.items():
        said, words = "".join(file.title), tables.words.get(stem_of(name))
        if words is None:
            continue
        project = [tables.project] if tables.project else []
        wanted = "".join(shown_text(word, tables.version) for word in (*project, *words))
        bare, row = said.replace(" ", ""), wanted.replace(" ", "")
        if bare.startswith(row):
            ends[name] = bare[len(row) :]
        else:
            at = next((k for k, (one, other) in enumerate(zip(bare, row, strict=False)) if one != other), len(bare))
            yield f"{name} says {bare[max(0, at - 20) : at + 20]!r}, the report {row[max(0, at - 20) : at + 20]!r}"
    for usual, _ in Counter(ends.values()).most_common(1):
        yield from (
            f"the last line of text in {name} is not that of the others" for name in ends if ends[name] != usual
        )


def _of_sheets(files: Mapping[str, DxfFile], tables: _Tables, outlines: dict[str, FloatArray]) -> Iterator[str]:
    if "pieces.csv" not in tables.contents.files or not outlines:
        return
    for name, file in files.items():
        rows = tables.placed[stem_of(name)]
        texts = [text for row in rows for text in marks_on(row["Mark"], tables.labels)]
        yield from check_sheet(name, file, rows, outlines, texts)

"""What a finished folder contains: its manifest and its tables, in the dialect that the manifest states."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
import re
import zipfile
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from pathlib import Path, PurePosixPath
from typing import Annotated, Any
from xml.etree import ElementTree

from pydantic import AfterValidator, AllowInfNan, TypeAdapter, ValidationError
from pydantic.dataclasses import dataclass as checked

from fabkit.errors import FolderError
from fabkit.formats.manifest import MANIFEST
from fabkit.production import table_file
from fabkit.rules import DrawingRules, SiteRules, TableRules, TitleBlock
from fabkit.wording import echo

__all__ = ["Contents", "FolderTable", "in_words"]


def _inside(path: str) -> str:
    if not path or "\0" in path or PurePosixPath(path).is_absolute() or ".." in PurePosixPath(path).parts:
        raise ValueError(path)
    return path


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON. Raises ValueError where it has a key twice."""
    found = dict(pairs)
    if len(found) != len(pairs):
        raise ValueError
    return found


_Inside = Annotated[str, AfterValidator(_inside)]
_Number = Annotated[float, AllowInfNan(False)]


@checked(frozen=True)
class _Settings:
    tables: TableRules
    drawings: DrawingRules
    title_block: TitleBlock
    site: SiteRules | None


@checked(frozen=True)
class _Manifest:
    """What the checks read of a manifest."""

    name: str
    files: dict[_Inside, str]
    folders: list[_Inside]
    counts: dict[str, int | dict[str, int]]
    origin: dict[str, tuple[_Number, _Number, _Number]]
    settings: _Settings
    versions: dict[str, str]


_MANIFEST: TypeAdapter[_Manifest] = TypeAdapter(_Manifest)
LONGEST_REASON = 200
"""Largest number of letters of what a library says of a cell that it cannot read."""
_NO_NUMBER = re.compile(r"\s*[-+]?(nan|inf(inity)?)\s*", re.IGNORECASE)
_MEASURED = re.compile(r"\((mm|deg|kg|m2)\)$|(^| )[xyz]$")
_COMMA_NUMBER = re.compile(r"-?\d+,\d+")
_DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)
_ARRAYS = re.compile(r'<script type="text/plain" id="model-data">(.*?)</script>', re.DOTALL)
_SHEET = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"


@dataclass(frozen=True)
class FolderTable:
    """A table as read: the names of its columns, and its rows as text, with decimal points; totals and sentences about
    parts that were left out are apart."""

    columns: tuple[str, ...]
    rows: tuple[dict[str, str], ...]
    totals: dict[str, str]
    left_out: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[dict[str, str]]:
        return iter(self.rows)


class Contents:
    """A folder that `fabkit build` wrote. Raises FolderError where there is no such folder, or where it is of a version
    whose manifest says less."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        if not folder.is_dir():
            raise FolderError(f"{folder} is not a folder: give one that fabkit build wrote")
        path = folder / MANIFEST
        if path.is_symlink() or not path.is_file():
            raise FolderError(
                f"{folder} has no {MANIFEST}, so fabkit build did not write it, or its files are incomplete"
            )
        damaged = (
            f"{path} cannot be read as that of a build: it is damaged, or of another version of fabkit; build the "
        )
        try:
            manifest = json.loads(path.read_bytes(), object_pairs_hook=_once)
            written, own = manifest["versions"]["fabkit"], version("fabkit")
        except (ValueError, LookupError, TypeError, RecursionError):
            raise FolderError(f"{damaged}folder again") from None
        if isinstance(written, str) and written != own:
            raise FolderError(
                f"{folder} was written by fabkit {written[:40]}, whose files may say other things than those of {own}: "
                "use that version, or build the folder again"
            )
        try:
            _MANIFEST.validate_python(manifest)
        except ValidationError as error:
            place = ".".join(map(str, error.errors()[0]["loc"]))
            raise FolderError(f"{damaged}folder again ({echo(place)} is not as a build writes it)") from None
        self.manifest: dict[str, Any] = manifest
        self._tables: dict[str, FolderTable] = {}

    @cached_property
    def files(self) -> dict[str, str]:
        """The hash of each file by its path, as the manifest lists them."""
        return dict(self.manifest["files"])

    @cached_property
    def found(self) -> dict[str, bool]:
        """Everything in the folder but folders, and whether it is a file: neither a link nor a pipe or the like."""
        return dict(_found(self.folder, ""))

    @cached_property
    def rules(self) -> TableRules:
        return TableRules(**self.manifest["settings"]["tables"])

    def data(self, name: str) -> bytes:
        """The bytes of a file. Raises FolderError where it is missing, a link or a pipe, or cannot be read."""
        if not self.found.get(name, False):
            why = "is missing" if name not in self.found else "is not read, since it is a link, a pipe or the like"
            raise FolderError(f"{name} {why}")
        try:
            return (self.folder / name).read_bytes()
        except OSError as error:
            raise FolderError(f"{name} cannot be read: {error.strerror or error}") from None

    def text(self, name: str) -> str:
        """The text of a file. Raises FolderError where it is missing or no text."""
        try:
            text = self.data(name).decode("utf-8-sig" if name.endswith(".csv") else "utf-8")
        except UnicodeDecodeError:
            raise FolderError(f"{name} is not text in UTF-8") from None
        return text.replace("\r\n", "\n").replace("\r", "\n")

    @cached_property
    def workbook(self) -> dict[str, list[list[str]]]:
        """The sheets of the workbook by their names, as rows of texts; numbers with all their digits. Raises
        FolderError where it is missing or damaged."""
        return _sheets("cutlist.xlsx", self.data("cutlist.xlsx"))

    @cached_property
    def report(self) -> tuple[dict[str, Any], str]:
        """What the scripts of report.html read: its data, and the arrays of its model. Raises FolderError where it is
        missing or damaged."""
        text = self.text("report.html")
        data, arrays = _DATA.findall(text), _ARRAYS.findall(text)
        if not text.rstrip().endswith("</html>") or len(data) != 1 or len(arrays) != 1:
            raise FolderError("report.html is not complete")
        try:
            return json.loads(data[0]), arrays[0].strip()
        except ValueError:
            raise FolderError("the tables in report.html are damaged") from None

    def as_read(self, cell: str) -> str:
        """A text as a table has it once it is read, with a decimal point where it looks like a number."""
        has_comma = self.rules.decimal == "," and _COMMA_NUMBER.fullmatch(cell)
        return cell.replace(",", ".") if has_comma else cell

    def table(self, name: str) -> FolderTable:
        """A table by its name, such as `pieces`, read once. Raises FolderError where it is missing or damaged."""
        if name not in self._tables:
            self._tables[name] = self._table(name)
        return self._tables[name]

    def check_unchanged(self, files: Sequence[str]) -> None:
        """Raise FolderError where one of these files is not as it was written."""
        for name in files:
            if hashlib.sha256(self.data(name)).hexdigest() != self.files.get(name):
                raise FolderError(
                    f"{name} there was changed after it was written; take an untouched copy of the folder"
                )

    def tables_of_marks(self) -> Iterator[tuple[str, FolderTable]]:
        """The groups that have a table of marks, and these."""
        for name in self.files:
            group = name.removesuffix(".csv").replace("_", " ")
            if group in self.manifest["counts"] and name.endswith(".csv"):
                yield group, self.table(group)

    def _table(self, name: str) -> FolderTable:
        file = table_file(name)
        text = self.text(file)
        if not text.endswith("\n"):
            raise FolderError(f"{file} is cut off: its last line has no end")
        reader = csv.reader(io.StringIO(text, newline=""), delimiter=self.rules.delimiter)
        try:
            head, *rows = list(reader)
        except (ValueError, csv.Error):
            raise FolderError(f"{file} is empty or damaged") from None
        for number, row in enumerate(rows, start=2):
            if len(row) != len(head):
                raise FolderError(f"row {number} of {file} has {len(row)} cells, its heading {len(head)}")
        if self.rules.decimal == ",":
            rows = [[self.as_read(cell) for cell in row] for row in rows]
        for column, cells in zip(head, zip(*rows, strict=True), strict=False):
            strange = [cell for cell in {*cells} if _NO_NUMBER.fullmatch(cell)] if _MEASURED.search(column) else []
            if strange:
                raise FolderError(f"{file} has {strange[0]} in the column {column}, which is no number")
        if len(set(head)) != len(head):
            raise FolderError(f"two columns of {file} have the same name")
        own = [dict(zip(head, row, strict=True)) for row in rows]
        first = head[0]
        totals = [row for row in own if row[first] == "Total"]
        if len(totals) > 1:
            raise FolderError(f"{file} has its totals twice")
        left_out = tuple(row[first] for row in own if row[first].startswith("left out:"))
        kept = [row for row in own if row[first] != "Total" and not row[first].startswith("left out:")]
        return FolderTable(tuple(head), tuple(kept), totals[0] if totals else {}, left_out)


def in_words(error: Exception) -> str:
    """What was wrong with a row or a cell that could not be read."""
    if isinstance(error, KeyError):
        return f"there is no {echo(error.args[0])} where one is needed"
    return " ".join(str(error).split())[:LONGEST_REASON]


def _found(folder: str | Path, prefix: str) -> Iterator[tuple[str, bool]]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _found(entry.path, f"{prefix}{entry.name}/")
            else:
                yield prefix + entry.name, entry.is_file(follow_symlinks=False)


def _sheets(file: str, data: bytes) -> dict[str, list[list[str]]]:
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as files:
            if files.testzip() is not None:
                raise FolderError(f"{file} is damaged")
            names = [
                each.get("name", "")
                for each in ElementTree.fromstring(files.read("xl/workbook.xml")).iter(f"{_SHEET}sheet")
            ]
            shared = [
                "".join(part.text or "" for part in item.iter(f"{_SHEET}t"))
                for item in ElementTree.fromstring(files.read("xl/sharedStrings.xml"))
            ]
            return {
                name: _rows(files.read(f"xl/worksheets/sheet{number}.xml"), shared)
                for number, name in enumerate(names, start=1)
            }
    except (
        zipfile.BadZipFile,
        zlib.error,
        ElementTree.ParseError,
        KeyError,
        ValueError,
        IndexError,
        EOFError,
    ):
        raise FolderError(f"{file} is damaged: it cannot be read as a workbook") from None


def _rows(data: bytes, shared: list[str]) -> list[list[str]]:
    rows = []
    for row in ElementTree.fromstring(data).iter(f"{_SHEET}row"):
        cells = []
        for cell in row.iter(f"{_SHEET}c"):
            value = cell.find(f"{_SHEET}v")
            text = "" if value is None else value.text or ""
            cells.append(shared[int(text)] if cell.get("t") == "s" and text else text)
        rows.append(cells)
    return rows

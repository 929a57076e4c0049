"""What is written, and how: which documents, their title block, and the dialects of tables, DXF and STEP."""

from __future__ import annotations

import datetime
from dataclasses import field
from typing import Annotated, Literal, get_args

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from fabkit.wording import echo, one_line

__all__ = ["DOCUMENTS", "Document", "DocumentRules", "DrawingRules", "StepRules", "TableRules", "TitleBlock"]

Document = Literal[
    "meshes", "step", "parts", "sheets", "panels", "plates", "drawings", "tables", "workbook", "glb", "report"
]
DOCUMENTS: tuple[Document, ...] = get_args(Document)
"""All documents: M.obj and S.obj, model.step, parts/, sheets/, panels/, plates/, drawings/, the CSV files,
cutlist.xlsx, model.glb, report.html."""

_STRICT = ConfigDict(extra="forbid")


def _date(given: object) -> object:
    """A date of TOML, or a text, as 2026-03-01; what is neither is left to the type."""
    if given and isinstance(given, str | datetime.date):
        try:
            return datetime.date.fromisoformat(str(given)).isoformat()
        except ValueError:
            raise ValueError("a date such as 2026-03-01 is needed, year first") from None
    return given


Line = Annotated[str, Field(max_length=120), AfterValidator(one_line)]


@dataclass(frozen=True, config=_STRICT)
class TitleBlock:
    """Who issues the documents, and which issue they are; written into STEP headers, drawings and the workbook.

    date: as 2026-03-01, never that of today, so that the same project gives the same bytes.

    >>> from fabkit.rules import TitleBlock
    >>> TitleBlock(author="A. Meier", date="2026-03-01", revision="B").issue
    'revision B, 2026-03-01'
    """

    author: Line = ""
    organisation: Line = ""
    date: Annotated[str, BeforeValidator(_date)] = ""
    revision: Line = ""

    @property
    def issue(self) -> str:
        """Revision and date in words, empty where neither is given."""
        return ", ".join(([f"revision {self.revision}"] if self.revision else []) + ([self.date] if self.date else []))

    def title_of(self, name: str) -> str:
        """The first words of drawings of the structure with this name: the name and the issue, as far as given."""
        return ", ".join(filter(None, (name, self.issue)))


@dataclass(frozen=True, config=_STRICT)
class TableRules:
    """The dialect of the CSV files.

    separator: comma, semicolon, tab or bar between cells. decimal: point or comma. bom: whether the files begin with a
    byte order mark, without which Excel reads names beyond ASCII wrongly.

    >>> from fabkit.rules import TableRules
    >>> TableRules(separator=";", decimal=",", bom=True)
    TableRules(separator=';', decimal=',', bom=True)
    """

    separator: Literal[",", ";", "tab", "|"] = ","
    decimal: Literal[".", ","] = "."
    bom: bool = False

    @model_validator(mode="after")
    def _can_be_read_back(self) -> TableRules:
        if self.separator == self.decimal:
            raise ValueError(
                f"separator and decimal are both {echo(self.decimal)}, so that numbers could not be told from cells: "
                "take the separator ';', or the decimal '.'"
            )
        return self

    @property
    def delimiter(self) -> str:
        """The character between two cells."""
        return "\t" if self.separator == "tab" else self.separator


@dataclass(frozen=True, config=_STRICT)
class DrawingRules:
    """DXF files. version: R12 knows no unit, so that its files are called P001-mm.dxf. labels: marks and arrows in a
    "corner" of the panel no larger than corner_mm, where the frame covers them, in the "middle" for plates that nobody
    looks through, or "none".

    >>> from fabkit.rules import DrawingRules
    >>> DrawingRules().suffix, DrawingRules(version="R12").suffix
    ('.dxf', '-mm.dxf')
    """

    version: Literal["R12", "R2010", "R2018"] = "R2010"
    labels: Literal["corner", "middle", "none"] = "corner"
    corner_mm: Annotated[float, Field(ge=5, le=1000, allow_inf_nan=False)] = 20.0

    @property
    def suffix(self) -> str:
        """End of the names of DXF files."""
        return "-mm.dxf" if self.version == "R12" else ".dxf"


@dataclass(frozen=True, config=_STRICT)
class StepRules:
    """STEP files. schema: AP242, or AP214 for programs that do not read it.

    >>> from fabkit.rules import StepRules
    >>> StepRules(schema="AP214").schema
    'AP214'
    """

    schema: Literal["AP242", "AP214"] = "AP242"


@dataclass(frozen=True, config=_STRICT)
class DocumentRules:
    """Which documents are written, and how.

    >>> from fabkit.rules import DocumentRules
    >>> DocumentRules(documents=("tables", "step")).documents, len(DocumentRules().documents)
    (('tables', 'step'), 11)
    """

    documents: tuple[Document, ...] = DOCUMENTS
    title_block: TitleBlock = field(default_factory=TitleBlock)
    tables: TableRules = field(default_factory=TableRules)
    drawings: DrawingRules = field(default_factory=DrawingRules)
    step: StepRules = field(default_factory=StepRules)

    @model_validator(mode="after")
    def _something(self) -> DocumentRules:
        if not self.documents:
            raise ValueError(
                f"documents is empty, so that nothing would be written; name some of {', '.join(DOCUMENTS)}"
            )
        return self

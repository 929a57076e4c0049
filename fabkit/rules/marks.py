"""How pieces are marked: what counts as equal, and how marks are numbered."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import AfterValidator, ConfigDict, Field
from pydantic.dataclasses import dataclass

__all__ = ["MarkOrder", "MarkRules"]

MAX_PREFIX_LETTERS = 16
"""Number of characters of the prefix of marks: with it a mark still fits on the side of a block and in a line of the
reports."""

MarkOrder = Literal["elements", "rings", "rows"]


def _prefix(text: str) -> str:
    sound = text.isascii() and text.replace("-", "").replace("_", "").isalnum() and text[0].isalnum()
    if text and not (sound and len(text) <= MAX_PREFIX_LETTERS):
        raise ValueError(
            "marks are names of files and products, and a spreadsheet must not take them for formulas: take up to "
            f"{MAX_PREFIX_LETTERS} of the letters A to Z, digits, - and _, a letter or digit first, as in 'NO1-'"
        )
    if text.isdigit():
        raise ValueError(
            f"a spreadsheet takes marks such as {text}E001 for numbers: add a letter or -, as in '{text}-'"
        )
    return text


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class MarkRules:
    """Marks, which equal pieces share.

    far_end_mm: of node blocks with one mark, how far the far ends of their beams may be displaced since their facets
    differ in direction, in each coordinate, for the longest beam; 10 000 is no limit, for nodes that are set in a jig.
    mirrored_panes: whether a pane that is the mirror image of another one is the same piece turned over, as it is where
    both faces are equal: neither coated nor printed. order: the order in which marks are numbered: that of the elements
    of the mesh, in rings from its boundary inwards, or in rows along its longer side. prefix, start: of marks, such as
    NO1-B100. keep: an earlier folder, whose marks equal pieces keep; others get numbers that it never had.

    >>> from fabkit.rules import MarkRules
    >>> MarkRules(prefix="NO1-", start=100).far_end_mm
    0.5
    """

    far_end_mm: Annotated[float, Field(gt=0, le=10_000, allow_inf_nan=False)] = 0.5
    mirrored_panes: bool = False
    order: MarkOrder = "elements"
    prefix: Annotated[str, AfterValidator(_prefix)] = ""
    start: Annotated[int, Field(ge=1, le=1_000_000)] = 1
    keep: Path | None = None

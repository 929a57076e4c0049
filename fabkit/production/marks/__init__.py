"""Marks: which parts are equal, how marks are numbered, and which an earlier folder had."""

from fabkit.production.marks.kept import MARK_POINTS, KeptMarks, MarkPoints, mark_points
from fabkit.production.marks.numbering import element_ranks
from fabkit.production.marks.sharing import EQUAL_WITHIN_MM, share_equal_parts

__all__ = [
    "EQUAL_WITHIN_MM",
    "MARK_POINTS",
    "KeptMarks",
    "MarkPoints",
    "element_ranks",
    "mark_points",
    "share_equal_parts",
]

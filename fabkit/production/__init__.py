"""From parts to shop documents, still as data: marks, nests, cut lists, drawings, the facts of a build."""

from fabkit.production.cut_lists import CutList, Table, cut_list, table_file
from fabkit.production.drawing import CUT, MARK, SHEET, Drawing, panel_drawings, sheet_drawings
from fabkit.production.erection import Erection, erection_order
from fabkit.production.facts import (
    ANY_LINES,
    LEAST_UNDIRECTED_SHARE,
    REPORT,
    SURFACE_DISTANCE,
    TERMINAL,
    WORKBOOK,
    BuildFacts,
    Fact,
    build_facts,
)
from fabkit.production.marks import (
    EQUAL_WITHIN_MM,
    MARK_POINTS,
    KeptMarks,
    MarkPoints,
    element_ranks,
    mark_points,
    share_equal_parts,
)
from fabkit.production.nesting import Nest, Sheet, nest_panels, panels_from_outlines, too_large
from fabkit.production.part_drawing import HIDDEN, LABEL, VISIBLE, part_drawings
from fabkit.production.pieces import mark_table, piece_tables
from fabkit.production.plate_drawing import plate_drawings
from fabkit.production.summary import (
    ExactGaussImage,
    GaussImageSource,
    GivenGaussImage,
    OptimisedGaussImage,
    Summary,
    SurfaceSummary,
    irregular_vertices,
)

__all__ = [
    "ANY_LINES",
    "CUT",
    "EQUAL_WITHIN_MM",
    "HIDDEN",
    "LABEL",
    "LEAST_UNDIRECTED_SHARE",
    "MARK",
    "MARK_POINTS",
    "REPORT",
    "SHEET",
    "SURFACE_DISTANCE",
    "TERMINAL",
    "VISIBLE",
    "WORKBOOK",
    "BuildFacts",
    "CutList",
    "Drawing",
    "Erection",
    "ExactGaussImage",
    "Fact",
    "GaussImageSource",
    "GivenGaussImage",
    "KeptMarks",
    "MarkPoints",
    "Nest",
    "OptimisedGaussImage",
    "Sheet",
    "Summary",
    "SurfaceSummary",
    "Table",
    "build_facts",
    "cut_list",
    "element_ranks",
    "erection_order",
    "irregular_vertices",
    "mark_points",
    "mark_table",
    "nest_panels",
    "panel_drawings",
    "panels_from_outlines",
    "part_drawings",
    "piece_tables",
    "plate_drawings",
    "share_equal_parts",
    "sheet_drawings",
    "table_file",
    "too_large",
]

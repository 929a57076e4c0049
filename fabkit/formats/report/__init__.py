"""The page that shows a build: model, tables, figures, sheets."""

from fabkit.formats.report.page import report_html

__all__ = ["report_html"]

"""The pages that show a build, and how two builds differ."""

from fabkit.formats.report.differences import ShownModel, differences_html
from fabkit.formats.report.html_page import report_values
from fabkit.formats.report.page import report_html

__all__ = ["ShownModel", "differences_html", "report_html", "report_values"]

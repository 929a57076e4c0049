"""Finished folders, from their files alone: whether one is as it was written, how two differ, the marks of one."""

from fabkit.formats.finished.differences import differences_page, folder_differences
from fabkit.formats.finished.earlier_marks import kept_marks
from fabkit.formats.finished.folder_checks import check_folder

__all__ = ["check_folder", "differences_page", "folder_differences", "kept_marks"]

"""Finished folders: whether one is still as it was written, and how two differ; from their files alone."""

from fabkit.formats.finished.differences import differences_page, folder_differences
from fabkit.formats.finished.folder_checks import check_folder

__all__ = ["check_folder", "differences_page", "folder_differences"]

"""The only room that knows formats and kernels; whole folders of files that appear at once or not at all."""

from fabkit.formats.documents import write_documents
from fabkit.formats.folder import check_replaceable, whole_folder
from fabkit.formats.gltf import glb_bytes
from fabkit.formats.kernels import to_build123d, to_cadquery
from fabkit.formats.legend_table import legend
from fabkit.formats.manifest import write_manifest
from fabkit.formats.single_files import whole_file
from fabkit.formats.surfaces import EXACT_SUFFIXES, exact_surface
from fabkit.formats.tables import write_csv
from fabkit.formats.workbook import write_xlsx

__all__ = [
    "EXACT_SUFFIXES",
    "check_replaceable",
    "exact_surface",
    "glb_bytes",
    "legend",
    "to_build123d",
    "to_cadquery",
    "whole_file",
    "whole_folder",
    "write_csv",
    "write_documents",
    "write_manifest",
    "write_xlsx",
]

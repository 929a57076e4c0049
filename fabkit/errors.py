"""Errors of fabkit: each message is one sentence that names the parts, the value, the bound and what to do."""

from __future__ import annotations

from geometry.errors import GeometryError, MeshFileError

__all__ = [
    "DetailingError",
    "FabkitError",
    "FolderError",
    "NestingError",
    "OutputError",
    "ProjectError",
    "error_sentence",
]


class FabkitError(ValueError):
    """Base of all errors of this package; `str(error)` is a sentence for the user.

    >>> from fabkit import FabkitError, Project, build
    >>> try:
    ...     build(Project(mesh="roof.obj", unit="m"))
    ... except FabkitError as error:
    ...     print(str(error).split(":")[0])
    there is no output folder
    """


class ProjectError(FabkitError):
    """The project file or the options ask for something that does not exist or does not make sense."""


class DetailingError(FabkitError):
    """A beam, node or panel cannot be built, or two parts do not fit."""


class NestingError(FabkitError):
    """A panel does not fit on a sheet, or a nest violates gaps or borders."""


class FolderError(FabkitError):
    """A finished folder, or a file in it, is not as fabkit writes it."""


class OutputError(FabkitError):
    """The output folder or a file in it cannot be written."""


def error_sentence(error: FabkitError | GeometryError) -> str:
    """The message of an error. If it numbers elements of a mesh, it says that they are counted from 0; messages about
    lines and elements of a file already say from where they count."""
    sentence = str(error)
    if isinstance(error, GeometryError) and not isinstance(error, MeshFileError) and error.elements:
        if "counted from" in sentence:
            return sentence
        return f"{sentence} (vertices, edges and faces counted from 0)"
    return sentence

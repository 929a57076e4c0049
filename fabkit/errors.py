"""What fabkit says when something cannot be made: a sentence that names parts, value, bound and what to do."""

from __future__ import annotations

from geometry.errors import GeometryError, MeshFileError

__all__ = ["DetailingError", "FabkitError", "NestingError", "OutputError", "ProjectError", "error_sentence"]


class FabkitError(ValueError):
    """Base of all errors of this package; `str(error)` is meant for the person at the keyboard.

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
    """A part fits on no sheet, or a nest breaks its own rules."""


class OutputError(FabkitError):
    """The output folder or a file in it cannot be written."""


def error_sentence(error: FabkitError | GeometryError) -> str:
    """What an error says; where it numbers elements of a mesh, from where it counts: from 0, but for what is said of
    lines and elements of a file, which says so itself."""
    said = str(error)
    if isinstance(error, GeometryError) and not isinstance(error, MeshFileError) and error.elements:
        if "counted from" in said:
            return said
        return f"{said} (vertices, edges and faces counted from 0)"
    return said

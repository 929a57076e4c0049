"""What fabkit says when something cannot be made: a sentence that names parts, value, bound and what to do."""

from __future__ import annotations

__all__ = ["DetailingError", "FabkitError", "NestingError", "OutputError", "ProjectError"]


class FabkitError(ValueError):
    """Base of all errors of this package; `str(error)` is meant for the person at the keyboard."""


class ProjectError(FabkitError):
    """The project file or the options ask for something that does not exist or does not make sense."""


class DetailingError(FabkitError):
    """A beam, node or panel cannot be built, or two parts do not fit."""


class NestingError(FabkitError):
    """A part fits on no sheet, or a nest breaks its own rules."""


class OutputError(FabkitError):
    """The output folder or a file in it cannot be written."""

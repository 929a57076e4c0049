"""An output file that appears complete or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from fabkit.errors import FabkitError, OutputError
from fabkit.signals import DeferredSignals
from geometry.errors import GeometryError

__all__ = ["DRAFTS", "naming", "whole_file"]

DRAFTS = ".fabkit"
"""End of the names of folders in which drafts are."""


@contextmanager
def whole_file(out: Path, *, force: bool, inputs: Iterable[Path] = ()) -> Iterator[Path]:
    """A path of the same name to write to; its file becomes `out` if no error is raised, and is removed otherwise.

    Other files written beside it, such as materials, are moved along with it. Existing files are replaced only with
    `force`, and the `inputs` never. Raises OutputError if a file may not be replaced, if the folder does not exist, and
    if the disk cannot be written.

    >>> import os
    >>> from pathlib import Path
    >>> with whole_file(Path("mesh.obj"), force=False) as draft:
    ...     _ = draft.write_text("v 0 0 0")
    ...     print(os.path.exists("mesh.obj"))
    False
    >>> os.listdir()
    ['mesh.obj']
    """
    inputs = tuple(inputs)
    with naming(out):
        _check_replaceable(out, force, inputs)
        with TemporaryDirectory(dir=out.parent, prefix=".", suffix=DRAFTS) as folder, naming(out, folder):
            yield Path(folder, out.name)
            with DeferredSignals():
                drafts = {out.parent / path.name: path for path in sorted(Path(folder).iterdir())}
                for target in drafts:
                    _check_replaceable(target, force, inputs)
                for target, draft in drafts.items():
                    os.replace(draft, target)


@contextmanager
def naming(out: Path, drafts: str = DRAFTS) -> Iterator[None]:
    """Raise errors of the operating system as OutputError that names the file or folder that is asked for. So are those
    of which a writer made a sentence about a draft, whose path has these drafts in it.

    >>> from pathlib import Path
    >>> from fabkit.formats.single_files import naming
    >>> with naming(Path("roof")):
    ...     Path("none/of/these").mkdir()
    Traceback (most recent call last):
        ...
    fabkit.errors.OutputError: roof cannot be written: No such file or directory
    """
    try:
        yield
    except OSError as error:
        raise OutputError(f"{out} cannot be written: {error.strerror or error}") from error
    except (FabkitError, GeometryError) as error:
        if not isinstance(error.__cause__, OSError) or drafts not in str(error):
            raise
        raise OutputError(f"{out} cannot be written: {error.__cause__.strerror or error.__cause__}") from error


def _check_replaceable(out: Path, force: bool, inputs: tuple[Path, ...]) -> None:
    if not out.parent.is_dir():
        raise OutputError(f"the folder {out.parent} in which {out.name} should appear does not exist; make it first")
    if not os.path.lexists(out):
        return
    if any(path.exists() and out.exists() and out.samefile(path) for path in inputs):
        raise OutputError(f"{out} is an input of this run; choose another name")
    if not out.is_file():
        raise OutputError(f"{out} is not a file, so it is not replaced; choose another name")
    if not force:
        raise OutputError(f"{out} exists already; choose another name, or replace it with --force")

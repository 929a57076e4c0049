"""An output folder that appears whole or not at all."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fabkit.errors import OutputError

__all__ = ["MANIFEST", "check_replaceable", "whole_folder"]

MANIFEST = "manifest.json"
"""Every folder that was written whole holds this file, and only such a folder is ever replaced."""


def check_replaceable(out: Path, *, force: bool) -> None:
    """Raise OutputError unless a folder may be written at `out`.

    An existing folder is replaced only with `force`, and only where it is empty or an earlier result of fabkit.
    """
    if not out.parent.is_dir():
        raise OutputError(f"the folder {out.parent} in which {out.name} should appear does not exist; make it first")
    if not out.exists() and not out.is_symlink():
        return
    if not force:
        raise OutputError(f"{out} exists already; choose another folder, or replace it with --force")
    if out.is_symlink() or not out.is_dir():
        raise OutputError(f"{out} is not a folder, so it is not replaced; choose another name")
    if any(out.iterdir()) and not (out / MANIFEST).is_file():
        raise OutputError(f"{out} holds files that fabkit did not write (no {MANIFEST}); choose another folder")


@contextmanager
def whole_folder(out: Path, *, force: bool) -> Iterator[Path]:
    """A folder to write into, which becomes `out` when all went well, and vanishes when not.

    Raises OutputError as `check_replaceable` does, and where the disk does not let us write.
    """
    out = Path(os.path.abspath(out))
    check_replaceable(out, force=force)
    try:
        draft = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    except OSError as error:
        raise OutputError(f"{out} cannot be written: {error.strerror}") from None
    try:
        draft.chmod(0o755)
        yield draft
        _swap(draft, out)
    except OSError as error:
        raise OutputError(f"{out} cannot be written: {error.strerror or error}") from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _swap(draft: Path, out: Path) -> None:
    """Put the draft where out is; what was there goes only once the draft is in place."""
    if not out.exists():
        draft.rename(out)
        return
    old = Path(tempfile.mkdtemp(prefix=f".{out.name}.old.", dir=out.parent))
    out.rename(old / out.name)
    try:
        draft.rename(out)
    except OSError:
        (old / out.name).rename(out)
        raise
    finally:
        if out.exists():
            shutil.rmtree(old, ignore_errors=True)

"""An output folder that appears complete or not at all, and replaces only files that fabkit wrote earlier."""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path

from fabkit.errors import OutputError
from fabkit.formats.manifest import foreign_files
from fabkit.formats.renaming import exchange, rename_new
from fabkit.formats.single_files import DRAFTS, naming
from fabkit.signals import DeferredSignals, exit_if_signalled

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

__all__ = ["check_replaceable", "whole_folder"]

MAX_NAMED_FILES = 5
"""Largest number of foreign files that an error names."""

LONGEST_FOLDER_NAME = 200
"""Largest number of bytes of a folder name that is not shortened in the name of the working folder beside it. File
systems allow 255."""


def check_replaceable(out: Path, *, force: bool, inputs: Iterable[Path] = ()) -> None:
    """Raise OutputError unless a folder may be written at `out`.

    An existing folder is replaced only with `force`, and only if fabkit wrote all files in it, none of them has been
    edited since, and none is among the `inputs`.

    >>> from fabkit.formats import check_replaceable
    >>> check_replaceable(Path("new"), force=False)
    >>> Path("old").mkdir()
    >>> _ = Path("old/notes.txt").write_text("mine")
    >>> check_replaceable(Path("old"), force=True)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    fabkit.errors.OutputError: ...old holds files that fabkit did not write...
    """
    with naming(out):
        out = _absolute(out)
        _check_parent(out)
        if not _exists(out):
            return
        if not force:
            raise OutputError(f"{out} exists already; choose another folder{_or_replace(out, inputs)}")
        _check_not_needed(out, inputs)
        _check_ours(out, out)


@contextmanager
def whole_folder(out: Path, *, force: bool, inputs: Iterable[Path] = ()) -> Iterator[Path]:
    """A folder to write into, which becomes `out` if no error is raised, and is removed otherwise.

    Its manifest has to be written last. Until the end no other run of fabkit can write to `out`. An earlier `out` is
    replaced only if `check_replaceable` allows it then. Raises OutputError as that does, if another run is writing, and
    if the disk cannot be written.

    >>> from fabkit.formats import whole_folder, write_manifest
    >>> with whole_folder(Path("out"), force=False) as folder:
    ...     _ = (folder / "list.csv").write_text("B001,6")
    ...     write_manifest(folder, {"name": "roof"})
    >>> sorted(path.name for path in Path("out").iterdir())
    ['list.csv', 'manifest.json']
    """
    inputs = tuple(inputs)
    with naming(out):
        out = _absolute(out)
        _check_parent(out)
        if not force and not _exists(_workspace(out)):
            check_replaceable(out, force=force, inputs=inputs)  # before anything is written beside it
        exit_if_signalled()
        with DeferredSignals() as signals:
            workspace = _workspace(out)
            lock = _locked(workspace, out)
            try:
                _clear(workspace, out)
                check_replaceable(out, force=force, inputs=inputs)
                draft = workspace / "draft"
                draft.mkdir()
                signals.deferring = False
                signals.handle()
                yield draft
                signals.deferring = True
                exit_if_signalled()
                _put_in_place(workspace, out, force=force)
            finally:
                signals.deferring = True
                _remove_workspace(workspace, out, lock)


def _absolute(out: Path) -> Path:
    """The absolute path. Symbolic links are resolved in the parent, but not in the last name."""
    if "\0" in str(out):
        raise OutputError(f"the folder {str(out)!r} has a NUL character in its name; choose another name")
    if out.name in ("", ".."):
        return Path(os.path.realpath(out))
    return Path(os.path.realpath(out.parent)) / out.name


def _exists(path: Path) -> bool:
    """Whether the path exists, if only as a broken link. Raises OSError where that cannot be known, or for a name that
    is too long."""
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    return True


def _check_parent(out: Path) -> None:
    if not out.parent.is_dir():
        raise OutputError(f"the folder {out.parent} in which {out.name} should appear does not exist; make it first")


def _check_not_needed(out: Path, inputs: Iterable[Path]) -> None:
    """Raise OutputError if an input, or the current folder, lies in the folder that would be replaced."""
    for path in inputs:
        if _contains(out, Path(os.path.abspath(path))) or _contains(out, Path(os.path.realpath(path))):
            raise OutputError(f"{out} contains {path}, which is an input of this run; choose another folder")
    if _contains(out, Path.cwd()):
        raise OutputError(f"{out} is the current folder, or contains it; choose another folder")


def _contains(folder: Path, path: Path) -> bool:
    """Whether a path is an existing folder or lies in it, however the two are spelled."""
    known = folder.lstat()
    found = (os.stat(place) for place in (path, *path.parents) if os.path.exists(place))
    return any(os.path.samestat(known, status) for status in found)


def _or_replace(out: Path, inputs: Iterable[Path]) -> str:
    """The advice to use --force, if that would replace `out`; otherwise empty."""
    try:
        _check_not_needed(out, inputs)
        _check_ours(out, out)
    except OutputError:
        return ""
    return ", or replace it with --force"


def _check_ours(folder: Path, out: Path) -> None:
    """Raise OutputError with the names of files in the folder, which is or was `out`, that fabkit did not write."""
    if folder.is_symlink() or not folder.is_dir():
        raise OutputError(f"{out} is not a folder, so it is not replaced; choose another name")
    names = list(islice(foreign_files(folder), MAX_NAMED_FILES + 1))
    if names:
        more = " and others" if len(names) > MAX_NAMED_FILES else ""
        raise OutputError(
            f"{out} holds files that fabkit did not write or that were edited since, and is not replaced: "
            f"{', '.join(names[:MAX_NAMED_FILES])}{more}; "
            "move them elsewhere, or choose another folder"
        )


def _put_in_place(workspace: Path, out: Path, *, force: bool) -> None:
    """Rename the draft to `out`. An earlier folder is checked again after it lost the name, and put back unless all its
    files are ours."""
    ready = workspace / "ready"
    (workspace / "draft").rename(ready)
    if not force or not _exists(out):
        try:
            rename_new(ready, out)
        except FileExistsError:
            raise OutputError(
                f"{out} was made by another program during this run, so it is kept; choose another folder"
            ) from None
        return
    before = exchange(ready, out, workspace / "before")
    try:
        _check_ours(before, out)
    except BaseException:
        exchange(before, out, ready)
        raise


# --- the working folder beside it


def _workspace(out: Path) -> Path:
    """The folder `.NAME.fabkit` beside `out`. A lock file in it, which the system releases when a process ends, shows
    whether a run is using it. The next run clears what an interrupted run left there, or puts it back.

    It contains up to three folders. draft: being written or removed, may be deleted. ready: the complete result before
    it becomes `out`; after the names were exchanged, the former `out`. before: the former `out` on systems that cannot
    exchange names.
    """
    name = out.name
    if len(os.fsencode(name)) > LONGEST_FOLDER_NAME:
        name = name[: LONGEST_FOLDER_NAME // 8] + hashlib.sha256(os.fsencode(name)).hexdigest()[:16]
    return out.parent / f".{name}{DRAFTS}"


def _locked(workspace: Path, out: Path) -> int:
    """A file descriptor that owns the lock of the workspace, which is made if it is missing."""
    while True:
        with suppress(FileExistsError):
            workspace.mkdir()
        try:
            lock = os.open(workspace / "lock", os.O_RDWR | os.O_CREAT)
        except FileNotFoundError:
            if workspace.is_symlink():
                raise
            continue  # another run has just ended and removed the folder
        except OSError:
            with suppress(OSError):
                workspace.rmdir()
            raise
        try:
            if not _is_free(lock):
                raise OutputError(f"another run of fabkit is writing {out}; wait for it, or choose another folder")
            if os.path.samestat(os.fstat(lock), os.stat(workspace / "lock")):
                return lock
        except FileNotFoundError:
            pass  # likewise: the lock file has been removed
        except BaseException:
            os.close(lock)
            raise
        os.close(lock)


def _is_free(lock: int) -> bool:
    """Take the lock, until it is closed or the process ends; False if another process has it."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(lock, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    return True


def _clear(workspace: Path, out: Path) -> None:
    """Remove drafts and earlier results from the workspace, but put back a former `out` that was not replaced.

    Raises OutputError if fabkit did not write all files in them.
    """
    draft, ready, before = (workspace / name for name in ("draft", "ready", "before"))
    if _exists(before) and not _exists(out):
        rename_new(before, out)
    with suppress(FileNotFoundError):
        shutil.rmtree(draft)
    for folder in (ready, before):
        if _exists(folder):
            _check_ours(folder, folder)
            folder.rename(draft)  # a half-removed folder would no longer be recognised as ours
            shutil.rmtree(draft)


def _remove_workspace(workspace: Path, out: Path, lock: int) -> None:
    """Remove the workspace; the next run removes what cannot be removed now."""
    try:
        with suppress(OSError, OutputError):
            _clear(workspace, out)
            if sys.platform == "win32":
                os.close(lock)
                lock = -1
            (workspace / "lock").unlink()
            workspace.rmdir()
    finally:
        if lock >= 0:
            os.close(lock)

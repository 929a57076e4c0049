"""An output folder that appears whole or not at all, and replaces nothing that an earlier result did not write."""

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
from fabkit.signals import DeferredSignals, exit_if_signalled

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

__all__ = ["check_replaceable", "whole_folder"]

MAX_NAMED_FILES = 5
"""Largest number of foreign files that an error names."""

LONGEST_FOLDER_NAME = 200
"""Largest number of bytes of a folder name that is used whole in the name of the working folder beside it. File systems
take 255."""


def check_replaceable(out: Path, *, force: bool, inputs: Iterable[Path] = ()) -> None:
    """Raise OutputError unless a folder may be written at `out`.

    An existing folder is replaced only with `force`, and only where all files in it are as an earlier result of fabkit
    wrote them, none of which is among the `inputs`.

    >>> from fabkit.formats import check_replaceable
    >>> check_replaceable(Path("new"), force=False)
    >>> Path("old").mkdir()
    >>> _ = Path("old/notes.txt").write_text("mine")
    >>> check_replaceable(Path("old"), force=True)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    fabkit.errors.OutputError: ...old holds files that fabkit did not write...
    """
    with _said_of(out):
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
    """A folder to write into, which becomes `out` when all went well, and vanishes when not.

    Its manifest has to be written last. Until the end no other process can write to `out`. What is there then is
    replaced as `check_replaceable` allows it, or stays. Raises OutputError as that does, where another process is
    writing, and where the disk does not let us write.

    >>> from fabkit.formats import whole_folder, write_manifest
    >>> with whole_folder(Path("out"), force=False) as folder:
    ...     _ = (folder / "list.csv").write_text("B001,6")
    ...     write_manifest(folder, {"name": "roof"})
    >>> sorted(path.name for path in Path("out").iterdir())
    ['list.csv', 'manifest.json']
    """
    inputs = tuple(inputs)
    with _said_of(out):
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
                signals.waiting = False
                signals.answer()
                yield draft
                signals.waiting = True
                exit_if_signalled()
                _put_in_place(workspace, out, force=force)
            finally:
                signals.waiting = True
                _leave(workspace, out, lock)


def _absolute(out: Path) -> Path:
    """With links followed, but where the last name is one."""
    if "\0" in str(out):
        raise OutputError(f"the folder {str(out)!r} has a NUL character in its name; choose another name")
    if out.name in ("", ".."):
        return Path(os.path.realpath(out))
    return Path(os.path.realpath(out.parent)) / out.name


def _exists(path: Path) -> bool:
    """Also where it is a link that leads nowhere. Raises OSError where that cannot be known, or no name is so long."""
    try:
        path.lstat()
    except FileNotFoundError:
        return False
    return True


def _check_parent(out: Path) -> None:
    if not out.parent.is_dir():
        raise OutputError(f"the folder {out.parent} in which {out.name} should appear does not exist; make it first")


def _check_not_needed(out: Path, inputs: Iterable[Path]) -> None:
    """Raise OutputError where an input, or the working folder, is in the folder that would be replaced."""
    for path in inputs:
        if _holds(out, Path(os.path.abspath(path))) or _holds(out, Path(os.path.realpath(path))):
            raise OutputError(f"{out} holds {path}, from which it would be made; choose another folder")
    if _holds(out, Path.cwd()):
        raise OutputError(f"{out} is the folder in which you are, or holds it; choose another folder")


def _holds(folder: Path, path: Path) -> bool:
    """Whether a path is a folder that exists, or in it, however the two are spelled."""
    known = folder.lstat()
    found = (os.stat(place) for place in (path, *path.parents) if os.path.exists(place))
    return any(os.path.samestat(known, status) for status in found)


def _or_replace(out: Path, inputs: Iterable[Path]) -> str:
    """What else may be done about what is at `out`, where it may."""
    try:
        _check_not_needed(out, inputs)
        _check_ours(out, out)
    except OutputError:
        return ""
    return ", or replace it with --force"


def _check_ours(folder: Path, out: Path) -> None:
    """Raise OutputError, naming them, where files in the folder that is or was at `out` are not ours."""
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
    """Give the draft its name. What has the name goes only where it is still ours when it no longer has it."""
    ready = workspace / "ready"
    (workspace / "draft").rename(ready)
    if not force or not _exists(out):
        try:
            rename_new(ready, out)
        except FileExistsError:
            raise OutputError(
                f"{out} was made by somebody else meanwhile, so it stays; choose another folder"
            ) from None
        return
    before = exchange(ready, out, workspace / "before")
    try:
        _check_ours(before, out)
    except BaseException:
        exchange(before, out, ready)
        raise


# --- the folder beside it in which we work


def _workspace(out: Path) -> Path:
    """The folder `.NAME.fabkit` beside `out`, which is ours alone until the end: a lock in it, which the system takes
    from a process that ends, tells whether somebody works there. What a process left that did not come to its end is
    cleared by the next one, or put back.

    draft: being written, or being removed, and of no worth. ready: a whole result, which is to take the place of `out`,
    or, where names were exchanged, is what was there. before: what was there, where the system cannot exchange names.
    """
    name = out.name
    if len(os.fsencode(name)) > LONGEST_FOLDER_NAME:
        name = name[: LONGEST_FOLDER_NAME // 8] + hashlib.sha256(os.fsencode(name)).hexdigest()[:16]
    return out.parent / f".{name}.fabkit"


def _locked(workspace: Path, out: Path) -> int:
    """A file descriptor that holds the lock of the workspace, which is made if it is missing."""
    while True:
        with suppress(FileExistsError):
            workspace.mkdir()
        try:
            lock = os.open(workspace / "lock", os.O_RDWR | os.O_CREAT)
        except FileNotFoundError:
            if workspace.is_symlink():
                raise
            continue  # another run left just now, and took the folder away
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
            pass  # the same: the lock is of a file that is no more
        except BaseException:
            os.close(lock)
            raise
        os.close(lock)


def _is_free(lock: int) -> bool:
    """Whether no process had the lock, which is ours from now on until it is closed, or the process ends."""
    try:
        if sys.platform == "win32":
            msvcrt.locking(lock, msvcrt.LK_NBLCK, 1)
        else:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        return False
    return True


def _clear(workspace: Path, out: Path) -> None:
    """Remove drafts and earlier results from the workspace, but put back what was taken from `out` and not replaced.

    Raises OutputError where files are among them that fabkit did not write.
    """
    draft, ready, before = (workspace / name for name in ("draft", "ready", "before"))
    if _exists(before) and not _exists(out):
        rename_new(before, out)
    with suppress(FileNotFoundError):
        shutil.rmtree(draft)
    for folder in (ready, before):
        if _exists(folder):
            _check_ours(folder, folder)
            folder.rename(draft)  # half of it is no longer known as ours
            shutil.rmtree(draft)


def _leave(workspace: Path, out: Path, lock: int) -> None:
    """Take the workspace away; what cannot be taken away now is seen to by the next run."""
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


@contextmanager
def _said_of(out: Path) -> Iterator[None]:
    """Errors of the system, as OutputError that names the folder."""
    try:
        yield
    except OSError as error:
        raise OutputError(f"{out} cannot be written: {error.strerror or error}") from error

"""Atomic renaming of folders: without overwriting, and without a moment in which the name is missing."""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from pathlib import Path

__all__ = ["exchange", "rename_new"]

_UNKNOWN = {errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP}
"""Errors of operating systems and file systems that do not support these calls."""

_LINUX_HERE = -100
"""AT_FDCWD: paths start from the working folder."""


def rename_new(source: Path, target: Path) -> None:
    """Give a folder a new name. Raises FileExistsError, changing nothing, if the name is taken."""
    if _renamed(source, target, linux=1, darwin=4):
        return
    if os.name == "nt":
        source.rename(target)  # refuses to replace
        return
    target.mkdir()  # the name is ours from here on
    try:
        source.rename(target)  # replaces an empty folder only
    except BaseException:
        target.rmdir()
        raise


def exchange(new: Path, target: Path, backup: Path) -> Path:
    """Put the folder `new` where `target` is. Returns where the former target is from then on: at `new` or `backup`.

    If anything fails, nothing has changed. On systems that cannot exchange two names, the name `target` is missing for
    a moment.
    """
    if _renamed(new, target, linux=2, darwin=2):
        return new
    target.rename(backup)
    try:
        new.rename(target)
    except BaseException:
        backup.rename(target)
        raise
    return backup


def _renamed(source: Path, target: Path, *, linux: int, darwin: int) -> bool:
    """Rename with these flags of the system; False if it does not support them."""
    if sys.platform not in ("linux", "darwin"):
        return False
    libc = ctypes.CDLL(None, use_errno=True)
    paths = os.fsencode(source), os.fsencode(target)
    if sys.platform == "linux" and hasattr(libc, "renameat2"):
        failed = libc.renameat2(_LINUX_HERE, paths[0], _LINUX_HERE, paths[1], ctypes.c_uint(linux))
    elif sys.platform == "darwin" and hasattr(libc, "renamex_np"):
        failed = libc.renamex_np(paths[0], paths[1], ctypes.c_uint(darwin))
    else:
        return False
    if not failed:
        return True
    code = ctypes.get_errno()
    if code in _UNKNOWN:
        return False
    raise OSError(code, os.strerror(code), str(source), None, str(target))

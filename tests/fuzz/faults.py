"""What a file system may do to a run: nothing can be made outside a folder, the device is full, one call fails."""

from __future__ import annotations

import os
import resource
import sys
from pathlib import Path

__all__ = ["FileSystem"]

PATHS_OF = {"open": 1, "os.mkdir": 1, "os.rename": 2, "os.remove": 1, "os.rmdir": 1, "os.symlink": 2, "os.link": 2}
"""Arguments that are paths of what the system is asked for."""

WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


class FileSystem:
    """Inside, what would be made or removed outside `folder` is refused and noted in `outside`.

    failing: which call that concerns the folder fails once, with that number of an error. device: bytes that a file
    may have, as on a device that is nearly full.
    """

    def __init__(self, folder: Path, *, failing: tuple[int, int] | None = None, device: int | None = None) -> None:
        self._folder = os.path.realpath(folder) + os.sep
        self._failing, self._calls, self._device = failing, 0, device
        self.outside: list[str] = []

    def __enter__(self) -> FileSystem:
        if not _watching:
            sys.addaudithook(lambda event, arguments: _watching[-1] and _watching[-1]._hear(event, arguments))
        _watching.append(self)
        self._limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        if self._device is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (self._device, self._limits[1]))
        return self

    def __exit__(self, *error: object) -> None:
        _watching.append(None)
        resource.setrlimit(resource.RLIMIT_FSIZE, self._limits)

    def _hear(self, event: str, arguments: tuple[object, ...]) -> None:
        paths = [os.fsdecode(path) for path in arguments[: PATHS_OF.get(event, 0)] if isinstance(path, str | bytes)]
        flags = int(str(arguments[2] or 0)) if event == "open" else 0
        is_writing = event != "open" or bool(flags & WRITING)
        is_tidying = event in ("os.remove", "os.rmdir") or bool(flags & os.O_NONBLOCK)  # as `rmtree` opens folders
        for path in paths:
            place = os.path.join(os.path.realpath(os.path.dirname(path)), os.path.basename(path))
            if not place.startswith(self._folder):
                if is_writing and not path.startswith("/dev/"):
                    self.outside.append(place)
                    raise PermissionError(13, os.strerror(13), path)
                continue
            self._calls += not is_tidying  # where that fails, the next run does it
            if self._failing and self._calls == self._failing[0] and not is_tidying:
                self._calls += 1
                raise OSError(self._failing[1], os.strerror(self._failing[1]), path)


_watching: list[FileSystem | None] = []

"""The manifest: a list of the files in a folder with their hashes, which shows whether any was added or edited
since."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from fabkit.production import Fact

__all__ = ["MANIFEST", "foreign_files", "write_manifest"]

MANIFEST = "manifest.json"

_SYSTEM_FILES = {".DS_Store", ".localized", ".directory", "Thumbs.db", "ehthumbs.db", "desktop.ini", "Icon\r"}
"""Files that operating systems create in folders that are opened, and create again when needed."""

_UNSIGNED = "0" * 64
_HASH_BLOCK_BYTES = 1 << 16
"""Number of bytes read at a time while a file is hashed."""


def write_manifest(folder: Path, entries: dict[str, Any], facts: Iterable[Fact] = ()) -> None:
    """Write manifest.json: these entries, the facts by their keys, then a list of everything in the folder.

    `folders` are those within it; `files` gives the sha256 of every file by its path, parts of which are joined by /.
    `sha256` is that of the manifest itself, written with 64 zeros in its place.

    >>> from fabkit.formats import write_manifest
    >>> _ = Path("list.csv").write_text("B001,6")
    >>> write_manifest(Path(), {"name": "roof"})
    >>> manifest = json.loads(Path("manifest.json").read_text())
    >>> manifest["name"], list(manifest["files"])
    ('roof', ['list.csv'])
    """
    files: dict[str, str] = {}
    folders: list[str] = []
    for name, entry in _entries(folder, ""):
        if entry.is_dir(follow_symlinks=False):
            folders.append(name)
        else:
            files[name] = _sha256(entry.path)
    listed = {**entries, **_by_keys(facts), "folders": folders, "files": files, "sha256": _UNSIGNED}
    text = json.dumps(listed, indent=1) + "\n"
    signature = hashlib.sha256(text.encode("ascii")).hexdigest()
    head, _, tail = text.rpartition(_UNSIGNED)
    (folder / MANIFEST).write_text(head + signature + tail, encoding="ascii", newline="\n")


def _entries(folder: str | Path, prefix: str) -> Iterator[tuple[str, os.DirEntry[str]]]:
    """All files and folders in a folder, with their paths relative to it."""
    with os.scandir(folder) as found:
        entries = sorted(found, key=lambda entry: entry.name)
    for entry in entries:
        yield prefix + entry.name, entry
        if entry.is_dir(follow_symlinks=False):
            yield from _entries(entry.path, f"{prefix}{entry.name}/")


def _by_keys(facts: Iterable[Fact]) -> dict[str, Any]:
    tree: dict[str, Any] = {}
    for fact in facts:
        for key, value in zip(fact.keys, fact.values if fact.keys else (), strict=True):
            *outer, last = key.split(".")
            branch = tree
            for name in outer:
                branch = branch.setdefault(name, {})
            branch[last] = value
    return tree


def foreign_files(folder: Path) -> Iterator[str]:
    """The files that were added to the folder or edited since its manifest was written, a few words for each.

    Files of the operating system and missing files do not count. Without a valid manifest all files are named. Raises
    OSError where something cannot be read.
    """
    if folder.is_symlink() or not folder.is_dir():
        yield "it is not a folder"
        return
    files, folders = _listed(folder)
    yield from _others(folder, "", files, folders)


def _others(folder: Path, prefix: str, files: dict[str, str], folders: set[str]) -> Iterator[str]:
    with os.scandir(folder) as found:
        entries = sorted(found, key=lambda entry: entry.name)
    for entry in entries:
        name = prefix + entry.name
        if entry.is_dir(follow_symlinks=False):
            if name not in folders:
                yield name + "/"
            else:
                yield from _others(Path(entry), name + "/", files, folders)
        elif not entry.is_file(follow_symlinks=False):
            yield name
        elif name in files:
            if files[name] != _sha256(entry.path):
                yield f"{name} (edited)"
        elif name == MANIFEST:
            yield f"{name} (edited, or of an earlier version: it does not say what fabkit wrote)"
        elif not _is_system_file(prefix, entry.name, files, folders):
            yield name


def _listed(folder: Path) -> tuple[dict[str, str], set[str]]:
    """Files and folders according to the manifest, including itself; nothing if it is missing or was edited."""
    path = folder / MANIFEST
    nothing: tuple[dict[str, str], set[str]] = {}, set()
    if path.is_symlink() or not path.is_file():
        return nothing
    data = path.read_bytes()
    try:
        entries = json.loads(data)
        signature, files, folders = entries["sha256"], dict(entries["files"]), set(entries["folders"])
        unsigned = data.replace(signature.encode("ascii"), _UNSIGNED.encode("ascii"))
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return nothing
    if hashlib.sha256(unsigned).hexdigest() != signature:
        return nothing
    return {**files, MANIFEST: hashlib.sha256(data).hexdigest()}, folders


def _is_system_file(prefix: str, name: str, files: dict[str, str], folders: set[str]) -> bool:
    """Whether it is a file of the operating system; macOS also makes `._` files on some file systems."""
    beside = prefix + name.removeprefix("._")
    return name in _SYSTEM_FILES or (
        name.startswith("._") and (beside in files or beside in folders or name[2:] in _SYSTEM_FILES)
    )


def _sha256(path: str | Path) -> str:
    digest = hashlib.sha256()
    with open(
        path, "rb", buffering=0
    ) as stream:  # most files are small, so buffers would cost more time than they save
        while block := stream.read(_HASH_BLOCK_BYTES):
            digest.update(block)
    return digest.hexdigest()

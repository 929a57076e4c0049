"""The output folder appears whole or not at all, and nothing that is not ours is ever replaced."""

from __future__ import annotations

import json
import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from fabkit.errors import OutputError
from fabkit.formats import folder as folders
from fabkit.formats import renaming
from fabkit.formats.folder import check_replaceable, whole_folder
from fabkit.formats.manifest import MANIFEST, foreign_files, write_manifest


def write(out: Path, text: str, *, force: bool = False) -> None:
    with whole_folder(out, force=force) as folder:
        (folder / "part.txt").write_text(text)
        (folder / "parts").mkdir()
        (folder / "parts" / "B001.step").write_text(text + text)
        (folder / "sheets").mkdir()
        write_manifest(folder, {"name": text})


def test_it_appears_whole(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with whole_folder(out, force=False) as folder:
        (folder / "a").write_text("a")
        assert not out.exists()
    assert (out / "a").read_text() == "a"
    assert list(tmp_path.iterdir()) == [out]


def test_it_does_not_appear_when_something_goes_wrong(tmp_path: Path) -> None:
    def fail_halfway() -> None:
        with whole_folder(tmp_path / "out", force=False) as folder:
            (folder / "a").write_text("a")
            raise KeyError

    with pytest.raises(KeyError):
        fail_halfway()
    assert list(tmp_path.iterdir()) == []


def test_an_earlier_result_is_replaced_only_with_force(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "one")
    with pytest.raises(OutputError, match="exists already"):
        write(out, "two")
    assert (out / "part.txt").read_text() == "one"
    write(out, "two", force=True)
    assert (out / "part.txt").read_text() == "two"
    assert list(tmp_path.iterdir()) == [out]


def test_force_is_offered_only_where_it_would_be_taken(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "one")
    (tmp_path / "link").symlink_to(out)
    (tmp_path / "file").touch()
    with pytest.raises(OutputError, match="--force"):
        check_replaceable(out, force=False)
    for path, inputs in ((tmp_path / "link", []), (tmp_path / "file", []), (tmp_path, []), (out, [out / "part.txt"])):
        with pytest.raises(OutputError, match=r"exists already; choose another folder$"):
            check_replaceable(path, force=False, inputs=inputs)
        with pytest.raises(OutputError):
            check_replaceable(path, force=True, inputs=inputs)


def test_a_failure_keeps_the_earlier_result(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "one")
    with pytest.raises(KeyError), whole_folder(out, force=True):
        raise KeyError
    assert (out / "part.txt").read_text() == "one"
    assert list(tmp_path.iterdir()) == [out]


def test_what_is_not_ours_is_not_replaced_even_with_force(tmp_path: Path) -> None:
    mine = tmp_path / "thesis"
    mine.mkdir()
    (mine / "chapter.txt").write_text("years of work")
    with pytest.raises(OutputError, match=r"holds files that fabkit did not write .*: chapter\.txt; move them"):
        write(mine, "x", force=True)
    assert (mine / "chapter.txt").read_text() == "years of work"
    file = tmp_path / "file"
    file.write_text("text")
    with pytest.raises(OutputError, match="is not a folder"):
        write(file, "x", force=True)
    with pytest.raises(OutputError, match="does not exist; make it first"):
        write(tmp_path / "no" / "out", "x")
    assert {path.name for path in tmp_path.iterdir()} == {"thesis", "file"}


def add_file(out: Path) -> str:
    (out / "notes.txt").write_text("mine")
    return "notes.txt"


def add_file_below(out: Path) -> str:
    (out / "parts" / "B001.nc").write_text("G0")
    return "parts/B001.nc"


def add_empty_folder(out: Path) -> str:
    (out / "cam").mkdir()
    return "cam/"


def add_link(out: Path) -> str:
    (out / "link").symlink_to("part.txt")
    return "link"


def edit_file(out: Path) -> str:
    (out / "parts" / "B001.step").write_text("corrected by hand")
    return r"parts/B001\.step \(edited\)"


def make_link_of_file(out: Path) -> str:
    (out / "part.txt").rename(out.parent / "part.txt")
    (out / "part.txt").symlink_to("../part.txt")
    return r"part\.txt"


def edit_manifest(out: Path) -> str:
    manifest = json.loads((out / MANIFEST).read_text())
    (out / MANIFEST).write_text(json.dumps({**manifest, "name": "another"}, indent=1) + "\n")
    return r"manifest\.json \(edited, or of an earlier version"


def remove_manifest(out: Path) -> str:
    (out / MANIFEST).unlink()
    return r"part\.txt, parts/, sheets/"


def write_earlier_manifest(out: Path) -> str:
    (out / MANIFEST).write_text('{"name": "roof", "counts": {"beams": 5}}\n')
    return r"manifest\.json \(edited, or of an earlier version"


def write_manifest_of_a_web_app(out: Path) -> str:
    (out / MANIFEST).write_text('{"name": "app", "icons": [], "files": 5, "sha256": "no", "folders": null}\n')
    return r"manifest\.json \(edited, or of an earlier version"


def put_folder_for_file(out: Path) -> str:
    (out / "part.txt").unlink()
    (out / "part.txt").mkdir()
    return "part.txt/"


CHANGES = [
    add_file,
    add_file_below,
    add_empty_folder,
    add_link,
    edit_file,
    make_link_of_file,
    edit_manifest,
    remove_manifest,
    write_earlier_manifest,
    write_manifest_of_a_web_app,
    put_folder_for_file,
]


def contents(folder: Path) -> dict[str, str]:
    """Every path below the folder, with what it holds."""
    return {
        str(path.relative_to(folder)): (os.readlink(path) if path.is_symlink() else path.read_text())
        if not path.is_dir()
        else ""
        for path in folder.rglob("*")
    }


@pytest.mark.parametrize("change", CHANGES)
def test_what_was_added_or_edited_stays_and_is_named(tmp_path: Path, change: Callable[[Path], str]) -> None:
    out = tmp_path / "out"
    write(out, "one")
    name = change(out)
    before = contents(tmp_path)
    with pytest.raises(OutputError, match=name):
        write(out, "two", force=True)
    assert contents(tmp_path) == before


@pytest.mark.parametrize("change", CHANGES)
def test_what_is_added_or_edited_during_a_build_stays_too(tmp_path: Path, change: Callable[[Path], str]) -> None:
    out = tmp_path / "out"
    write(out, "one")

    def build() -> None:
        with whole_folder(out, force=True) as folder:
            write_manifest(folder, {})
            found.append(change(out))
            found.append(contents(out))

    found: list[object] = []
    with pytest.raises(OutputError, match=r"manifest\.json|holds files"):
        build()
    assert contents(out) == found[1]
    assert not list(tmp_path.glob(".out.*"))


def test_many_files_are_not_all_named(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "one")
    for number in range(30):
        (out / f"note{number:02}.txt").write_text("mine")
    with pytest.raises(OutputError, match=r"note03\.txt, note04\.txt and others; move them"):
        check_replaceable(out, force=True)


def test_litter_of_the_system_and_missing_files_do_not_matter(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "one")
    for name in (".DS_Store", "Thumbs.db", "parts/desktop.ini", "parts/._B001.step", "._parts", "._.DS_Store"):
        (out / name).write_bytes(b"\0\1")
    (out / "part.txt").unlink()
    (out / "sheets").rmdir()
    write(out, "two", force=True)
    assert set(contents(out)) == {"part.txt", "parts", "parts/B001.step", "sheets", MANIFEST}
    (out / "._diary").write_text("mine")
    assert list(foreign_files(out)) == ["._diary"]


def test_a_file_of_another_result_is_none_of_this_one(tmp_path: Path) -> None:
    write(tmp_path / "one", "one")
    write(tmp_path / "two", "two")
    assert list(foreign_files(tmp_path / "one")) == []
    (tmp_path / "one" / "part.txt").write_bytes((tmp_path / "two" / "part.txt").read_bytes())
    assert list(foreign_files(tmp_path / "one")) == ["part.txt (edited)"]


def test_no_input_is_in_the_folder_nor_are_we(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out"
    write(out, "one")
    (tmp_path / "link").symlink_to(out)
    (tmp_path / "mesh.obj").symlink_to(out / "part.txt")
    for path in (out / "part.txt", tmp_path / "link" / "parts" / "B001.step", tmp_path / "mesh.obj"):
        with pytest.raises(OutputError, match="which is an input of this run"):
            check_replaceable(out, force=True, inputs=[path])
    check_replaceable(out, force=True, inputs=[tmp_path / "another.obj"])
    for place in (out, out / "parts"):
        monkeypatch.chdir(place)
        with pytest.raises(OutputError, match="is the current folder"):
            write(out, "two", force=True)
    with pytest.raises(OutputError, match="is the current folder"):
        write(Path("/"), "two", force=True)
    assert (out / "part.txt").read_text() == "one"


# --- others who write at the same time


@pytest.mark.parametrize("atomic", [True, False])
@pytest.mark.parametrize("filled", [True, False])
def test_what_appears_meanwhile_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, atomic: bool, filled: bool
) -> None:
    if not atomic:
        monkeypatch.setattr(renaming, "_renamed", lambda *paths, **flags: False)
    out = tmp_path / "out"

    def build() -> None:
        with whole_folder(out, force=False) as folder:
            write_manifest(folder, {})
            out.mkdir()
            if filled:
                (out / "mine.txt").write_text("mine")

    with pytest.raises(OutputError, match="was made by another program during this run"):
        build()
    assert contents(tmp_path) == ({"out": "", "out/mine.txt": "mine"} if filled else {"out": ""})


def test_only_one_of_two_runs_writes(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with whole_folder(out, force=False) as folder:
        write_manifest(folder, {"name": "first"})
        with pytest.raises(OutputError, match="another run of fabkit is writing"):
            write(out, "second")
        assert folder.is_dir()
    assert json.loads((out / MANIFEST).read_text())["name"] == "first"


def test_of_many_threads_one_wins(tmp_path: Path) -> None:
    wins: list[str] = []
    start = threading.Barrier(8)

    def run(name: str) -> None:
        start.wait()
        try:
            write(tmp_path / "out", name)
            wins.append(name)
        except OutputError:
            pass

    threads = [threading.Thread(target=run, args=(str(number),)) for number in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(wins) == 1
    assert json.loads((tmp_path / "out" / MANIFEST).read_text())["name"] == wins[0]
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


# --- names that are exchanged


def test_the_name_is_never_missing(tmp_path: Path) -> None:
    out = tmp_path / "out"
    write(out, "0")
    missing, stop = [], threading.Event()

    def look() -> None:
        while not stop.is_set():
            if not os.path.exists(out / "part.txt"):
                missing.append(1)

    thread = threading.Thread(target=look)
    thread.start()
    for number in range(30):
        write(out, str(number), force=True)
    stop.set()
    thread.join()
    assert not missing


@pytest.mark.parametrize("fails", [1, 2])
def test_a_failing_exchange_is_rolled_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, fails: int) -> None:
    """Where the system has no exchange: the first or second of the two renamings fails."""
    out = tmp_path / "out"
    write(out, "one")
    monkeypatch.setattr(renaming, "_renamed", lambda *paths, **flags: False)
    rename, calls = Path.rename, []

    def failing(path: Path, target: Path) -> Path:
        if out in (path, target):
            calls.append(path)
            if len(calls) == fails:
                raise PermissionError(13, "a program has it open")
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(OutputError, match="cannot be written: a program has it open"):
        write(out, "two", force=True)
    assert (out / "part.txt").read_text() == "one"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_without_exchange_it_is_replaced_all_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(renaming, "_renamed", lambda *paths, **flags: False)
    write(tmp_path / "out", "one")
    write(tmp_path / "out", "two", force=True)
    assert (tmp_path / "out" / "part.txt").read_text() == "two"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


# --- what a hard kill leaves


def leftover(tmp_path: Path) -> Path:
    workspace = tmp_path / ".out.fabkit"
    workspace.mkdir()
    (workspace / "lock").touch()
    return workspace


def test_a_draft_that_was_left_is_cleared(tmp_path: Path) -> None:
    (leftover(tmp_path) / "draft" / "parts").mkdir(parents=True)
    (tmp_path / ".out.fabkit" / "draft" / "part.txt").write_text("hal")
    write(tmp_path / "out", "one")
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_what_was_taken_away_and_not_replaced_is_put_back(tmp_path: Path) -> None:
    write(tmp_path / "out", "one")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    (tmp_path / "out").rename(leftover(tmp_path) / "before")
    with pytest.raises(OutputError, match="exists already"):
        write(tmp_path / "out", "two")
    assert (tmp_path / "out" / "part.txt").read_text() == "one"
    assert (tmp_path / "out" / "notes.txt").read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.parametrize("slot", ["ready", "before"])
def test_an_earlier_result_that_was_replaced_is_cleared_unless_it_holds_what_is_not_ours(
    tmp_path: Path, slot: str
) -> None:
    write(tmp_path / "one", "one")
    write(tmp_path / "out", "two")
    workspace = leftover(tmp_path)
    (tmp_path / "one").rename(workspace / slot)
    (workspace / slot / "notes.txt").write_text("mine")
    with pytest.raises(OutputError, match=rf"\.out\.fabkit/{slot} holds files .*: notes\.txt; move them"):
        write(tmp_path / "out", "three", force=True)
    assert (workspace / slot / "notes.txt").read_text() == "mine"
    (workspace / slot / "notes.txt").unlink()
    write(tmp_path / "out", "three", force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


# --- names that file systems do not take


@pytest.mark.parametrize("name", ["x" * 300, "nul\0"])
def test_names_that_no_folder_can_have_are_refused_before_any_work(tmp_path: Path, name: str) -> None:
    with (
        pytest.raises(OutputError, match=r"File name too long|NUL character"),
        whole_folder(tmp_path / name, force=True),
    ):
        raise AssertionError
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["x" * 255, "ä" * 127, os.fsdecode(b"\xff\xfe")])
def test_names_that_folders_just_can_have_are_taken(tmp_path: Path, name: str) -> None:
    for text in ("one", "two"):
        write(tmp_path / name, text, force=True)
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_parent_that_cannot_be_read_or_written_gets_a_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def denied(path: Path, *arguments: object, **settings: object) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(Path, "mkdir", denied)
    with pytest.raises(OutputError, match="out cannot be written: Permission denied"):
        write(tmp_path / "out", "one")
    monkeypatch.setattr(Path, "is_dir", denied)
    with pytest.raises(OutputError, match="out cannot be written: Permission denied"):
        write(tmp_path / "out", "one")


def test_a_lock_that_was_taken_away_meanwhile_is_no_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another run leaves between our opening of the lock and our having it."""
    lock, calls = folders._is_free, []

    def late(descriptor: int) -> bool:
        calls.append(descriptor)
        if len(calls) == 1:
            (tmp_path / ".out.fabkit" / "lock").unlink()
            (tmp_path / ".out.fabkit").rmdir()
        return lock(descriptor)

    monkeypatch.setattr(folders, "_is_free", late)
    write(tmp_path / "out", "one")
    assert len(calls) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["out"]

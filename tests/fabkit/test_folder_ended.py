"""Runs ended while they write: by signals, which wait while names are exchanged, and by kills, which do not wait."""

from __future__ import annotations

import os
import random
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable
from pathlib import Path

import pytest

from fabkit.errors import OutputError
from fabkit.formats import renaming
from fabkit.formats.folder import whole_folder
from fabkit.formats.manifest import foreign_files, write_manifest
from fabkit.signals import EXIT_SIGNALS, DeferredSignals, exit_on_signal

N_FILES = 12

posix = pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are forked")


def write(out: Path, text: str) -> None:
    with whole_folder(out, force=True) as folder:
        for number in range(N_FILES):
            (folder / f"part{number}.txt").write_text(text)
        write_manifest(folder, {"name": text})


def whole(out: Path) -> bool:
    texts = [path.read_text() for path in out.glob("part*.txt")]
    return len(texts) == N_FILES and len(set(texts)) == 1 and not list(foreign_files(out))


def in_a_process(work: Callable[[], None]) -> int:
    """The number of a process that does this, and then ends at once."""
    child = os.fork()
    if child:
        return child
    code = 99
    try:
        work()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 98
    except BaseException:
        traceback.print_exc()
    os._exit(code)


def write_or_wait(out: Path, text: str) -> bool:
    """False where another run is writing; nothing else may stand in the way."""
    try:
        write(out, text)
    except OutputError as error:
        if "another run" not in str(error):
            raise
        return False
    return True


def write_for_ever(out: Path) -> None:
    number = 0
    while True:
        write_or_wait(out, f"{os.getpid()} {number}")
        number += 1


@posix
@pytest.mark.parametrize("atomic", [True, False])
def test_what_a_kill_leaves_is_seen_to_by_the_next_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, atomic: bool
) -> None:
    """40 kills at any moment, which fall on all steps; without an exchange of names, some leave no folder at all."""
    if not atomic:
        monkeypatch.setattr(renaming, "_renamed", lambda *paths, **flags: False)
    out = tmp_path / "out"
    write(out, "first")
    chance = random.Random(7)
    left = 0
    for _ in range(40):
        child = in_a_process(lambda: write_for_ever(out))
        time.sleep(chance.uniform(0, 0.03))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        left += (tmp_path / ".out.fabkit").exists()
        assert out.exists() or not atomic
        with pytest.raises(KeyError), whole_folder(out, force=True):  # a run that comes to nothing
            raise KeyError
        assert whole(out)
        assert [path.name for path in tmp_path.iterdir()] == ["out"]
    assert left > 10  # else the kills fell beside what is tried


@posix
def test_a_run_that_lives_is_left_alone(tmp_path: Path) -> None:
    out = tmp_path / "out"
    child = in_a_process(lambda: write_for_ever(out))
    try:
        while not out.exists():
            time.sleep(0.001)
        written, deadline = set(), time.monotonic() + 60
        while written != {True, False} and time.monotonic() < deadline:
            written.add(write_or_wait(out, "ours"))
        assert written == {True, False}
        assert os.waitpid(child, os.WNOHANG) == (0, 0)
    finally:
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)


@posix
@pytest.mark.parametrize("number", EXIT_SIGNALS)
def test_signals_end_a_run_tidily_at_any_moment(tmp_path: Path, number: signal.Signals) -> None:
    out = tmp_path / "out"
    write(out, "first")

    def work() -> None:
        signal.signal(number, signal.SIG_DFL)  # a shell that runs the tests in the background has them ignored
        with exit_on_signal():
            (tmp_path / "ready").touch()
            write_for_ever(out)

    chance = random.Random(7)
    for _ in range(15):
        child = in_a_process(work)
        while not (tmp_path / "ready").exists():
            time.sleep(0.001)
        time.sleep(chance.uniform(0, 0.02))
        os.kill(child, number)
        _, status = os.waitpid(child, 0)
        assert os.waitstatus_to_exitcode(status) == 128 + number
        assert whole(out)
        (tmp_path / "ready").unlink()
        assert [path.name for path in tmp_path.iterdir()] == ["out"]


@posix
@pytest.mark.parametrize("number", EXIT_SIGNALS)
def test_an_exit_that_a_destructor_drops_ends_the_run_before_anything_is_replaced(
    tmp_path: Path, number: signal.Signals
) -> None:
    class Dropping:
        def __del__(self) -> None:
            signal.raise_signal(number)

    out = tmp_path / "out"
    write(out, "first")

    def work() -> None:
        with exit_on_signal(), whole_folder(out, force=True) as folder:
            (folder / "part0.txt").write_text("second")
            sys.unraisablehook = lambda args: None
            Dropping()
            write_manifest(folder, {"name": "second"})

    _, status = os.waitpid(in_a_process(work), 0)
    assert os.waitstatus_to_exitcode(status) == 128 + number
    assert whole(out)
    assert (out / "part0.txt").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@posix
@pytest.mark.parametrize("number", EXIT_SIGNALS)
def test_signals_wait_until_names_are_exchanged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: signal.Signals
) -> None:
    """Also those that would end a process at once, and also between the two renamings where there is no exchange."""
    monkeypatch.setattr(renaming, "_renamed", lambda *paths, **flags: False)
    out = tmp_path / "out"
    write(out, "one")
    rename = Path.rename

    def interrupted(path: Path, target: Path) -> Path:
        signal.raise_signal(number)
        return rename(path, target)

    monkeypatch.setattr(Path, "rename", interrupted)
    child = in_a_process(lambda: write(out, "two"))
    _, status = os.waitpid(child, 0)
    assert status  # it did end by the signal
    assert {path.read_text() for path in out.glob("part*.txt")} == {"two"}
    assert whole(out)


def test_signals_that_waited_are_answered_in_their_order() -> None:
    seen: list[int] = []
    before = {number: signal.signal(number, lambda number, frame: seen.append(number)) for number in EXIT_SIGNALS}
    try:
        with DeferredSignals():
            for number in reversed(EXIT_SIGNALS):
                signal.raise_signal(number)
            assert seen == []
        assert seen == list(reversed(EXIT_SIGNALS))
        signal.signal(EXIT_SIGNALS[0], signal.SIG_IGN)
        with exit_on_signal(), DeferredSignals():
            assert signal.getsignal(EXIT_SIGNALS[0]) is signal.SIG_IGN  # as under nohup
        assert all(callable(signal.getsignal(number)) for number in EXIT_SIGNALS[1:])
        with pytest.raises(SystemExit) as end, exit_on_signal():
            signal.raise_signal(EXIT_SIGNALS[1])
        assert end.value.code == 128 + EXIT_SIGNALS[1]
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def test_an_exit_that_became_an_error_on_the_way_is_an_exit_all_the_same() -> None:
    """numpy compares structured arrays by Python code, and says TypeError where that does not come to its end."""

    def compare(number: int | None) -> None:
        try:
            if number:
                signal.raise_signal(number)
        finally:
            raise TypeError("Cannot compare structured arrays")

    with pytest.raises(SystemExit) as end, exit_on_signal():
        compare(signal.SIGTERM)
    assert end.value.code == 128 + signal.SIGTERM
    with pytest.raises(TypeError), exit_on_signal():
        compare(None)


def test_a_thread_of_its_own_writes_too(tmp_path: Path) -> None:
    thread = threading.Thread(target=write, args=(tmp_path / "out", "one"))
    thread.start()
    thread.join()
    assert whole(tmp_path / "out")

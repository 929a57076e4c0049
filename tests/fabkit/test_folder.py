"""The output folder appears whole or not at all, and nothing that is not ours is ever replaced."""

from __future__ import annotations

from pathlib import Path

import pytest

from fabkit.errors import OutputError
from fabkit.export.folder import MANIFEST, whole_folder


def write(out: Path, text: str, *, force: bool = False) -> None:
    with whole_folder(out, force=force) as folder:
        (folder / "part.txt").write_text(text)
        (folder / MANIFEST).write_text("{}")


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
    with pytest.raises(OutputError, match="holds files that fabkit did not write"):
        write(mine, "x", force=True)
    assert (mine / "chapter.txt").read_text() == "years of work"
    file = tmp_path / "file"
    file.write_text("text")
    with pytest.raises(OutputError, match="is not a folder"):
        write(file, "x", force=True)
    with pytest.raises(OutputError, match="does not exist; make it first"):
        write(tmp_path / "no" / "out", "x")

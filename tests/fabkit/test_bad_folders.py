"""Folders of other versions, damaged manifests, links and pipes, and disks that are full half-way: one sentence that
names them, nothing half-written, nothing waited for."""

from __future__ import annotations

import json
import os
import shutil
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from fabkit import Project, build
from fabkit.errors import FolderError, OutputError
from fabkit.formats import whole_file
from fabkit.formats.finished import check_folder, folder_differences, kept_marks
from geometry.files import write_mesh
from geometry.mesh import Mesh
from geometry.mesh.shapes import dome

resource = pytest.importorskip("resource", reason="there are no limits of this kind on Windows")

LONGEST_S = 20
"""Time in s after which a check that waits for a pipe is ended."""

Change = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("finished") / "roof"
    build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out=out))
    return out


@pytest.fixture(autouse=True)
def ended() -> Iterator[None]:
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.alarm(LONGEST_S)
    yield
    signal.alarm(0)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda m: m["versions"].update(fabkit="0.0.1"), r"was written by fabkit 0\.0\.1"),
        (lambda m: m.update(versions={"fabkit": "99.0"}, settings={}), r"was written by fabkit 99\.0"),
        (lambda m: m["versions"].update(fabkit=None), "versions.fabkit"),
        (lambda m: m.update(versions=[]), "another version"),
        (lambda m: m.update(files=["a"]), "'files'"),
        (lambda m: m.update(files={"a": 1}), "'files.a'"),
        (lambda m: m["files"].update({"../secret.csv": ""}), "secret.csv"),
        (lambda m: m["files"].update({"parts/../../x.step": ""}), "x.step"),
        (lambda m: m["files"].update({"/etc/hosts.csv": ""}), "hosts.csv"),
        (lambda m: m["files"].update({"a\0b.csv": ""}), "files"),
        (lambda m: m.update(counts=[]), "'counts'"),
        (lambda m: m.update(origin={"mm": [1, 2]}), "'origin.mm"),
        (lambda m: m["settings"].update(tables=None), "'settings.tables'"),
        (lambda m: m["settings"]["tables"].update(separator="!!"), "'settings.tables.separator'"),
        (lambda m: m["settings"].pop("drawings"), "'settings.drawings'"),
        (lambda m: m["settings"].update(site={"turn": 1}), "'settings.site"),
    ],
)
def test_a_manifest_of_another_kind_is_named(made: Path, tmp_path: Path, change: Change, sentence: str) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(made, copy)
    manifest = json.loads((copy / "manifest.json").read_text())
    change(manifest)
    (copy / "manifest.json").write_text(json.dumps(manifest))
    for read in (check_folder, kept_marks, lambda folder: folder_differences(made, folder)):
        with pytest.raises(FolderError, match=sentence) as raised:
            read(copy)
        assert str(copy) in str(raised.value)


@pytest.mark.parametrize("text", ["", "hello", "[]", "null", "NaN", "[" * 99_999, '{"name":"x","files":["a"]}'])
def test_a_manifest_that_is_none_is_named(made: Path, tmp_path: Path, text: str) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(made, copy)
    (copy / "manifest.json").write_text(text)
    with pytest.raises(FolderError, match=r"manifest\.json cannot be read as that of a build"):
        check_folder(copy)


@pytest.mark.parametrize("name", ["pieces.csv", "parts/B001.step", "report.html", "cutlist.xlsx", "model.glb", "M.obj"])
@pytest.mark.parametrize("kind", ["pipe", "link"])
def test_links_and_pipes_are_named_and_not_read(made: Path, tmp_path: Path, name: str, kind: str) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(made, copy)
    if kind == "pipe":
        (copy / name).unlink()
        os.mkfifo(copy / name)
    else:
        (copy / name).rename(tmp_path / "elsewhere")
        (copy / name).symlink_to(tmp_path / "elsewhere")
    for hashes in (True, False):
        assert any(name in sentence and "link" in sentence for sentence in check_folder(copy, hashes=hashes))
    if name == "pieces.csv":
        for read in (kept_marks, lambda folder: folder_differences(folder, made)):
            with pytest.raises(FolderError, match=r"pieces\.csv is not read, since it is a link, a pipe"):
                read(copy)


def test_a_changed_manifest_is_one_sentence(made: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(made, copy)
    manifest = json.loads((copy / "manifest.json").read_text())
    (copy / "manifest.json").write_text(json.dumps({**manifest, "mine": 1}))
    assert check_folder(copy) == (
        "manifest.json is not as it was written, so that its hashes say nothing of other files",
    )
    (copy / "pipe").symlink_to(copy)
    assert check_folder(copy, hashes=False) == ("pipe was added",)


# --- full disks


@contextmanager
def files_up_to(n_bytes: int) -> Iterator[None]:
    """The system refuses to write more than these bytes into a file."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (n_bytes, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("n_bytes", [0, 200, 11_000, 20_000, 30_000, 60_000])
@pytest.mark.parametrize("force", [False, True])
def test_a_full_disk_leaves_what_was_there(made: Path, tmp_path: Path, n_bytes: int, force: bool) -> None:
    out = tmp_path / "out"
    if force:
        shutil.copytree(made, out)
    project = Project(mesh=dome(4, 1), mean_edge_mm=1400, out=out)
    with pytest.raises(OutputError) as raised, files_up_to(n_bytes):
        build(project, force=force)
    assert str(raised.value) == f"{out} cannot be written: File too large"
    assert os.listdir(tmp_path) == (["out"] if force else [])
    assert not force or contents(out) == contents(made)


def test_each_document_can_be_the_one_that_does_not_fit(tmp_path: Path) -> None:
    for document in ("meshes", "step", "parts", "panels", "drawings", "tables", "workbook", "glb", "report"):
        out = tmp_path / "out"
        project = Project(mesh=dome(4, 1), mean_edge_mm=1400, out=out, documents=[document])
        with pytest.raises(OutputError) as raised, files_up_to(150):
            build(project)
        assert str(raised.value) == f"{out} cannot be written: File too large"
        assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("suffix", [".obj", ".off", ".ply"])
def test_a_file_that_does_not_fit_leaves_the_earlier_one(tmp_path: Path, suffix: str) -> None:
    out = tmp_path / f"mesh{suffix}"
    out.write_text("mine")
    mesh: Mesh = dome(6, 3)
    with pytest.raises(OutputError) as raised, files_up_to(500), whole_file(out, force=True) as draft:
        write_mesh(draft, mesh)
    assert str(raised.value) == f"{out} cannot be written: File too large"
    assert os.listdir(tmp_path) == [out.name]
    assert out.read_text() == "mine"


def test_a_draft_that_is_removed_meanwhile_is_told(tmp_path: Path) -> None:
    out = tmp_path / "mesh.obj"

    def write() -> None:
        with whole_file(out, force=False) as draft:
            shutil.rmtree(draft.parent)
            write_mesh(draft, dome(4, 1))

    with pytest.raises(OutputError, match=r"mesh\.obj cannot be written"):
        write()

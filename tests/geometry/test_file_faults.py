"""Files as programs, disks and people spoil them: encodings, capitals, headers that promise, names that are none."""

from __future__ import annotations

import codecs
import os
import struct
import tracemalloc
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import MeshError, MeshFileError
from geometry.files import read_mesh, write_mesh
from geometry.mesh import Mesh, shapes

SUFFIXES = [".obj", ".off", ".ply"]
MARKS = {
    "utf-8": codecs.BOM_UTF8,
    "utf-16-le": codecs.BOM_UTF16_LE,
    "utf-16-be": codecs.BOM_UTF16_BE,
    "utf-32-le": codecs.BOM_UTF32_LE,
    "utf-32-be": codecs.BOM_UTF32_BE,
}
MESH = shapes.dome(5, 2)


def text_of(folder: Path, suffix: str) -> str:
    write_mesh(folder / f"clean{suffix}", MESH)
    return (folder / f"clean{suffix}").read_text()


def read_without_warning(path: Path) -> tuple[Mesh, tuple[str, ...]]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = read_mesh(path)
    return found.mesh, found.mended


def read_bytes(path: Path, content: bytes) -> tuple[Mesh, tuple[str, ...]]:
    path.write_bytes(content)
    return read_without_warning(path)


def assert_read(path: Path, content: bytes) -> None:
    mesh, said = read_bytes(path, content)
    np.testing.assert_array_equal(mesh.vertices, MESH.vertices)
    assert mesh.combinatorics.same_as(MESH.combinatorics)
    assert said == ()


def refused(path: Path, content: bytes | None = None) -> str:
    """The sentence, at most three lines of a terminal long, without warnings on the way."""
    if content is not None:
        path.write_bytes(content)
    with pytest.raises((MeshError, MeshFileError)) as caught:
        read_without_warning(path)
    said = caught.value.message.removeprefix(f"{path}: ")
    assert said.isprintable()
    assert len(said) < 360
    return said


# --- encodings and capitals


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("encoding", MARKS)
@pytest.mark.parametrize("marked", [True, False])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_every_encoding_is_read(tmp_path: Path, suffix: str, encoding: str, marked: bool, end: str) -> None:
    text = text_of(tmp_path, suffix).replace("\n", end)
    assert_read(tmp_path / f"a{suffix}", (MARKS[encoding] if marked else b"") + text.encode(encoding))


@pytest.mark.parametrize("name", ["Dach über Süd", "屋根", "крыша"])
@pytest.mark.parametrize("encoding", ["latin-1", "utf-8", "utf-16", "cp1251", "shift-jis"])
def test_names_and_comments_may_be_in_any_language(tmp_path: Path, name: str, encoding: str) -> None:
    for suffix, line in ((".obj", f"# {name}\no {name}\n"), (".off", f"# {name}\n"), (".ply", f"comment {name}\n")):
        text = text_of(tmp_path, suffix)
        place = text.index("\n") + 1 if suffix == ".ply" else 0
        content = (text[:place] + line + text[place:]).encode(encoding, errors="replace")
        assert_read(tmp_path / f"a{suffix}", content)


def test_marks_in_the_middle_of_joined_files_are_no_words(tmp_path: Path) -> None:
    head, tail = text_of(tmp_path, ".obj").split("f ", 1)
    assert_read(tmp_path / "a.obj", (f"\ufeff{head}\ufefff {tail}").encode())


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_words_in_capitals_and_in_small_letters_are_read(tmp_path: Path, suffix: str) -> None:
    text = text_of(tmp_path, suffix)
    other = text.lower() if suffix == ".off" else text.upper()
    assert other != text
    assert_read(tmp_path / f"a{suffix}", other.encode())


@pytest.mark.parametrize("header", ["off", "Off", "coff", "Noff", "stoff", "OFF"])
def test_off_headers_in_any_case(tmp_path: Path, header: str) -> None:
    extra = {"coff": " 9 9 9 9", "Noff": " 0 0 1", "stoff": " 0 1"}.get(header, "")
    lines = text_of(tmp_path, ".off").splitlines()[1:]
    lines[1 : 1 + MESH.n_vertices] = [line + extra for line in lines[1 : 1 + MESH.n_vertices]]
    assert_read(tmp_path / "a.off", "\n".join([header, *lines]).encode())


@pytest.mark.parametrize("space", ["\t", "\u00a0", "\u2003", " \t  "])
@pytest.mark.parametrize("suffix", [".obj", ".off"])
def test_any_space_parts_words(tmp_path: Path, space: str, suffix: str) -> None:
    assert_read(tmp_path / f"a{suffix}", text_of(tmp_path, suffix).replace(" ", space).encode())


# --- OBJ: what is ignored is reported


def test_obj_words_and_shapes_that_are_no_polygons_are_reported(tmp_path: Path) -> None:
    text = text_of(tmp_path, ".obj") + "vp 1 2\ncstype bezier\ncurv 0 1 1 2\nend\nvv 1 2 3\nface 1 2 3\np 1\n"
    mesh, said = read_bytes(tmp_path / "a.obj", text.encode())
    assert mesh.n_faces == MESH.n_faces
    line = MESH.n_vertices + MESH.n_faces + 5
    assert said == (
        "1 point elements ignored",
        "1 curve elements ignored",
        f"2 lines ignored that begin with no keyword of OBJ, such as line {line} with 'vv'",
    )


# --- PLY: what contradicts

PLY = "ply\nformat {}\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n"


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("code", ["f", "d"])
@given(index=st.floats(allow_nan=True, allow_infinity=True, width=32))
@settings(max_examples=20)
def test_binary_indices_are_whole_as_those_of_text_are(
    tmp_path_factory: pytest.TempPathFactory, order: str, code: str, index: float
) -> None:
    kind = {"f": "float", "d": "double"}[code]
    name = {"<": "binary_little_endian 1.0", ">": "binary_big_endian 1.0"}[order]
    header = PLY.format(name) + f"property list uchar {kind} vertex_indices\nend_header\n"
    content = header.encode() + b"".join(struct.pack(order + "fff", *vertex) for vertex in SQUARE)
    path = tmp_path_factory.getbasetemp() / "a.ply"
    assert read_bytes(path, content + struct.pack(f"{order}B4{code}", 4, 0, 1, 2, 3))[0].n_faces == 1
    if index in (0, 1, 2, 3):
        return
    binary = refused(path, content + struct.pack(f"{order}B4{code}", 4, 0, 1, 2, index))
    header = PLY.format("ascii 1.0") + f"property list uchar {kind} vertex_indices\nend_header\n"
    text = refused(path, f"{header}{ROWS}4 0 1 2 {index!r}\n".encode())
    assert ("a whole number is needed" in binary) == ("a whole number is needed" in text)
    assert binary.startswith("face 0")


@pytest.mark.parametrize(
    ("after", "line", "sentence"),
    [
        ("float x", "property list uchar float x", "gives its elements 'vertex' two properties 'x'"),
        ("float x", "property double X", "gives its elements 'vertex' two properties 'x'"),
        ("float z", "element vertex 3", "describes its elements 'vertex' twice"),
        ("vertex_indices", "property int vertex_indices", "gives its elements 'face' two properties 'vertex_indices'"),
        ("vertex_indices", "element face 1", "describes its elements 'face' twice"),
    ],
)
@pytest.mark.parametrize("format_", ["ascii 1.0", "binary_little_endian 1.0"])
def test_ply_headers_that_say_a_thing_twice(tmp_path: Path, after: str, line: str, sentence: str, format_: str) -> None:
    header = PLY.format(format_) + "property list uchar int vertex_indices\nend_header\n"
    header = header.replace(f"{after}\n", f"{after}\n{line}\n")
    assert sentence in refused(tmp_path / "a.ply", f"{header}{ROWS}4 0 1 2 3\n".encode())


def test_ply_without_vertices(tmp_path: Path) -> None:
    text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\nend_header\n3 0 1 2\n"
    assert refused(tmp_path / "a.ply", text.encode()).startswith("face 0 names vertex 0, but there are no vertices")


def test_a_scalar_beside_the_list_of_corners_is_passed_over(tmp_path: Path) -> None:
    header = PLY.format("ascii 1.0") + "property int vertex_indices\nproperty list uchar int vertex_index\nend_header\n"
    mesh, _ = read_bytes(tmp_path / "a.ply", f"{header}{ROWS}7 4 0 1 2 3\n".encode())
    assert [face.tolist() for face in mesh.combinatorics.faces] == [[0, 1, 2, 3]]


@pytest.mark.parametrize("bits", [0x7F800001, 0xFFC00000, 0x7F800000])
def test_bytes_that_are_no_number_are_refused_without_a_warning(tmp_path: Path, bits: int) -> None:
    header = PLY.format("binary_little_endian 1.0") + "property list uchar int vertex_indices\nend_header\n"
    content = header.encode() + b"".join(struct.pack("<fff", *vertex) for vertex in SQUARE[:3])
    said = refused(tmp_path / "a.ply", content + struct.pack("<IffB4i", bits, 1, 0, 4, 0, 1, 2, 3))
    assert said.startswith("vertex 3 is (")


# --- numbers


HUGE = ["9" * 5000, "1e400", "-1e400", "1e61", "nan", "inf", "1" + "0" * 30, "-" + "9" * 400]


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("number", HUGE)
def test_numbers_beyond_all_bounds_are_refused_wherever_they_stand(tmp_path: Path, suffix: str, number: str) -> None:
    """Coordinates, counts, indices, sizes of faces: without warnings, and without memory for what is announced."""
    lines = text_of(tmp_path, suffix).splitlines()
    for row, line in enumerate(lines):
        words = line.split()
        for place, word in enumerate(words):
            if not word.lstrip("-").replace(".", "").replace("e-", "").isdecimal() or (
                row in (1, 2) and suffix == ".ply"
            ):
                continue
            spoilt = [*lines[:row], " ".join([*words[:place], number, *words[place + 1 :]]), *lines[row + 1 :]]
            if suffix == ".off" and (row, place) == (1, 2):  # the number of edges is not asked
                continue
            refused(tmp_path / f"a{suffix}", "\n".join(spoilt).encode())


@pytest.mark.parametrize(
    "content",
    [
        "OFF\n{0} {0} 0\n0 0 0\n",
        "COFF\n{0} 1 0\n0 0 0\n3 0 1 2\n",
        "OFF\n3 {0} 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n{0} 0 1 2\n",
        "ply\nformat ascii 1.0\nelement vertex {0}\nproperty float x\nproperty float y\nproperty float z\n"
        "end_header\n1 2 3",
        "ply\nformat binary_big_endian 1.0\nelement vertex {0}\nproperty float x\nproperty float y\nproperty float z\n"
        "element face {0}\nproperty list uint int vertex_indices\nend_header\n0000",
        "ply\nformat ascii 1.0\nelement face {0}\nproperty list uint int vertex_indices\nend_header\n3 0 1 2\n",
        "ply\nformat ascii 1.0\nelement face 1\nproperty list uint int vertex_indices\nend_header\n{0} 0 1 2\n",
        "v 0 0 0\nf {0} -1 1\n",
    ],
)
@pytest.mark.parametrize("count", [10**9, 10**12, 10**18])
def test_what_is_announced_takes_no_memory(tmp_path: Path, content: str, count: int) -> None:
    suffix = ".ply" if content.startswith("ply") else ".obj" if content.startswith("v") else ".off"
    tracemalloc.start()
    try:
        refused(tmp_path / f"a{suffix}", content.format(count).encode())
        assert tracemalloc.get_traced_memory()[1] < 10e6  # the file has 200 bytes; Python itself takes some
    finally:
        tracemalloc.stop()


def test_damaged_lines_are_not_repeated_whole_and_all_are_counted(tmp_path: Path) -> None:
    long = "x" * 3000
    for name, content in [
        ("a.obj", f"v 0 0 {long}\n"),
        ("a.off", f"{long}\n"),
        ("a.off", f"OFF\n{long} {long}\n"),
        ("a.ply", f"ply\nformat ascii 1.0\n{long} {long}\nend_header\n"),
        ("a.ply", f"ply\nformat ascii 1.0\nelement {long} 1\nproperty int a\nend_header\n"),
        ("a.ply", PLY.format("ascii 1.0") + f"property list int int vertex_index\nend_header\n{ROWS}4 0 1 {long} 3"),
    ]:
        refused(tmp_path / name, content.encode())
    said = refused(tmp_path / "a.obj", b"v 0 0 one\nv 0 1_0 0\n" + b"v 0 0 x\n" * 30)
    assert said.startswith("line 1: 'one' is not a number; correct it; likewise lines 2, 3, 4,")
    assert said.endswith("and 21 more")
    said = refused(tmp_path / "a.obj", b"v 0 0\nv 0\nv 0 0 0\n")
    assert said.endswith("the file is cut off or damaged; likewise line 2")


# --- names and files that are none


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_folders_pipes_and_devices_are_no_files(tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"folder{suffix}").mkdir()
    os.mkfifo(tmp_path / f"pipe{suffix}")
    (tmp_path / f"zero{suffix}").symlink_to("/dev/zero")
    (tmp_path / f"round{suffix}").symlink_to(f"round{suffix}")
    (tmp_path / "file").touch()
    assert "folder" in refused(tmp_path / f"folder{suffix}")
    assert refused(tmp_path / f"pipe{suffix}").startswith("this is a pipe or a device, not a file")
    assert refused(tmp_path / f"zero{suffix}").startswith("this is a pipe or a device, not a file")
    assert refused(tmp_path / f"round{suffix}").startswith("the file cannot be read: ")
    assert refused(tmp_path / "file" / f"a{suffix}") == "there is no such file; check the path"


@pytest.mark.parametrize("name", ["x" * 300, "a\0b", "a\nb", "\udcff\udcfe", "[bold]", "é" * 200], ids=ascii)
@pytest.mark.parametrize("suffix", [".obj", ".stl", ""])
def test_names_that_no_file_has_are_reported_in_one_printable_line(tmp_path: Path, name: str, suffix: str) -> None:
    for attempt in (read_mesh, lambda path: write_mesh(path / "a.obj", MESH)):
        with pytest.raises(MeshFileError) as caught:
            attempt(tmp_path / (name + suffix))
        assert caught.value.message.isprintable()
        assert len(caught.value.message) < 360
        caught.value.message.encode("utf-8")


def test_a_name_of_any_bytes_is_read(tmp_path: Path) -> None:
    path = tmp_path / os.fsdecode(b"\xff\xe4.obj")
    path.write_text(text_of(tmp_path, ".obj"))
    assert read_mesh(path).mesh.n_faces == MESH.n_faces


@pytest.mark.parametrize("error", [PermissionError(13, "Permission denied"), OSError(5, "Input/output error")])
@pytest.mark.parametrize("call", ["stat", "read_bytes"])
def test_errors_of_the_system_are_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: OSError, call: str
) -> None:
    path = tmp_path / "a.obj"
    path.write_text(text_of(tmp_path, ".obj"))

    def denied(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr(Path, call, denied)
    assert refused(path) == f"the file cannot be read: {error.strerror}"
    monkeypatch.setattr(Path, "write_text", denied)
    with pytest.raises(MeshFileError, match=f"the file cannot be written: {error.strerror}"):
        write_mesh(path, MESH)

"""OBJ, OFF and PLY as they are written by others, as we write them, and as they should not be."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.errors import GeometryError, MeshError, MeshFileError
from geometry.files import read_mesh, write_mesh
from geometry.mesh import Mesh, shapes

SUFFIXES = [".obj", ".off", ".ply"]
QUAD_AND_TRIANGLE = [[0, 1, 2, 3], [1, 4, 2]]
VERTICES = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.5, 0.25]]
ROWS = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0.5 0.25\n"
V_ROWS = "".join(f"v {row}\n" for row in ROWS.splitlines())


Read = Callable[..., tuple[Mesh, tuple[str, ...]]]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Write a text or bytes to a file of this name and read it as a mesh."""

    def read_text(name: str, content: str | bytes, *, flip: bool = False) -> tuple[Mesh, tuple[str, ...]]:
        path = tmp_path / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        found = read_mesh(path, flip=flip)
        assert found.path == path
        return found.mesh, found.mended

    return read_text


def assert_quad_and_triangle(found: tuple[Mesh, tuple[str, ...]], *mended: str) -> None:
    mesh, said = found
    np.testing.assert_array_equal(mesh.vertices, VERTICES)
    assert [face.tolist() for face in mesh.combinatorics.faces] == QUAD_AND_TRIANGLE
    assert said == mended


# --- what we write


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=30)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-9, 1.0, 1e12]))
def test_every_digit_comes_back(tmp_path_factory: pytest.TempPathFactory, suffix: str, seed: int, scale: float) -> None:
    mesh = shapes.dome(6, 2)
    noise = np.random.default_rng(seed).uniform(-0.01, 0.01, mesh.vertices.shape)
    mesh = mesh.with_vertices((mesh.vertices + noise) * scale)
    path = tmp_path_factory.getbasetemp() / f"digits{suffix}"
    write_mesh(path, mesh)
    found = read_mesh(path)
    np.testing.assert_array_equal(found.mesh.vertices, mesh.vertices)
    assert found.mesh.combinatorics.same_as(mesh.combinatorics)
    assert found.mended == ()


@pytest.mark.parametrize("suffix", [*SUFFIXES, ".PLY"])
@pytest.mark.parametrize("mesh", [shapes.dodecahedron(), shapes.regular_prism(300)], ids=["pentagons", "300-gons"])
def test_faces_of_any_number_of_corners_come_back(tmp_path: Path, suffix: str, mesh: Mesh) -> None:
    path = tmp_path / f"mesh{suffix}"
    write_mesh(path, mesh)
    assert read_mesh(path).mesh.combinatorics.same_as(mesh.combinatorics)


def test_flip_turns_the_faces_round(read: Read) -> None:
    mesh, said = read("a.obj", V_ROWS + "f 1 2 3 4", flip=True)
    assert mesh.vector_areas[:, 2].tolist() == [-1]
    assert said[-1] == "all faces reversed, as requested"


# --- OBJ


def test_obj_keeps_to_v_and_f(read: Read) -> None:
    text = f"""\
# made by hand
mtllib things.mtl
o first
{V_ROWS}vt 0 0
vn 0 0 1
g roof
s off
usemtl glass/blue
f 1/1/1 2/1/1 3//1 4/1  # a quad
o second
f -4 -1 -3
"""
    assert_quad_and_triangle(read("a.obj", text))


def test_obj_indices_count_back_from_where_they_stand(read: Read) -> None:
    v = V_ROWS.splitlines(keepends=True)
    assert_quad_and_triangle(read("a.obj", "".join(v[:4]) + "f -4 -3 -2 -1\n" + v[4] + "f 2 -1 3\n"))


def test_obj_faces_may_stand_before_their_vertices(read: Read) -> None:
    assert_quad_and_triangle(read("a.obj", "f 1 2 3 4\nf 2 5 3\n" + V_ROWS))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_obj_lines_go_on_after_a_backslash(read: Read, end: str) -> None:
    text = V_ROWS + "f 1 2 \\\n3 4\nf 2\\\n 5\\\n 3\\\n"
    assert_quad_and_triangle(read("a.obj", text.replace("\n", end)))


def test_obj_extra_coordinates_and_a_byte_order_mark(read: Read) -> None:
    colours = "".join(line + " 0.5 0.5 0.5\n" for line in V_ROWS.splitlines())
    assert_quad_and_triangle(read("a.obj", "\ufeff" + colours + "f 1 2 3 4\nf 2 5 3\n"))


def test_obj_lines_and_points_are_ignored_and_reported(read: Read) -> None:
    text = V_ROWS + "f 1 2 3 4\nf 2 5 3\nl 1 2\nl 2 3 4\np 1\n"
    assert_quad_and_triangle(read("a.obj", text), "2 line elements ignored", "1 point elements ignored")


# --- OFF


@pytest.mark.parametrize(
    "header", ["OFF\n5 2 0\n", "OFF 5 2 0\n", "5 2 0\n", "# c\n\nOFF # c\n\n5 2 # c\n", "OFF 5 2 6 "]
)
def test_off_headers(read: Read, header: str) -> None:
    assert_quad_and_triangle(read("a.off", header + ROWS + "4 0 1 2 3\n3 1 4 2\n"))


@pytest.mark.parametrize(
    "faces",
    ["4 0 1 2 3 3 1 4 2", "4 0\n1\n2 3\n\n3 1 4\n2", "4\n0 1 2 3 3\n1 4 2\n", "\n4 0 1 2 3 # c\n# c\n3 1 4 2"],
)
def test_off_faces_run_over_lines_and_share_them(read: Read, faces: str) -> None:
    assert_quad_and_triangle(read("a.off", "OFF\n5 2 0\n" + ROWS + faces))


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("OFF", ""),
        ("OFF", " 255 0 0"),
        ("COFF", " 255 0 0 255"),
        ("NOFF", " 0 0 1"),
        ("STCNOFF", " 0 0 1 1 1 1 1 0 0"),
    ],
)
@pytest.mark.parametrize("colours", ["", " 200 200 200", " 0.5 0.5 0.5 1"])
def test_off_extra_columns_are_passed_over(read: Read, header: str, columns: str, colours: str) -> None:
    rows = "".join(row + columns + "\n" for row in ROWS.splitlines())
    text = f"{header}\n5 2 0\n{rows}4 0 1 2 3{colours}\n3 1 4 2{colours}\n"
    assert_quad_and_triangle(read("a.off", text))


def test_off_fourth_coordinates_divide_the_others(read: Read) -> None:
    rows = "".join(f"{2 * x} {2 * y} {2 * z} 2\n" for x, y, z in VERTICES)
    assert_quad_and_triangle(read("a.off", f"4OFF\n5 2 0\n{rows}4 0 1 2 3\n3 1 4 2\n"))


def test_off_indices_that_start_at_1_are_noticed(read: Read) -> None:
    found = read("a.off", "OFF\n5 2 0\n" + ROWS + "4 1 2 3 4\n3 2 5 3\n")
    assert_quad_and_triangle(found, "face indices started at 1; counted from 0")


def test_off_indices_that_start_at_1_are_noticed_by_the_last_one_too(read: Read) -> None:
    mesh, said = read("a.off", "OFF\n6 2 0\n7 7 7\n" + ROWS + "4 2 3 4 5\n3 3 6 4\n")
    assert [face.tolist() for face in mesh.combinatorics.faces] == QUAD_AND_TRIANGLE
    assert said[0] == "face indices started at 1; counted from 0"


def test_off_first_vertex_unused_is_not_taken_for_base_1(read: Read) -> None:
    mesh, said = read("a.off", "OFF\n6 2 0\n7 7 7\n" + ROWS + "4 1 2 3 4\n3 2 5 3\n")
    assert [face.tolist() for face in mesh.combinatorics.faces] == QUAD_AND_TRIANGLE
    assert said == ("1 of 6 vertices belonged to no face; removed",)


# --- PLY

PLY_HEADER = """\
ply
format {format} 1.0
comment made by hand
obj_info nothing
element vertex 5
property double x
property uchar red
property double y
property double z
element face 2
property uchar flags
property list uchar int vertex_indices
property list uchar float texcoord
element edge 1
property int vertex1
property int vertex2
end_header
"""


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_ply_binary(read: Read, order: str, end: bytes) -> None:
    name = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    content = PLY_HEADER.format(format=name).encode().replace(b"\n", end)
    content += b"".join(struct.pack(order + "dBdd", x, 9, y, z) for x, y, z in VERTICES)
    for face in QUAD_AND_TRIANGLE:
        content += struct.pack(f"{order}BB{len(face)}iBff", 7, len(face), *face, 2, 0.5, 0.5)
    assert_quad_and_triangle(read("a.ply", content + struct.pack(order + "ii", 0, 1)))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_ply_text(read: Read, end: str) -> None:
    text = PLY_HEADER.format(format="ascii") + "".join(f"{x} 9 {y} {z}\n" for x, y, z in VERTICES)
    text += "".join(f"7 {len(face)} {' '.join(map(str, face))} 2 0.5 0.5\n" for face in QUAD_AND_TRIANGLE) + "0 1\n"
    assert_quad_and_triangle(read("a.ply", text.replace("\n", end)))


def test_ply_elements_in_another_order_and_other_names_of_types(read: Read) -> None:
    header = "ply\nformat binary_little_endian 1.0\nelement face 2\nproperty list uint8 uint16 vertex_index\n"
    header += "element vertex 5\nproperty float32 z\nproperty float32 y\nproperty float32 x\nend_header\n"
    content = header.encode()
    content += b"".join(struct.pack(f"<B{len(face)}H", len(face), *face) for face in QUAD_AND_TRIANGLE)
    content += b"".join(struct.pack("<fff", z, y, x) for x, y, z in VERTICES)
    assert_quad_and_triangle(read("a.ply", content))


# --- bad input

OFF = "OFF\n5 2 0\n" + ROWS
PLY = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
PLY += "property list uchar int vertex_indices\nend_header\n"


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("a.dae", "solid\n", "meshes are read from .obj, .off, .ply, .stl, .glb and .gltf, not .dae"),
        ("a", "OFF\n", "meshes are read from .obj, .off, .ply, .stl, .glb and .gltf, not a name without suffix"),
        ("a.obj", "", "the file is empty"),
        ("a.off", " \n\n", "the file is empty"),
        ("a.off", "# only\n# comments\n", "the file is empty: there is no OFF header"),
        ("a.obj", "# only comments\n", "there are no faces"),
        ("a.obj", V_ROWS + "p 1 2\ncurv 0 1 1 2\n", "there are no faces"),
        ("a.obj", "\x00\x01binary\xff", "there are no faces"),
        ("a.off", "OFF\n5 0 0\n" + ROWS, "there are no faces"),
        ("a.ply", PLY.replace("face 2", "face 0") + ROWS, "there are no faces"),
        ("a.obj", "v 0 0 0\nv 1 zero 0\nf 1 2 2\n", "line 2: 'zero' is not a number; correct it"),
        ("a.obj", V_ROWS + "\nf 1 2 x/1\n", "line 7: 'x' is not a number; correct it"),
        ("a.obj", V_ROWS + "f 1 2 2.5\n", "line 6: a vertex index of a face is 2.5, a whole number is needed"),
        ("a.obj", V_ROWS + "f 1 2 0\n", "line 6: a face names vertex 0, but OBJ counts vertices from 1"),
        ("a.obj", V_ROWS + "f 1 2 -6\n", "line 6: a face names vertex -6, but counted back there are 5 vertices above"),
        (
            "a.obj",
            V_ROWS + "f 1 2 6\n",
            "face 1 names vertex 6, but the 5 vertices end at 5 (vertices and faces counted",
        ),
        ("a.obj", V_ROWS + "f 1 2\nf\n", "there are no faces: none of 2 has three separate corners"),
        ("a.obj", "v 1 2\n", "line 1: vertex 1 has 2 coordinates, 3 are needed"),
        ("a.obj", V_ROWS + "v nan 0 0\nf 1 2 3\n", "vertex 6 is (nan, 0.0, 0.0): coordinates must be finite"),
        ("a.obj", V_ROWS + "f 1 2 3 4\nf 3 2 4 1\n", "faces 1 and 2 have the same vertices (1, 2, 3, 4)"),
        ("a.off", "STL\n", "line 1: an OFF file begins with OFF, this one with 'STL'"),
        ("a.off", "OFF\n", "the file ends after its header: the numbers of vertices and faces are missing"),
        ("a.off", "OFF BINARY\n", "line 1: this OFF file is binary; save it as a plain one"),
        ("a.off", "nOFF\n3\n", "line 1: this OFF file is n-dimensional; save it as a plain one"),
        ("a.off", "OFF\n5 two 0\n", "line 2 should give the numbers of vertices, faces and edges, but is '5 two 0'"),
        (
            "a.off",
            OFF + "4 0 1 2 3\n",
            "line 2 announces 5 vertices and 2 faces, but 6 lines of numbers follow: the file",
        ),
        ("a.off", OFF + "4 0 1 2 3\n3 1 4 2\n3 0 0 0\n", "line 2 announces 5 vertices and 2 faces, but 8 lines"),
        (
            "a.off",
            OFF + "4 0 1 2 3\n3 1 4\n",
            "line 9: face 1 should have 3 corners, the line holds 2; the file is cut",
        ),
        ("a.off", OFF.replace("1 1 0", "1 1") + "4 0 1 2 3\n3 1 4 2\n", "line 5: vertex 2 has 2 coordinates, 3 are"),
        ("a.off", OFF + "4 0 1 2 3\n3 1 four 2\n", "line 9: 'four' is not a number; correct it"),
        ("a.off", OFF + "4 0 1 2 3\n3 1 4 5\n", "face 1 names vertex 5, but the 5 vertices end at 4"),
        ("a.off", OFF + "4 0 1 2 3\n3 1 4 nan\n", "line 9: a vertex index of a face is nan, a whole number is needed"),
        ("a.off", OFF + "4 1 2 3 4\n3 1 5 1.5\n", "line 9: a vertex index of a face is 1.5"),
        ("a.off", OFF + "4 0 1 2 3\n3 1 4 1e300\n", "line 9: a vertex index of a face is 1e+300, a whole number is"),
        ("a.off", OFF + "4 0 1 2 3\n-3 1 4 2\n", "line 9: face 1 should have -3 corners, the line holds 3"),
        ("a.off", OFF + "4 1 2 3 2\n3 5 2 5\n", "face 1 touches itself: two of its corners are vertex 2 or lie on it"),
        (
            "a.off",
            OFF.replace("OFF", "4OFF").replace("\n2 0.5", " 1\n2 0.5"),
            "line 2 announces 5 vertices and 2 faces",
        ),
        ("a.off", "4OFF\n3 1 0\n0 0 0 1\n1 0 0 1\n0 1 0 0\n3 0 1 2\n", "vertex 2 of the 4OFF file is at infinity"),
        ("a.ply", "OFF\n", "a PLY file begins with a line 'ply', this one does not"),
        ("a.ply", "ply\nformat ascii 1.0\n", "the PLY header does not end"),
        ("a.ply", "ply\nend_header\n", "the PLY header does not say its format"),
        ("a.ply", "ply\nformat ascii 2.0\nend_header\n", "line 2: 'format ascii 2.0' is not a line of a PLY header"),
        ("a.ply", PLY.replace("float y", "float64x y"), "line 5: 'property float64x y' is not a line of a PLY header"),
        ("a.ply", PLY.replace("float y", "float u"), "the PLY header gives its vertices no x, y and z"),
        (
            "a.ply",
            PLY.replace("vertex_indices", "corners") + ROWS + "4 0 1 2 3\n3 1 4 2\n",
            "the PLY header gives its fa",
        ),
        ("a.ply", PLY + "0 0 0\n1 0\n", "the file is cut off: its header announces 5 elements 'vertex', and number 1 "),
        (
            "a.ply",
            PLY + ROWS + "4 0 1 2 3\n3 1 4\n",
            "the file is cut off: its header announces 2 elements 'face', and n",
        ),
        (
            "a.ply",
            PLY + ROWS + "4 0 1 2 3\n",
            "the file is cut off: its header announces 2 elements 'face', and number 1",
        ),
        ("a.ply", PLY + ROWS + "4 0 1 2 3\n-3 1 4 2\n", "face 1 announces a list of -3 values: a whole number"),
        ("a.ply", PLY + ROWS + "4 0 1 2 3\ninf 1 4 2\n", "face 1 announces a list of inf values: a whole number"),
        ("a.ply", PLY + ROWS + "4 0 1 2 3\n3 1 b 2\n", "line 16: 'b' is not a number; correct it"),
    ],
)
def test_bad_files_are_refused_in_one_sentence(tmp_path: Path, name: str, content: str, sentence: str) -> None:
    path = tmp_path / name
    path.write_text(content, encoding="latin-1", newline="\n")
    with pytest.raises((MeshFileError, MeshError)) as caught:
        read_mesh(path)
    assert caught.value.message.startswith(f"{path}: {sentence}")
    assert "\n" not in caught.value.message
    if re.search(r"\b(vertex|face) -?\d", caught.value.message):
        assert re.search(r"count(s|ed) (vertices )?(from|back)", caught.value.message)


@pytest.mark.parametrize("mesh_name", ["a.obj", "folder.off", "missing/a.ply"])
def test_files_that_are_not_there(tmp_path: Path, mesh_name: str) -> None:
    (tmp_path / "folder.off").mkdir()
    with pytest.raises(MeshFileError, match="there is no such file; check the path"):
        read_mesh(tmp_path / mesh_name)


def test_binary_ply_cut_off_anywhere(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    content = PLY.replace("ascii", "binary_little_endian").encode()
    content += b"".join(struct.pack("<fff", *vertex) for vertex in VERTICES)
    content += b"".join(struct.pack(f"<B{len(face)}i", len(face), *face) for face in QUAD_AND_TRIANGLE)
    path.write_bytes(content)
    assert read_mesh(path).mesh.n_faces == 2
    for length in range(len(content)):
        path.write_bytes(content[:length])
        with pytest.raises(MeshFileError, match=r"cut off|the file is empty|begins with a line 'ply'"):
            read_mesh(path)


@pytest.mark.parametrize("suffix", SUFFIXES)
@settings(max_examples=60)
@given(st.data())
def test_damaged_files_are_read_or_refused_but_nothing_else(
    tmp_path_factory: pytest.TempPathFactory, suffix: str, data: st.DataObject
) -> None:
    """A line lost, doubled or cut, a character changed: a mesh, or a GeometryError."""
    path = tmp_path_factory.getbasetemp() / f"damaged{suffix}"
    write_mesh(path, shapes.grid(2, 1))
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 3))):
        place = data.draw(st.integers(0, len(content) - 1))
        content[place : place + data.draw(st.integers(0, 12))] = data.draw(
            st.sampled_from([b"", b"9", b"-", b" ", b"\n"])
        )
    path.write_bytes(content)
    with suppress(GeometryError):
        read_mesh(path)


def test_write_refuses_before_it_writes(tmp_path: Path) -> None:
    with pytest.raises(MeshFileError, match=r"written to \.obj, \.off and \.ply, not \.stl"):
        write_mesh(tmp_path / "a.stl", shapes.cube())
    with pytest.raises(MeshFileError, match="there is no folder"):
        write_mesh(tmp_path / "none" / "a.obj", shapes.cube())
    assert list(tmp_path.iterdir()) == []

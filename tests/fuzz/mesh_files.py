"""Damaged mesh files: read and sound, or refused in one sentence."""

from __future__ import annotations

import struct
from itertools import pairwise
from pathlib import Path
from random import Random

import numpy as np
from driver import Files, Kind, mutated

from geometry.errors import MeshError, MeshFileError
from geometry.files import check_faces, read_mesh, write_mesh
from geometry.files.obj import obj_text
from geometry.files.off import off_text
from geometry.files.ply import ply_text
from geometry.mesh import Mesh, shapes

MESHES = [
    shapes.grid(2, 1),
    shapes.grid(4, 3),
    shapes.cube(),
    shapes.dome(5, 2),
    shapes.dodecahedron(),
    shapes.hexagonal_paraboloid(2, 2),
    shapes.regular_prism(30),
]

COLUMNS = (
    "ply\nformat {} 1.0\ncomment by program\nelement vertex {}\nproperty {} x\nproperty uchar red\nproperty {} y\n"
)
COLUMNS += "property {} z\nelement face {}\nproperty list {} {} vertex_indices\nproperty list uchar float texcoord\n"


def inputs(random: Random) -> Files:
    """A mesh in one of the formats, with its faults."""
    name, content = written("mesh", random.choice(MESHES), random)
    return {name: mutated(content, random)}


def attempt(folder: Path) -> str:
    """What is read is sound, and comes back from a file of its own with nothing to mend."""
    (path,) = folder.iterdir()
    found = read_mesh(path)
    check_faces(found.mesh)
    write_mesh(folder / "again.ply", found.mesh)
    again = read_mesh(folder / "again.ply")
    assert again.mended == (), again.mended
    assert again.mesh.combinatorics.same_as(found.mesh.combinatorics)
    assert np.array_equal(again.mesh.vertices, found.mesh.vertices)
    return "mended" if found.mended else "good"


def written(stem: str, mesh: Mesh, random: Random) -> tuple[str, bytes]:
    """Name and content of a file in one of the formats, now and then with every face of its own vertices."""
    mesh = _apart(mesh) if random.random() < 0.3 else mesh
    match random.randrange(5):
        case 0:
            return f"{stem}.obj", obj_text(mesh).encode()
        case 1:
            return f"{stem}.off", off_text(mesh).encode()
        case 2:
            return f"{stem}.off", _with_colours(off_text(mesh), mesh.n_vertices, random).encode()
        case 3:
            return f"{stem}.ply", ply_text(mesh).encode()
        case _:
            return f"{stem}.ply", _binary_ply(mesh, random)


def _apart(mesh: Mesh) -> Mesh:
    """Every face with vertices of its own."""
    c = mesh.combinatorics
    return Mesh.from_faces(mesh.vertices[c.corners], [range(a, b) for a, b in pairwise(c.face_starts.tolist())])


def _with_colours(text: str, n_vertices: int, random: Random) -> str:
    header, *lines = text.splitlines()
    lines[1:] = [f"{line} 9 9 9" if k < n_vertices else line for k, line in enumerate(lines[1:])]
    return "\n".join([random.choice(["COFF", "NOFF", header]), *lines])


def _binary_ply(mesh: Mesh, random: Random) -> bytes:
    order, name = random.choice([("<", "binary_little_endian"), (">", "binary_big_endian")])
    is_large = np.abs(mesh.vertices).max() > 1e38
    real, real_name = random.choice([("d" if is_large else "f", "double" if is_large else "float"), ("d", "double")])
    index, index_name = random.choice([("i", "int"), ("H", "ushort"), ("f", "float")])
    count, count_name = random.choice([("B", "uchar"), ("i", "int"), ("f", "float")])
    faces = [face.tolist() for face in mesh.combinatorics.faces]
    header = COLUMNS.format(name, mesh.n_vertices, real_name, real_name, real_name, len(faces), count_name, index_name)
    body = b"".join(struct.pack(f"{order}{real}B{real}{real}", x, 7, y, z) for x, y, z in mesh.vertices.tolist())
    for face in faces:
        body += struct.pack(f"{order}{count}{len(face)}{index}Bf", len(face), *face, 1, 0.5)
    return f"{header}end_header\n".encode() + body


MESH_FILES = Kind("meshes", inputs, attempt, (MeshError, MeshFileError))

"""Damaged mesh files, alone and in pairs: read and sound, or refused in one sentence.

Run: python tests/fuzz/mesh_files.py --seconds 60 --seed 1
"""

from __future__ import annotations

import struct
import sys
from itertools import pairwise
from pathlib import Path
from random import Random

import numpy as np
from driver import Files, fuzz, mutated

from geometry.errors import MeshError, MeshFileError
from geometry.mesh import Mesh, check_faces, read_mesh, read_mesh_pair, shapes, write_mesh
from geometry.mesh.obj import obj_text
from geometry.mesh.off import off_text
from geometry.mesh.ply import ply_text

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
    """A mesh in one of the formats, or a pair, with its faults."""
    mesh = random.choice(MESHES)
    if random.random() < 0.8:
        name, content = _written("a", mesh, random)
        return {name: mutated(content, random)}
    files = dict([_written("first", mesh, random), _written("second", _image(mesh), random)])
    return {name: mutated(content, random) if random.random() < 0.6 else content for name, content in files.items()}


def attempt(folder: Path) -> None:
    """What is read is sound, and comes back from a file of its own with nothing to mend."""
    paths = sorted(folder.iterdir())
    if len(paths) > 1:
        found, image = read_mesh_pair(*paths)
        assert image.combinatorics is found.mesh.combinatorics
    else:
        found = read_mesh(paths[0])
    check_faces(found.mesh)
    write_mesh(folder / "again.ply", found.mesh)
    again = read_mesh(folder / "again.ply")
    assert again.mended == (), again.mended
    assert again.mesh.combinatorics.same_as(found.mesh.combinatorics)
    assert np.array_equal(again.mesh.vertices, found.mesh.vertices)


def _image(mesh: Mesh) -> Mesh:
    return mesh.with_vertices(mesh.vertices @ [[0.1, 0.2, 0], [0, 0.3, 0.1], [0.1, 0, 0.4]])


def _written(stem: str, mesh: Mesh, random: Random) -> tuple[str, bytes]:
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
    real, real_name = random.choice([("f", "float"), ("d", "double")])
    index, index_name = random.choice([("i", "int"), ("H", "ushort"), ("f", "float")])
    count, count_name = random.choice([("B", "uchar"), ("i", "int"), ("f", "float")])
    faces = mesh.combinatorics.faces()
    header = COLUMNS.format(name, mesh.n_vertices, real_name, real_name, real_name, len(faces), count_name, index_name)
    body = b"".join(struct.pack(f"{order}{real}B{real}{real}", x, 7, y, z) for x, y, z in mesh.vertices.tolist())
    for face in faces:
        body += struct.pack(f"{order}{count}{len(face)}{index}Bf", len(face), *face, 1, 0.5)
    return f"{header}end_header\n".encode() + body


if __name__ == "__main__":
    sys.exit(fuzz(inputs, attempt, (MeshError, MeshFileError), "Damaged mesh files."))

"""Copies of a mesh: moved, turned, scaled, numbered otherwise; and what must be the same of what is made of them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fabkit import Built, Project, design
from fabkit.kinds.look_alikes import dot_vertices
from fabkit.parts import Part
from geometry.arrays import FloatArray, IntArray
from geometry.files import write_mesh
from geometry.mesh import Mesh

__all__ = ["Copy", "assert_same", "copy_of", "made_of", "piece"]

from tests.fabkit.assemblies import by_name

MEAN_EDGE_MM = 1000.0

SOLVED_MM = 3e-8
"""What solving leaves where coordinates are finer: faces are planar to 1e-12 of a mean edge, 1e-9 mm, and what follows
from them multiplies that by up to ten, an exact Gauss image by up to thirty."""

FEW_HUNDRED = 300.0
"""How often the rounding of the coordinates of a copy may be found in its parts: solving for planar faces and Gauss
images multiplies it by ten or so for fair meshes."""


@dataclass(frozen=True, eq=False)
class Copy:
    """A mesh made from another: vertex v became vertices[v], face f faces[f], p became scale p rotation^T + move."""

    mesh: Mesh
    vertices: IntArray
    faces: IntArray
    rotation: FloatArray
    scale: float
    move: FloatArray


def copy_of(
    mesh: Mesh, seed: int, *, reach: float = 0.0, turned: bool = False, scaled: bool = False, renumbered: bool = False
) -> Copy:
    """By random numbers; reach: largest coordinate of the move."""
    rng = np.random.default_rng(seed)
    rotation = Rotation.random(random_state=seed).as_matrix() if turned else np.eye(3)
    scale = float(10.0 ** rng.uniform(-4, 4)) if scaled else 1.0
    move = rng.uniform(-reach, reach, 3)
    vertices, faces = np.arange(mesh.n_vertices), np.arange(mesh.n_faces)
    if renumbered:
        vertices, faces = rng.permutation(mesh.n_vertices), rng.permutation(mesh.n_faces)
    positions = np.empty_like(mesh.vertices)
    positions[vertices] = scale * mesh.vertices @ rotation.T + move
    corners: list[list[int]] = [[] for _ in range(mesh.n_faces)]
    for face, ring in enumerate(mesh.combinatorics.faces):
        start = int(rng.integers(len(ring))) if renumbered else 0
        corners[faces[face]] = vertices[np.roll(ring, -start)].tolist()
    return Copy(Mesh.from_faces(positions, corners), vertices, faces, rotation, scale, move)


def made_of(mesh: Mesh, folder: Path, **settings: Any) -> Built:
    write_mesh(folder / "copy.obj", mesh)
    settings = {"equal_within_mm": 1e-7, **settings}  # with more it hangs on the order of parts which share a mark
    project = Project(mesh=folder / "copy.obj", mean_edge_mm=MEAN_EDGE_MM, nesting={"mode": "off"}, **settings)
    return design(project)


def piece(mesh: Mesh, n_faces: int) -> Mesh:
    """The faces nearest to one in the middle of the list, with edges of mean length 1."""
    centres = np.array([mesh.vertices[ring].mean(axis=0) for ring in mesh.combinatorics.faces])
    distances = np.linalg.norm(centres - centres[len(centres) // 3], axis=1)
    part = mesh.part(np.sort(np.argsort(distances, kind="stable")[:n_faces]))
    return part * (1 / part.mean_edge_length)


def assert_same(before: Built, after: Built, copy: Copy, *, shared_mm: float = 0.0) -> None:
    """Parts, axes and marks are the same, up to a few hundred times the rounding of the coordinates of the copy.

    shared_mm: by how much parts that share a mark differ, where another of them may be the first, whose solid all have,
    or another of two turns in which they fit equally well the better one.
    """
    coarse_mm = np.spacing(np.abs(copy.mesh.vertices).max()) * after.summary.scale_mm
    within = max(SOLVED_MM, FEW_HUNDRED * coarse_mm)
    assert abs(after.summary.scale_mm * copy.scale / before.summary.scale_mm - 1) < within / MEAN_EDGE_MM
    move_mm = copy.move * after.summary.scale_mm
    for kind, group in by_name(before.assembly).items():
        theirs = {_element(part, after): part for part in by_name(after.assembly)[kind]}
        renamed: dict[str, str] = {}
        assert len(theirs) == len(group)
        for part in group:
            other = theirs[_renumbered(part, before, copy)]
            expected = _corners(part, before) @ copy.rotation.T + move_mm
            found = _corners(other, after)
            apart = np.linalg.norm(expected[:, None] - found, axis=2)
            assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) < within + shared_mm
            assert abs(part.solid.volume_mm3 ** (1 / 3) - other.solid.volume_mm3 ** (1 / 3)) < within + shared_mm
            assert renamed.setdefault(part.mark, other.mark) == other.mark
        assert len(set(renamed.values())) == len(renamed)
    turned = before.structure.axes @ copy.rotation.T
    assert np.abs(after.structure.axes[copy.vertices] - turned).max() < within / MEAN_EDGE_MM


def _corners(part: Part, built: Built) -> FloatArray:
    """(n, 3) where the mesh file has them, in mm; without dots, which are beside the first beam that the file has."""
    corners = np.delete(part.solid.vertices, dot_vertices(part.solid.topology), axis=0)
    return part.placement.to_world(corners) + built.assembly.origin_mm


def _element(part: Part, built: Built) -> frozenset[int]:
    """The vertices that a part stands for."""
    c = built.structure.mesh.combinatorics
    if part.kind.name == "node":
        return frozenset([part.element])
    return frozenset((c.edges[part.element] if part.kind.name == "beam" else c.face(part.element)).tolist())


def _renumbered(part: Part, built: Built, copy: Copy) -> frozenset[int]:
    return frozenset(int(copy.vertices[vertex]) for vertex in _element(part, built))

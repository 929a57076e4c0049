"""Laying quads beside the remeshers that pip installs, in one run: `python tests/benchmarks/remeshers.py [faces]`.

`pip install pynanoinstantmeshes pyquadriflow` for the others, which print much of their own before the table; what is
missing is left out, saying so. Neither takes a field of directions. On three roofs, where they are at hand, and six
surfaces with known principal lines.

faces, quads: number, and share of quads. irregular: inner vertices of a valence other than 4. chi: whether the Euler
characteristic is that of the surface. on: share of edges within 10 degrees of the lines of curvature. planarity: of
faces, mean and largest, in mean edge lengths. planarise: moves of the vertices in mean edge lengths, 95 % and
largest, to planar faces while they glide on the surface; or why it refuses.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from laying import surfaces
from numerics import table
from rich.console import Console

from geometry.errors import GeometryError
from geometry.layout import lay_quads
from geometry.layout.quality import along_network, layout_quality
from geometry.mesh import Mesh
from geometry.meshing import Guides, planarise
from geometry.networks.networks import Network
from geometry.surface import Surface, refined

sys.path.insert(0, str(Path(__file__).parents[2]))

Remesher = Callable[[Mesh, int], Mesh]


def by_instant_meshes(triangles: Mesh, n_faces: int) -> Mesh:
    """Extrinsic, edges at the boundary aligned; the faces it finds are cut into four, so that all are quads."""
    import pynanoinstantmeshes

    corners = np.array(triangles.combinatorics.faces, dtype=np.uint32)
    vertices, faces = pynanoinstantmeshes.remesh(
        triangles.vertices.astype(np.float32),
        corners,
        vertex_count=n_faces // 4,
        align_to_boundaries=True,
        deterministic=True,
    )
    quads = [list(dict.fromkeys(face)) for face in faces.tolist()]  # a triangle repeats a corner
    return _used(vertices, [face for face in quads if len(face) > 2])


def by_quadriflow(triangles: Mesh, n_faces: int) -> Mesh:
    from pyQuadriFlow.pyQuadriFlow import pyquadriflow

    corners = np.array(triangles.combinatorics.faces).tolist()
    found = pyquadriflow(n_faces, 0, triangles.vertices.tolist(), corners, False, True, False, False, False)
    return _used(np.array(found["vertices"]), found["faces"])


def _used(vertices: np.ndarray, faces: list[list[int]]) -> Mesh:
    used, corners = np.unique(np.concatenate(faces), return_inverse=True)
    ends = np.cumsum([len(face) for face in faces])[:-1]
    return Mesh.from_faces(vertices[used], [each.tolist() for each in np.split(corners, ends)])


REMESHERS: dict[str, Remesher] = {"Instant Meshes": by_instant_meshes, "QuadriFlow": by_quadriflow}


def judged(mesh: Mesh, surface: Surface, network: Network, smooth: Surface) -> list[str]:
    quality = layout_quality(mesh, along_network(mesh, network), surface, 0.0)
    same = mesh.combinatorics.euler_characteristic == surface.triangulated.combinatorics.euler_characteristic
    try:
        moves = planarise(mesh, Guides(surface=smooth, fairness=0.3, keep_boundary=True)).moves
        taken = f"{np.quantile(moves, 0.95):.3f} {moves.max():.2f}"
    except GeometryError as error:
        taken = error.message[:50]
    return [
        str(mesh.n_faces),
        f"{quality.quad_share:.3f}",
        str(sum(quality.valences.values())),
        "same" if same else "other",
        f"{(quality.off_network < np.radians(10)).mean():.2f}",
        f"{quality.planarity.mean():.4f} {quality.planarity.max():.3f}",
        taken,
    ]


def rows(name: str, surface: Surface, n_faces: int) -> list[list[str]]:
    smooth = refined(surface)
    started = time.perf_counter()
    laid = lay_quads(surface, n_faces=n_faces)
    seconds = time.perf_counter() - started
    found = [[name, "fabkit", f"{seconds:.1f}", *judged(laid.mesh, surface, laid.network, smooth)]]
    for peer, remesher in REMESHERS.items():
        started = time.perf_counter()
        try:
            mesh = remesher(surface.triangulated, n_faces)
            seconds = time.perf_counter() - started
            found.append([name, peer, f"{seconds:.1f}", *judged(mesh, surface, laid.network, smooth)])
        except (ModuleNotFoundError, GeometryError) as reason:
            found.append([name, peer, f"{reason}"[:60]])
    return found


def main(n_faces: int) -> None:
    columns = ("surface", "program", "s", "faces", "quads", "irregular", "chi", "on", "planarity", "planarise")
    filled = table(f"{n_faces} faces wanted", *columns)
    for name, surface in surfaces().items():
        for row in rows(name, surface, n_faces):
            filled.add_row(*row)
    Console(width=170).print(filled)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)

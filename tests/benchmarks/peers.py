"""Planarising beside the programs others use, in one run: `python tests/benchmarks/peers.py [seconds]`.

libigl is always there; `pip install mpfp compas compas_shapeop` for the others: what is missing is left out, saying so.
Each peer gets the steps with which it comes closest to planar, unless a mesh would take it longer than the given
seconds (default 60). Planarity is the largest distance of a corner from its face's best plane, moves the largest
distance of a vertex from where it was, both in mean edge lengths. `times ours` compares seconds.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable

import igl
import numpy as np
from numerics import DATA, fresh, table, timed
from rich.console import Console

from geometry.arrays import FloatArray
from geometry.files import read_mesh
from geometry.functionals.planar_faces import relative_plane_deviations
from geometry.mesh import Mesh
from geometry.meshing import planarise

MESHES = (
    "libhedra/YasIsland.off",
    "dos/planarizednormalized_six_quad.obj",
    "dos/botanic-garden-bubble-0.obj",
    "dos/conical1.obj",
    "libhedra/gitter.off",
    "directional/inspired_mesh_quads_Conjugate.off",
)
STEPS = {"libigl": 1000, "mpfp": 50, "ShapeOp": 1000}
"""Steps of each peer; of mpfp these are its default rounds."""

Peer = Callable[[Mesh, int], FloatArray]


def by_libigl(mesh: Mesh, steps: int) -> FloatArray:
    quads = np.array(mesh.combinatorics.faces)
    return igl.planarize_quad_mesh(mesh.vertices, quads, maxIter=steps, threshold=0.0)


def by_mpfp(mesh: Mesh, steps: int) -> FloatArray:
    import mpfp

    settings = mpfp.MakePlanarSettings()
    settings.verbose = False
    settings.optimization_rounds = steps
    return np.array(mpfp.make_planar_faces(list(mesh.vertices), [face.tolist() for face in mesh.faces], [], settings))


def by_shapeop(mesh: Mesh, steps: int) -> FloatArray:
    from compas_shapeop.shapeop import Solver

    solver = Solver()
    solver.points = mesh.vertices / mesh.mean_edge_length
    for face in mesh.combinatorics.faces:
        solver.add_plane_constraint(face, 1.0)
    for vertex in range(mesh.n_vertices):
        solver.add_closeness_constraint(vertex, 1e-4)
    solver.init()
    solver.solve(steps)
    return np.array(solver.points) * mesh.mean_edge_length


PEERS: dict[str, Peer] = {"libigl": by_libigl, "mpfp": by_mpfp, "ShapeOp": by_shapeop}


def affordable(peer: Peer, mesh: Mesh, steps: int, seconds: float) -> int:
    """The steps, or fewer where a twentieth of them says that they would take too long."""
    few = max(1, steps // 20)
    started = time.perf_counter()
    peer(mesh, few)
    return min(steps, max(few, int(few * seconds / (time.perf_counter() - started))))


def rows(name: str, mesh: Mesh, seconds: float) -> list[list[str]]:
    def judged(vertices: FloatArray) -> list[str]:
        moves = np.linalg.norm(vertices - mesh.vertices, axis=1) / mesh.mean_edge_length
        return [f"{relative_plane_deviations(mesh.with_vertices(vertices)).max():.1e}", f"{moves.max():.3f}"]

    result, ours = timed(lambda: planarise(fresh(mesh)))
    found = [[name, "fabkit", f"{ours / 1e3:.2f}", *judged(result.mesh.vertices), "1"]]
    for peer_name, peer in PEERS.items():
        if peer_name == "libigl" and (mesh.combinatorics.face_sizes != 4).any():
            continue
        try:
            steps = affordable(peer, mesh, STEPS[peer_name], seconds)
        except ModuleNotFoundError as missing:
            found.append([name, f"{peer_name}: {missing}", "", "", "", ""])
            continue
        vertices, milliseconds = timed(lambda peer=peer, steps=steps: peer(mesh, steps), repeats=1)
        label = f"{peer_name}, {steps} steps"
        found.append([name, label, f"{milliseconds / 1e3:.2f}", *judged(vertices), f"{milliseconds / ours:.0f}"])
    return found


def main(seconds: float) -> None:
    filled = table("Planarise, with peers", "mesh", "program", "s", "planarity", "largest move", "times ours")
    for name in MESHES:
        for row in rows(name.split("/")[1].split(".")[0], read_mesh(DATA / name).mesh, seconds):
            filled.add_row(*row)
    Console(width=120).print(filled)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 60.0)

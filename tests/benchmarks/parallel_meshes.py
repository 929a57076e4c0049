"""How long P(M) and Gauss images take, up to a million faces: `python tests/benchmarks/parallel_meshes.py [faces ...]`.

First a basis of P(M) of a roof of 649 vertices beside the paper's way, the singular value decomposition of the dense
matrix of (2). Then Gauss images of smooth meshes of quads of the given numbers of faces, each in a process of its own,
whose peak memory is that of the whole process, read from /proc as Linux has it. Set OPENBLAS_NUM_THREADS=1 where cores
are shared.
"""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from numerics import fresh, smooth, table, timed
from rich.console import Console

from geometry.arrays import FloatArray
from geometry.gauss import approximate_pair
from geometry.mesh import Mesh, shapes
from geometry.parallel import ParallelSpace, parallelity

SIZES = (1_000, 10_000, 100_000, 1_000_000)


def roof() -> Mesh:
    """649 vertices and 580 planar quads, near to the 649 and 568 of [Pottmann2007, Fig. 14]."""
    u, v = np.linspace(-1, 1, 59), np.linspace(-1, 1, 11)
    first = np.stack([5 * u, 0.1 * u, -(u**2) + 0.2 * np.sin(5 * u)], axis=1)
    second = np.stack([0.1 * v, v, -0.3 * v**2 + 0.1 * v**3], axis=1)
    mesh = shapes.translation_surface(first, second)
    return mesh.with_vertices(mesh.vertices / (1 + mesh.vertices[:, :2] @ [[0.05], [0.1]]))


def cross_products(mesh: Mesh) -> FloatArray:
    """(3E, 3N) the dense matrix of [Pottmann2007, (2)]."""
    x, y, z = mesh.edge_vectors.T
    zero = np.zeros(mesh.n_edges)
    blocks = np.array([[zero, z, -y], [-z, zero, x], [y, -x, zero]]).transpose(2, 0, 1)  # s -> s x e
    edge, row, column = (index.ravel() for index in np.indices(blocks.shape))
    matrix = np.zeros((3 * mesh.n_edges, 3 * mesh.n_vertices))
    for end, sign in ((0, -1.0), (1, 1.0)):
        matrix[3 * edge + row, 3 * mesh.combinatorics.edges[edge, end] + column] = sign * blocks.ravel()
    return matrix


def papers_basis(mesh: Mesh) -> FloatArray:
    """(dimension, 3N) by a dense singular value decomposition."""
    values, vectors = np.linalg.svd(cross_products(mesh))[1:]
    return vectors[int((values > 1e-9 * values[0]).sum()) :]


def basis_against_the_papers(console: Console) -> None:
    mesh = roof()
    ours, milliseconds = timed(lambda: ParallelSpace(fresh(mesh)).basis)
    dense, of_dense = timed(lambda: papers_basis(mesh), repeats=1)
    flat = np.reshape(ours, (len(ours), -1))
    off = np.linalg.norm(dense - (dense @ flat.T) @ flat, axis=1).max()
    filled = table("Basis of P(M)", "mesh", "V / F", "dimension", "ms", "dense SVD, ms", "ratio", "spaces differ by")
    sizes = f"{mesh.n_vertices} / {mesh.n_faces}"
    ratio = f"{of_dense / milliseconds:.0f}"
    filled.add_row(
        "roof", sizes, f"{len(flat)} ({len(dense)})", f"{milliseconds:.0f}", f"{of_dense:.0f}", ratio, f"{off:.0e}"
    )
    console.print(filled)


def gauss_image_alone(n_faces: int) -> str:
    """Faces, seconds, largest deviation from parallel and peak memory in GB of this process, as text."""
    mesh = fresh(smooth((round(n_faces**0.5) + 1) ** 2))
    started = time.perf_counter()
    image = approximate_pair(mesh).gauss_image
    seconds = time.perf_counter() - started
    (peak,) = (line.split()[1] for line in Path("/proc/self/status").read_text().splitlines() if line[:6] == "VmHWM:")
    return f"{mesh.n_faces} {seconds:.2f} {parallelity(mesh, image).max():.1e} {int(peak) / 1e6:.2f}"


def gauss_images(console: Console, sizes: tuple[int, ...]) -> None:
    filled = table("Gauss image of a smooth mesh", "faces", "s", "off parallel", "peak GB")
    for size in sizes:
        result = subprocess.run(
            [sys.executable, __file__, "alone", str(size)], check=True, capture_output=True, text=True
        )
        filled.add_row(*result.stdout.split())
    console.print(filled)


def main(sizes: tuple[int, ...]) -> None:
    console = Console(width=120)
    basis_against_the_papers(console)
    gauss_images(console, sizes)


if __name__ == "__main__":
    if sys.argv[1:2] == ["alone"]:
        print(gauss_image_alone(int(sys.argv[2])))
    else:
        main(tuple(int(argument) for argument in sys.argv[1:]) or SIZES)

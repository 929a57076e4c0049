"""A mesh M and a Gauss image S together: what is parallel but for the last digits becomes exactly so."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, eye_array

from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.functionals import Parallelity, Planarity, face_deviations
from geometry.gauss.refinement import PARALLEL
from geometry.mesh import Mesh
from geometry.optimise import Blocks, ConvergenceError, Reason, Stack, nearest_feasible
from geometry.parallel.edge_parallelity import PLANAR, parallelity

__all__ = ["nearest_parallel_pair"]

ACCURACY = 1e-13
"""What is asked of parallelity and planarity, over the size of S and the mean edge length: a tenth of what others ask,
so that they take the pair as it is."""

LONGEST_STEP = 0.1
"""Of a vertex, over the mean edge length of M or the size of S: a pair further off is not nearly parallel."""

LEAST_SIZE = 1e-60
"""Of S: products of four such lengths are still numbers, as are those of its inverse."""

HELD_STEPS = 2
MAX_STEPS = 12
"""Steps that pull towards the given pair, and of all: two or three reach rounding from six digits, four from four."""


def nearest_parallel_pair(mesh: Mesh, image: Mesh) -> tuple[Mesh, Mesh]:
    """Planar meshes M and S, parallel to rounding, near to a given pair.

    The squared moves of the vertices of M, over its mean edge length, and of those of S, over the mean distance of its
    vertices from the origin, have a small sum. Both move together, because a mesh
    made planar alone may be parallel to no mesh near S: P(M) often has more dimensions than a mesh nearby has. A pair
    that is exact comes back as the same objects.

    Raises MeshError where the faces differ, an edge of M has no length or S no size, and ConvergenceError, naming the
    worst edge, where no such pair is found near the given one.
    """
    if parallelity(mesh, image).max() <= PARALLEL and face_deviations(mesh).max() <= PLANAR:
        return mesh, image
    centre = mesh.vertices.mean(axis=0)
    size, radius = mesh.mean_edge_length, float(np.linalg.norm(image.vertices, axis=1).mean())
    if not LEAST_SIZE <= radius <= 1 / LEAST_SIZE:
        raise MeshError(
            f"the vertices of the Gauss image are {radius:.1e} from the origin in the mean, and from {LEAST_SIZE:.0e} "
            f"to {1 / LEAST_SIZE:.0e} can be reckoned with: a Gauss image lies near the unit sphere about the origin",
            value=radius,
            bound=LEAST_SIZE if radius < LEAST_SIZE else 1 / LEAST_SIZE,
        )
    blocks = Blocks({"M": mesh.vertices.shape, "S": mesh.vertices.shape})
    start = blocks.join(M=(mesh.vertices - centre) / size, S=image.vertices / radius)
    solution = nearest_feasible(
        _exactness(mesh, blocks, start),
        start,
        csr_array(eye_array(len(start))),
        tolerance=ACCURACY,
        longest_step=LONGEST_STEP,
        blocks=blocks,
        held_steps=HELD_STEPS,
        max_steps=MAX_STEPS,
    )
    found = blocks.split(solution.x)
    vertices, normals = found["M"], found["S"]
    if solution.reason is not Reason.CONVERGED:
        sideways = parallelity(mesh.with_vertices(vertices), image.with_vertices(normals))
        edge = int(sideways.argmax())
        raise ConvergenceError(
            f"no mesh near the given one is parallel to one near the given Gauss image: "
            f"{mesh.combinatorics.edge_name(edge)} stays {sideways[edge]:.1e} off the direction of its mesh edge after "
            f"{solution.steps} steps, allowed {ACCURACY:.0e}: {solution.reason.value}; write both with more digits",
            solution=solution,
            elements=[edge],
            value=float(sideways[edge]),
            bound=ACCURACY,
        )
    return mesh.with_vertices(vertices * size + centre), image.with_vertices(normals * radius)


def _exactness(mesh: Mesh, blocks: Blocks, start: FloatArray) -> Stack:
    """S parallel to M, both with planar faces: residuals of x (6N,), which is near to the start.

    Planarity of M follows where no edge of S vanishes; asked for all the same, it also holds where one does.
    """
    c = mesh.combinatorics
    planar = [blocks.of(Planarity(c, near.ravel()), name) for name, near in blocks.split(start).items()]
    return Stack([blocks.of(Parallelity(c), "M", "S"), *planar])

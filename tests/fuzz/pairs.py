"""Damaged pairs of a mesh and its Gauss image: they are made parallel, or refused with one sentence that counts from
0."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random

import numpy as np
from driver import Files, Kind, mutated
from mesh_files import MESHES, written

from fabkit.gauss_image import GIVEN_PAIR_TOLERANCE, read_given_pair
from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.files import check_faces, read_mesh_pair
from geometry.gauss import Pair, approximate_pair, nearest_parallel_pair
from geometry.mesh import Mesh, shapes
from geometry.parallel import parallelity

ELEMENTS = re.compile(r"\b(vertex|vertices|edge|edges|face|faces) \d+[ ,;:-]")


def inputs(random: Random) -> Files:
    """A mesh and its Gauss image, or another element of P(M), or unrelated meshes: moved, noisy, as files with
    faults."""
    mesh, image = random.choice(_pairs())
    if random.random() < 0.2:
        image = image.with_vertices(image.vertices @ [[0.1, 0.2, 0], [0, 0.3, 0.1], [0.1, 0, 0.4]])
    if random.random() < 0.6:
        image = image.with_vertices(_disturbed(image.vertices, random))
    if random.random() < 0.3:
        mesh = mesh.with_vertices(_disturbed(mesh.vertices, random))
    files = dict([written("first", mesh, random), written("second", image, random)])
    return {name: mutated(content, random) if random.random() < 0.3 else content for name, content in files.items()}


def attempt(folder: Path) -> str:
    """Two files are read as one mesh with two sets of vertices; as M and S they are made planar and parallel."""
    first, second = sorted(folder.iterdir())
    found, image = read_mesh_pair(first, second)
    assert image.combinatorics is found.mesh.combinatorics
    check_faces(found.mesh)
    tolerance = 10.0 ** -(len(first.read_bytes()) % 7)
    is_given = _is_made_or_refused(lambda: _made_exact(first, second, tolerance))
    is_found = _is_made_or_refused(lambda: _is_parallel(nearest_parallel_pair(found.mesh.near_zero()[0], image)))
    return "a pair" if is_given else "parallel" if is_found else "read"


def _made_exact(first: Path, second: Path, tolerance: float) -> None:
    given = read_given_pair(first, second, flip=tolerance < GIVEN_PAIR_TOLERANCE, tolerance=tolerance)
    exact = nearest_parallel_pair(given.file.mesh, given.gauss_image, tolerance=tolerance)
    assert exact.moves_from(given.file.mesh, given.gauss_image)[1].max() <= tolerance
    _is_parallel(exact)


def _is_parallel(pair: Pair) -> None:
    size = np.abs(pair.gauss_image.vertices).max()
    assert parallelity(pair.mesh, pair.gauss_image).max() <= 1e-11 * max(size, 1.0), (
        "not parallel"
    )  # what the library promises


def _is_made_or_refused(make: Callable[[], None]) -> bool:
    """Whether `make` succeeds. If not, assert that its error is one sentence, and that an error which numbers elements
    also carries them in `error.elements`, so that `fabkit` can say that they are counted from 0."""
    try:
        make()
        return True
    except GeometryError as error:
        sentence, is_counted = str(error), "counted from" in str(error) or bool(error.elements)
    assert sentence.isprintable(), sentence
    assert len(sentence) < 700, sentence
    assert is_counted or not ELEMENTS.search(sentence), sentence
    return False


@cache
def _pairs() -> list[tuple[Mesh, Mesh]]:
    """Meshes with planar faces and their Gauss images, and pairs of meshes that are not parallel."""
    planar = [shapes.grid(3, 2), shapes.dome(5, 2), shapes.catenoid(6, 2), shapes.dodecahedron(), shapes.cube()]
    made = [(mesh, approximate_pair(mesh, normals=mesh.vertex_normals).gauss_image) for mesh in planar]
    centred = [mesh.with_vertices(mesh.vertices - mesh.vertices.mean(axis=0)) for mesh in planar]
    return [*made, *zip(planar, centred, strict=True), *((mesh, mesh) for mesh in MESHES)]


def _disturbed(points: FloatArray, random: Random) -> FloatArray:
    noise = np.random.default_rng(random.randrange(2**32)).normal(size=points.shape)
    match random.randrange(8):
        case 0:
            return points + noise * 10.0 ** -random.randrange(1, 17)
        case 1:
            return np.round(points, random.randrange(9))
        case 2:
            return points * 10.0 ** random.randrange(-300, 300, 7)
        case 3:
            return points * random.choice([-1.0, 0.0, 0.5, 2.0, 1e-3])
        case 4:
            return points + random.choice([0.3, 1e3, 5e6, 1e15])
        case 5:
            return points[random.sample(range(len(points)), len(points))]
        case 6:
            return points * [1.0, 1.0, random.choice([0.0, -1.0, 1e-9])]
        case _:
            return np.where(noise > random.choice([0.5, 1.5]), points[0], points)


PAIRS = Kind("pairs", inputs, attempt, (GeometryError,))

"""What a mesh is fit for, before anything is built from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fabkit.gauss_image import TOLERANCE, computed_image
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.errors import GeometryError
from geometry.mesh import Mesh, MeshFile, read_mesh, read_mesh_pair
from geometry.meshing import OptimisedMesh, planarise
from geometry.parallel import (
    DISTANCE_TOLERANCE,
    SupportStructure,
    circularity,
    conicality,
    edge_distances,
    edge_factors,
    face_distances,
    nearest_parallel_pair,
    offset_deviations,
    parallelity,
    vertex_distances,
)

__all__ = ["Inspection", "PairInspection", "inspect_mesh", "inspect_pair"]

EXACT, NEARLY = 1e-6, 1e-2
"""Largest deviation, as a part of the edge length or in radians, up to which a property is said to hold or nearly to
hold: drawing programs write seven digits; a hundredth of an edge is what one sees."""


@dataclass(frozen=True, eq=False)
class Inspection:
    """A mesh file, and what follows from it. Lengths are in the unit of the file.

    planar: the mesh made planar, None where that failed. heights (E,): of beams over the nominal height, None where
    there is no Gauss image. trouble: why something is missing, a sentence each.
    """

    file: MeshFile
    planar: OptimisedMesh | None
    heights: FloatArray | None
    trouble: tuple[str, ...]

    def facts(self) -> Iterator[tuple[str, str]]:
        """Name and sentence of each fact, in the order in which one wants to read them."""
        yield from _as_read(self.file)
        if self.planar is not None:
            yield "planarised", _moves(self.planar)
            yield from _offsets(self.planar.mesh)
        if self.heights is not None:
            yield "beam heights", _heights(self.heights)
        for sentence in self.trouble:
            yield "unfit", sentence


@dataclass(frozen=True, eq=False)
class PairInspection:
    """A mesh and a Gauss image as their files say. exact: the nearest parallel pair, None where there is none near, for
    the reason in `trouble`."""

    file: MeshFile
    image: Mesh
    exact: tuple[Mesh, Mesh] | None
    trouble: tuple[str, ...]

    def facts(self) -> Iterator[tuple[str, str]]:
        """Name and sentence of each fact, in the order in which one wants to read them."""
        yield from _as_read(self.file)
        mesh, image = self.file.mesh, self.image
        sideways = parallelity(mesh, image)
        worst = mesh.combinatorics.edge_name(int(sideways.argmax()))
        yield "parallel", f"to {sideways.max():.1e} of the unit sphere's radius, at {worst}, counted from 0"
        if self.exact is not None:
            yield "made exact", _pair_moves((mesh, image), self.exact)
            yield from _distances(*self.exact)
            yield "reversed", _reversed(*self.exact)
            yield "alignment", _alignment(*self.exact)
        for sentence in self.trouble:
            yield "unfit", sentence


def _as_read(file: MeshFile) -> Iterator[tuple[str, str]]:
    mesh, c = file.mesh, file.mesh.combinatorics
    lengths = mesh.edge_lengths
    yield "vertices", f"{mesh.n_vertices}; edges {mesh.n_edges}; faces {mesh.n_faces}"
    yield "corners", _counts(c.face_sizes, "faces with {}")
    yield "valences inside", _counts(c.vertex_degrees[c.is_used & ~c.is_boundary_vertex], "of {}")
    yield "at the boundary", _counts(c.vertex_degrees[c.is_boundary_vertex], "of {}")
    yield "boundaries", _boundaries(mesh)
    yield "edge lengths", f"{lengths.min():.4g} to {lengths.max():.4g}, mean {lengths.mean():.4g}"
    for note in file.mended:
        yield "mended", note
    yield "planarity", f"{mesh.planarity.max():.1e} of the edge length at worst, as read"


def inspect_mesh(path: Path) -> Inspection:
    """Read a mesh and try all that a build would ask of it, up to the Gauss image.

    Raises GeometryError where there is no mesh to be read; what fails after that is part of the answer.
    """
    file = read_mesh(path)
    try:
        planar = planarise(file.mesh)
    except GeometryError as error:
        return Inspection(file, None, None, (error.message,))
    try:
        heights = edge_distances(planar.mesh, computed_image(planar.mesh, {})[0])
    except GeometryError as error:
        return Inspection(file, planar, None, (error.message,))
    return Inspection(file, planar, heights, ())


def inspect_pair(mesh: Path, image: Path) -> PairInspection:
    """Read a mesh and its Gauss image and say how they fit, whatever a build would accept.

    Raises GeometryError where a file cannot be read or the faces differ; what fails after that is part of the answer.
    """
    file, gauss = read_mesh_pair(mesh, image)
    try:
        exact = nearest_parallel_pair(file.mesh, gauss)
        SupportStructure(*exact, 1.0)  # no node axis lies in an edge
    except GeometryError as error:
        return PairInspection(file, gauss, None, (error.message,))
    return PairInspection(file, gauss, exact, ())


def _counts(values: IntArray, wording: str) -> str:
    found, counts = np.unique(values, return_counts=True)
    pairs = zip(found.tolist(), counts.tolist(), strict=True)
    return ", ".join(f"{count} {wording.format(value)}" for value, count in pairs) or "none"


def _boundaries(mesh: Mesh) -> str:
    loops = [len(loop) for loop in mesh.combinatorics.boundary_loops]
    pieces = int(mesh.combinatorics.face_components.max()) + 1
    parts = "one piece" if pieces == 1 else f"{pieces} pieces"
    if not loops:
        return f"closed; {parts}, Euler characteristic {mesh.combinatorics.euler_characteristic}"
    sizes = ", ".join(str(size) for size in sorted(loops, reverse=True))
    return f"{len(loops)} of {sizes} vertices; {parts}, Euler characteristic {mesh.combinatorics.euler_characteristic}"


def _moves(planar: OptimisedMesh) -> str:
    if planar.iterations == 0:
        return "nothing to do"
    return (
        f"to {planar.planarity_after:.1e} by moving vertices by {planar.mean_move:.2g} of the edge length in the mean, "
        f"{planar.largest_move:.2g} at most"
    )


def _offsets(mesh: Mesh) -> Iterator[tuple[str, str]]:
    """Which offsets at exactly constant distance the planar mesh has [Pottmann2007, Prop. 2], judged by the nearest S:
    circular faces give a vertex offset to quads alone, and three planes at each vertex always give a face offset."""
    off = offset_deviations(mesh)
    yield "vertex offset", _offset(off["vertex"], "constant distance between vertices")
    yield "edge offset", _offset(off["edge"], "beams of constant height")
    yield "face offset", _offset(off["face"], "constant distance between faces")
    yield "circular", _verdict(circularity(mesh), "of the edge length")
    yield "conical", _verdict(conicality(mesh), "radians")


def _offset(deviation: float, offers: str) -> str:
    if deviation > NEARLY:
        return f"no: not {offers}"
    answer = "yes" if deviation <= DISTANCE_TOLERANCE else "nearly"
    return f"{answer}: {offers}, to {deviation:.1e} of it at worst"


def _verdict(deviations: FloatArray, unit: str) -> str:
    asked = deviations[~np.isnan(deviations)]
    if not len(asked):
        return "nothing is asked of this mesh"
    worst, median = float(asked.max()), float(np.median(asked))
    answer = "yes" if worst <= EXACT else "nearly" if worst <= NEARLY else "no"
    return f"{answer}: off by {median:.1e} {unit} in the median, {worst:.1e} at worst"


def _heights(heights: FloatArray) -> str:
    low, early, middle, late, high = np.percentile(heights, [0, 5, 50, 95, 100])
    within: BoolArray = np.abs(heights - 1) <= 0.02
    return (
        f"{low:.3f} to {high:.3f} of the nominal height, median {middle:.3f}, 90 % within {early:.3f} to {late:.3f}; "
        f"{within.mean():.0%} of the beams are within 2 %"
    )


# --- pairs


def _pair_moves(given: tuple[Mesh, Mesh], exact: tuple[Mesh, Mesh]) -> str:
    of_mesh, of_image = (
        float(np.linalg.norm(after.vertices - before.vertices, axis=1).max())
        for before, after in zip(given, exact, strict=True)
    )
    of_mesh /= given[0].mean_edge_length
    if of_mesh == of_image == 0:
        return "nothing to do"
    refused = f", more than {TOLERANCE:g}, so that a build refuses it" if max(of_mesh, of_image) > TOLERANCE else ""
    return (
        f"by moving vertices of the mesh by {of_mesh:.1e} of its mean edge length at most, of the Gauss image by "
        f"{of_image:.1e} of the unit sphere's radius{refused}"
    )


def _distances(mesh: Mesh, image: Mesh) -> Iterator[tuple[str, str]]:
    """Of S from the origin: what is constant is an offset [Pottmann2007, Prop. 2]."""
    for name, offers, distances in (
        ("vertices of S", "a vertex offset", vertex_distances(image)),
        ("edges of S", "an edge offset: beams of one height", edge_distances(mesh, image)),
        ("faces of S", "a face offset", face_distances(mesh, image)),
    ):
        size = np.abs(distances)
        spread = float(np.ptp(size) / size.mean())
        verdict = f"constant to {spread:.1e}, {offers}" if spread <= EXACT else f"so not {offers}"
        if EXACT < spread <= NEARLY:
            verdict = f"constant to {spread:.1e}, nearly {offers}"
        yield name, f"{size.min():.4g} to {size.max():.4g} from the origin, {verdict}"


def _reversed(mesh: Mesh, image: Mesh) -> str:
    factors = edge_factors(mesh, image)
    around = np.zeros((2, mesh.n_vertices), dtype=bool)
    for side, edges in enumerate((factors < 0, factors > 0)):
        around[side, mesh.combinatorics.edges[edges]] = True
    return (
        f"{(factors < 0).sum()} of {mesh.n_edges} edges run against those of S; around {around.all(axis=0).sum()} of "
        f"{mesh.n_vertices} vertices some do and some do not, as on a saddle: beams end at two levels there"
    )


def _alignment(mesh: Mesh, image: Mesh) -> str:
    """How far tops and bottoms of beams of one height miss each other on the node axes: h / cos, h the height."""
    structure = SupportStructure(mesh, image, 1.0)
    ends = mesh.combinatorics.edges.ravel()
    along = np.einsum("ek,ek->e", structure.axes[ends], np.repeat(mesh.edge_directions, 2, axis=0))
    cuts = 1 / np.sqrt(np.maximum(1 - along**2, np.finfo(float).tiny))
    least, largest = np.full(mesh.n_vertices, np.inf), np.full(mesh.n_vertices, -np.inf)
    np.minimum.at(least, ends, cuts)
    np.maximum.at(largest, ends, cuts)
    spread = (largest - least)[mesh.combinatorics.is_used]
    return (
        f"tops and bottoms of beams miss each other on the node axes by {np.median(spread):.1e} of the beam height in "
        f"the median, {spread.max():.1e} at most"
    )

"""What a mesh is fit for, before anything is built from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.errors import GeometryError
from geometry.mesh import Mesh, MeshFile, read_mesh
from geometry.meshing import OptimisedMesh, planarise
from geometry.parallel.gauss_image import gauss_image
from geometry.parallel.offsets import circularity, conicality, edge_axis_twist, edge_cone_deviation, edge_distances

__all__ = ["Inspection", "inspect_mesh"]

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
        mesh, c = self.file.mesh, self.file.mesh.combinatorics
        lengths = mesh.edge_lengths
        yield "vertices", f"{mesh.n_vertices}; edges {mesh.n_edges}; faces {mesh.n_faces}"
        yield "corners", _counts(c.face_sizes, "faces with {}")
        yield "valences inside", _counts(c.vertex_degrees[c.is_used & ~c.is_boundary_vertex], "of {}")
        yield "at the boundary", _counts(c.vertex_degrees[c.is_boundary_vertex], "of {}")
        yield "boundaries", _boundaries(mesh)
        yield "edge lengths", f"{lengths.min():.4g} to {lengths.max():.4g}, mean {lengths.mean():.4g}"
        for note in self.file.mended:
            yield "mended", note
        yield "planarity", f"{mesh.planarity.max():.1e} of the edge length at worst, as read"
        if self.planar is not None:
            yield "planarised", _moves(self.planar)
            yield from _offsets(self.planar.mesh)
        if self.heights is not None:
            yield "beam heights", _heights(self.heights)
        for sentence in self.trouble:
            yield "unfit", sentence


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
        heights = edge_distances(planar.mesh, gauss_image(planar.mesh))
    except GeometryError as error:
        return Inspection(file, planar, None, (error.message,))
    return Inspection(file, planar, heights, ())


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
    """Which offsets at exactly constant distance the planar mesh has [Pottmann2007, Prop. 2]."""
    yield "circular", _verdict(circularity(mesh), "constant distance between vertices", "of the edge length")
    yield "conical", _verdict(conicality(mesh), "constant distance between faces", "radians")
    # edges on cones of revolution whose axes are coplanar over each edge [Pottmann2007, Prop. 3]
    cones = np.concatenate([edge_cone_deviation(mesh), edge_axis_twist(mesh)])
    yield "edge offset", _verdict(cones, "beams of constant height", "radians")


def _verdict(deviations: FloatArray, offers: str, unit: str) -> str:
    asked = deviations[~np.isnan(deviations)]
    if not len(asked):
        return f"nothing is asked of this mesh: {offers}"
    worst, median = float(asked.max()), float(np.median(asked))
    answer = "yes" if worst <= EXACT else "nearly" if worst <= NEARLY else "no"
    gives = f", which gives {offers}" if worst <= NEARLY else f", so not: {offers}"
    return f"{answer}: off by {median:.1e} {unit} in the median, {worst:.1e} at worst{gives}"


def _heights(heights: FloatArray) -> str:
    low, early, middle, late, high = np.percentile(heights, [0, 5, 50, 95, 100])
    within: BoolArray = np.abs(heights - 1) <= 0.02
    return (
        f"{low:.3f} to {high:.3f} of the nominal height, median {middle:.3f}, 90 % within {early:.3f} to {late:.3f}; "
        f"{within.mean():.0%} of the beams are within 2 %"
    )

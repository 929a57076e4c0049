"""The facts that `fabkit inspect` prints about a mesh, or a pair M and S: a name and a sentence for each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from fabkit.detailing import Ends, axis_misalignments, beam_ends
from fabkit.fitness import Finding
from fabkit.gauss_image import GIVEN_PAIR_TOLERANCE
from fabkit.production import OptimisedGaussImage
from fabkit.rules import DetailingRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.errors import GeometryError
from geometry.exact_offsets import circularity, conicality, offset_deviations
from geometry.exact_offsets.exact_or_approximate import EXACT_OFFSET_TOLERANCE
from geometry.files import MeshFile
from geometry.gauss import Pair, SupportStructure, nearest_parallel_pair
from geometry.mesh import Mesh
from geometry.parallel import parallelity

__all__ = [
    "as_read",
    "beam_heights",
    "ends_of_all",
    "findings_facts",
    "moves",
    "offset_kinds",
    "optimising",
    "pair_fit",
]

EXACT_PROPERTY_TOLERANCE, NEAR_PROPERTY_TOLERANCE = 1e-6, 1e-2
"""Largest deviation up to which a property holds, and nearly holds, relative to an edge or in radians: drawing programs
write seven digits; a hundredth of an edge is visible."""


def as_read(file: MeshFile) -> Iterator[tuple[str, str]]:
    mesh, c = file.mesh, file.mesh.combinatorics
    lengths = mesh.edge_lengths
    yield "vertices", f"{mesh.n_vertices}; edges {mesh.n_edges}; faces {mesh.n_faces}"
    yield "corners", _counts(c.face_sizes, "faces with {}")
    yield "inner valences", _counts(c.vertex_degrees[c.is_used & ~c.is_boundary_vertex], "vertices of valence {}")
    yield "at the boundary", _counts(c.vertex_degrees[c.is_boundary_vertex], "vertices of valence {}")
    yield "boundaries", _boundaries(mesh)
    yield "edge lengths", f"{lengths.min():.4g} to {lengths.max():.4g}, mean {lengths.mean():.4g}"
    for note in file.mended:
        yield "mended", note
    yield "planarity", f"{mesh.planarity.max():.1e} of the face's mean edge length at most, as read"


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


def moves(before: Mesh, after: Mesh) -> str | None:
    moves = np.linalg.norm(after.vertices - before.vertices, axis=1) / before.mean_edge_length
    if not moves.any():
        return None
    return (
        f"to {after.planarity.max():.1e} by moving vertices by {moves.mean():.2g} of the mean edge length on average, "
        f"{np.percentile(moves, 95):.2g} at 95 %, {moves.max():.2g} at most (vertex {moves.argmax()}, counted from 0)"
    )


def offset_kinds(mesh: Mesh) -> Iterator[tuple[str, str]]:
    """The offsets at exactly constant distance that the planar mesh has [Pottmann2007, Prop. 2], found from the nearest
    S. Circular faces give a vertex offset to quad meshes alone; a mesh with three faces at each vertex always has a
    face offset."""
    deviations = offset_deviations(mesh)
    yield "vertex offset", _offset(deviations["vertex"], "constant distance between vertices")
    yield "edge offset", _offset(deviations["edge"], "beams of constant height")
    yield "face offset", _offset(deviations["face"], "constant distance between faces")
    yield "circular", _verdict(circularity(mesh), "of the edge length")
    yield "conical", _verdict(conicality(mesh), "radians")


def _offset(deviation: float, offers: str) -> str:
    if deviation > NEAR_PROPERTY_TOLERANCE:
        return f"no: it does not have {offers}"
    answer = "yes" if deviation <= EXACT_OFFSET_TOLERANCE else "nearly"
    return f"{answer}: {offers}, with a largest relative deviation of {deviation:.1e}"


def _verdict(deviations: FloatArray, unit: str) -> str:
    known = deviations[~np.isnan(deviations)]
    if not len(known):
        return "satisfied without conditions"
    worst, median = float(known.max()), float(np.median(known))
    answer = "yes" if worst <= EXACT_PROPERTY_TOLERANCE else "nearly" if worst <= NEAR_PROPERTY_TOLERANCE else "no"
    return f"{answer}: median deviation {median:.1e} {unit}, largest {worst:.1e}"


def findings_facts(findings: Iterable[Finding], *, may_accept: bool = True) -> Iterator[tuple[str, str]]:
    """Notes and accepted findings, then refused ones with their cures, and with --accept if the command has that
    option."""
    findings = tuple(findings)
    for finding in findings:
        if finding.level != "refused":
            yield finding.level, f"{finding.name}: {finding.sentence}"
    for finding in findings:
        if finding.level == "refused":
            yield "unfit", f"{finding.name}: {finding.sentence}: {finding.advice if may_accept else finding.cure}"


def beam_heights(heights: FloatArray) -> str:
    low, early, middle, late, high = np.percentile(heights, [0, 5, 50, 95, 100])
    within: BoolArray = np.abs(heights - 1) <= 0.02
    return (
        f"{low:.3f} to {high:.3f} times the nominal height, median {middle:.3f}, 90 % from {early:.3f} to "
        f"{late:.3f}; {within.mean():.0%} of the beams are within 2 % of it"
    )


def optimising(image: OptimisedGaussImage, length_mm: float) -> str:
    """What optimising changed; length_mm: the mean edge of the mesh before."""
    (spread, spread_after), (lean, lean_after) = image.height_spread, image.lean_p95_deg
    median, largest = (move / length_mm for move in image.moves_mm)
    convex = len(image.no_longer_convex)
    lost = f"; {convex} faces are no longer convex" if convex else ""
    return (
        f"spread of beam heights (2.5 to 97.5 %) from {spread:.2g} to {spread_after:.2g}, lean of 95 % of the axes "
        f"from {lean:.0f} to {lean_after:.0f} degrees, by moving vertices by {median:.2g} of the mean edge length in "
        f"the median, {largest:.2g} at most (vertex {image.farthest_vertex}, counted from 0){lost}"
    )


# --- pairs


def pair_fit(mesh: Mesh, gauss_image: Mesh) -> Iterator[tuple[str, str]]:
    """How well a mesh and a Gauss image fit each other, also where a build would refuse them."""
    deviations = parallelity(mesh, gauss_image)
    worst = mesh.combinatorics.edge_name(int(deviations.argmax()))
    yield "parallel", f"to {deviations.max():.1e} of the unit sphere's radius, at {worst}, counted from 0"
    try:
        pair = nearest_parallel_pair(mesh, gauss_image)
        structure = SupportStructure(pair, 1.0)  # no node axis lies in an edge
    except GeometryError:
        return  # a build fails for the same reason, which is reported
    yield "made exact", _pair_moves(*pair.moves_from(mesh, gauss_image))
    yield from _distances(pair)
    yield "reversed", _reversed(pair)
    yield "alignment", _alignment(structure)


def _pair_moves(of_mesh: FloatArray, of_gauss_image: FloatArray) -> str:
    largest = max(of_mesh.max(), of_gauss_image.max())
    if largest == 0:
        return "nothing to do"
    refused = (
        f", more than {GIVEN_PAIR_TOLERANCE:g}, so that a build refuses it" if largest > GIVEN_PAIR_TOLERANCE else ""
    )
    return (
        f"by moving vertices of the mesh by {of_mesh.max():.1e} of its mean edge length at most, of the Gauss image by "
        f"{of_gauss_image.max():.1e} of the unit sphere's radius{refused}"
    )


def _distances(pair: Pair) -> Iterator[tuple[str, str]]:
    """Distances of S from the origin; each kind that is constant gives an exact offset [Pottmann2007, Prop. 2]."""
    for name, offers, distances in (
        ("vertices of S", "a vertex offset", pair.vertex_distances),
        ("edges of S", "an edge offset: beams of one height", pair.edge_distances),
        ("faces of S", "a face offset", pair.face_distances),
    ):
        size = np.abs(distances)
        spread = float(np.ptp(size) / size.mean())
        verdict = f"constant to {spread:.1e}, {offers}" if spread <= EXACT_PROPERTY_TOLERANCE else f"so not {offers}"
        if EXACT_PROPERTY_TOLERANCE < spread <= NEAR_PROPERTY_TOLERANCE:
            verdict = f"constant to {spread:.1e}, nearly {offers}"
        yield name, f"{size.min():.4g} to {size.max():.4g} from the origin, {verdict}"


def _reversed(pair: Pair) -> str:
    mesh = pair.mesh
    return (
        f"{pair.reversed_edges.sum()} of {mesh.n_edges} edges run against those of S; at "
        f"{len(pair.mixed_vertices)} of {mesh.n_vertices} vertices only some of the edges do, as on a saddle: beams "
        "end at two levels there"
    )


def _alignment(structure: SupportStructure) -> str:
    """The misalignment of tops and bottoms of beams of one height at the node axes."""
    found = axis_misalignments(ends_of_all(structure), (0.0, 1.0), structure.mesh.n_vertices)
    return (
        f"misalignment of tops and bottoms of beams at the node axes: median {np.nanmedian(found):.1e} of the beam "
        f"height, largest {np.nanmax(found):.1e}"
    )


def ends_of_all(structure: SupportStructure) -> Ends:
    return beam_ends(structure, np.ones(structure.mesh.n_edges, dtype=bool), DetailingRules())

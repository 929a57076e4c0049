"""What a mesh is fit for, before anything is built from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.detailing.ends import Ends, beam_ends
from fabkit.detailing.nodes import axis_spreads
from fabkit.errors import FabkitError, in_one_sentence
from fabkit.fitness import CRITERIA, Finding, FitnessError, allowed
from fabkit.fitness.parts import mitres
from fabkit.fitness.shape import self_intersection
from fabkit.gauss_image import EXACT as EXACT_OFFSET
from fabkit.gauss_image import TOLERANCE
from fabkit.pipeline import design, judged_image, judged_pair, judged_planar, mesh_in_mm
from fabkit.project import GaussImageRules, Project
from fabkit.rules import DetailingRules
from fabkit.stages import Stages
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.errors import GeometryError
from geometry.files import MeshFile, read_mesh, read_mesh_pair
from geometry.gauss import (
    SupportStructure,
    circularity,
    conicality,
    edge_distances,
    face_distances,
    nearest_parallel_pair,
    offset_deviations,
    vertex_distances,
)
from geometry.mesh import Mesh
from geometry.parallel import edge_factors, parallelity

__all__ = ["UNSIZED", "Inspection", "inspect_mesh", "inspect_pair", "inspect_project"]

EXACT, NEARLY = 1e-6, 1e-2
"""Largest deviation, as a part of the edge length or in radians, up to which a property is said to hold or nearly to
hold: drawing programs write seven digits; a hundredth of an edge is what one sees."""

UNSIZED: dict[str, Any] = {"mean_edge_mm": 1000.0}
"""To what a mesh without size is scaled: what is judged of it then depends on no size."""


@dataclass(frozen=True, eq=False)
class Inspection:
    """A mesh file, near zero, and what follows from it. Lengths are in the unit of the file.

    image: the Gauss image as given, None where it is computed. moved: what making faces planar took, None for nothing.
    planar: the mesh after that; structure: it and its Gauss image; None where that failed. findings: what is unusual,
    told, allowed or refused. trouble: why nothing can be built, a sentence each. is_sized: whether parts were made, or
    only what depends on no size was judged.
    """

    file: MeshFile
    image: Mesh | None
    moved: str | None
    planar: Mesh | None
    structure: SupportStructure | None
    findings: tuple[Finding, ...]
    trouble: tuple[str, ...]
    is_sized: bool

    @property
    def is_unfit(self) -> bool:
        """Whether a build would be refused."""
        return bool(self.trouble) or any(finding.level == "refused" for finding in self.findings)

    def facts(self) -> Iterator[tuple[str, str]]:
        """Name and sentence of each fact, in the order in which one wants to read them."""
        yield from _as_read(self.file)
        if self.image is not None:
            yield from _pair(self.file.mesh, self.image)
        elif self.planar is not None:
            yield "planarised", self.moved or "nothing to do"
            yield from _offsets(self.planar)
        if self.structure is not None:
            yield "beam heights", _heights(self.structure.heights)
        for finding in self.findings:
            if finding.level != "refused":
                yield finding.level, f"{finding.name}: {finding.sentence}"
        for finding in self.findings:
            if finding.level == "refused":
                yield "unfit", f"{finding.name}: {finding.sentence}: {finding.advice}"
        for sentence in self.trouble:
            yield "unfit", sentence
        if not self.is_sized:
            yield (
                "not judged",
                "room for beams and panels, node blocks, lift and sheets, which need sizes: say --unit or --mean-edge, "
                "or inspect a project file",
            )
        yield "verdict", self._verdict()

    def _verdict(self) -> str:
        if self.is_unfit:
            return "unfit: a build would be refused"
        so_far = "" if self.is_sized else ", as far as it depends on no size"
        return f"fit to build{so_far}; {'what is unusual is told above' if self.findings else 'nothing is unusual'}"


def inspect_mesh(path: Path) -> Inspection:
    """Read a mesh and judge all that depends on no size; see `inspect_project`."""
    return inspect_project(Project(mesh=path, **UNSIZED), is_sized=False)


def inspect_pair(mesh: Path, image: Path) -> Inspection:
    """The same of a mesh and its Gauss image, and how the two fit."""
    return inspect_project(Project(mesh=mesh, gauss_image=GaussImageRules(file=image), **UNSIZED), is_sized=False)


def inspect_project(project: Project, *, is_sized: bool = True) -> Inspection:
    """Do all that a build would do, short of writing, and judge it by the same rules; what a build would refuse, and
    what it says where it fails, is part of the answer.

    is_sized: whether the sizes in the project are meant; otherwise only what depends on none is judged. Raises
    GeometryError where a file cannot be read or does not hold a usable mesh, or the faces of the two files differ.
    """
    image = None
    if project.gauss_image.file is None:
        file = read_mesh(project.mesh, flip=project.flip)
    else:
        file, image = read_mesh_pair(project.mesh, project.gauss_image.file)
    file = file.near_zero()
    everything = tuple(name for name, reason in CRITERIA.items() if not reason)
    tried = _tried(project.model_copy(update={"allow": everything}), is_sized=is_sized)
    return Inspection(
        file,
        image,
        _moves(tried.given, tried.planar) if tried.given and tried.planar else None,
        tried.planar,
        tried.structure,
        allowed(tried.findings, project.allow),
        tried.trouble,
        is_sized,
    )


# --- what a build comes to


@dataclass(frozen=True, eq=False)
class _Tried:
    """How far a build came. given, planar: the mesh as read and made planar, in mm."""

    given: Mesh | None = None
    planar: Mesh | None = None
    structure: SupportStructure | None = None
    findings: tuple[Finding, ...] = ()
    trouble: tuple[str, ...] = ()


def _tried(project: Project, *, is_sized: bool) -> _Tried:
    """What comes of a build that accepts whatever may be accepted; where it fails, of its first stages."""
    shaped = _shaped(project)
    if shaped.structure is None:
        return shaped
    if not is_sized:
        slanted = _mitres(shaped.structure, project)
        return replace(shaped, findings=(*shaped.findings, slanted)) if slanted else shaped
    try:
        return replace(shaped, findings=design(project).summary.fitness)
    except FitnessError as error:
        return replace(shaped, findings=error.findings)
    except (FabkitError, GeometryError) as error:
        return replace(shaped, trouble=(in_one_sentence(error),))


def _shaped(project: Project) -> _Tried:
    """The stages up to the Gauss image."""
    tried = _Tried()
    try:
        mesh, rounding_mm, given = mesh_in_mm(project)
        tried = replace(tried, given=mesh)
        if given is not None:
            structure, _, found = judged_pair(project, mesh, given, Stages())
            return _Tried(mesh, structure.mesh, structure, found)
        planar, found = judged_planar(project, mesh, Stages())
        tried = _Tried(mesh, planar, None, found)
        structure, _, found = judged_image(project, mesh, planar, rounding_mm, found, Stages())
    except FitnessError as error:
        return replace(tried, findings=error.findings)
    except GeometryError as error:
        crossing = self_intersection(tried.given) if tried.given and not tried.planar else None
        findings = (*tried.findings, crossing) if crossing else tried.findings
        return replace(tried, findings=findings, trouble=(in_one_sentence(error),))
    return replace(tried, structure=structure, findings=found)


def _mitres(structure: SupportStructure, project: Project) -> Finding | None:
    """Of beams that have no marks yet: named by their edges."""
    edges = range(structure.mesh.n_edges)
    cuts = np.degrees(_ends(structure).inclination.reshape(-1, 2))
    return mitres(cuts, [f"edge {edge}" for edge in edges], edges, project.fitness)


def _ends(structure: SupportStructure) -> Ends:
    return beam_ends(structure, np.ones(structure.mesh.n_edges, dtype=bool), DetailingRules())


# --- facts


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


def _moves(before: Mesh, after: Mesh) -> str | None:
    moves = np.linalg.norm(after.vertices - before.vertices, axis=1) / before.mean_edge_length
    if not moves.any():
        return None
    return (
        f"to {after.planarity.max():.1e} by moving vertices by {moves.mean():.2g} of the edge length in the mean, "
        f"{np.percentile(moves, 95):.2g} at 95 %, {moves.max():.2g} at most (vertex {moves.argmax()}, counted from 0)"
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
    answer = "yes" if deviation <= EXACT_OFFSET else "nearly"
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


def _pair(mesh: Mesh, image: Mesh) -> Iterator[tuple[str, str]]:
    """How a mesh and a Gauss image fit, whatever a build would accept."""
    sideways = parallelity(mesh, image)
    worst = mesh.combinatorics.edge_name(int(sideways.argmax()))
    yield "parallel", f"to {sideways.max():.1e} of the unit sphere's radius, at {worst}, counted from 0"
    try:
        exact = nearest_parallel_pair(mesh, image)
        structure = SupportStructure(*exact, 1.0)  # no node axis lies in an edge
    except GeometryError:
        return  # a build fails by the same reason, which is told
    yield "made exact", _pair_moves((mesh, image), exact)
    yield from _distances(*exact)
    yield "reversed", _reversed(*exact)
    yield "alignment", _alignment(structure)


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


def _alignment(structure: SupportStructure) -> str:
    """How far tops and bottoms of beams of one height miss each other on the node axes."""
    spreads = axis_spreads(_ends(structure), (0.0, 1.0), structure.mesh.n_vertices)
    return (
        f"tops and bottoms of beams miss each other on the node axes by {np.nanmedian(spreads):.1e} of the beam height "
        f"in the median, {np.nanmax(spreads):.1e} at most"
    )

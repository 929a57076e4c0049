"""What a mesh is fit for, before anything is built from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.commands.facts import (
    as_read,
    beam_heights,
    ends_of_all,
    findings_facts,
    moves,
    offset_kinds,
    optimising,
    pair_fit,
)
from fabkit.errors import FabkitError, error_sentence
from fabkit.fitness import CRITERIA, Finding, FitnessError, with_accepted
from fabkit.fitness.parts import mitres
from fabkit.fitness.shape import self_intersection
from fabkit.gauss_image import GaussImageRules
from fabkit.pipeline import design, given_in_mm, mesh_file
from fabkit.production import OptimisedGaussImage
from fabkit.project import Project
from fabkit.stages import Stages
from fabkit.structure import checked_image, checked_pair, checked_planar
from geometry.errors import GeometryError
from geometry.files import MeshFile, read_mesh_pair
from geometry.gauss import SupportStructure
from geometry.mesh import Mesh

__all__ = ["UNSIZED", "Inspection", "inspect_mesh", "inspect_pair", "inspect_project"]

UNSIZED: dict[str, Any] = {"mean_edge_mm": 1000.0}
"""Settings for a mesh without a size: only properties that are independent of size are then judged."""


@dataclass(frozen=True, eq=False)
class Inspection:
    """A mesh file, near zero, and what follows from it. Lengths are in the unit of the file.

    gauss_image: as given, None where it is computed. moved: what making faces planar took, None for nothing. planar:
    the mesh after that; structure: it and its Gauss image; None where that failed. optimised: what optimising both
    changed, where the project requests it. findings: unusual properties, noted, accepted or refused. trouble: sentences
    on why nothing can be built. is_sized: whether parts were made; if not, only properties that are independent of size
    were judged.
    """

    file: MeshFile
    gauss_image: Mesh | None
    moved: str | None
    planar: Mesh | None
    structure: SupportStructure | None
    optimised: OptimisedGaussImage | None
    findings: tuple[Finding, ...]
    trouble: tuple[str, ...]
    is_sized: bool

    @property
    def is_unfit(self) -> bool:
        """Whether a build would be refused."""
        return bool(self.trouble) or any(finding.level == "refused" for finding in self.findings)

    def facts(self) -> Iterator[tuple[str, str]]:
        """Name and sentence of each fact, in the order in which they are printed."""
        yield from as_read(self.file)
        if self.gauss_image is not None:
            yield from pair_fit(self.file.mesh, self.gauss_image)
        elif self.planar is not None:
            yield "planarised", self.moved or "nothing to do"
            yield from offset_kinds(self.planar)
        if self.optimised is not None and self.planar is not None:
            yield "optimised", optimising(self.optimised, self.planar.mean_edge_length)
        if self.structure is not None:
            yield "beam heights", beam_heights(self.structure.heights)
        yield from findings_facts(self.findings)
        for sentence in self.trouble:
            yield "unfit", sentence
        if not self.is_sized:
            yield (
                "not judged",
                "room for beams and panels, node blocks and sheets, which need sizes: give --unit or --mean-edge,"
                " or inspect a project file",
            )
        yield "verdict", self._verdict()

    def _verdict(self) -> str:
        if self.is_unfit:
            return "unfit: a build would be refused"
        so_far = "" if self.is_sized else ", as far as can be judged without sizes"
        remark = "unusual properties are listed above" if self.findings else "nothing is unusual"
        return f"fit to build{so_far}; {remark}"


def inspect_mesh(path: Path) -> Inspection:
    """Read a mesh and judge the properties that are independent of size; see `inspect_project`."""
    return inspect_project(Project(mesh=path, **UNSIZED), is_sized=False)


def inspect_pair(mesh: Path, gauss_image: Path) -> Inspection:
    """As `inspect_mesh`, of a mesh and its Gauss image, and how well the two fit."""
    return inspect_project(Project(mesh=mesh, gauss_image=GaussImageRules(file=gauss_image), **UNSIZED), is_sized=False)


def inspect_project(project: Project, *, is_sized: bool = True) -> Inspection:
    """Do the steps of a build except for writing, and judge them by the same rules. Findings that a build would refuse,
    and an error at which it would stop, are part of the result.

    is_sized: whether the sizes in the project are real; if not, only properties that are independent of size are
    judged. Raises GeometryError where a file cannot be read or does not hold a usable mesh, or the faces of the two
    files differ.
    """
    gauss_image = None
    if project.gauss_image.file is None:
        file = mesh_file(project)
    else:
        file, gauss_image = read_mesh_pair(project.mesh_path, project.gauss_image.file)
        file = file.near_zero()
    everything = tuple(name for name, reason in CRITERIA.items() if not reason)
    tried = _tried(project.model_copy(update={"accept": everything}), is_sized=is_sized)
    return Inspection(
        file,
        gauss_image,
        moves(tried.given, tried.planar) if tried.given and tried.planar else None,
        tried.planar,
        tried.structure,
        tried.optimised,
        with_accepted(tried.findings, project.accept),
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
    optimised: OptimisedGaussImage | None = None
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
        return replace(shaped, trouble=(error_sentence(error),))


def _shaped(project: Project) -> _Tried:
    """The stages up to the Gauss image."""
    tried = _Tried()
    try:
        given = given_in_mm(project)
        mesh, surface = given.mesh, given.surface
        tried = replace(tried, given=mesh)
        if given.pair is not None:
            structure, _, found = checked_pair(project, mesh, given.pair, Stages())
            return _Tried(mesh, structure.mesh, structure, findings=found)
        planar, found = checked_planar(project, mesh, surface, Stages())
        tried = _Tried(mesh, planar, findings=found)
        structure, image, found = checked_image(project, mesh, planar, given.rounding_mm, surface, found, Stages())
    except FitnessError as error:
        return replace(tried, findings=error.findings)
    except GeometryError as error:
        crossing = self_intersection(tried.given) if tried.given and not tried.planar else None
        findings = (*tried.findings, crossing) if crossing else tried.findings
        return replace(tried, findings=findings, trouble=(error_sentence(error),))
    optimised = image if isinstance(image, OptimisedGaussImage) else None
    return replace(tried, structure=structure, optimised=optimised, findings=found)


def _mitres(structure: SupportStructure, project: Project) -> Finding | None:
    """Of beams that have no marks yet: named by their edges."""
    edges = range(structure.mesh.n_edges)
    cuts = np.degrees(ends_of_all(structure).inclination.reshape(-1, 2))
    return mitres(cuts, [f"edge {edge}" for edge in edges], edges, project.fitness)

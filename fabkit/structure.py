"""From a mesh to a support structure that can be built: the faces made planar, a Gauss image, and the findings."""

from __future__ import annotations

from typing import Any

import numpy as np

from fabkit.fitness import Finding, FitnessError, check_fit_to_build, with_accepted
from fabkit.fitness.shape import CROSSINGS, crossings, folded, of_gauss_image, of_planar_mesh
from fabkit.gauss_image import GivenPair
from fabkit.optimisation import optimised
from fabkit.production import ExactGaussImage, GaussImageSource, GivenGaussImage
from fabkit.project import Project
from fabkit.stages import Stages
from geometry.errors import FoldedError, GeometryError
from geometry.exact_offsets import exact_or_approximate_pair
from geometry.gauss import SupportStructure, nearest_parallel_pair
from geometry.mesh import Mesh
from geometry.meshing import Guides, planarise
from geometry.surface import Surface

__all__ = ["checked_image", "checked_pair", "checked_planar", "checked_structure", "made_planar", "with_checked"]


def checked_structure(
    project: Project,
    mesh: Mesh,
    rounding_mm: float,
    given: GivenPair | None,
    surface: Surface | None,
    stages: Stages,
) -> tuple[SupportStructure, GaussImageSource | None, tuple[Finding, ...]]:
    """The support structure of the planar mesh and its Gauss image; the record of an exact, given or optimised Gauss
    image, None for another one; the findings so far.

    surface: in mm, on which the mesh was laid, None if it was not.
    """
    if given is not None:
        return checked_pair(project, mesh, given, stages)
    planar, found = checked_planar(project, mesh, surface, stages)
    return checked_image(project, mesh, planar, rounding_mm, surface, found, stages)


def checked_planar(
    project: Project, mesh: Mesh, surface: Surface | None, stages: Stages
) -> tuple[Mesh, tuple[Finding, ...]]:
    """The mesh with planar faces, and the findings about it. Raises FitnessError if a finding is refused."""
    with stages("Planarise"):
        weights = project.planarise.model_dump(exclude_none=True)
        if surface is not None:
            weights = {"surface": surface, "keep_boundary": True, **weights}
        planar = made_planar(mesh, weights)
        return planar, with_checked(project, (), of_planar_mesh(mesh, planar, project.fitness))


def checked_image(
    project: Project,
    mesh: Mesh,
    planar: Mesh,
    rounding_mm: float,
    surface: Surface | None,
    before: tuple[Finding, ...],
    stages: Stages,
) -> tuple[SupportStructure, GaussImageSource | None, tuple[Finding, ...]]:
    """The structure with a computed Gauss image, and the findings so far; where the project asks for it, both are
    optimised.

    mesh: before it was made planar; rounding_mm: of its coordinates as read; surface: on which it was laid, None if it
    was not; before: the findings about `planar`. Raises FitnessError if a finding is refused.
    """
    with stages("Gauss image"):
        moved = float(np.linalg.norm(planar.vertices - mesh.vertices, axis=1).max())
        try:
            pair, offset = exact_or_approximate_pair(
                planar, moved=moved, rounding=rounding_mm, **project.gauss_image.weights
            )
        except GeometryError as error:
            if planar.combinatorics.face_sizes.max() > 3:
                raise
            raise GeometryError(f"{error.message}, or here by --faces or --edge-length") from None
        image: GaussImageSource | None = None if offset is None else ExactGaussImage(offset)
    found: tuple[Finding, ...] = ()
    if project.optimise is not None:
        with stages("Optimise"):
            pair, image = optimised(pair, project.optimise, offset=offset, surface=surface)
            found = crossings(pair.mesh)
            before = tuple(finding for finding in before if finding.name not in CROSSINGS)  # of the mesh that was
    structure = SupportStructure(pair, project.beams.profile.height_mm)
    return structure, image, with_checked(project, before, (*found, *of_gauss_image(structure, project.fitness)))


def checked_pair(
    project: Project, mesh: Mesh, given: GivenPair, stages: Stages
) -> tuple[SupportStructure, GivenGaussImage, tuple[Finding, ...]]:
    """The structure with a given Gauss image. Raises FitnessError if a finding is refused."""
    with stages("Planar and parallel"):
        pair = nearest_parallel_pair(mesh, given.gauss_image, tolerance=project.gauss_image.tolerance)
        _, moves = pair.moves_from(mesh, given.gauss_image)
        image = GivenGaussImage(given.name, given.sha256, float(moves.max()), float(moves.mean()))
        found = with_checked(project, (), of_planar_mesh(mesh, pair.mesh, project.fitness))
        structure = SupportStructure(pair, project.beams.profile.height_mm)
        return structure, image, with_checked(project, found, of_gauss_image(structure, project.fitness))


def made_planar(mesh: Mesh, weights: dict[str, Any]) -> Mesh:
    """The mesh with planar faces. weights: fields of `Guides`. Raises FitnessError where it folds over."""
    try:
        return planarise(mesh, Guides(**weights)).mesh
    except FoldedError as error:
        raise FitnessError([folded(error, on_surface="surface" in weights)]) from None


def with_checked(project: Project, before: tuple[Finding, ...], found: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """All findings so far. Raises FitnessError if one is refused and not accepted."""
    findings = (*before, *with_accepted(found, project.accept))
    check_fit_to_build(findings)
    return findings

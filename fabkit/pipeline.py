"""The pipeline: from a mesh file to a folder with everything that a workshop needs."""

from __future__ import annotations

from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path

import numpy as np

from fabkit.built import Built, manifest_of, summary_of
from fabkit.detailing import Detailed, detail
from fabkit.errors import NestingError, ProjectError
from fabkit.fitness import Finding, FitnessError, check_fit_to_build, with_accepted
from fabkit.fitness.parts import block_heights, mitres_of, sheets, underside
from fabkit.fitness.shape import folded, of_gauss_image, of_planar_mesh
from fabkit.formats import whole_folder, write_documents, write_manifest
from fabkit.gauss_image import GivenPair, read_given_pair
from fabkit.kinds import BEAM, NODE, PANEL
from fabkit.parts import Assembly, LeftOut
from fabkit.production import (
    ExactGaussImage,
    GivenGaussImage,
    Nest,
    Sheet,
    nest_panels,
    share_equal_parts,
    too_large,
)
from fabkit.project import Project
from fabkit.stages import Listener, Stages
from fabkit.units import MM_PER_UNIT
from geometry.errors import FoldedError
from geometry.files import MeshFile, check_faces, read_mesh
from geometry.gauss import SupportStructure, exact_or_approximate_pair, nearest_parallel_pair
from geometry.mesh import Mesh
from geometry.meshing import Guides, planarise

__all__ = [
    "Built",
    "build",
    "checked_image",
    "checked_pair",
    "checked_planar",
    "design",
    "mesh_file",
    "mesh_in_mm",
    "write_built",
]

COPY_ROUNDING = 4.0
"""Difference that rounding of file coordinates makes between equal parts, in the spacing of doubles there. It is 2 at
map coordinates of symmetric meshes, where each coordinate of two parts is off by half a spacing."""


def build(project: Project, *, force: bool = False, listener: Listener | None = None) -> Built:
    """Design the structure and write all documents to the folder `project.out`, which appears whole or not at all.

    An earlier result there is replaced only with `force`. Raises GeometryError or FabkitError, in one sentence,
    where something in the mesh, the project or the output folder is not as it must be.

    >>> from fabkit import Project, build
    >>> from geometry.mesh.shapes import dome
    >>> built = build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out="roof"))
    >>> sorted(path.name for path in Path("roof").iterdir() if path.suffix in (".csv", ".html", ".step"))
    ['beams.csv', 'model.step', 'nodes.csv', 'panels.csv', 'report.html']
    """
    stages = Stages(listener)
    with _output_folder(project, force) as folder:
        built = design(project, stages)
        _write(folder, built, stages)
    return built


def write_built(built: Built, *, force: bool = False, listener: Listener | None = None) -> None:
    """Write what was designed to the folder `built.project.out`, as `build` does.

    >>> from fabkit import Project, design, write_built
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, out="dome"))
    >>> write_built(built)
    >>> sorted(path.name for path in Path("dome/sheets").iterdir())
    ['sheet-001.dxf', 'sheet-002.dxf', 'sheet-003.dxf']
    """
    with _output_folder(built.project, force) as folder:
        _write(folder, built, Stages(listener))


def _output_folder(project: Project, force: bool) -> AbstractContextManager[Path]:
    if project.out is None:
        raise ProjectError("there is no output folder: say -o FOLDER, or out = 'FOLDER' in the project file")
    inputs = [path for path in (project.mesh, project.gauss_image.file) if isinstance(path, Path)]
    return whole_folder(project.out, force=force, inputs=inputs)


def _write(folder: Path, built: Built, stages: Stages) -> None:
    write_documents(folder, built.structure.pair, built.assembly, built.nest, built.summary, stages)
    write_manifest(folder, manifest_of(built), built.facts.all)


def design(project: Project, stages: Stages | None = None) -> Built:
    """Design the structure without writing files: planar mesh, Gauss image, parts, marks and nest.

    Raises GeometryError or FabkitError as `build` does.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> built.assembly["beams"].mark_names, round(built.assembly["beams"][0].details.long_point_mm)
    (('B001', 'B002', 'B003', 'B004', 'B005'), 2332)
    """
    stages = stages or Stages()
    with stages("Read"):
        file, given = _read(project)
        scale = _scale(project, file.mesh)
        mesh = file.mesh * scale
    structure, image, found = _structure(project, mesh, file.rounding * scale, given, stages)
    with stages("Detail and check fit"):
        detailed = detail(structure, project.rules, name=project.title, skip_unbuildable=project.skip_unbuildable)
    with stages("Marks"):
        within = max(project.equal_within_mm, COPY_ROUNDING * file.rounding * scale)
        assembly = share_equal_parts(detailed.assembly, within_mm=within)
        assembly = replace(assembly, origin_mm=file.origin * scale)
    with stages("Nest"):
        reasons = too_large(assembly.of(PANEL), _sheet(project), border_mm=project.sheets.border_mm)
        found = _checked(project, found, _unusual_parts(project, detailed, assembly, reasons))
        if project.skip_unbuildable and project.nesting.mode != "off":
            assembly = _without_too_large(assembly, reasons)
        nest = _nest(project, assembly, stages)
    summary = replace(
        summary_of(project, file, scale, structure, detailed), gauss_image=image, equal_within_mm=within, fitness=found
    )
    return Built(project, structure, assembly, nest, summary, stages.seconds, file.sha256)


def _read(project: Project) -> tuple[MeshFile, GivenPair | None]:
    """The mesh near zero, and its Gauss image where that is given."""
    rules = project.gauss_image
    if rules.file is None:
        return mesh_file(project), None
    pair = read_given_pair(project.mesh_path, rules.file, flip=project.flip, tolerance=rules.tolerance)
    return pair.file, pair


def mesh_file(project: Project) -> MeshFile:
    """The mesh of a project without its Gauss image, near zero; one in memory is checked as a file is."""
    if not isinstance(project.mesh, Mesh):
        return read_mesh(project.mesh, flip=project.flip).near_zero()
    check_faces(project.mesh)
    mesh = project.mesh.reversed() if project.flip else project.mesh
    return MeshFile(Path(project.source), mesh, ()).near_zero()


def mesh_in_mm(project: Project) -> tuple[Mesh, float, GivenPair | None]:
    """The mesh of a project, how coarse its coordinates were, in mm, and its Gauss image where that is given."""
    file, given = _read(project)
    scale = _scale(project, file.mesh)
    return file.mesh * scale, file.rounding * scale, given


def _structure(
    project: Project, mesh: Mesh, rounding_mm: float, given: GivenPair | None, stages: Stages
) -> tuple[SupportStructure, GivenGaussImage | ExactGaussImage | None, tuple[Finding, ...]]:
    """The structure between the planar mesh and its Gauss image; where that image is from; the findings so far."""
    if given is not None:
        return checked_pair(project, mesh, given, stages)
    planar, found = checked_planar(project, mesh, stages)
    return checked_image(project, mesh, planar, rounding_mm, found, stages)


def checked_planar(project: Project, mesh: Mesh, stages: Stages) -> tuple[Mesh, tuple[Finding, ...]]:
    """The mesh with planar faces, and the findings about it. Raises FitnessError if a finding is refused."""
    with stages("Planarise"):
        planar = _planar(project, mesh)
        return planar, _checked(project, (), of_planar_mesh(mesh, planar, project.fitness))


def checked_image(
    project: Project, mesh: Mesh, planar: Mesh, rounding_mm: float, before: tuple[Finding, ...], stages: Stages
) -> tuple[SupportStructure, ExactGaussImage | None, tuple[Finding, ...]]:
    """The structure with a computed Gauss image, and the findings so far.

    mesh: before it was made planar; rounding_mm: of its coordinates as read; before: the findings about `planar`.
    Raises FitnessError if a finding is refused.
    """
    with stages("Gauss image"):
        moved = float(np.linalg.norm(planar.vertices - mesh.vertices, axis=1).max())
        pair, offset = exact_or_approximate_pair(
            planar, moved=moved, rounding=rounding_mm, **project.gauss_image.weights
        )
        structure = SupportStructure(pair, project.beams.height_mm)
        image = None if offset is None else ExactGaussImage(offset)
        return structure, image, _checked(project, before, of_gauss_image(structure, project.fitness))


def checked_pair(
    project: Project, mesh: Mesh, given: GivenPair, stages: Stages
) -> tuple[SupportStructure, GivenGaussImage, tuple[Finding, ...]]:
    """The structure with a given Gauss image. Raises FitnessError if a finding is refused."""
    with stages("Planar and parallel"):
        pair = nearest_parallel_pair(mesh, given.gauss_image, tolerance=project.gauss_image.tolerance)
        _, moves = pair.moves_from(mesh, given.gauss_image)
        image = GivenGaussImage(given.name, given.sha256, float(moves.max()), float(moves.mean()))
        found = _checked(project, (), of_planar_mesh(mesh, pair.mesh, project.fitness))
        structure = SupportStructure(pair, project.beams.height_mm)
        return structure, image, _checked(project, found, of_gauss_image(structure, project.fitness))


def _planar(project: Project, mesh: Mesh) -> Mesh:
    try:
        return planarise(mesh, Guides(**project.planarise.model_dump(exclude_none=True))).mesh
    except FoldedError as error:
        raise FitnessError([folded(error)]) from None


def _checked(project: Project, before: tuple[Finding, ...], found: tuple[Finding, ...]) -> tuple[Finding, ...]:
    """All findings so far. Raises FitnessError if one is refused and not accepted."""
    findings = (*before, *with_accepted(found, project.accept))
    check_fit_to_build(findings)
    return findings


def _unusual_parts(
    project: Project, detailed: Detailed, assembly: Assembly, reasons: dict[int, str]
) -> tuple[Finding, ...]:
    rules, height = project.fitness, project.beams.height_mm
    nodes, panels = assembly.of(NODE), assembly.of(PANEL)
    marks = dict(zip(nodes.elements.tolist(), nodes.marks, strict=True))
    faces = {int(panels.elements[k]): reason for k, reason in reasons.items()}
    of_panels = dict(zip(panels.elements.tolist(), panels.marks, strict=True))
    is_refused = project.nesting.mode != "off" and not project.skip_unbuildable
    found = (
        mitres_of(assembly.of(BEAM), rules),
        block_heights(nodes, height, rules),
        underside(detailed.needed_mm, marks, height, rules) if project.panels.underside_mm is None else None,
        sheets(faces, of_panels, "refused" if is_refused else "note"),
    )
    return tuple(finding for finding in found if finding)


def _scale(project: Project, mesh: Mesh) -> float:
    """Millimetres a unit of the mesh file."""
    if project.unit is not None:
        return MM_PER_UNIT[project.unit]
    assert project.mean_edge_mm is not None  # a project has one of the two
    return project.mean_edge_mm / mesh.mean_edge_length


def _sheet(project: Project) -> Sheet:
    return Sheet(project.sheets.length_mm, project.sheets.width_mm)


def _without_too_large(assembly: Assembly, reasons: dict[int, str]) -> Assembly:
    """Without the panels that fit on no sheet, for these reasons by index."""
    panels = assembly.of(PANEL)
    if len(reasons) == len(panels) > 0:
        raise NestingError(
            f"with what fits on no sheet left out, no panel remains of {len(reasons)}: {next(iter(reasons.values()))}; "
            "take larger sheets (--sheet), or turn nesting off (--nest off)"
        )
    if not reasons:
        return assembly
    left_out = tuple(LeftOut(PANEL.name, int(panels.elements[k]), reason) for k, reason in reasons.items())
    fitting = np.ones(len(panels), dtype=bool)
    fitting[list(reasons)] = False
    return replace(assembly.with_group(panels.take(fitting)), left_out=assembly.left_out + left_out)


def _nest(project: Project, assembly: Assembly, stages: Stages) -> Nest | None:
    panels = assembly.of(PANEL)
    if project.nesting.mode == "off" or not len(panels):
        return None
    rules = project.sheets
    return nest_panels(
        panels,
        _sheet(project),
        gap_mm=rules.gap_mm,
        border_mm=rules.border_mm,
        mode=project.nesting.mode,
        seconds=project.nesting.seconds,
        progress=lambda share, _: stages.progress("Nest", share),
    )

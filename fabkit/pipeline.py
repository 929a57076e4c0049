"""The pipeline: from a mesh file to a folder with all documents for the workshop."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fabkit.built import Built, manifest_of, summary_of
from fabkit.detailing import Detailed, detail
from fabkit.detailing.second_layer import rules_of_second_layer
from fabkit.detailing.shapes.dots import stamped
from fabkit.errors import NestingError, ProjectError
from fabkit.fitness import Finding
from fabkit.fitness.panels import corners, panel_masses, short_edges
from fabkit.fitness.parts import block_heights, going_in, mitres_of, props, sheets, slots, uncovered, underside
from fabkit.formats import EXACT_SUFFIXES, whole_folder, write_documents, write_manifest
from fabkit.formats.finished import kept_marks
from fabkit.gauss_image import GivenPair, read_given_pair
from fabkit.kinds import BEAM, NODE, PANEL
from fabkit.layer_meshes import parallel_mesh
from fabkit.parts import Assembly, LeftOut
from fabkit.production import (
    Nest,
    Sheet,
    element_ranks,
    erection_order,
    nest_panels,
    share_equal_parts,
    too_large,
)
from fabkit.project import Project
from fabkit.rules import DetailingRules
from fabkit.stages import Listener, Stages
from fabkit.structure import checked_structure, with_checked
from fabkit.surface import LaidSurface, lay_on_surface, read_exact_file
from fabkit.units import MM_PER_UNIT
from geometry.arrays import FloatArray
from geometry.errors import described
from geometry.files import MeshFile, check_faces, read_mesh
from geometry.mesh import Mesh
from geometry.surface import Surface

__all__ = [
    "Built",
    "build",
    "design",
    "given_in_mm",
    "mesh_file",
    "write_built",
]

COPY_ROUNDING = 4.0
"""Largest difference of equal parts that is put down to rounding, over the spacing of double numbers at the coordinates
in the file. For symmetric meshes at map coordinates it is 2: each coordinate of two parts is off by half a spacing."""


def build(project: Project, *, force: bool = False, listener: Listener | None = None) -> Built:
    """Design the structure and write all documents to the folder `project.out`, which appears complete or not at all.

    An earlier result there is replaced only with `force`. Raises GeometryError or FabkitError, with one sentence, if
    the mesh, the project or the output folder is invalid, or a part cannot be built.

    >>> from fabkit import Project, build
    >>> from geometry.mesh.shapes import dome
    >>> built = build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out="roof"))
    >>> sorted(path.name for path in Path("roof").iterdir() if path.suffix in (".html", ".step", ".xlsx"))
    ['cutlist.xlsx', 'model.step', 'report.html']
    """
    stages = Stages(listener)
    with _output_folder(project, force) as folder:
        built = design(project, stages)
        _write(folder, built, stages)
    return built


def write_built(built: Built, *, force: bool = False, listener: Listener | None = None) -> None:
    """Write the documents of a design to the folder `built.project.out`, as `build` does.

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
    _check_project(project)
    if project.out is None:
        raise ProjectError("there is no output folder: give -o FOLDER, or out = 'FOLDER' in the project file")
    keep = project.marks.keep
    if keep is not None and Path(os.path.realpath(keep)) in Path(os.path.realpath(project.out)).parents:
        raise ProjectError(
            f"{project.out} lies in {keep}, the folder whose marks are kept, which would no longer be as it was "
            "written: choose another folder"
        )
    strokes = None if project.surface is None else project.surface.strokes
    files = (project.mesh, project.gauss_image.file, strokes, *(layer.parallel for layer in project.layers))
    inputs = [path for path in files if isinstance(path, Path)]
    return whole_folder(project.out, force=force, inputs=inputs)


def _write(folder: Path, built: Built, stages: Stages) -> None:
    rules = built.project.document_rules
    write_documents(folder, built.structure.pair, built.assembly, built.nest, built.summary, stages, rules)
    write_manifest(folder, manifest_of(built), built.facts.all)


def design(project: Project, stages: Stages | None = None) -> Built:
    """Design the structure without writing files: planar mesh, Gauss image, parts, marks and nest.

    Raises GeometryError or FabkitError as `build` does.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> built.assembly["beams"].mark_names, round(built.assembly["beams"][0].details.long_point_mm)
    (('B001', 'B002', 'B003', 'B004', 'B005'), 2288)
    """
    _check_project(project)
    stages = stages or Stages()
    kept = {} if project.marks.keep is None else kept_marks(project.marks.keep)
    given = _given(project, stages)
    structure, image, found = checked_structure(
        project, given.mesh, given.rounding_mm, given.pair, given.surface, stages
    )
    file, laid, scale = given.file, given.laid, given.scale
    with stages("Detail and check fit"):
        detailed = detail(
            structure,
            _rules_near_zero(project, file.origin * scale),
            name=project.title,
            skip_unbuildable=project.skip_unbuildable,
            meshes=_layer_meshes(project, given, structure.mesh),
        )
    with stages("Marks"):
        within = max(project.equal_within_mm, COPY_ROUNDING * file.rounding * scale)
        nominal = replace(detailed.assembly, origin_mm=file.origin * scale)
        ranks = element_ranks(structure.mesh, project.marks.order)
        assembly = stamped(share_equal_parts(nominal, within_mm=within, rules=project.marks, ranks=ranks, kept=kept))
    with stages("Nest"):
        reasons = too_large(
            assembly.of(PANEL),
            _sheet_sizes(project),
            border_mm=project.sheets.border_mm,
            rotation=project.sheets.rotation,
        )
        found = with_checked(project, found, _unusual_parts(project, detailed, assembly, reasons))
        if project.skip_unbuildable and project.nesting.mode != "off":
            assembly = _without_too_large(assembly, reasons)
        nest = _nest(project, assembly, stages)
    summary = replace(
        summary_of(project, file, laid, scale, structure, detailed),
        gauss_image=image,
        equal_within_mm=within,
        earlier_marks=kept,
        site=None if project.site is None else project.site.frame,
        fitness=found,
    )
    return Built(project, structure, assembly, nominal, nest, summary, stages.seconds, file.sha256)


def _layer_meshes(project: Project, given: GivenInMm, mesh: Mesh) -> dict[int, Mesh]:
    """The meshes of layers that have their own, parallel to M in mm, by the numbers of the layers."""
    path = None if isinstance(project.mesh, Mesh) else project.mesh
    return {
        number: parallel_mesh(number, layer.parallel, path, given.file, mesh, given.scale)
        for number, layer in enumerate(project.layers)
        if layer.parallel is not None
    }


def _check_project(given: object) -> None:
    if not isinstance(given, Project):
        raise ProjectError(
            f"a Project is needed, not {described(given)}: write Project(mesh='roof.obj', unit='m', out='roof'), or "
            "load_project(path, {}) for a project file"
        )


def _read(project: Project) -> tuple[MeshFile, GivenPair | None]:
    """The mesh near zero, and its Gauss image if one is given."""
    rules = project.gauss_image
    if rules.file is None:
        return mesh_file(project), None
    pair = read_given_pair(project.mesh_path, rules.file, flip=project.flip, tolerance=rules.tolerance)
    return pair.file, pair


def mesh_file(project: Project) -> MeshFile:
    """The mesh of a project, near zero, without its Gauss image; a mesh in memory is checked like a file."""
    if isinstance(project.mesh, Path) and project.mesh.suffix.lower() in EXACT_SUFFIXES:
        return read_exact_file(project.mesh, project.surface, flip=project.flip).near_zero()
    if not isinstance(project.mesh, Mesh):
        return read_mesh(project.mesh, flip=project.flip).near_zero()
    check_faces(project.mesh)
    mesh = project.mesh.reversed() if project.flip else project.mesh
    return MeshFile(Path(project.source), mesh, ()).near_zero()


def _laid(project: Project, file: MeshFile, stages: Stages) -> tuple[MeshFile, LaidSurface | None]:
    """The file, with a mesh laid on its surface if the project requests it."""
    if project.surface is None:
        return file, None
    mm = None if project.unit is None else MM_PER_UNIT[project.unit]
    with stages("Lay mesh"):
        return lay_on_surface(file, project.surface, mm, lambda share: stages.progress("Lay mesh", share))


@dataclass(frozen=True, eq=False)
class GivenInMm:
    """What a project gives, with a mesh laid on its surface if it asks for that.

    file: near zero, in its unit; scale: mm in that unit. mesh: in mm, with coordinates rounded to rounding_mm; pair:
    with its Gauss image, None if none is given; laid, surface: None if the mesh is not laid on a surface, which is in
    mm.
    """

    file: MeshFile
    scale: float
    mesh: Mesh
    rounding_mm: float
    pair: GivenPair | None
    laid: LaidSurface | None
    surface: Surface | None


def given_in_mm(project: Project) -> GivenInMm:
    """The mesh of a project and what belongs to it. Raises as `design` does."""
    return _given(project, Stages())


def _given(project: Project, stages: Stages) -> GivenInMm:
    with stages("Read"):
        file, pair = _read(project)
    file, laid = _laid(project, file, stages)
    scale = _scale(project, file.mesh)
    surface = None if laid is None else laid.scaled_surface(scale)
    return GivenInMm(file, scale, file.mesh * scale, file.rounding * scale, pair, laid, surface)


def _unusual_parts(
    project: Project, detailed: Detailed, assembly: Assembly, reasons: dict[int, str]
) -> tuple[Finding, ...]:
    rules, height = project.fitness, project.beams.profile.height_mm
    nodes, panels = assembly.of(NODE), assembly.of(PANEL)
    marks = dict(zip(nodes.elements.tolist(), nodes.marks, strict=True))
    is_refused = project.nesting.mode != "off" and not project.skip_unbuildable
    is_raised_by_blocks = any(layer.is_at_lift for layer in project.layers) and project.nodes.top == "enclosing"
    found = (
        *_unusual_frame(project, assembly),
        underside(detailed.needed_mm, marks, height, rules) if is_raised_by_blocks else None,
        corners(panels, rules),
        short_edges(panels, rules),
        panel_masses(panels, rules),
        sheets(reasons, panels, "refused" if is_refused else "note"),
    )
    return tuple(finding for finding in found if finding)


def _unusual_frame(project: Project, assembly: Assembly) -> Iterator[Finding | None]:
    """Of beams and nodes, layer by layer."""
    rules, erection = project.fitness, erection_order(assembly)
    second = project.rules.second_layer
    own_rules = [project.rules, *([rules_of_second_layer(project.rules, second)] if second else [])]
    layers = zip(assembly.of_layers(BEAM), assembly.of_layers(NODE), own_rules, strict=True)
    for beams, nodes, own in layers:
        yield mitres_of(beams, rules)
        yield block_heights(nodes, own.beams.profile.height_mm, rules)
        yield slots(nodes, rules) if own.connection.kind in ("welded", "hub") else None
        yield uncovered(nodes, rules)
        yield going_in(beams, erection.is_closing[beams.kind.group], own.connection.gap_mm, rules)
    yield props(assembly.of(NODE), erection.propped)


def _rules_near_zero(project: Project, origin_mm: FloatArray) -> DetailingRules:
    """The rules of a project with heights above the origin that is taken out."""
    rules, level = project.rules, float(origin_mm[2])
    supports, zones = rules.supports, rules.zones
    if supports is not None and supports.below_mm is not None:
        supports = replace(supports, below_mm=supports.below_mm - level)
    zones = tuple(zone if zone.below_mm is None else replace(zone, below_mm=zone.below_mm - level) for zone in zones)
    return replace(rules, supports=supports, zones=zones)


def _scale(project: Project, mesh: Mesh) -> float:
    """Millimetres in a unit of the mesh file."""
    if project.unit is not None:
        return MM_PER_UNIT[project.unit]
    assert project.mean_edge_mm is not None  # a project has one of the two
    return project.mean_edge_mm / mesh.mean_edge_length


def _sheet_sizes(project: Project) -> tuple[Sheet, ...]:
    rules = project.sheets
    sizes = tuple(Sheet(size.length_mm, size.width_mm, size.count) for size in rules.sizes)
    return sizes or (Sheet(rules.length_mm, rules.width_mm),)


def _without_too_large(assembly: Assembly, reasons: dict[int, str]) -> Assembly:
    """The assembly without the panels that do not fit on a sheet, and those that belong to a layer with them. reasons:
    a sentence for each, by its index."""
    panels = assembly.of(PANEL)
    if len(reasons) == len(panels) > 0:
        raise NestingError(
            f"none of the {len(reasons)} panels fits on a sheet, so leaving them out leaves no panel: "
            f"{next(iter(reasons.values()))}; "
            "take larger sheets (--sheet), or turn nesting off (--nest off)"
        )
    if not reasons:
        return assembly
    left_out = tuple(LeftOut(PANEL.name, int(panels.elements[k]), reason) for k, reason in reasons.items())
    layer = panels.details.layer
    places = panels.elements * (int(layer.max()) + 1) + layer
    fitting = ~np.isin(places, places[list(reasons)])
    return replace(assembly.with_group(panels.take(fitting)), left_out=assembly.left_out + left_out)


def _nest(project: Project, assembly: Assembly, stages: Stages) -> Nest | None:
    panels = assembly.of(PANEL)
    if project.nesting.mode == "off" or not len(panels):
        return None
    rules = project.sheets
    return nest_panels(
        panels,
        _sheet_sizes(project),
        gap_mm=rules.gap_mm,
        border_mm=rules.border_mm,
        rotation=rules.rotation,
        mode=project.nesting.mode,
        seconds=project.nesting.seconds,
        progress=lambda share, _: stages.progress("Nest", share),
    )

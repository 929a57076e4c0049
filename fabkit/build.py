"""The pipeline: from a mesh file to a folder with everything that a workshop needs."""

from __future__ import annotations

import hashlib
import json
import platform
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np

from fabkit.detailing.detail import Detailed, detail
from fabkit.errors import ProjectError
from fabkit.export.documents import write_documents
from fabkit.export.folder import MANIFEST, check_replaceable, whole_folder
from fabkit.gauss_image import GivenPair, computed_image, exact_pair, read_given_pair
from fabkit.parts import Assembly, LeftOut
from fabkit.production.marks import share_equal_parts
from fabkit.production.nest import Nest, Sheet
from fabkit.production.sheet_nesting import nest_panels, too_large
from fabkit.production.summary import ExactGaussImage, GivenGaussImage, Summary
from fabkit.project import Project
from fabkit.stages import Listener, Stages
from fabkit.units import MM_PER_UNIT
from geometry.mesh import Mesh, MeshFile, read_mesh
from geometry.meshing import planarise
from geometry.parallel.support import SupportStructure

__all__ = ["Built", "build", "design"]


@dataclass(frozen=True, eq=False)
class Built:
    """What a build made, in memory. seconds: by stage."""

    structure: SupportStructure
    assembly: Assembly
    nest: Nest | None
    summary: Summary
    seconds: dict[str, float]


def build(project: Project, *, force: bool = False, listener: Listener | None = None) -> Built:
    """Design the structure and write it to the folder `project.out`, which appears whole or not at all.

    An earlier result there is replaced only with `force`. Raises GeometryError or FabkitError, in one sentence,
    where something in the mesh, the project or the output folder is not as it must be.
    """
    if project.out is None:
        raise ProjectError("there is no output folder: say -o FOLDER, or out = 'FOLDER' in the project file")
    check_replaceable(project.out, force=force)
    stages = Stages(listener)
    built = design(project, stages)
    with whole_folder(project.out, force=force) as folder:
        write_documents(folder, built.structure.mesh, built.assembly, built.nest, built.summary, stages)
        (folder / MANIFEST).write_text(json.dumps(_manifest(project, built), indent=1) + "\n", encoding="utf-8")
    return built


def design(project: Project, stages: Stages | None = None) -> Built:
    """Everything but the files: mesh, planar mesh, Gauss image, parts, marks and nest."""
    stages = stages or Stages()
    with stages("Read"):
        file, given = _read(project)
        scale = _scale(project, file.mesh)
        mesh = file.mesh * scale
    structure, told = _structure(project, mesh, given, stages)
    with stages("Detail and check fit"):
        detailed = detail(structure, project.rules, name=project.title, skip_unbuildable=project.skip_unbuildable)
    with stages("Marks"):
        assembly = share_equal_parts(detailed.assembly, within_mm=project.equal_within_mm)
    with stages("Nest"):
        if project.skip_unbuildable and project.nesting.mode != "off":
            assembly = _without_too_large(project, assembly)
        nest = _nest(project, assembly, stages)
    summary = replace(_summary(project, file, scale, structure, detailed), gauss_image=told)
    return Built(structure, assembly, nest, summary, stages.seconds)


def _read(project: Project) -> tuple[MeshFile, GivenPair | None]:
    rules = project.gauss_image
    if rules.file is None:
        return read_mesh(project.mesh, flip=project.flip), None
    pair = read_given_pair(project.mesh, rules.file, flip=project.flip, tolerance=rules.tolerance)
    return pair.file, pair


def _structure(
    project: Project, mesh: Mesh, given: GivenPair | None, stages: Stages
) -> tuple[SupportStructure, GivenGaussImage | ExactGaussImage | None]:
    """Between the planar mesh and its Gauss image, computed or given; and what is to be told of it."""
    rules, height = project.gauss_image, project.beams.height_mm
    if given is None:
        with stages("Planarise"):
            planar = planarise(mesh, **project.planarise.model_dump(exclude_none=True)).mesh
        with stages("Gauss image"):
            image, offset = computed_image(planar, rules.weights)
            return SupportStructure(planar, image, height), None if offset is None else ExactGaussImage(offset)
    with stages("Planar and parallel"):
        pair = exact_pair(mesh, given.image, tolerance=rules.tolerance)
        told = GivenGaussImage(given.name, given.sha256, pair.largest_move, pair.mean_move)
        return SupportStructure(pair.mesh, pair.image, height), told


def _scale(project: Project, mesh: Mesh) -> float:
    """Millimetres a unit of the mesh file."""
    if project.unit is not None:
        return MM_PER_UNIT[project.unit]
    assert project.mean_edge_mm is not None  # a project has one of the two
    return project.mean_edge_mm / mesh.mean_edge_length


def _sheet(project: Project) -> Sheet:
    return Sheet(project.sheets.length_mm, project.sheets.width_mm)


def _without_too_large(project: Project, assembly: Assembly) -> Assembly:
    """Without the panels that fit on no sheet."""
    reasons = too_large(assembly.panels, _sheet(project), border_mm=project.sheets.border_mm)
    left_out = tuple(LeftOut("panel", assembly.panels[k].element, reason) for k, reason in reasons.items())
    panels = tuple(panel for k, panel in enumerate(assembly.panels) if k not in reasons)
    return replace(assembly, panels=panels, left_out=assembly.left_out + left_out)


def _nest(project: Project, assembly: Assembly, stages: Stages) -> Nest | None:
    if project.nesting.mode == "off" or not assembly.panels:
        return None
    rules = project.sheets
    return nest_panels(
        assembly.panels,
        _sheet(project),
        gap_mm=rules.gap_mm,
        border_mm=rules.border_mm,
        mode=project.nesting.mode,
        seconds=project.nesting.seconds,
        progress=lambda share, _: stages.progress("Nest", share),
    )


def _summary(
    project: Project,
    file: MeshFile,
    scale: float,
    structure: SupportStructure,
    detailed: Detailed,
) -> Summary:
    mesh = structure.mesh
    moves = np.linalg.norm(mesh.vertices - file.mesh.vertices * scale, axis=1)
    return Summary(
        name=project.title,
        source=project.mesh.name,
        scale_mm=scale,
        n_vertices=mesh.n_vertices,
        n_edges=mesh.n_edges,
        n_faces=mesh.n_faces,
        n_boundaries=len(mesh.combinatorics.boundary_loops),
        mended=file.mended,
        planarity_before=float(file.mesh.planarity.max()),
        planarity_after=float(mesh.planarity.max()),
        largest_move_mm=float(moves.max()),
        mean_move_mm=float(moves.mean()),
        edge_lengths_mm=mesh.edge_lengths,
        heights=structure.heights,
        twists_deg=np.degrees(structure.twists),
        lift_mm=detailed.lift_mm,
        lift_reason=detailed.lift_reason,
    )


def _manifest(project: Project, built: Built) -> dict[str, Any]:
    summary, assembly = built.summary, built.assembly
    heights = summary.heights
    return {
        "name": summary.name,
        "input": {"file": summary.source, "sha256": hashlib.sha256(project.mesh.read_bytes()).hexdigest()},
        "gauss_image": None if summary.gauss_image is None else vars(summary.gauss_image),
        "settings": project.model_dump(mode="json", exclude={"mesh": True, "out": True, "gauss_image": {"file"}}),
        "versions": {
            "fabkit": version("fabkit"),
            "python": platform.python_version(),
            **{name: version(name) for name in ("numpy", "scipy", "ezdxf", "shapely")},
        },
        "counts": {
            "vertices": summary.n_vertices,
            "edges": summary.n_edges,
            "faces": summary.n_faces,
            **{name: len(group) for name, group in assembly.groups().items()},
            "marks": {name: len({part.mark for part in group}) for name, group in assembly.groups().items()},
            "sheets": built.nest.n_sheets if built.nest else 0,
            "left_out": len(assembly.left_out),
        },
        "largest_twist_deg": float(summary.twists_deg.max()),
        "heights": {"least": heights.min(), "median": float(np.median(heights)), "largest": heights.max()},
        "planarity": {"before": summary.planarity_before, "after": summary.planarity_after},
        "moved_mm": {"largest": summary.largest_move_mm, "mean": summary.mean_move_mm},
        "lift": {"mm": summary.lift_mm, "reason": summary.lift_reason},
        "mended": list(summary.mended),
        "left_out": [vars(part) for part in assembly.left_out],
        "seconds": {stage: round(seconds, 3) for stage, seconds in built.seconds.items()},
    }

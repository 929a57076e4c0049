"""What `fabkit mesh` writes and prints."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from rich.text import Text

from fabkit.commands.facts import moves
from fabkit.commands.printing import MESH_SUFFIXES, add_facts, check_suffix, progress_display
from fabkit.commands.terminal import OUT, facts_table, printable
from fabkit.errors import ProjectError
from fabkit.formats import EXACT_SUFFIXES, whole_file
from fabkit.formats.drawings import networks_html
from fabkit.formats.polylines import write_polylines
from fabkit.production import ANY_LINES, LEAST_UNDIRECTED_SHARE, irregular_vertices
from fabkit.project import surface_rules_from
from fabkit.stages import Stages
from fabkit.structure import made_planar
from fabkit.surface import (
    LaidSurface,
    SurfaceRules,
    curves_on_surface,
    design_surface,
    lay_on_surface,
    read_exact_file,
)
from fabkit.units import MM_PER_UNIT
from fabkit.wording import echo, readable
from geometry.arrays import FloatArray
from geometry.errors import listed
from geometry.files import MeshFile, read_mesh, write_mesh
from geometry.mesh import Mesh
from geometry.remeshing import study_networks
from geometry.traced_curves import TracedCurves

__all__ = ["write_surface_mesh"]

STUDIED_FACES = 300
"""Faces of the coarse meshes of a study, for which exact surfaces are cut into triangles."""


def write_surface_mesh(
    path: Path,
    out: Path | None,
    settings: dict[str, Any],
    *,
    unit: str | None,
    flip: bool,
    polylines: Path | None,
    curves: Path | None,
    asymptotic: Path | None,
    study: Path | None,
    force: bool,
) -> None:
    """Write the planar mesh, its lines, curves, and the study of networks, whichever is asked for, all or none of
    them."""
    traced = [each for each in (curves, asymptotic) if each is not None]
    _check_outputs(settings, out, polylines, traced, study)
    if unit is not None and unit not in MM_PER_UNIT:
        raise ProjectError(f"--unit is {echo(unit)}: one of {', '.join(MM_PER_UNIT)} is needed")
    lines_suffixes = (".obj", ".dxf")
    for target, known in (
        (out, MESH_SUFFIXES),
        *((each, lines_suffixes) for each in (polylines, curves, asymptotic)),
        (study, (".html", ".htm")),
    ):
        if target is not None:
            check_suffix(target, known)
    mm = 1.0 if path.suffix.lower() in EXACT_SUFFIXES else None if unit is None else MM_PER_UNIT[unit]
    rules = surface_rules_from(settings) if out is not None or traced else None
    inputs = [path, *([rules.strokes] if rules is not None and rules.strokes is not None else [])]
    with ExitStack() as stack:
        drafts = {
            target: stack.enter_context(whole_file(target, force=force, inputs=inputs))
            for target in (out, polylines, *traced, study)
            if target is not None
        }
        facts: list[tuple[str, str]] = []
        with progress_display() as listener:
            stages = Stages(listener)
            with stages("Read"):
                file = _read(path, rules, flip=flip).near_zero()
            facts += [("mended", note) for note in file.mended]
            if study is not None:
                facts += _study(file, drafts[study], stages)
            affine = None
            if rules is not None and out is not None:
                mesh, laid = _mesh(file, rules, mm, stages)
                affine = laid.affine
                write_mesh(drafts[out], mesh, origin=file.origin)
                facts += _facts(mesh, laid)
                if polylines is not None:
                    families = ([mesh.vertices[line] + file.origin for line in each] for each in laid.laid.polylines)
                    write_polylines(drafts[polylines], *families)
            if rules is not None and curves is not None:
                facts += _curves(file, rules, mm, drafts[curves], affine, stages)
            if rules is not None and asymptotic is not None:
                facts += _asymptotic(file, rules, mm, drafts[asymptotic], stages)
    table = facts_table()
    add_facts(table, facts)
    OUT.print(table)
    for target in drafts:
        OUT.print(Text.assemble("written to ", (printable(str(target)), "bold")))


def _check_outputs(
    settings: dict[str, Any], out: Path | None, polylines: Path | None, traced: list[Path], study: Path | None
) -> None:
    """Raise ProjectError where there is nothing to write, or an option would have no effect."""
    if out is None and polylines is not None:
        raise ProjectError("--polylines writes the lines of a mesh: give -o FILE, too, or --curves FILE without a mesh")
    if out is None and not traced and (study is None or settings):
        raise ProjectError(
            "there is no mesh file to write: give -o FILE, --curves FILE or --asymptotic FILE, or --study FILE alone "
            "for a page of networks"
        )
    ignored = [name for name in ("boundary", "strokes", "finer_where_curved") if name in settings]
    if out is None and ignored:
        option = ignored[0].replace("_", "-")
        raise ProjectError(
            f"--{option} changes the lines of a mesh, not the curves of the surface: give -o FILE, too, or leave it out"
        )


def _curves(
    file: MeshFile, rules: SurfaceRules, mm: float | None, draft: Path, affine: FloatArray | None, stages: Stages
) -> list[tuple[str, str]]:
    with stages("Trace curves"):
        found = curves_on_surface(
            file, rules, mm, affine=affine, progress=lambda share: stages.progress("Trace curves", share)
        )
    return _written(found, rules.lines, file, draft)


def _asymptotic(
    file: MeshFile, rules: SurfaceRules, mm: float | None, draft: Path, stages: Stages
) -> list[tuple[str, str]]:
    with stages("Trace asymptotic curves"):
        found = curves_on_surface(file, rules, mm, asymptotic=True)
    return _written(found, "asymptotic", file, draft)


def _written(found: TracedCurves, kind: str, file: MeshFile, draft: Path) -> list[tuple[str, str]]:
    first, second = found.by_family
    write_polylines(draft, *([line + file.origin for line in family] for family in (first, second)))
    lengths, closed = found.lengths, np.count_nonzero(found.is_closed)
    text = f"{len(first)} and {len(second)}, {lengths.min():.4g} to {lengths.max():.4g} long, {closed} of them closed"
    return [(f"{kind} curves", text)]


def _read(path: Path, rules: SurfaceRules | None, *, flip: bool) -> MeshFile:
    if path.suffix.lower() in EXACT_SUFFIXES:
        return read_exact_file(path, rules or SurfaceRules(faces=STUDIED_FACES), flip=flip)
    return read_mesh(path, flip=flip)


def _study(file: MeshFile, draft: Path, stages: Stages) -> list[tuple[str, str]]:
    with stages("Study networks"):
        surface = design_surface(file)
        trials = study_networks(surface, progress=lambda share: stages.progress("Study networks", share))
        page = networks_html(readable(file.path.stem), trials, surface.triangulated.n_faces)
        draft.write_text(page, encoding="utf-8", newline="\n")
    best = trials[0]
    spread = f"{100 * best.height_spread:.1f} %" if best.pair is not None else "no mesh could be made"
    return [("networks", f"{len(trials)}, of which the best has heights within {spread} in a coarse mesh")]


def _mesh(file: MeshFile, rules: SurfaceRules, mm: float | None, stages: Stages) -> tuple[Mesh, LaidSurface]:
    with stages("Lay mesh"):
        _, laid = lay_on_surface(file, rules, mm, lambda share: stages.progress("Lay mesh", share))
    with stages("Planarise"):
        return made_planar(laid.laid.mesh, {"surface": laid.surface, "keep_boundary": True}), laid


def _remarks(laid: LaidSurface) -> list[tuple[str, str]]:
    """What is particular about the surface."""
    share, loops = laid.laid.quality.undirected_share, laid.loop_lengths
    found = []
    if share > LEAST_UNDIRECTED_SHARE:
        found.append(("flat or spherical", f"{100 * share:.0f} % of the area: {ANY_LINES}"))
    if len(loops) > 1:
        lengths = listed([f"{length:.4g}" for length in loops], len(loops))
        found.append(("boundary loops", f"{lengths} long; all are kept"))
    return found


def _facts(mesh: Mesh, laid: LaidSurface) -> list[tuple[str, str]]:
    quality = laid.laid.quality
    lengths = mesh.edge_lengths
    low, high = np.quantile(lengths, [0.05, 0.95])
    distances = laid.distances(mesh)
    most, largest = np.quantile(distances, 0.95), distances.max()
    return [
        ("mesh", f"{mesh.n_vertices} vertices, {mesh.n_faces} faces, {100 * quality.quad_share:.1f} % of them quads"),
        ("edges", f"{lengths.min():.4g} to {lengths.max():.4g}, 90 % of them {low:.4g} to {high:.4g}"),
        ("lines", f"{laid.lines}; {100 * laid.aligned_share:.1f} % of the edges within 10 degrees of them"),
        *([("passed over", f"networks better in the study: {laid.passed_over}")] if laid.passed_over else []),
        ("irregular vertices", irregular_vertices(quality.valences)),
        *_remarks(laid),
        ("planarised", moves(laid.laid.mesh, mesh) or "nothing to do"),
        ("from the surface", f"95 % of the vertices within {most:.3g}, all {largest:.3g}"),
    ]

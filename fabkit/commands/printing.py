"""What the terminal prints of a build, an inspection and a design."""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from fabkit.commands.facts import findings_facts
from fabkit.commands.inspection import UNSIZED, Inspection, inspect_project
from fabkit.commands.inspection_picture import check_picture, draw_inspection
from fabkit.commands.options import project_of
from fabkit.commands.terminal import ERR, OUT, facts_table, printable
from fabkit.designs import EdgeOffsetDesign, with_span, write_design
from fabkit.errors import OutputError, ProjectError
from fabkit.fitness import MAX_NAMED_ELEMENTS
from fabkit.formats import whole_file
from fabkit.pipeline import Built, build
from fabkit.production import TERMINAL
from fabkit.project import Project
from fabkit.stages import Listener

__all__ = [
    "MESH_SUFFIXES",
    "add_facts",
    "build_and_print",
    "check_suffix",
    "inspect_and_print",
    "progress_display",
    "write_and_print",
]

MESH_SUFFIXES = (".obj", ".off", ".ply")
"""Of mesh files that commands write."""

COLOURS = {"note": "yellow", "accepted": "yellow", "unfit": "red"}

LARGEST_BOOST_COMPONENT = 1e9
"""Above it, the square of a component of a boost might overflow; a boost is shorter than 1."""


def check_suffix(out: Path, known: tuple[str, ...]) -> None:
    """Raise OutputError for a file to write whose suffix is none of those known."""
    if out.suffix.lower() not in known:
        raise OutputError(f"{out} ends in {out.suffix or 'no suffix'!r}: one of {', '.join(known)} is needed")


def build_and_print(mesh: Path, settings: dict[str, Any], *, force: bool) -> None:
    """Build while the stages are shown, and print the facts."""
    project = project_of(mesh, settings)
    with progress_display() as listener:
        built = build(project, force=force, listener=listener)
    _print_result(project, built)


def inspect_and_print(
    mesh: Path, settings: dict[str, Any], picture: Path | None = None, *, force: bool = False
) -> bool:
    """Print the facts and the verdict, and draw the picture, if any; whether a build would be refused."""
    is_sized = mesh.suffix.lower() == ".toml" or not settings.keys() <= {"flip", "accept", "gauss_image", "optimise"}
    project = project_of(mesh, settings if is_sized else settings | UNSIZED)
    if picture is None:
        return _inspected(project, is_sized).is_unfit
    check_picture(picture)
    inputs = [path for path in (mesh, project.mesh_path, project.gauss_image.file) if path is not None]
    with whole_file(picture, force=force, inputs=inputs) as draft:
        inspection = _inspected(project, is_sized)
        draw_inspection(inspection, draft)
    OUT.print(Text.assemble("picture written to ", (printable(str(picture)), "bold")))
    return inspection.is_unfit


def _inspected(project: Project, is_sized: bool) -> Inspection:
    """Inspect and print."""
    inspection, table = inspect_project(project, is_sized=is_sized), facts_table()
    add_facts(table, inspection.facts())
    OUT.print(table)
    return inspection


def write_and_print(
    design: EdgeOffsetDesign, out: Path, boosts: list[str] | None, *, force: bool, span_mm: float | None = None
) -> None:
    """Boost and scale a design, write it, and print its measures and the command that builds it."""
    boosted = design.boosted([_vector(text) for text in boosts or []])
    if span_mm is not None:
        boosted = with_span(boosted, span_mm)
    measures = write_design(boosted, out, force=force)
    mean, lengths = measures["mean_curvature"], measures["edge_lengths"]
    table = facts_table()
    table.add_row("mesh", f"{measures['vertices']} vertices, {measures['edges']} edges, {measures['faces']} faces")
    shortest, longest = lengths["least"] / lengths["mean"], lengths["largest"] / lengths["mean"]
    table.add_row("edges", f"{shortest:.2f} to {longest:.2f} of their mean; {measures['edges_reversed']} run against S")
    table.add_row("edges of S", f"at distance 1 from the origin to {measures['edges_of_s_off_distance_1']:.1e}")
    table.add_row("parallel", f"to {measures['edges_off_parallel']:.1e}, planar to {measures['faces_off_plane']:.1e}")
    table.add_row("mean curvature", f"{mean['least']:.6g} to {mean['largest']:.6g}, median {mean['median']:.6g}")
    crossed, met = measures["faces_that_cross_themselves"], measures["pairs_of_faces_that_meet"]
    if crossed or met:
        table.add_row("meets itself", f"{crossed} faces cross themselves, {met} pairs of faces do: it cannot be built")
    if boosted.is_in_mm:
        sides = np.ptp(boosted.mesh.vertices, axis=0)
        table.add_row("size", f"{sides[0]:.6g} by {sides[1]:.6g} mm in plan, rise {sides[2]:.6g} mm")
    for note in boosted.notes:
        table.add_row("note", printable(note))
    OUT.print(table)
    unit = " (or the unit of the surface)" if boosted.has_unit else ""
    OUT.print(Text.assemble("written to ", (printable(str(out)), "bold"), f"; build it with{unit}"))
    size = f"--unit {'mm' if boosted.is_in_mm else 'm'}"
    if not boosted.has_unit and not boosted.is_in_mm:
        size = f"--mean-edge {boosted.proposed_mean_edge_mm()}"
    mesh, image, built = (_as_typed(path) for path in (out / "M.obj", out / "S.obj", Path(f"{out}-built")))
    OUT.print(f"  fabkit build {mesh} --gauss-image {image} {size} -o {built}")


@contextmanager
def progress_display() -> Iterator[Listener]:
    """What stages are reported to, one line each, while it runs."""
    with Progress(
        SpinnerColumn(finished_text="[green]✓[/]"),
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        TimeElapsedColumn(),
        console=ERR,
    ) as progress:
        yield _Display(progress)


class _Display:
    """Shows the stages of a build, one line each."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, stage: str, share: float) -> None:
        if stage not in self._tasks:
            self._tasks[stage] = self._progress.add_task(stage, total=None)
        total = 1.0 if share > 0 else None
        self._progress.update(self._tasks[stage], completed=share, total=total)


def _print_result(project: Project, built: Built) -> None:
    summary, table = built.summary, facts_table()
    for fact in built.facts.all:
        if TERMINAL in fact.shown:
            table.add_row(fact.name, printable(f"{fact.text} ({fact.note})" if fact.note else fact.text))
    for note in summary.mended:
        table.add_row("mended", printable(note))
    add_facts(table, findings_facts(summary.fitness))
    OUT.print(table)
    reasons = [part.reason for part in built.assembly.left_out]
    if len(reasons) > MAX_NAMED_ELEMENTS:
        reasons[MAX_NAMED_ELEMENTS:] = [
            f"{len(reasons) - MAX_NAMED_ELEMENTS} more, which the report and the manifest name"
        ]
    for reason in reasons:
        OUT.print(Text.assemble(("left out: ", "bold red"), printable(reason)))
    seconds = sum(built.seconds.values())
    OUT.print(Text.assemble("written to ", (printable(str(project.out)), "bold"), f" in {seconds:.1f} s"))


def add_facts(table: Table, facts: Iterable[tuple[str, str]]) -> None:
    """Rows of names and sentences; findings are coloured."""
    for name, fact in facts:
        table.add_row(Text(name, style=COLOURS.get(name, "")), printable(fact))


def _as_typed(path: Path) -> str:
    """A path as it is typed into a shell: quoted where it has blanks and the like, and never taken for an option."""
    text = printable(str(path))
    return shlex.quote(f"./{text}" if text.startswith("-") else text)


def _vector(text: str) -> tuple[float, float, float]:
    number = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*"
    found = re.fullmatch(f"{number},{number},{number}", text)
    if not found:
        raise ProjectError(f"--boost is {text!r}, but needs three numbers such as 0.3,0,-0.1")
    x, y, z = (float(word) for word in found.groups())
    if not max(abs(x), abs(y), abs(z)) < LARGEST_BOOST_COMPONENT:
        raise ProjectError(f"--boost is {text!r}, and together its numbers have to be shorter than 1")
    return x, y, z

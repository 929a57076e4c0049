"""The command line: `fabkit build` and `fabkit inspect`; `fabkit design` has its commands in a file of its own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from fabkit.commands.design import design_app
from fabkit.commands.inspection import UNSIZED, Inspection, inspect_project
from fabkit.commands.options import (
    RUN,
    Accept,
    Beam,
    Clearance,
    EqualWithin,
    Flip,
    GaussImage,
    Joint,
    MeanEdge,
    MeshPath,
    NestMode,
    NestSeconds,
    Reference,
    Sheet,
    SkipUnbuildable,
    Thickness,
    Underside,
    Unit,
    project_of,
    settings_of,
)
from fabkit.commands.terminal import ERR, OUT, Commands, facts_table, one_sentence, told
from fabkit.fitness import MAX_NAMED_ELEMENTS, Finding
from fabkit.pipeline import Built, build
from fabkit.production import TERMINAL
from fabkit.project import Project

__all__ = ["app"]

app = typer.Typer(
    cls=Commands,
    help="From a freeform mesh with planar faces to what a workshop needs: torsion-free beams, nodes and panels as "
    "STEP, DXF, cut lists and a report.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)

app.add_typer(design_app, name="design")

COLOURS = {"note": "yellow", "accepted": "yellow", "unfit": "red"}


@app.command("build")
def build_command(
    mesh: MeshPath,
    gauss_image: GaussImage = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Folder to write; must not exist yet.")] = None,
    unit: Unit = None,
    mean_edge: MeanEdge = None,
    flip: Flip = False,
    name: Annotated[str | None, typer.Option(help="Name of the structure; by default that of the mesh file.")] = None,
    beam: Beam = None,
    reference: Reference = None,
    clearance: Clearance = None,
    thickness: Thickness = None,
    joint: Joint = None,
    underside: Underside = None,
    sheet: Sheet = None,
    nest: NestMode = None,
    nest_seconds: NestSeconds = None,
    equal_within: EqualWithin = None,
    accept: Accept = None,
    skip_unbuildable: SkipUnbuildable = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace an earlier result in the folder.", rich_help_panel=RUN)
    ] = False,
) -> None:
    """Make parts and documents from a mesh.

    Faces may have any number of corners; they are made planar if they are not. The folder appears whole or not at all.
    """
    with one_sentence():
        settings = settings_of(
            out=out,
            name=name,
            unit=unit,
            mean_edge_mm=mean_edge,
            flip=flip or None,
            skip_unbuildable=skip_unbuildable or None,
            equal_within_mm=equal_within,
            accept=accept,
            gauss_image={"file": gauss_image},
            beam=beam,
            reference=reference,
            clearance=clearance,
            thickness=thickness,
            joint=joint,
            underside=underside,
            sheet=sheet,
            nest=nest,
            nest_seconds=nest_seconds,
        )
        project = project_of(mesh, settings)
        with _progress() as progress:
            built = build(project, force=force, listener=_Display(progress))
        _print_result(project, built)


@app.command("inspect")
def inspect_command(
    mesh: MeshPath,
    gauss_image: GaussImage = None,
    unit: Unit = None,
    mean_edge: MeanEdge = None,
    flip: Flip = False,
    beam: Beam = None,
    reference: Reference = None,
    clearance: Clearance = None,
    thickness: Thickness = None,
    joint: Joint = None,
    underside: Underside = None,
    sheet: Sheet = None,
    nest: NestMode = None,
    accept: Accept = None,
    skip_unbuildable: SkipUnbuildable = False,
) -> None:
    """Print what a mesh is fit for, by the rules that a build goes by.

    With a unit, a mean edge or a project file all that a build does is tried, short of writing; without, what depends
    on no size. Ends with 0 where a build would go through, with 1 where it would be refused.
    """
    with one_sentence():
        settings = settings_of(
            unit=unit,
            mean_edge_mm=mean_edge,
            flip=flip or None,
            skip_unbuildable=skip_unbuildable or None,
            accept=accept,
            gauss_image={"file": gauss_image},
            beam=beam,
            reference=reference,
            clearance=clearance,
            thickness=thickness,
            joint=joint,
            underside=underside,
            sheet=sheet,
            nest=nest,
        )
        if mesh.suffix.lower() == ".toml" or not settings.keys() <= {"flip", "accept", "gauss_image"}:
            found = inspect_project(project_of(mesh, settings))
        else:
            found = inspect_project(project_of(mesh, settings | UNSIZED), is_sized=False)
        _print_inspection(found)
    if found.is_unfit:
        raise typer.Exit(1)


# --- output


def _progress() -> Progress:
    return Progress(
        SpinnerColumn(finished_text="[green]✓[/]"),
        TextColumn("{task.description}"),
        BarColumn(bar_width=24),
        TimeElapsedColumn(),
        console=ERR,
    )


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
            table.add_row(fact.name, told(f"{fact.text} ({fact.note})" if fact.note else fact.text))
    for note in summary.mended:
        table.add_row("mended", told(note))
    _add_findings(table, summary.fitness)
    OUT.print(table)
    reasons = [part.reason for part in built.assembly.left_out]
    if len(reasons) > MAX_NAMED_ELEMENTS:
        reasons[MAX_NAMED_ELEMENTS:] = [
            f"{len(reasons) - MAX_NAMED_ELEMENTS} more, which the report and the manifest name"
        ]
    for reason in reasons:
        OUT.print(Text.assemble(("left out: ", "bold red"), told(reason)))
    seconds = sum(built.seconds.values())
    OUT.print(Text.assemble("written to ", (told(str(project.out)), "bold"), f" in {seconds:.1f} s"))


def _print_inspection(found: Inspection) -> None:
    table = facts_table()
    for name, fact in found.facts():
        table.add_row(Text(name, style=COLOURS.get(name, "")), told(fact))
    OUT.print(table)


def _add_findings(table: Table, findings: tuple[Finding, ...]) -> None:
    for finding in findings:
        table.add_row(Text(finding.level, style=COLOURS[finding.level]), told(f"{finding.name}: {finding.sentence}"))

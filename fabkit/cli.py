"""The command line: `fabkit build` and `fabkit inspect`; `fabkit design` has its commands in a file of its own."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.progress import BarColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.text import Text

from fabkit.build import Built, build
from fabkit.design_commands import design_app
from fabkit.errors import ProjectError
from fabkit.inspection import Inspection, PairInspection, inspect_mesh, inspect_pair
from fabkit.project import Project, load_project, project_from
from fabkit.terminal import ERR, OUT, Commands, facts_table, one_sentence, told

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

SIZES, SHOP, RUN = "Sizes (mm)", "Shop", "Run"


@app.command("build")
def build_command(
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="OBJ, OFF or PLY file, or a project file (.toml).")],
    gauss_image: Annotated[
        Path | None,
        typer.Option(help="Mesh file of a Gauss image to build with, parallel to MESH. Default: compute one."),
    ] = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Folder to write; must not exist yet.")] = None,
    unit: Annotated[str | None, typer.Option(help="Unit of the mesh file: mm, cm, m, in or ft. Never guessed.")] = None,
    mean_edge: Annotated[
        float | None, typer.Option(help="Instead of a unit: scale the mesh so that its mean edge has this many mm.")
    ] = None,
    flip: Annotated[bool, typer.Option("--flip", help="Turn the outside round.")] = False,
    name: Annotated[str | None, typer.Option(help="Name of the structure; by default that of the mesh file.")] = None,
    beam: Annotated[
        str | None, typer.Option(metavar="WxH", help="Section of the beams. Default: 50x120.", rich_help_panel=SIZES)
    ] = None,
    reference: Annotated[
        str | None,
        typer.Option(
            help="What of the beams lies on the mesh: outer, centre or inner. Default: outer.", rich_help_panel=SIZES
        ),
    ] = None,
    clearance: Annotated[
        float | None,
        typer.Option(help="Between beams at a node, beyond what is needed. Default: 5.", rich_help_panel=SIZES),
    ] = None,
    thickness: Annotated[float | None, typer.Option(help="Of the panels. Default: 10.", rich_help_panel=SIZES)] = None,
    joint: Annotated[float | None, typer.Option(help="Between panels. Default: 10.", rich_help_panel=SIZES)] = None,
    lift: Annotated[
        float | None,
        typer.Option(
            help="Of the panels above the mesh. Default: the least that clears beams and nodes, plus 5.",
            rich_help_panel=SIZES,
        ),
    ] = None,
    sheet: Annotated[
        str | None, typer.Option(metavar="LxW", help="Stock sheets. Default: 6000x3210.", rich_help_panel=SHOP)
    ] = None,
    nest: Annotated[
        str | None,
        typer.Option(help="Lay panels on sheets: quick, best or off. Default: quick.", rich_help_panel=SHOP),
    ] = None,
    nest_seconds: Annotated[
        float | None, typer.Option(help="What best may take. Default: 60.", rich_help_panel=SHOP)
    ] = None,
    equal_within: Annotated[
        float | None,
        typer.Option(
            help="Parts that differ by less share a mark, and stand off by as much; at most 1. Default: 1e-7.",
            rich_help_panel=SHOP,
        ),
    ] = None,
    skip_unbuildable: Annotated[
        bool,
        typer.Option(
            "--skip-unbuildable",
            help="Leave out what cannot be built, and show it in red, instead of stopping.",
            rich_help_panel=RUN,
        ),
    ] = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace an earlier result in the folder.", rich_help_panel=RUN)
    ] = False,
) -> None:
    """Make parts and documents from a mesh.

    Faces may have any number of corners; they are made planar if they are not. The folder appears whole or not at all.
    """
    with one_sentence():
        settings = _without_nothing(
            {
                "out": out,
                "name": name,
                "unit": unit,
                "mean_edge_mm": mean_edge,
                "flip": flip or None,
                "skip_unbuildable": skip_unbuildable or None,
                "equal_within_mm": equal_within,
                "gauss_image": {"file": gauss_image},
                "beams": {**_pair("--beam", beam, "width_mm", "height_mm"), "reference": reference},
                "nodes": {"clearance_mm": clearance},
                "panels": {"thickness_mm": thickness, "joint_mm": joint, "lift_mm": lift},
                "sheets": _pair("--sheet", sheet, "length_mm", "width_mm"),
                "nesting": {"mode": nest, "seconds": nest_seconds},
            }
        )
        if mesh.suffix.lower() == ".toml":
            project = load_project(mesh, settings)
        else:
            project = project_from({"mesh": mesh, **settings})
        with _progress() as progress:
            built = build(project, force=force, listener=_Display(progress))
        _print_result(project, built)


@app.command("inspect")
def inspect_command(
    mesh: Annotated[Path, typer.Argument(metavar="MESH", help="OBJ, OFF or PLY file.")],
    gauss_image: Annotated[
        Path | None, typer.Option(help="Mesh file of a Gauss image: print how the two fit instead.")
    ] = None,
) -> None:
    """Print what a mesh is fit for: sizes, planarity, offsets, the heights that beams would have."""
    with one_sentence():
        _print_inspection(inspect_pair(mesh, gauss_image) if gauss_image else inspect_mesh(mesh))


# --- input


def _without_nothing(settings: dict[str, Any]) -> dict[str, Any]:
    """Settings without those that were not given, on both levels."""
    nested = {k: _without_nothing(v) if isinstance(v, dict) else v for k, v in settings.items()}
    return {key: value for key, value in nested.items() if value is not None and value != {}}


def _pair(option: str, text: str | None, first: str, second: str) -> dict[str, float]:
    if text is None:
        return {}
    number = r"\s*(\d+\.?\d*|\.\d+)\s*"
    found = re.fullmatch(f"{number}[xX*]{number}", text)
    if not found:
        raise ProjectError(f"{option} is {text!r}, but needs two sizes in mm such as 50x120")
    return {first: float(found[1]), second: float(found[2])}


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
    summary, assembly = built.summary, built.assembly
    table = facts_table()
    for kind, group in assembly.groups().items():
        marks, mass = len({part.mark for part in group}), sum(part.mass_kg for part in group)
        table.add_row(kind, f"{len(group)} of {marks} marks, {mass:,.0f} kg")
    if built.nest:
        table.add_row("sheets", f"{built.nest.n_sheets}, {built.nest.utilisation:.0%} used")
    table.add_row("planarity", f"{summary.planarity_before:.1e} as read, {summary.planarity_after:.1e} as built")
    table.add_row("vertices moved", f"{summary.mean_move_mm:.2f} mm in the mean, {summary.largest_move_mm:.2f} at most")
    table.add_row("largest twist", f"{summary.twists_deg.max():.1e} degrees")
    if summary.gauss_image:
        table.add_row("gauss image", told(summary.gauss_image_origin))
    table.add_row("heights", f"{_spread(summary.heights)} of the nominal height")
    table.add_row("panels lifted", f"{summary.lift_mm:.1f} mm: {summary.lift_reason}")
    for note in summary.mended:
        table.add_row("mended", told(note))
    OUT.print(table)
    for part in assembly.left_out:
        OUT.print(Text.assemble(("left out: ", "bold red"), told(part.reason)))
    seconds = sum(built.seconds.values())
    OUT.print(Text.assemble("written to ", (told(str(project.out)), "bold"), f" in {seconds:.1f} s"))


def _print_inspection(found: Inspection | PairInspection) -> None:
    table = facts_table()
    for name, fact in found.facts():
        table.add_row(name, told(fact))
    OUT.print(table)


def _spread(values: np.ndarray[Any, np.dtype[np.float64]]) -> str:
    low, middle, high = np.percentile(values, [0, 50, 100])
    return f"{low:.3f} to {high:.3f} (median {middle:.3f})"

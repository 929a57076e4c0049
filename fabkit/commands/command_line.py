"""The command line: `fabkit build` and `fabkit inspect`; others are in `meshes.py` and `design.py`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fabkit.commands.design import design_app
from fabkit.commands.folders import check_command, diff_command
from fabkit.commands.meshes import curvature_command, offset_command, planarise_command
from fabkit.commands.options import (
    RUN,
    Accept,
    Beam,
    BoundaryLines,
    ByteOrderMark,
    Clearance,
    Connection,
    DecimalSign,
    EdgeLength,
    EqualWithin,
    Faces,
    FinerWhereCurved,
    Flip,
    GaussImage,
    Joint,
    KeepMarks,
    Lift,
    Lines,
    MeanEdge,
    MeshPath,
    NestMode,
    NestSeconds,
    NodeTop,
    Optimise,
    Reference,
    SectionOfBeams,
    Separator,
    Sheet,
    SkipUnbuildable,
    Smooth,
    Strokes,
    Thickness,
    Unit,
    settings_of,
)
from fabkit.commands.surface_mesh import mesh_command
from fabkit.commands.terminal import Commands, exit_on_error

__all__ = ["app"]

app = typer.Typer(
    cls=Commands,
    help="From a freeform mesh with planar faces to the documents of a workshop: torsion-free beams, nodes and "
    "panels as "
    "STEP, DXF, cut lists and a report.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)


@app.command("build")
def build_command(
    mesh: MeshPath,
    gauss_image: GaussImage = None,
    optimise: Optimise = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="FOLDER", help="Folder to write; must not exist yet.")
    ] = None,
    unit: Unit = None,
    mean_edge: MeanEdge = None,
    flip: Flip = False,
    name: Annotated[str | None, typer.Option(help="Name of the structure; by default that of the mesh file.")] = None,
    faces: Faces = None,
    edge_length: EdgeLength = None,
    lines: Lines = None,
    boundary: BoundaryLines = None,
    strokes: Strokes = None,
    finer_where_curved: FinerWhereCurved = None,
    smooth: Smooth = None,
    beam: Beam = None,
    section: SectionOfBeams = None,
    connection: Connection = None,
    reference: Reference = None,
    clearance: Clearance = None,
    node_top: NodeTop = None,
    thickness: Thickness = None,
    joint: Joint = None,
    lift: Lift = None,
    sheet: Sheet = None,
    nest: NestMode = None,
    nest_seconds: NestSeconds = None,
    equal_within: EqualWithin = None,
    keep_marks: KeepMarks = None,
    separator: Separator = None,
    decimal: DecimalSign = None,
    bom: ByteOrderMark = False,
    accept: Accept = None,
    skip_unbuildable: SkipUnbuildable = False,
    force: Annotated[
        bool, typer.Option("--force", help="Replace an earlier result in the folder.", rich_help_panel=RUN)
    ] = False,
) -> None:
    """Make parts and shop documents from a mesh.

    Faces may have any number of corners; they are made planar if they are not. The folder appears complete or not at
    all.
    """
    with exit_on_error():
        from fabkit.commands.printing import build_and_print

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
            optimise=optimise,
            faces=faces,
            edge_length=edge_length,
            lines=lines,
            boundary=boundary,
            strokes=strokes,
            finer_where_curved=finer_where_curved,
            smooth=smooth,
            beam=beam,
            section=section,
            connection=connection,
            reference=reference,
            clearance=clearance,
            node_top=node_top,
            thickness=thickness,
            joint=joint,
            lift=lift,
            sheet=sheet,
            nest=nest,
            nest_seconds=nest_seconds,
            separator=separator,
            decimal=decimal,
            bom=bom,
            keep_marks=keep_marks,
        )
        build_and_print(mesh, settings, force=force)


@app.command("inspect")
def inspect_command(
    mesh: MeshPath,
    gauss_image: GaussImage = None,
    optimise: Optimise = None,
    unit: Unit = None,
    mean_edge: MeanEdge = None,
    flip: Flip = False,
    faces: Faces = None,
    edge_length: EdgeLength = None,
    lines: Lines = None,
    boundary: BoundaryLines = None,
    strokes: Strokes = None,
    finer_where_curved: FinerWhereCurved = None,
    smooth: Smooth = None,
    beam: Beam = None,
    section: SectionOfBeams = None,
    connection: Connection = None,
    reference: Reference = None,
    clearance: Clearance = None,
    node_top: NodeTop = None,
    thickness: Thickness = None,
    joint: Joint = None,
    lift: Lift = None,
    sheet: Sheet = None,
    nest: NestMode = None,
    accept: Accept = None,
    skip_unbuildable: SkipUnbuildable = False,
    picture: Annotated[
        Path | None,
        typer.Option(
            help="PNG file to write, with curvatures, planarity, beam heights and lean of the node axes.",
            rich_help_panel=RUN,
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace an existing picture.", rich_help_panel=RUN)] = False,
) -> None:
    """Print the properties of a mesh and whether a build would succeed.

    With a unit, a mean edge or a project file the whole build is tried, except for writing; without, only what does not
    depend on size is judged. The exit code is 0 where a build would succeed, and 1 where it would be refused.
    """
    with exit_on_error():
        from fabkit.commands.printing import inspect_and_print

        settings = settings_of(
            unit=unit,
            mean_edge_mm=mean_edge,
            flip=flip or None,
            skip_unbuildable=skip_unbuildable or None,
            accept=accept,
            gauss_image={"file": gauss_image},
            optimise=optimise,
            faces=faces,
            edge_length=edge_length,
            lines=lines,
            boundary=boundary,
            strokes=strokes,
            finer_where_curved=finer_where_curved,
            smooth=smooth,
            beam=beam,
            section=section,
            connection=connection,
            reference=reference,
            clearance=clearance,
            node_top=node_top,
            thickness=thickness,
            joint=joint,
            lift=lift,
            sheet=sheet,
            nest=nest,
        )
        is_unfit = inspect_and_print(mesh, settings, picture, force=force)
    if is_unfit:
        raise typer.Exit(1)


app.command("mesh")(mesh_command)
app.command("planarise")(planarise_command)
app.command("offset")(offset_command)
app.command("curvature")(curvature_command)
app.command("check")(check_command)
app.command("diff")(diff_command)
app.add_typer(design_app, name="design")

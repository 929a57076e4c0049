"""`fabkit mesh`: a planar mesh on a design surface, without parts, in the unit and at the place of the surface."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fabkit.commands.options import (
    RUN,
    SURFACE,
    BoundaryLines,
    EdgeLength,
    Faces,
    FinerWhereCurved,
    Flip,
    Lines,
    Smooth,
    Strokes,
    Unit,
    settings_of,
)
from fabkit.commands.terminal import exit_on_error

__all__ = ["mesh_command"]


def mesh_command(
    surface: Annotated[
        Path,
        typer.Argument(
            metavar="SURFACE", help="File of a design surface: OBJ, OFF, PLY, STL or GLB; STEP, IGES or BREP."
        ),
    ],
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Mesh file to write: OBJ, OFF or PLY.")] = None,
    faces: Faces = None,
    edge_length: EdgeLength = None,
    unit: Unit = None,
    flip: Flip = False,
    lines: Lines = None,
    boundary: BoundaryLines = None,
    strokes: Strokes = None,
    finer_where_curved: FinerWhereCurved = None,
    smooth: Smooth = None,
    polylines: Annotated[
        Path | None,
        typer.Option(help="Write the lines of the mesh as polylines, too: OBJ or DXF.", rich_help_panel=SURFACE),
    ] = None,
    curves: Annotated[
        Path | None,
        typer.Option(
            help="Write the curves of the network, traced on the surface itself, as far apart as --faces or "
            "--edge-length say: OBJ or DXF. Needs no -o.",
            rich_help_panel=SURFACE,
        ),
    ] = None,
    asymptotic: Annotated[
        Path | None,
        typer.Option(
            help="Write the asymptotic curves of the saddle-shaped parts in the same way.", rich_help_panel=SURFACE
        ),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option(
            help="Write a page (HTML) of many networks of lines side by side, the best first; without -o nothing else.",
            rich_help_panel=SURFACE,
        ),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.", rich_help_panel=RUN)] = False,
) -> None:
    """Lay a mesh of planar quads on a design surface, along conjugate lines.

    The mesh is in the unit and at the place of the surface. `fabkit build` does the same and continues to the parts.
    """
    with exit_on_error():
        settings = settings_of(
            faces=faces,
            edge_length=edge_length,
            lines=lines,
            boundary=boundary,
            strokes=strokes,
            finer_where_curved=finer_where_curved,
            smooth=smooth,
        )
        from fabkit.commands.surface_output import write_surface_mesh

        write_surface_mesh(
            surface,
            out,
            settings.get("surface", {}),
            unit=unit,
            flip=flip,
            polylines=polylines,
            curves=curves,
            asymptotic=asymptotic,
            study=study,
            force=force,
        )

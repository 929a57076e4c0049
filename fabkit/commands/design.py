"""`fabkit design`: edge offset meshes for people who do not write Python, as pairs of files to build from."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fabkit.commands.options import refuse_beside
from fabkit.commands.terminal import exit_on_error
from fabkit.errors import ProjectError
from fabkit.families import Bend, Faces, MinimalShape, Tiles

if TYPE_CHECKING:
    from fabkit.designs import EdgeOffsetDesign

__all__ = ["design_app"]

design_app = typer.Typer(
    help="Make an edge offset mesh and its Gauss image: beams of one height that align at all nodes.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

SIZE, NEAR, RUN = "Size (mm)", "Near to a mesh", "Run"

Out = Annotated[Path, typer.Option("-o", "--out", metavar="FOLDER", help="Folder to write; must not exist yet.")]
Boosts = Annotated[
    list[str] | None,
    typer.Option("--boost", metavar="X,Y,Z", help="Laguerre boost, shorter than 1, of M and S; may be repeated."),
]
Span = Annotated[
    float | None, typer.Option(help="Length in mm of the longer side of the plan, along x or y.", rich_help_panel=SIZE)
]
Rise = Annotated[
    float | None,
    typer.Option(
        help="Height in mm from the lowest to the highest vertex; it determines --coverage of a dome, and needs "
        "--span.",
        rich_help_panel=SIZE,
    ),
]
EnneperRise = Annotated[
    float | None,
    typer.Option(
        help="Height in mm from the lowest to the highest vertex; it determines --turn of Enneper's surface, "
        "and needs --span.",
        rich_help_panel=SIZE,
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace an earlier result in the folder.", rich_help_panel=RUN)]


@design_app.command("koebe")
def koebe_command(
    context: typer.Context,
    out: Out,
    tiles: Annotated[Tiles, typer.Option(help="Shape of the faces of a patch.")] = Tiles.QUADS,
    count: Annotated[int, typer.Option(help="Faces along a side of the patch.")] = 12,
    combinatorics: Annotated[
        Path | None,
        typer.Option(
            help="Instead of a patch: mesh file, open or closed, of which only the faces are used, not the positions."
        ),
    ] = None,
    dual: Annotated[bool, typer.Option("--dual", help="Take the dual mesh, with a face for each vertex.")] = False,
    coverage: Annotated[
        float | None,
        typer.Option(
            help="Share of the sphere that an open S covers; with a larger share the mesh bends more. "
            "Default: 0.4, saddle of pentagons: 0.2."
        ),
    ] = None,
    bend: Annotated[
        Bend, typer.Option(help="dome: convex; saddle: edges across a direction are reversed; sphere: S itself.")
    ] = Bend.DOME,
    direction: Annotated[float, typer.Option(help="Direction of a saddle, in degrees from the x axis.")] = 45.0,
    span: Span = None,
    rise: Rise = None,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """The fairest mesh parallel to a Koebe polyhedron, of quads, hexagons, pentagons or the faces of a given mesh."""
    with exit_on_error():
        from fabkit.commands.printing import write_and_print
        from fabkit.designs import COVERAGE_RANGE, koebe_design, with_rise
        from fabkit.formats import check_replaceable

        check_replaceable(out, force=force)
        if combinatorics:
            refuse_beside(context, "--combinatorics gives the faces", "tiles", "count")
        if bend is not Bend.SADDLE:
            refuse_beside(context, f"--bend {bend} has no direction", "direction")

        def designed(share: float | None) -> EdgeOffsetDesign:
            return koebe_design(
                tiles=tiles,
                count=count,
                combinatorics=combinatorics,
                take_dual=dual,
                coverage=share,
                bend=bend,
                direction_deg=direction,
            )

        if rise is None:
            design = designed(coverage)
        else:
            _check_rise(context, span, None if bend is Bend.DOME else f"--bend {bend}", boost, "coverage")
            design = with_rise(designed, COVERAGE_RANGE, span_mm=span or 0.0, rise_mm=rise)
        write_and_print(design, out, boost, force=force, span_mm=span)


@design_app.command("minimal")
def minimal_command(
    context: typer.Context,
    out: Out,
    shape: Annotated[MinimalShape, typer.Option(help="The minimal surface.")] = MinimalShape.CATENOID,
    faces: Annotated[Faces, typer.Option(help="Shape of the faces of a catenoid.")] = Faces.QUADS,
    count: Annotated[int, typer.Option(help="Faces around a catenoid, or along a side of Enneper's surface.")] = 24,
    turn: Annotated[
        float, typer.Option(help="Angle in degrees between the normals in the middle and at the rim.")
    ] = 60.0,
    gauss_image: Annotated[
        Path | None,
        typer.Option(
            help="Instead of a shape: mesh file of a Koebe polyhedron with boundary, taken as the Gauss image."
        ),
    ] = None,
    span: Span = None,
    rise: EnneperRise = None,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """A mesh of mean curvature zero: catenoid, surface of Enneper, or with a given Gauss image."""
    with exit_on_error():
        from fabkit.commands.printing import write_and_print
        from fabkit.designs import TURN_RANGE_DEG, minimal_design, with_rise
        from fabkit.formats import check_replaceable

        check_replaceable(out, force=force)
        if gauss_image:
            refuse_beside(context, "--gauss-image decides the shape", "shape", "faces", "count", "turn")

        def designed(turn_deg: float) -> EdgeOffsetDesign:
            return minimal_design(shape=shape, faces=faces, count=count, turn_deg=turn_deg, gauss_image=gauss_image)

        if rise is None:
            design = designed(turn)
        else:
            other = "--gauss-image" if gauss_image else None if shape is MinimalShape.ENNEPER else f"--shape {shape}"
            _check_rise(context, span, other, boost, "turn")
            design = with_rise(designed, TURN_RANGE_DEG, span_mm=span or 0.0, rise_mm=rise)
        write_and_print(design, out, boost, force=force, span_mm=span)


@design_app.command("cmc")
def cmc_command(
    context: typer.Context,
    out: Out,
    faces: Annotated[
        Faces, typer.Option(help="Shape of the faces. Hexagons give a single bulge, without inflections.")
    ] = Faces.QUADS,
    count: Annotated[int, typer.Option(help="Number of faces around the axis.")] = 24,
    rows: Annotated[int, typer.Option(help="Rows of faces from one inflection to the next.")] = 6,
    folds: Annotated[
        int | None,
        typer.Option(help="Number of inflections between bulges and necks. Default: 2 for quads, 0 for hexagons."),
    ] = None,
    bulge: Annotated[
        float | None,
        typer.Option(
            help="Widest radius; 1 is a sphere, 0.5 a cylinder. Default: inflections where rows end, or without folds "
            "half way from there to a sphere."
        ),
    ] = None,
    start: Annotated[
        Path | None,
        typer.Option(help="Instead of these: mesh file of a mesh M near which the result stays.", rich_help_panel=NEAR),
    ] = None,
    gauss_image: Annotated[
        Path | None, typer.Option(help="Mesh file of the Gauss image S of that M.", rich_help_panel=NEAR)
    ] = None,
    mean: Annotated[
        float | None,
        typer.Option(help="Mean curvature, negative for a dome. Default: the median of M.", rich_help_panel=NEAR),
    ] = None,
    span: Span = None,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """A mesh of constant mean curvature: bulges and necks about an axis, like soap films, or near a given mesh."""
    with exit_on_error():
        from fabkit.commands.printing import write_and_print
        from fabkit.designs import cmc_design, cmc_near_design
        from fabkit.formats import check_replaceable

        check_replaceable(out, force=force)
        if start and gauss_image:
            refuse_beside(context, "--start decides the shape", "faces", "count", "rows", "folds", "bulge", "span")
            design = cmc_near_design(start, gauss_image, mean=mean)
        elif start or gauss_image or mean is not None:
            raise ProjectError("--start needs the files of both meshes: --start M.obj --gauss-image S.obj")
        else:
            design = cmc_design(faces=faces, count=count, rows=rows, folds=folds, bulge=bulge)
        write_and_print(design, out, boost, force=force, span_mm=span)


@design_app.command("hexagons")
def hexagons_command(
    surface: Annotated[Path, typer.Argument(metavar="SURFACE", help="Mesh file of a surface, finely meshed.")],
    out: Out,
    count: Annotated[int, typer.Option(help="Number of hexagons across the Gauss image of the surface.")] = 12,
    curvature: Annotated[
        int,
        typer.Option(help="1: touch the surface only where it is convex or concave; -1: only where it is a saddle."),
    ] = 0,
    turn: Annotated[
        float | None,
        typer.Option(
            help="Angle in degrees by which the hexagons are turned. Default: the most buildable of 0, 15, 30 and 45."
        ),
    ] = None,
    flip: Annotated[
        bool, typer.Option("--flip", help="Reverse all faces of the surface, so that the other side is outside.")
    ] = False,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """A mesh of hexagons whose planes touch a surface, with beams of one height."""
    with exit_on_error():
        from fabkit.commands.printing import write_and_print
        from fabkit.designs import hexagons_design
        from fabkit.formats import check_replaceable

        check_replaceable(out, force=force)
        design = hexagons_design(surface, count=count, curvature=curvature, turn_deg=turn, flip=flip)
        write_and_print(design, out, boost, force=force)


def _check_rise(
    context: typer.Context, span: float | None, other: str | None, boost: list[str] | None, parameter: str
) -> None:
    """Raise ProjectError where --rise is given without --span, for a shape without it, or with an option that changes
    the rise or that it determines."""
    if boost:
        raise ProjectError("--boost changes the rise that --rise asks for: leave out one of the two")
    if span is None:
        raise ProjectError("--rise needs --span: give the length of the longer side of the plan, too")
    if other is not None:
        raise ProjectError(
            "--rise is met by domes of fabkit design koebe and by --shape enneper of fabkit design minimal, and "
            f"{other} is asked for: give --span alone, which scales the mesh"
        )
    refuse_beside(context, "--rise decides the shape", parameter)

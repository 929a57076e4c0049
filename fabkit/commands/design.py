"""`fabkit design`: edge offset meshes for people who do not write Python, as pairs of files to build from."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import Annotated

import typer
from rich.text import Text

from fabkit.commands.terminal import OUT, facts_table, one_sentence, told
from fabkit.designs import (
    Bend,
    EdgeOffsetDesign,
    Faces,
    MinimalShape,
    Tiles,
    cmc_design,
    cmc_near_design,
    hexagons_design,
    koebe_design,
    minimal_design,
    write_design,
)
from fabkit.errors import ProjectError
from fabkit.formats import check_replaceable

__all__ = ["design_app"]

design_app = typer.Typer(
    help="Make an edge offset mesh and its Gauss image: beams of one height that align at all nodes.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)

NEAR, RUN = "Near to a mesh", "Run"

Out = Annotated[Path, typer.Option("-o", "--out", help="Folder to write; must not exist yet.")]
Boosts = Annotated[
    list[str] | None,
    typer.Option("--boost", metavar="X,Y,Z", help="Laguerre boost, shorter than 1, of M and S; may be repeated."),
]
Force = Annotated[bool, typer.Option("--force", help="Replace an earlier result in the folder.", rich_help_panel=RUN)]


@design_app.command("koebe")
def koebe_command(
    context: typer.Context,
    out: Out,
    tiles: Annotated[Tiles, typer.Option(help="Faces of a patch.")] = Tiles.QUADS,
    count: Annotated[int, typer.Option(help="Faces along a side of the patch.")] = 12,
    combinatorics: Annotated[
        Path | None, typer.Option(help="Instead of a patch: mesh file, of which only the faces count, open or closed.")
    ] = None,
    dual: Annotated[bool, typer.Option("--dual", help="Take the dual: faces for vertices.")] = False,
    coverage: Annotated[
        float | None,
        typer.Option(
            help="Part of the sphere that S covers, if open; more bends more. Default: 0.4, saddle of pentagons: 0.2."
        ),
    ] = None,
    bend: Annotated[
        Bend, typer.Option(help="Convex, with edges reversed across a direction, or S itself.")
    ] = Bend.DOME,
    direction: Annotated[float, typer.Option(help="Of a saddle, in degrees from the x axis.")] = 45.0,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """The fairest mesh parallel to a Koebe polyhedron of quads, hexagons, pentagons or faces of your own."""
    with one_sentence():
        check_replaceable(out, force=force)
        if combinatorics:
            _refuse_beside(context, "--combinatorics has faces of its own", "tiles", "count")
        if bend is not Bend.SADDLE:
            _refuse_beside(context, f"--bend {bend} has no direction", "direction")
        design = koebe_design(
            tiles=tiles,
            count=count,
            combinatorics=combinatorics,
            take_dual=dual,
            coverage=coverage,
            bend=bend,
            direction_deg=direction,
        )
        _finish(design, out, boost, force)


@design_app.command("minimal")
def minimal_command(
    context: typer.Context,
    out: Out,
    shape: Annotated[MinimalShape, typer.Option(help="Which surface.")] = MinimalShape.CATENOID,
    faces: Annotated[Faces, typer.Option(help="Of a catenoid.")] = Faces.QUADS,
    count: Annotated[int, typer.Option(help="Faces around a catenoid, or along a side of Enneper's surface.")] = 24,
    turn: Annotated[float, typer.Option(help="Degrees by which normals turn from the middle to the rim.")] = 60.0,
    gauss_image: Annotated[
        Path | None,
        typer.Option(
            help="Instead of a shape: mesh file of a Koebe polyhedron with boundary to be the Gauss image of."
        ),
    ] = None,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """A mesh of mean curvature zero: catenoid, surface of Enneper, or with a Gauss image of your own."""
    with one_sentence():
        check_replaceable(out, force=force)
        if gauss_image:
            _refuse_beside(context, "--gauss-image decides the shape", "shape", "faces", "count", "turn")
        design = minimal_design(shape=shape, faces=faces, count=count, turn_deg=turn, gauss_image=gauss_image)
        _finish(design, out, boost, force)


@design_app.command("cmc")
def cmc_command(
    context: typer.Context,
    out: Out,
    faces: Annotated[Faces, typer.Option(help="Hexagons bulge once; they cannot fold.")] = Faces.QUADS,
    count: Annotated[int, typer.Option(help="Faces around the axis.")] = 24,
    rows: Annotated[int, typer.Option(help="Rows of faces from one inflection to the next.")] = 6,
    folds: Annotated[
        int | None, typer.Option(help="Inflections between bulges and necks. Default: 2 of quads, 0 of hexagons.")
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
        typer.Option(help="Instead of all that: mesh file of an M to stay near to.", rich_help_panel=NEAR),
    ] = None,
    gauss_image: Annotated[Path | None, typer.Option(help="The S of that M.", rich_help_panel=NEAR)] = None,
    mean: Annotated[
        float | None,
        typer.Option(help="Its mean curvature, negative for a dome. Default: the median of M.", rich_help_panel=NEAR),
    ] = None,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """A mesh of constant mean curvature: bulges and necks about an axis as soap films have them, or near to a mesh."""
    with one_sentence():
        check_replaceable(out, force=force)
        if start and gauss_image:
            _refuse_beside(context, "--start decides the shape", "faces", "count", "rows", "folds", "bulge")
            design = cmc_near_design(start, gauss_image, mean=mean)
        elif start or gauss_image or mean is not None:
            raise ProjectError("--start needs the files of both meshes: --start M.obj --gauss-image S.obj")
        else:
            design = cmc_design(faces=faces, count=count, rows=rows, folds=folds, bulge=bulge)
        _finish(design, out, boost, force)


@design_app.command("hexagons")
def hexagons_command(
    surface: Annotated[Path, typer.Argument(metavar="SURFACE", help="Mesh file of a surface, finely meshed.")],
    out: Out,
    count: Annotated[int, typer.Option(help="Hexagons across the normals of the surface.")] = 12,
    curvature: Annotated[int, typer.Option(help="1 or -1: touch only where it bulges, or is a saddle.")] = 0,
    turn: Annotated[
        float | None, typer.Option(help="Degrees by which the hexagons are turned. Default: what suits them best.")
    ] = None,
    flip: Annotated[bool, typer.Option("--flip", help="Turn the outside of the surface round.")] = False,
    boost: Boosts = None,
    force: Force = False,
) -> None:
    """Hexagons with beams of one height whose planes touch a surface."""
    with one_sentence():
        check_replaceable(out, force=force)
        design = hexagons_design(surface, count=count, curvature=curvature, turn_deg=turn, flip=flip)
        _finish(design, out, boost, force)


def _refuse_beside(context: typer.Context, reason: str, *options: str) -> None:
    """Raise ProjectError where one of these options was said, since it would do nothing."""
    for option in options:
        source = context.get_parameter_source(option)
        if source is not None and source.name == "COMMANDLINE":
            raise ProjectError(f"{reason}, so --{option} would do nothing: leave out one of the two")


def _finish(design: EdgeOffsetDesign, out: Path, boosts: list[str] | None, force: bool) -> None:
    """Boost, write and tell."""
    made = design.boosted([_vector(text) for text in boosts or []])
    measures = write_design(made, out, force=force)
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
    for note in made.notes:
        table.add_row("note", told(note))
    OUT.print(table)
    folder = told(str(out))
    unit = " (or the unit of the surface)" if made.has_unit else ""
    OUT.print(Text.assemble("written to ", (folder, "bold"), f"; build it with{unit}"))
    size = "--unit m" if made.has_unit else f"--mean-edge {made.proposed_mean_edge_mm()}"
    mesh, image, built = (_as_typed(path) for path in (out / "M.obj", out / "S.obj", Path(f"{out}-built")))
    OUT.print(f"  fabkit build {mesh} --gauss-image {image} {size} -o {built}")


def _as_typed(path: Path) -> str:
    """As a shell takes it for a path: quoted where it has blanks and the like, and never for an option."""
    text = told(str(path))
    return shlex.quote(f"./{text}" if text.startswith("-") else text)


def _vector(text: str) -> tuple[float, float, float]:
    number = r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*"
    found = re.fullmatch(f"{number},{number},{number}", text)
    if not found:
        raise ProjectError(f"--boost is {text!r}, but needs three numbers such as 0.3,0,-0.1")
    x, y, z = (float(word) for word in found.groups())
    if not max(abs(x), abs(y), abs(z)) < 1e9:  # squares of these are finite
        raise ProjectError(f"--boost is {text!r}, and together its numbers have to be shorter than 1")
    return x, y, z

"""The options that `build` and `inspect` share, and the project that they describe."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fabkit.errors import ProjectError

if TYPE_CHECKING:
    from fabkit.project import Project

__all__ = [
    "Accept",
    "Beam",
    "BoundaryLines",
    "ByteOrderMark",
    "Clearance",
    "Connection",
    "DecimalSign",
    "EdgeLength",
    "EqualWithin",
    "Faces",
    "Flip",
    "GaussImage",
    "Joint",
    "KeepMarks",
    "Lift",
    "Lines",
    "MeanEdge",
    "MeshPath",
    "NestMode",
    "NestSeconds",
    "NodeTop",
    "Optimise",
    "Reference",
    "SectionOfBeams",
    "Separator",
    "Sheet",
    "SkipUnbuildable",
    "Smooth",
    "Strokes",
    "Thickness",
    "Unit",
    "project_of",
    "refuse_beside",
    "settings_of",
]

SIZES, SHOP, RUN, SURFACE = "Sizes (mm)", "Shop", "Run", "Mesh on a design surface"
FILES = "Files"

MeshPath = Annotated[
    Path,
    typer.Argument(
        metavar="MESH",
        help="OBJ, OFF or PLY file of a mesh; a design surface of triangles, also STL or GLB, with --faces or "
        "--edge-length; or a project file (.toml).",
    ),
]
Faces = Annotated[
    int | None,
    typer.Option(
        help="Approximate number of faces of the mesh that is laid on the surface in MESH.", rich_help_panel=SURFACE
    ),
]
EdgeLength = Annotated[
    float | None, typer.Option(help="Instead of --faces: edge length of the quads, in mm.", rich_help_panel=SURFACE)
]
Lines = Annotated[
    str | None,
    typer.Option(
        help="principal: along lines of principal curvature; conjugate: along the best of many conjugate "
        "networks. Default: "
        "principal.",
        rich_help_panel=SURFACE,
    ),
]
BoundaryLines = Annotated[
    str | None,
    typer.Option(
        "--boundary",
        help="open: lines end at the boundary; aligned: the boundary is a line; or open,aligned,... for each boundary "
        "loop, the longest first. Default: open.",
        rich_help_panel=SURFACE,
    ),
]
Strokes = Annotated[
    Path | None,
    typer.Option(
        help="OBJ or DXF file of polylines on the surface, which the lines of the mesh follow.", rich_help_panel=SURFACE
    ),
]
FinerWhereCurved = Annotated[
    float | None,
    typer.Option(
        metavar="RATIO",
        help="How many times longer edges may be where the surface is flattest than where it curves most, 1 to 10, as "
        "far as the lines allow. Default: 1, all of one length.",
        rich_help_panel=SURFACE,
    ),
]
Smooth = Annotated[
    float | None,
    typer.Option(help="Smooth waves of the surface that are shorter than this many mm first.", rich_help_panel=SURFACE),
]
GaussImage = Annotated[
    Path | None,
    typer.Option(help="Mesh file of a Gauss image to build with, parallel to MESH. Default: compute one."),
]
Optimise = Annotated[
    str | None,
    typer.Option(
        metavar="heights|axes",
        help="Optimise mesh and Gauss image together: heights, beams of nearly constant height; axes, node axes within "
        "15 degrees of the normals; or heights,axes. Vertices move. Default: neither.",
    ),
]
Unit = Annotated[str | None, typer.Option(help="Unit of the mesh file: mm, cm, m, in or ft. Never guessed.")]
MeanEdge = Annotated[
    float | None, typer.Option(help="Instead of a unit: scale the mesh so that its mean edge has this many mm.")
]
Flip = Annotated[bool, typer.Option("--flip", help="Reverse all faces, so that the other side is outside.")]
Beam = Annotated[
    str | None,
    typer.Option(
        metavar="WxH",
        help="Instead of --section: width and height of beams that are solid bars.",
        rich_help_panel=SIZES,
    ),
]
SectionOfBeams = Annotated[
    str | None,
    typer.Option(
        "--section",
        metavar="NAME",
        help="Section of the beams, height first: flat 120x12, rhs 120x60x5 (with r10 or rounded: its corners), tee "
        "120x80x10x8, i 120x80x10x8, round 60, chs 60.3x4. Default: rhs 120x60x5.",
        rich_help_panel=SIZES,
    ),
]
Connection = Annotated[
    str | None,
    typer.Option(
        help="How beams meet their nodes: welded, bolted, hub or contact. Default: welded.", rich_help_panel=SIZES
    ),
]
Reference = Annotated[
    str | None,
    typer.Option(
        help="Side of the beams that lies on the mesh: outer, centre or inner; or glass. Default: outer.",
        rich_help_panel=SIZES,
    ),
]
Clearance = Annotated[
    float | None,
    typer.Option(
        help="Added to the minimum setback of beams that are in contact with their nodes. Default: 5.",
        rich_help_panel=SIZES,
    ),
]
NodeTop = Annotated[
    str | None,
    typer.Option(
        help="Tops of node blocks: trimmed along their beams, or enclosing these. Default: trimmed.",
        rich_help_panel=SIZES,
    ),
]
Thickness = Annotated[float | None, typer.Option(help="Thickness of the panels. Default: 8.76.", rich_help_panel=SIZES)]
Joint = Annotated[
    float | None, typer.Option(help="Width of the joints between panels. Default: 20.", rich_help_panel=SIZES)
]
Lift = Annotated[
    float | None,
    typer.Option(
        help="Height of the panels' lower side above the mesh. Default: the minimum that clears beams and "
        "nodes, plus 12.",
        rich_help_panel=SIZES,
    ),
]
Sheet = Annotated[
    str | None, typer.Option(metavar="LxW", help="Stock sheets. Default: 6000x3210.", rich_help_panel=SHOP)
]
NestMode = Annotated[
    str | None,
    typer.Option(help="Nesting of panels on sheets: quick, best or off. Default: quick.", rich_help_panel=SHOP),
]
NestSeconds = Annotated[
    float | None, typer.Option(help="Time limit of --nest best, in s. Default: 60.", rich_help_panel=SHOP)
]
Separator = Annotated[
    str | None,
    typer.Option(metavar="SIGN", help="Between cells of CSV files: , ; tab or |. Default: ,", rich_help_panel=FILES),
]
DecimalSign = Annotated[
    str | None,
    typer.Option("--decimal", metavar="SIGN", help="Decimal sign in CSV files, . or ,", rich_help_panel=FILES),
]
ByteOrderMark = Annotated[
    bool,
    typer.Option("--bom", help="Begin CSV files with a byte order mark, as Excel needs it.", rich_help_panel=FILES),
]
EqualWithin = Annotated[
    float | None,
    typer.Option(
        help="Parts whose corners differ by at most this many mm in each coordinate share a mark, and are made alike; "
        "at most 1. Default: 0.5.",
        rich_help_panel=SHOP,
    ),
]
KeepMarks = Annotated[
    Path | None,
    typer.Option(
        metavar="FOLDER",
        help="Folder of an earlier build, whose marks equal parts keep; others get numbers that it never had.",
        rich_help_panel=SHOP,
    ),
]
Accept = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME",
        help="Accept a finding that would be refused: moves, lean or self-intersection. May be repeated.",
        rich_help_panel=RUN,
    ),
]
SkipUnbuildable = Annotated[
    bool,
    typer.Option(
        "--skip-unbuildable",
        help="Leave out parts that cannot be built, and show them in red, instead of stopping.",
        rich_help_panel=RUN,
    ),
]


def settings_of(
    *,
    beam: str | None = None,
    section: str | None = None,
    connection: str | None = None,
    reference: str | None = None,
    clearance: float | None = None,
    node_top: str | None = None,
    thickness: float | None = None,
    joint: float | None = None,
    lift: float | None = None,
    sheet: str | None = None,
    nest: str | None = None,
    nest_seconds: float | None = None,
    faces: int | None = None,
    edge_length: float | None = None,
    lines: str | None = None,
    boundary: str | None = None,
    strokes: Path | None = None,
    finer_where_curved: float | None = None,
    smooth: float | None = None,
    optimise: str | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    bom: bool = False,
    keep_marks: Path | None = None,
    **whole: Any,
) -> dict[str, Any]:
    """The options that were given, nested as in a project file; whole: keys of the file's first level."""
    outermost = {"thickness_mm": thickness, "joint_mm": joint, "z_mm": lift}
    return _drop_unset(
        {
            **whole,
            "beams": {**_pair("--beam", beam, "width_mm", "height_mm"), "section": section, "reference": reference},
            "connection": {"kind": connection},
            "nodes": {"clearance_mm": clearance, "top": node_top},
            "layers": [layer] if (layer := _drop_unset(outermost)) else [],
            "sheets": _pair("--sheet", sheet, "length_mm", "width_mm"),
            "nesting": {"mode": nest, "seconds": nest_seconds},
            "optimise": {"targets": optimise},
            "marks": {"keep": keep_marks},
            "tables": {"separator": separator, "decimal": decimal, "bom": bom or None},
            "surface": {
                "faces": faces,
                "edge_length_mm": edge_length,
                "lines": lines,
                "boundary": boundary.split(",") if boundary and "," in boundary else boundary,
                "strokes": strokes,
                "finer_where_curved": finer_where_curved,
                "smooth_mm": smooth,
            },
        }
    )


def project_of(mesh: Path, settings: dict[str, Any]) -> Project:
    """The project in a project file, over which the settings win; or of a mesh file and the settings."""
    from fabkit.project import load_project, project_from

    if mesh.suffix.lower() == ".toml":
        return load_project(mesh, settings)
    return project_from({"mesh": mesh, **settings})


def refuse_beside(context: typer.Context, reason: str, *options: str) -> None:
    """Raise ProjectError where one of these options was given, since it would have no effect."""
    for option in options:
        source = context.get_parameter_source(option)
        if source is not None and source.name == "COMMANDLINE":
            raise ProjectError(
                f"{reason}, so --{option.replace('_', '-')} would have no effect: leave out one of the two"
            )


def _drop_unset(settings: dict[str, Any]) -> dict[str, Any]:
    """Settings without those that were not given, on both levels."""
    nested = {k: _drop_unset(v) if isinstance(v, dict) else v for k, v in settings.items()}
    return {key: value for key, value in nested.items() if value is not None and value not in ({}, [])}


def _pair(option: str, text: str | None, first: str, second: str) -> dict[str, float]:
    if text is None:
        return {}
    number = r"\s*(\d+\.?\d*|\.\d+)\s*"
    found = re.fullmatch(f"{number}[xX*]{number}", text)
    if not found:
        raise ProjectError(f"{option} is {text!r}, but needs two sizes in mm such as 50x120")
    return {first: float(found[1]), second: float(found[2])}

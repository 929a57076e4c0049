"""`fabkit planarise`, `offset` and `curvature`: meshes and tables without parts, in the unit and place of the input."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from fabkit.commands.options import RUN, Flip, GaussImage, refuse_beside
from fabkit.commands.terminal import exit_on_error

__all__ = ["curvature_command", "offset_command", "planarise_command"]

PLANARISING = "Planarising"


class Kind(StrEnum):
    """The elements of the offset that have a constant distance from the mesh: edge lines, face planes or vertices."""

    EDGE = "edge"
    FACE = "face"
    VERTEX = "vertex"


class Curvature(StrEnum):
    """The curvature that is shown as colours."""

    MEAN = "mean"
    GAUSSIAN = "gaussian"


MeshFilePath = Annotated[Path, typer.Argument(metavar="MESH", help="OBJ, OFF or PLY file.")]
OutFile = Annotated[Path, typer.Option("-o", "--out", metavar="FILE", help="Mesh file to write: OBJ, OFF or PLY.")]
Fairness = Annotated[
    float | None,
    typer.Option(
        help="Weight of smooth edge polylines, relative to closeness to the given vertices. Default: 0.3.",
        rich_help_panel=PLANARISING,
    ),
]
KeepBoundary = Annotated[
    bool,
    typer.Option(
        "--keep-boundary", help="Vertices of the boundary slide on the curve through them.", rich_help_panel=PLANARISING
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing file.", rich_help_panel=RUN)]


def planarise_command(
    mesh: MeshFilePath,
    out: OutFile,
    flip: Flip = False,
    fairness: Fairness = None,
    keep_boundary: KeepBoundary = False,
    force: Force = False,
) -> None:
    """Write the mesh with planar faces."""
    with exit_on_error():
        from fabkit.commands.mesh_output import write_planar

        write_planar(mesh, out, flip=flip, weights=_weights(fairness, keep_boundary), force=force)


def offset_command(
    context: typer.Context,
    mesh: MeshFilePath,
    distance: Annotated[
        float, typer.Option(help="Distance in the unit of the mesh, outwards; a negative one inwards.")
    ],
    out: OutFile,
    kind: Annotated[
        Kind | None,
        typer.Option(
            help="What has exactly this distance. Default: what the mesh allows; if nothing, faces approximately."
        ),
    ] = None,
    gauss_image: GaussImage = None,
    flip: Flip = False,
    fairness: Fairness = None,
    keep_boundary: KeepBoundary = False,
    force: Force = False,
) -> None:
    """Write the offset M + d S, with planar faces and edges parallel to those of M.

    Faces are made planar if they are not, as in a build.
    """
    with exit_on_error():
        _refuse_weights(context, gauss_image)
        from fabkit.commands.mesh_output import write_offset

        weights = _weights(fairness, keep_boundary)
        write_offset(mesh, out, distance, kind, gauss_image=gauss_image, flip=flip, weights=weights, force=force)


def curvature_command(
    context: typer.Context,
    mesh: MeshFilePath,
    out: Annotated[
        Path,
        typer.Option(
            "-o", "--out", metavar="FILE", help="CSV file of all faces, or mesh file (OBJ, OFF, PLY) with colours."
        ),
    ],
    colour: Annotated[Curvature, typer.Option(help="Curvature shown as colours.")] = Curvature.MEAN,
    gauss_image: GaussImage = None,
    flip: Flip = False,
    fairness: Fairness = None,
    keep_boundary: KeepBoundary = False,
    force: Force = False,
) -> None:
    """Write mean, Gaussian and principal curvatures of the faces with respect to the Gauss image.

    Lengths are in the unit of the mesh. Faces are made planar if they are not, as in a build.
    """
    with exit_on_error():
        _refuse_weights(context, gauss_image)
        if out.suffix.lower() == ".csv":
            refuse_beside(context, "a CSV file has all curvatures and no colours", "colour")
        from fabkit.commands.mesh_output import write_curvature

        weights = _weights(fairness, keep_boundary)
        write_curvature(mesh, out, str(colour), gauss_image=gauss_image, flip=flip, weights=weights, force=force)


def _refuse_weights(context: typer.Context, gauss_image: Path | None) -> None:
    if gauss_image is not None:
        reason = "with --gauss-image the mesh is made planar together with its Gauss image"
        refuse_beside(context, reason, "fairness", "keep_boundary")


def _weights(fairness: float | None, keep_boundary: bool) -> dict[str, float | bool]:
    """The weights that were given."""
    weights: dict[str, float | bool] = {"keep_boundary": True} if keep_boundary else {}
    return weights if fairness is None else weights | {"fairness": fairness}

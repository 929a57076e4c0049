"""A design surface in place of a mesh: the rules for the mesh that is laid on it, and that mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_serializer, model_validator

from fabkit.errors import ProjectError
from fabkit.formats.polylines import read_polylines
from fabkit.rules import Positive
from fabkit.wording import readable
from geometry.arrays import FloatArray, floats
from geometry.errors import GeometryError
from geometry.files import MeshFile
from geometry.layout import Boundary, LaidMesh, lay_quads
from geometry.mesh import Mesh
from geometry.remeshing import study_networks
from geometry.surface import Surface, refined, smoothed

__all__ = ["LaidSurface", "SurfaceRules", "lay_on_surface"]

ALIGNED_DEG = 10.0
"""Angle in degrees from a line of the network up to which an edge counts as lying along it."""


class SurfaceRules(BaseModel):
    """The mesh file is a design surface, on which a mesh of planar quads is laid.

    faces: approximate number of quads; or edge_length_mm: their edge length. lines: "principal", lines of principal
    curvature, along which the heights of the beams vary least on most surfaces; "conjugate", lines of the best of many
    conjugate networks. boundary: "open", lines end at the boundary, or "aligned", the boundary is a line; or one of
    these words for each boundary loop, the longest first. strokes: an OBJ or DXF file of polylines near the surface, in
    its unit, which the lines follow. smooth_mm: waves of the surface shorter than this are smoothed first.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    faces: Annotated[int, Field(ge=4)] | None = None
    edge_length_mm: Positive | None = None
    lines: Literal["principal", "conjugate"] = "principal"
    boundary: Boundary | tuple[Boundary, ...] = "open"
    strokes: Path | None = None
    smooth_mm: Positive | None = None

    @field_serializer("strokes")
    def _name_of_file(self, path: Path | None) -> str | None:
        return None if path is None else readable(path.name)

    @model_validator(mode="after")
    def _one_size(self) -> SurfaceRules:
        if (self.faces is None) == (self.edge_length_mm is None):
            found = "neither is given" if self.faces is None else "both are given"
            raise ValueError(
                "a mesh on a surface needs either its number of faces or their edge length, and "
                f"{found}: give faces (--faces) or edge_length_mm (--edge-length)"
            )
        return self


@dataclass(frozen=True, eq=False)
class LaidSurface:
    """A design surface and the mesh laid on it; lengths in the unit of the file, coordinates near zero.

    surface: smooth, through the vertices of the `n_triangles` triangles in the file. laid: the mesh, before its faces
    are made planar. affine (3, 3): the map whose principal lines the edges follow. largest_smoothing: largest
    displacement of a vertex of the surface by smoothing.
    """

    surface: Surface
    n_triangles: int
    laid: LaidMesh
    lines: str
    affine: FloatArray
    largest_smoothing: float

    @property
    def aligned_share(self) -> float:
        """Share of the inner edges of the mesh within `ALIGNED_DEG` of a line of the network."""
        return float((np.degrees(self.laid.quality.off_network) < ALIGNED_DEG).mean())

    def distances(self, mesh: Mesh) -> FloatArray:
        """(N,) distances of the vertices of a mesh from the surface."""
        feet, _ = self.surface.closest(mesh.vertices)
        return floats(np.linalg.norm(mesh.vertices - feet, axis=1))


def lay_on_surface(
    file: MeshFile, rules: SurfaceRules, mm: float | None, progress: Callable[[float], None] | None = None
) -> tuple[MeshFile, LaidSurface]:
    """The file with the mesh laid on its surface in place of the surface, and the record of it. file: near zero.

    mm: millimetres in a unit of the file, None if the unit is not given. progress: called with the completed share of a
    study of networks. Raises ProjectError for sizes in mm of a file without unit, and GeometryError as `lay_quads`
    does.
    """
    given = Surface(file.mesh)
    largest_smoothing = 0.0
    if rules.smooth_mm is not None:
        without_noise = smoothed(given, _in_unit(rules.smooth_mm, mm, "smooth_mm (--smooth)"))
        given, largest_smoothing = without_noise.surface, float(without_noise.moves.max())
    options: dict[str, Any] = {"boundary": rules.boundary}
    if rules.strokes is not None:
        options["strokes"] = [line - file.origin for line in read_polylines(rules.strokes)]
    affine = np.eye(3)
    if rules.lines == "conjugate":
        best = study_networks(given, progress=progress, **options)[0]
        if best.pair is None:
            raise GeometryError(f"no conjugate network gives a mesh; the first fails because {best.reason}")
        affine = np.array(best.affine)
    size: dict[str, Any] = {"n_faces": rules.faces}
    if rules.edge_length_mm is not None:
        size = {"edge_length": _in_unit(rules.edge_length_mm, mm, "edge_length_mm (--edge-length)")}
    laid = lay_quads(given, **size, affine=affine, **options)
    n_triangles = given.triangulated.n_faces
    return replace(file, mesh=laid.mesh), LaidSurface(
        refined(given), n_triangles, laid, rules.lines, floats(affine), largest_smoothing
    )


def _in_unit(length_mm: float, mm: float | None, name: str) -> float:
    if mm is None:
        raise ProjectError(
            f"{name} is in mm, but the surface has no unit: give unit (--unit), or faces (--faces) with mean_edge_mm "
            "(--mean-edge)"
        )
    return length_mm / mm

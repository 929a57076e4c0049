"""A design surface in place of a mesh: the rules for the mesh that is laid on it, and that mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_serializer, model_validator

from fabkit.errors import ProjectError
from fabkit.formats.polylines import read_polylines
from fabkit.formats.surfaces import EXACT_SUFFIXES, exact_surface, read_shape
from fabkit.formats.surfaces.exact_surfaces import ExactSurface
from fabkit.rules import Positive
from fabkit.wording import readable
from geometry.arrays import FloatArray, floats
from geometry.errors import GeometryError
from geometry.files import MeshFile
from geometry.layout import FEWEST_FACES, LARGEST_LENGTH_RATIO, Boundary, LaidMesh, boundary_lengths, lay_quads
from geometry.mesh import Mesh
from geometry.remeshing import NetworkTrial, remesh, study_networks
from geometry.surface import Surface, refined, smoothed
from geometry.traced_curves import TracedCurves, trace_curves

__all__ = [
    "ExactFile",
    "LaidSurface",
    "SurfaceRules",
    "check_surface",
    "curves_on_surface",
    "design_surface",
    "lay_on_surface",
    "read_exact_file",
]

ALIGNED_DEG = 10.0
"""Angle in degrees from a line of the network up to which an edge counts as lying along it."""


LEAST_SAMPLED_FACES = 1000
"""Faces for which exact surfaces are cut into triangles at least, so that their curvature shows."""

MAX_TRIED_NETWORKS = 5
"""Largest number of networks of a study that are tried with faces of the wanted size, the best first."""

TRIANGLE_EDGE_RATIO = 0.7
"""Length of the edges of those triangles over that of the edges of the mesh: some four triangles a face."""


class SurfaceRules(BaseModel):
    """The mesh file is a design surface, on which a mesh of planar quads is laid.

    faces: approximate number of quads; or edge_length_mm: their edge length. lines: "principal", lines of principal
    curvature, along which the heights of the beams vary least on most surfaces; "conjugate", lines of the best of many
    conjugate networks. boundary: "open", lines end at the boundary, or "aligned", the boundary is a line; or one of
    these words for each boundary loop, the longest first. strokes: an OBJ or DXF file of polylines near the surface, in
    its unit, which the lines follow. finer_where_curved: how many times longer edges may be where the surface is
    flattest than where it curves most, from 1, all of one length, to 10; the report has the lengths that the lines
    allow. smooth_mm: waves of the surface shorter than this are smoothed first.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    faces: Annotated[int, Field(ge=4)] | None = None
    edge_length_mm: Positive | None = None
    lines: Literal["principal", "conjugate"] = "principal"
    boundary: Boundary | tuple[Boundary, ...] = "open"
    strokes: Path | None = None
    finer_where_curved: Annotated[float, Field(ge=1, le=LARGEST_LENGTH_RATIO)] = 1.0
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


def check_surface(rules: SurfaceRules | None, mesh: Any, unit: str | None, *, has_image: bool) -> None:
    """Raise ValueError where the rest of a project contradicts its surface."""
    suffix = mesh.suffix.lower() if isinstance(mesh, Path) else ""
    if suffix in EXACT_SUFFIXES and unit not in (None, "mm"):
        raise ValueError(f"unit (--unit) is {unit}, but {suffix} files have a unit and are read in mm: give mm")
    if rules is not None and has_image:
        raise ValueError(
            "a mesh is laid on a surface by [surface], so that no Gauss image can be given for it: take out "
            "gauss_image.file (--gauss-image), or [surface]"
        )
    if rules is not None and unit is None and rules.faces is None:
        raise ValueError(
            "surface.edge_length_mm (--edge-length) is in mm, but the surface has no unit: give unit (--unit), or the "
            "number of faces (--faces) with mean_edge_mm (--mean-edge)"
        )


@dataclass(frozen=True, eq=False)
class LaidSurface:
    """A design surface and the mesh laid on it; lengths in the unit of the file, coordinates near zero.

    surface: smooth, through the vertices of the `n_triangles` triangles in the file. laid: the mesh, before its faces
    are made planar. affine (3, 3): the map whose principal lines the edges follow. largest_smoothing: largest
    displacement of a vertex of the surface by smoothing. loop_lengths: of the boundary loops of the surface, longest
    first. passed_over: why networks that are better in a study were not taken, or nothing.
    """

    surface: Surface
    n_triangles: int
    laid: LaidMesh
    lines: str
    affine: FloatArray
    largest_smoothing: float
    loop_lengths: FloatArray
    passed_over: str = ""

    @property
    def aligned_share(self) -> float:
        """Share of the inner edges of the mesh within `ALIGNED_DEG` of a line of the network."""
        return float((np.degrees(self.laid.quality.off_network) < ALIGNED_DEG).mean())

    def scaled_surface(self, scale: float) -> Surface:
        """The surface, scaled as the mesh is."""
        return self.surface.moved(scale, np.zeros(3))

    def distances(self, mesh: Mesh) -> FloatArray:
        """(N,) distances of the vertices of a mesh from the surface."""
        feet, _ = self.surface.closest(mesh.vertices)
        return floats(np.linalg.norm(mesh.vertices - feet, axis=1))


@dataclass(frozen=True, eq=False)
class ExactFile(MeshFile):
    """A STEP, IGES or BREP file: triangles on its faces as the mesh, and the exact surface."""

    surface: ExactSurface = field(kw_only=True)

    def near_zero(self) -> ExactFile:
        """As `MeshFile.near_zero`, with the surface."""
        mesh, origin = self.mesh.near_zero()
        moved = self.surface.moved(1.0, -origin)
        return replace(self, mesh=mesh, surface=moved, origin=floats(self.origin + origin))


def read_exact_file(path: Path, rules: SurfaceRules | None, *, flip: bool) -> ExactFile:
    """The exact surface in a STEP, IGES or BREP file, in millimetres, in triangles that are fine enough for the mesh.

    Raises ProjectError where no mesh is to be laid on it, and FabkitError where it cannot be read.
    """
    name = readable(path.name)
    if rules is None:
        raise ProjectError(
            f"{name} holds surfaces, and no mesh: say how many faces are laid on them, by faces (--faces), or how long "
            "their edges are, by edge_length_mm (--edge-length)"
        )

    def edge_length(area: float) -> float:
        count = rules.faces or area / (rules.edge_length_mm or 1.0) ** 2
        return float(np.sqrt(area / max(count, LEAST_SAMPLED_FACES)) * TRIANGLE_EDGE_RATIO)

    file = read_shape(path)
    surface = exact_surface(file.shape, edge_length, name=name)
    surface = surface.reversed() if flip else surface
    return ExactFile(path, surface.mesh, file.notes, file.sha256, surface=surface)


def design_surface(file: MeshFile) -> Surface:
    """The exact surface in a file, or that of its mesh."""
    return file.surface if isinstance(file, ExactFile) else Surface(file.mesh)


def lay_on_surface(
    file: MeshFile, rules: SurfaceRules, mm: float | None, progress: Callable[[float], None] | None = None
) -> tuple[MeshFile, LaidSurface]:
    """The file with the mesh laid on its surface in place of the surface, and the record of it. file: near zero.

    mm: millimetres in a unit of the file, None if the unit is not given. progress: called with the completed share of a
    study of networks. Raises ProjectError for sizes in mm of a file without unit, and GeometryError as `lay_quads`
    does.
    """
    given, largest_smoothing = _without_noise(file, rules, mm)
    line_options = _line_options(file, rules)
    size: dict[str, Any] = {"n_faces": rules.faces}
    if rules.edge_length_mm is not None:
        size = {"edge_length": _edge_length(given, rules.edge_length_mm, mm)}
    affine, passed_over = floats(np.eye(3)), ""
    if rules.lines == "conjugate":
        affine, laid, passed_over = _best_laid(given, _networks(given, line_options, progress), size | line_options)
    else:
        laid = lay_quads(given, **size, affine=affine, **line_options)
    n_triangles, loop_lengths = given.triangulated.n_faces, boundary_lengths(given)
    return replace(file, mesh=laid.mesh), LaidSurface(
        refined(given), n_triangles, laid, rules.lines, affine, largest_smoothing, loop_lengths, passed_over
    )


def _edge_length(surface: Surface, length_mm: float, mm: float | None) -> float:
    """In the unit of the surface. Raises ProjectError where it is too long for the surface."""
    length = _in_unit(length_mm, mm, "edge_length_mm (--edge-length)")
    longest = float(np.sqrt(np.linalg.norm(surface.triangulated.vector_areas, axis=1).sum() / FEWEST_FACES))
    if length > longest:
        raise ProjectError(
            f"edge_length_mm (--edge-length) is {length_mm:g}, but the surface has room for faces of at most "
            f"{longest * (mm or 1.0):.4g} mm: give a shorter length, and check the unit of the surface (--unit)"
        )
    return length


def curves_on_surface(
    file: MeshFile,
    rules: SurfaceRules,
    mm: float | None,
    *,
    asymptotic: bool = False,
    affine: FloatArray | None = None,
    progress: Callable[[float], None] | None = None,
) -> TracedCurves:
    """The curves along which the lines of a mesh would run, traced on the surface as far apart as these, or its
    asymptotic curves. file: near zero.

    affine: the map of the network, where it has been chosen already. Raises as `lay_on_surface` and `trace_curves` do.
    """
    given, _ = _without_noise(file, rules, mm)
    area = float(np.linalg.norm(given.triangulated.vector_areas, axis=1).sum())
    spacing = float(np.sqrt(area / (rules.faces or 1)))
    if rules.edge_length_mm is not None:
        spacing = _in_unit(rules.edge_length_mm, mm, "edge_length_mm (--edge-length)")
    if asymptotic:
        return trace_curves(given, spacing=spacing, kind="asymptotic")
    if affine is None:
        affine = floats(np.eye(3))
        if rules.lines == "conjugate":
            affine = _networks(given, _line_options(file, rules), progress)[0].affine
    return trace_curves(given, spacing=spacing, affine=affine)


def _without_noise(file: MeshFile, rules: SurfaceRules, mm: float | None) -> tuple[Surface, float]:
    """The surface in a file, smoothed where this is asked for, and by how much."""
    given = design_surface(file)
    if rules.smooth_mm is None:
        return given, 0.0
    if given.is_exact:
        raise ProjectError(
            f"smooth_mm (--smooth) takes noise out of triangles, and {readable(file.path.name)} holds exact surfaces: "
            "leave it out"
        )
    without_noise = smoothed(given, _in_unit(rules.smooth_mm, mm, "smooth_mm (--smooth)"))
    return without_noise.surface, float(without_noise.moves.max())


def _line_options(file: MeshFile, rules: SurfaceRules) -> dict[str, Any]:
    options: dict[str, Any] = {"boundary": rules.boundary, "finer_where_curved": rules.finer_where_curved}
    if rules.strokes is not None:
        options["strokes"] = [line - file.origin for line in read_polylines(rules.strokes)]
    return options


def _networks(
    surface: Surface, line_options: dict[str, Any], progress: Callable[[float], None] | None
) -> list[NetworkTrial]:
    """The conjugate networks that give a coarse mesh, the best first."""
    trials = study_networks(surface, progress=progress, **line_options)
    if trials[0].pair is None:
        raise GeometryError(f"no conjugate network gives a mesh; the first fails because {trials[0].reason}")
    return [trial for trial in trials if trial.pair is not None]


def _best_laid(
    surface: Surface, trials: list[NetworkTrial], options: dict[str, Any]
) -> tuple[FloatArray, LaidMesh, str]:
    """The map and the mesh of the first network whose mesh can be made planar, and why those before were passed over:
    finer faces may fold where coarse ones do not."""
    reasons: list[str] = []
    for trial in trials[:MAX_TRIED_NETWORKS]:
        try:
            return trial.affine, remesh(surface, affine=trial.affine, **options).laid, "; ".join(reasons)
        except GeometryError as error:
            reasons.append(error.message)
    raise GeometryError(
        f"none of the {len(reasons)} best conjugate networks gives a planar mesh with faces of this size; the first "
        f"fails because {reasons[0]}"
    )


def _in_unit(length_mm: float, mm: float | None, name: str) -> float:
    if mm is None:
        raise ProjectError(
            f"{name} is in mm, but the surface has no unit: give unit (--unit), or faces (--faces) with mean_edge_mm "
            "(--mean-edge)"
        )
    return length_mm / mm

"""The result of a build: its parts, its figures, and what the manifest says of it."""

from __future__ import annotations

import platform
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import Any

import numpy as np

from fabkit.checking import check_fit
from fabkit.detailing import Detailed
from fabkit.parts import Assembly, Parts
from fabkit.production import BuildFacts, Nest, Summary, SurfaceSummary, build_facts, element_ranks, share_equal_parts
from fabkit.project import Project
from fabkit.surface import LaidSurface
from geometry.files import MeshFile
from geometry.gauss import SupportStructure
from geometry.mesh import Mesh

__all__ = ["Built", "manifest_of", "summary_of"]

PATHS_OF_INPUTS: Any = {
    "mesh": True,
    "out": True,
    "gauss_image": {"file"},
    "marks": {"keep"},
    "layers": {"__all__": {"parallel"}},
}
"""Settings that differ from machine to machine, which the manifest leaves out."""


@dataclass(frozen=True, eq=False)
class Built:
    """The result of `design` or `build`, in memory.

    structure: the pair M and S and the beam height, in mm. assembly: the parts as they are made, those of a mark from
    one solid, near zero; add `assembly.origin_mm` to get the coordinates of the mesh file. nominal: the parts before
    they share solids, whose fit was checked: `violations(built.nominal)` checks it again. nest: None without nesting.
    summary: figures of the mesh. seconds: by stage. sha256: of the mesh file as read, empty for a mesh in memory.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> [len(parts) for parts in built.assembly.groups], built.nest.n_sheets
    ([30, 18, 12], 3)
    >>> [(fact.name, fact.text) for fact in built.facts.sheets][0]
    ('Sheets used', '3')
    """

    project: Project
    structure: SupportStructure
    assembly: Assembly
    nominal: Assembly
    nest: Nest | None
    summary: Summary
    seconds: dict[str, float]
    sha256: str

    def __repr__(self) -> str:
        return f"Built({self.assembly!r})"

    @property
    def facts(self) -> BuildFacts:
        """The facts that report, workbook, terminal and manifest show."""
        return build_facts(self.summary, self.assembly, self.nest)

    def with_parts(self, parts: Parts[Any]) -> Built:
        """The build with the parts of one kind replaced by these; equal ones share a mark. For kinds of one's own.

        Raises DetailingError where they share volume with other parts, or two of them belong to one mesh element.
        """
        nominal = self.nominal.with_group(parts)
        check_fit(nominal)
        within, rules = self.summary.equal_within_mm, self.project.marks
        ranks = element_ranks(self.structure.mesh, rules.order)
        shared = share_equal_parts(nominal, within_mm=within, rules=rules, ranks=ranks, kept=self.summary.earlier_marks)
        return replace(self, assembly=self.assembly.with_group(shared[parts.kind.group]), nominal=nominal)


def summary_of(
    project: Project,
    file: MeshFile,
    laid: LaidSurface | None,
    scale: float,
    structure: SupportStructure,
    detailed: Detailed,
) -> Summary:
    """The figures of a build that are known before its parts have marks. scale: millimetres in a unit of the file."""
    mesh, shade = structure.mesh, detailed.shade
    moves = np.linalg.norm(mesh.vertices - file.mesh.vertices * scale, axis=1)
    return Summary(
        name=project.title,
        source=project.source,
        scale_mm=scale,
        origin=file.origin,
        n_vertices=mesh.n_vertices,
        n_edges=mesh.n_edges,
        n_faces=mesh.n_faces,
        n_boundaries=len(mesh.combinatorics.boundary_loops),
        mended=file.mended,
        planarity_before=float(file.mesh.planarity.max()),
        planarity_after=float(mesh.planarity.max()),
        largest_move_mm=float(moves.max()),
        mean_move_mm=float(moves.mean()),
        farthest_vertex=int(moves.argmax()),
        edge_lengths_mm=mesh.edge_lengths,
        heights=structure.heights,
        leans_deg=np.degrees(structure.pair.leans),
        twists_deg=np.degrees(structure.twists),
        underside_mm=detailed.underside_mm,
        underside_reason=detailed.underside_reason,
        fin_direction=() if shade is None else tuple(shade.shift.tolist()),
        fin_shade=(0.0, 0.0) if shade is None else (shade.before.share, shade.after.share),
        surface=None if laid is None else _surface_summary(laid, mesh, scale),
    )


def _surface_summary(laid: LaidSurface, mesh: Mesh, scale: float) -> SurfaceSummary:
    quality, angles = laid.laid.quality, np.degrees(laid.laid.network.crossing_angles)
    return SurfaceSummary(
        n_triangles=laid.n_triangles,
        lines=laid.lines,
        affine=laid.affine,
        crossing_deg=(float(angles[0]), float(angles[1])),
        quad_share=quality.quad_share,
        valences=quality.valences,
        aligned_share=laid.aligned_share,
        distances_mm=laid.distances(mesh * (1 / scale)) * scale,
        smoothing_mm=laid.largest_smoothing * scale,
        undirected_share=quality.undirected_share,
        loop_lengths_mm=laid.loop_lengths * scale,
    )


def manifest_of(built: Built) -> dict[str, Any]:
    """The contents of manifest.json, without the facts and the list of files."""
    project, summary, assembly = built.project, built.summary, built.assembly
    return {
        "name": summary.name,
        "input": {"file": summary.source, "sha256": built.sha256} if built.sha256 else None,
        "gauss_image": None if summary.gauss_image is None else vars(summary.gauss_image),
        "settings": project.model_dump(mode="json", exclude=PATHS_OF_INPUTS),
        "versions": {
            "fabkit": version("fabkit"),
            "python": platform.python_version(),
            **{name: version(name) for name in ("numpy", "scipy", "ezdxf", "shapely")},
        },
        "origin": {"unit": summary.origin.tolist(), "mm": assembly.origin_mm.tolist()},
        "fitness": [vars(finding) for finding in summary.fitness],
        "mended": list(summary.mended),
        "left_out": [vars(part) for part in assembly.left_out],
    }

"""A designed pair: a mesh M with its Gauss image S, a Koebe polyhedron, and their files [Pottmann2007, 3.2]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.errors import ProjectError
from fabkit.formats import whole_folder, write_manifest
from fabkit.formats.drawings import pair_picture
from fabkit.wording import echo
from geometry.arrays import FloatArray
from geometry.curvature import face_curvatures
from geometry.edge_offset.buildability import face_extents
from geometry.files import write_mesh
from geometry.gauss import Pair, edge_distances
from geometry.mesh import Mesh
from geometry.mesh.intersections import intersecting_faces, self_crossing_faces
from geometry.parallel import parallelity
from geometry.spheres import LaguerreTransformation

__all__ = [
    "KOEBE_TOLERANCE",
    "MAX_FACES_IN_CLOSED_FORM",
    "MAX_FACES_SOLVED_FOR",
    "EdgeOffsetDesign",
    "check_count",
    "check_lengths",
    "check_touching",
    "write_design",
]

MAX_FACES_IN_CLOSED_FORM, MAX_FACES_SOLVED_FOR = 250_000, 20_000
"""Largest number of faces of designs in closed form, which take seconds, and of designs by a solver, which take
minutes."""

LARGEST_PANEL_MM = (3000.0, 5700.0)
"""Largest width and length of faces whose panels fit on sheets of 3210 x 6000 mm."""

KOEBE_TOLERANCE = 1e-5
"""Largest distance of the edges of S from the unit sphere, in radii: the accuracy of files with six digits."""

LEAST_RELATIVE_EDGE_LENGTH = 1e-6
"""Length of an edge over the mean, below which its direction is noise: solvers are accurate to nine digits of the
size."""


@dataclass(frozen=True, eq=False)
class EdgeOffsetDesign:
    """A pair with an S that points outwards.

    kind: the command that made it; settings: its numbers; notes: sentences about it; has_unit: whether M has the unit
    of a given file; is_in_mm: whether its unit is the millimetre. origin (3,): subtracted from the coordinates of a
    given file near which M lies, and added again when M is written. inputs: the files from which it was made, with
    their sha256.

    >>> from fabkit.designs import koebe_design
    >>> leaning = koebe_design(count=4).boosted([(0.3, 0.0, 0.0)])
    >>> leaning.kind, leaning.settings["boosts"], set(leaning.pair.edge_distances.round(9).tolist())
    ('koebe', [[0.3, 0.0, 0.0]], {1.0})
    """

    kind: str
    pair: Pair
    settings: dict[str, Any]
    notes: tuple[str, ...] = ()
    has_unit: bool = False
    is_in_mm: bool = False
    origin: FloatArray | None = None
    inputs: dict[Path, str] = field(default_factory=dict)

    @classmethod
    def of(cls, kind: str, pair: Pair, settings: dict[str, Any]) -> EdgeOffsetDesign:
        """A design whose faces are oriented to the side to which S points."""
        return cls(kind, pair.outwards(), settings)

    @property
    def mesh(self) -> Mesh:
        return self.pair.mesh

    def boosted(self, velocities: Sequence[Sequence[float]]) -> EdgeOffsetDesign:
        """The design after Laguerre boosts, one after the other. Edge offset meshes are mapped to edge offset meshes
        [Pottmann2007, 3.3, Prop. 4, Fig. 10].

        Boosts are about zero, or about the mean of the vertices where M lies near a given mesh: boosts about a distant
        point would move M and change the distance of its planes.

        Raises GeometryError for a velocity of length 1 or more, and where a vertex of S goes to infinity.
        """
        if not velocities:
            return self
        about = np.zeros(3) if self.origin is None else self.mesh.vertices.mean(axis=0)
        pair = self.pair.translated(-about)
        for velocity in velocities:
            pair = pair.laguerre(LaguerreTransformation.boost(velocity))
        settings = self.settings | {"boosts": [list(velocity) for velocity in velocities]}
        return replace(self, pair=pair.translated(about).outwards(), settings=settings)

    def measures(self) -> dict[str, Any]:
        """The figures of an edge offset mesh. mean_curvature: of the faces, in one over the unit of the mesh.

        Raises ProjectError where it is not an edge offset mesh, naming the worst edge of S, or the edge of M that has
        shrunk to a point; GeometryError where a face has no area.
        """
        pair, lengths = self.pair, self.mesh.edge_lengths
        check_lengths(self.mesh)
        check_touching(pair.gauss_image)
        mean = face_curvatures(pair).mean
        return {
            "vertices": self.mesh.n_vertices,
            "edges": self.mesh.n_edges,
            "faces": self.mesh.n_faces,
            "edges_of_s_off_distance_1": float(np.abs(pair.edge_distances - 1).max()),
            "edges_off_parallel": float(parallelity(pair.mesh, pair.gauss_image).max()),
            "faces_off_plane": float(self.mesh.planarity.max()),
            "mean_curvature": {"least": mean.min(), "median": float(np.median(mean)), "largest": mean.max()},
            "edge_lengths": {"least": lengths.min(), "mean": lengths.mean(), "largest": lengths.max()},
            "edges_reversed": int(pair.reversed_edges.sum()),
            "faces_that_cross_themselves": len(self_crossing_faces(self.mesh)),
            "pairs_of_faces_that_meet": len(intersecting_faces(self.mesh)),
        }

    def proposed_mean_edge_mm(self) -> int:
        """A mean edge length of 1500 mm, or less so that panels fit on common sheets: `LARGEST_PANEL_MM`."""
        largest = float((face_extents(self.mesh) / LARGEST_PANEL_MM).max())
        return max(1, min(1500, int(self.mesh.mean_edge_length / largest) // 50 * 50))


def check_lengths(mesh: Mesh) -> None:
    """Raise ProjectError where an edge of M has shrunk to a point."""
    lengths = mesh.edge_lengths / mesh.mean_edge_length
    edge = int(lengths.argmin())
    if not lengths[edge] >= LEAST_RELATIVE_EDGE_LENGTH:
        raise ProjectError(
            f"{mesh.combinatorics.edge_name(edge)} of the mesh has shrunk to {lengths[edge]:.1e} of the mean "
            f"edge length (counted from 0), and at least {LEAST_RELATIVE_EDGE_LENGTH:.0e} is needed: no such mesh has "
            "all these edges; give a start nearer to such a mesh, or other numbers"
        )


def check_count(n_faces: int, most: int) -> None:
    """Raise ProjectError for a number of faces that would take too long."""
    if n_faces > most:
        raise ProjectError(
            f"these counts give {echo(n_faces)} faces, and at most {most} are made in one design: take smaller counts"
        )


def check_touching(gauss_image: Mesh) -> None:
    """Raise ProjectError, naming the worst edge, where S is no Koebe polyhedron to `KOEBE_TOLERANCE`."""
    deviations = np.abs(edge_distances(gauss_image) - 1)
    edge = int(deviations.argmax())
    if not deviations[edge] <= KOEBE_TOLERANCE:
        raise ProjectError(
            f"{gauss_image.combinatorics.edge_name(edge)} of the Gauss image is off the unit sphere by "
            f"{deviations[edge]:.1e} "
            f"of its radius (counted from 0), allowed {KOEBE_TOLERANCE:.0e}, so beams on it do not have one height: "
            "give a Koebe polyhedron, all of whose edges touch the sphere, such as an S.obj, with all its digits"
        )


def write_design(design: EdgeOffsetDesign, out: Path, *, force: bool = False) -> dict[str, Any]:
    """Write M.obj, S.obj, picture.svg and manifest.json into a folder that appears whole or not at all.

    Returns the measures. Raises OutputError where the folder may not be written.

    >>> from fabkit.designs import minimal_design
    >>> measures = write_design(minimal_design(count=12), Path("shell"))
    >>> measures["faces"], sorted(path.name for path in Path("shell").iterdir())
    (48, ['M.obj', 'S.obj', 'manifest.json', 'picture.svg'])
    """
    measures, pair = design.measures(), design.pair
    with whole_folder(out, force=force, inputs=design.inputs) as folder:
        write_mesh(folder / "M.obj", pair.mesh, origin=np.zeros(3) if design.origin is None else design.origin)
        write_mesh(folder / "S.obj", pair.gauss_image)
        caption = (
            f"{design.kind}: {measures['faces']} faces, {measures['edges']} edges, {measures['edges_reversed']} red"
        )
        picture = pair_picture(pair.mesh, pair.gauss_image, pair.reversed_edges, caption)
        (folder / "picture.svg").write_text(picture, encoding="utf-8", newline="\n")
        manifest = {
            "design": design.kind,
            "settings": design.settings,
            "measures": measures,
            "notes": list(design.notes),
            "inputs": {path.name: sha256 for path, sha256 in design.inputs.items()},
            "versions": {name: version(name) for name in ("fabkit", "numpy", "scipy")},
        }
        write_manifest(folder, manifest)
    return measures

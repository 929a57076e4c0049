"""A designed pair: a mesh M with its Gauss image S, a Koebe polyhedron, and their files [Pottmann2007, 3.2]."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.export.folder import MANIFEST, whole_folder
from fabkit.export.picture import pair_picture
from fabkit.gauss_image import points_inwards
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.curvature import face_curvatures
from geometry.edge_offset.laguerre import LaguerreTransformation
from geometry.mesh import Mesh, write_mesh
from geometry.mesh.intersections import intersecting_faces, self_crossing_faces
from geometry.parallel import edge_distances, edge_factors, parallelity

__all__ = ["EdgeOffsetDesign", "largest_piece", "write_design"]

WIDEST_PANEL_MM = (3000.0, 5700.0)
"""Width and length of faces that leave panels for sheets of 3210 x 6000 mm."""


@dataclass(frozen=True, eq=False)
class EdgeOffsetDesign:
    """M and S over one combinatorics, S pointing outwards. kind: which command made it; settings: by which numbers;
    notes: what is to be known of it, a sentence each; has_unit: whether M has the size of something given."""

    kind: str
    mesh: Mesh
    gauss_image: Mesh
    settings: dict[str, Any]
    notes: tuple[str, ...] = ()
    has_unit: bool = False

    @classmethod
    def of(cls, kind: str, mesh: Mesh, gauss_image: Mesh, settings: dict[str, Any]) -> EdgeOffsetDesign:
        """With the faces of both turned to the side to which S points."""
        if points_inwards(mesh, gauss_image):
            mesh, gauss_image = mesh.reversed(), gauss_image.reversed()
        return cls(kind, mesh, gauss_image, settings)

    def boosted(self, velocities: Sequence[Sequence[float]]) -> EdgeOffsetDesign:
        """After Laguerre boosts, one after the other: edge offset meshes stay so [Pottmann2007, 3.3, Prop. 4, Fig. 10].

        Raises GeometryError for a velocity of length 1 or more, and where a vertex of S goes to infinity.
        """
        mesh, gauss_image = self.mesh, self.gauss_image
        for velocity in velocities:
            mesh, gauss_image = LaguerreTransformation.boost(velocity).map_mesh(mesh, gauss_image)
        boosts = {"boosts": [list(velocity) for velocity in velocities]} if velocities else {}
        boosted = EdgeOffsetDesign.of(self.kind, mesh, gauss_image, self.settings | boosts)
        return replace(boosted, notes=self.notes, has_unit=self.has_unit)

    @property
    def reversed_edges(self) -> BoolArray:
        """(E,) which edges of M run against those of S."""
        reversed_edges: BoolArray = edge_factors(self.mesh, self.gauss_image) < 0
        return reversed_edges

    def measures(self) -> dict[str, Any]:
        """What makes it an edge offset mesh, in numbers. mean_curvature: of the faces, one over the unit of the mesh.

        Raises GeometryError where M and S are not parallel, or a face has no area.
        """
        lengths = self.mesh.edge_lengths
        mean = face_curvatures(self.mesh, self.gauss_image).mean
        return {
            "vertices": self.mesh.n_vertices,
            "edges": self.mesh.n_edges,
            "faces": self.mesh.n_faces,
            "edges_of_s_off_distance_1": float(np.abs(edge_distances(self.mesh, self.gauss_image) - 1).max()),
            "edges_off_parallel": float(parallelity(self.mesh, self.gauss_image).max()),
            "faces_off_plane": float(self.mesh.planarity.max()),
            "mean_curvature": {"least": mean.min(), "median": float(np.median(mean)), "largest": mean.max()},
            "edge_lengths": {"least": lengths.min(), "mean": lengths.mean(), "largest": lengths.max()},
            "edges_reversed": int(self.reversed_edges.sum()),
            "faces_that_cross_themselves": len(self_crossing_faces(self.mesh)),
            "pairs_of_faces_that_meet": len(intersecting_faces(self.mesh)),
        }

    def proposed_mean_edge_mm(self) -> int:
        """1500, or less where panels would not go on common sheets: `WIDEST_PANEL_MM`."""
        largest = float((_face_widths(self.mesh) / WIDEST_PANEL_MM).max())
        return max(1, min(1500, int(self.mesh.mean_edge_length / largest) // 50 * 50))


def largest_piece(mesh: Mesh, faces: IntArray) -> IntArray:
    """Those of the faces (k,) that hang together over edges with most others."""
    if not len(faces):
        return faces
    components = mesh.part(faces).combinatorics.face_components
    return np.asarray(faces[components == np.bincount(components).argmax()])


def _face_widths(mesh: Mesh) -> FloatArray:
    """(F, 2) least extent of each face across one of its edges, and largest distance of two of its corners."""
    c = mesh.combinatorics
    widths = np.empty((c.n_faces, 2))
    for faces, corners in c.faces_by_size():
        p = mesh.vertices[c.corners[corners]]
        apart = p[:, None] - p[:, :, None]  # face, from, to
        along = np.roll(p, -1, axis=1) - p
        along /= np.linalg.norm(along, axis=2, keepdims=True)
        across = np.linalg.norm(np.cross(apart, along[:, :, None]), axis=3).max(axis=2)
        widths[faces] = np.stack([across.min(axis=1), np.linalg.norm(apart, axis=3).max(axis=(1, 2))], axis=1)
    return widths


def write_design(design: EdgeOffsetDesign, out: Path, *, force: bool = False) -> dict[str, Any]:
    """Write M.obj, S.obj, picture.svg and manifest.json into a folder that appears whole or not at all.

    Returns the measures. Raises OutputError where the folder may not be written.
    """
    measures = design.measures()
    with whole_folder(out, force=force) as folder:
        for name, mesh in (("M.obj", design.mesh), ("S.obj", design.gauss_image)):
            write_mesh(folder / name, mesh)
        caption = (
            f"{design.kind}: {measures['faces']} faces, {measures['edges']} edges, {measures['edges_reversed']} red"
        )
        picture = pair_picture(design.mesh, design.gauss_image, design.reversed_edges, caption)
        (folder / "picture.svg").write_text(picture, encoding="utf-8", newline="\n")
        manifest = {
            "design": design.kind,
            "settings": design.settings,
            "measures": measures,
            "notes": list(design.notes),
            "sha256": {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())},
            "versions": {name: version(name) for name in ("fabkit", "numpy", "scipy")},
        }
        (folder / MANIFEST).write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
    return measures

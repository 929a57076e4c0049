"""Which faces of a mesh can be built: those that neither cross themselves nor others, nor become too narrow."""

from __future__ import annotations

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.intersections import intersecting_faces, is_embedded, self_crossing_faces

__all__ = [
    "LEAST_FACE_WIDTH",
    "face_extents",
    "largest_buildable_patch",
    "largest_connected_patch",
    "least_face_widths",
    "without_unbuildable_rim",
]

LEAST_FACE_WIDTH = 0.05
"""Least width of a face over the mean edge length: at a mean edge of 1500 mm, room for two beams of 50 mm side by
side, less what mitres take. Joints cut narrower panels of pentagon saddles in two."""


def largest_connected_patch(mesh: Mesh, faces: IntArray) -> IntArray:
    """The largest set of the faces (k,) that is connected by edges."""
    if not len(faces):
        return faces
    components = mesh.part(faces).combinatorics.face_components
    return np.asarray(faces[components == np.bincount(components).argmax()])


def least_face_widths(mesh: Mesh) -> FloatArray:
    """(F,) least distance of a corner of each face from an edge of it that does not end there."""
    c = mesh.combinatorics
    widths = np.empty(c.n_faces)
    for faces, corners in c.faces_by_size():
        tails = mesh.vertices[c.corners[corners]]
        along = np.roll(tails, -1, axis=1) - tails
        from_tails = tails[:, :, None] - tails[:, None]  # face, corner, edge
        squares = np.maximum(np.einsum("fek,fek->fe", along, along), np.finfo(float).tiny)
        place = np.clip(np.einsum("fcek,fek->fce", from_tails, along) / squares[:, None], 0.0, 1.0)
        distances = np.linalg.norm(from_tails - place[..., None] * along[:, None], axis=3)
        own = np.eye(tails.shape[1], dtype=bool)
        distances[:, own | np.roll(own, -1, axis=1)] = np.inf
        widths[faces] = distances.min(axis=(1, 2))
    return widths


def face_extents(mesh: Mesh) -> FloatArray:
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


def without_unbuildable_rim(mesh: Mesh) -> IntArray:
    """The faces that remain when rows at the rim are removed until no face crosses itself or another, or is narrower
    than `LEAST_FACE_WIDTH`; all faces if none remain."""
    kept = np.arange(mesh.n_faces)
    while len(kept):
        part = mesh.part(kept)
        if least_face_widths(part).min() >= LEAST_FACE_WIDTH * part.mean_edge_length and is_embedded(part):
            return kept
        kept = kept[largest_connected_patch(part, part.combinatorics.inner_faces)]
    return np.arange(mesh.n_faces)


def largest_buildable_patch(mesh: Mesh, faces: IntArray) -> IntArray:
    """The largest connected set of the faces (k,) without faces that cross themselves or are narrower than
    `LEAST_FACE_WIDTH`; then faces that meet most others are removed until none meet. All faces if none remain."""
    kept = largest_connected_patch(mesh, _not_narrow(mesh, faces))
    while len(kept):
        met, counts = np.unique(intersecting_faces(mesh.part(kept)), return_counts=True)
        if not len(met):
            return kept
        kept = largest_connected_patch(mesh, np.delete(kept, met[counts == counts.max()]))
    return faces


def _not_narrow(mesh: Mesh, faces: IntArray) -> IntArray:
    """Those of the faces (k,) that are wide enough and do not cross themselves."""
    wide = faces[least_face_widths(mesh)[faces] >= LEAST_FACE_WIDTH * mesh.mean_edge_length]
    return np.asarray(np.setdiff1d(wide, self_crossing_faces(mesh)))

"""Mending of common defects of mesh files, each reported: superfluous vertices, corners and faces, reversed faces."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.errors import MeshError
from geometry.files.clusters import clusters_within, joined
from geometry.files.face_checks import (
    COINCIDENCE_TOLERANCE,
    check_duplicates,
    check_folds,
    check_indices,
    check_manifold,
    check_size,
    check_touching,
    check_without_faces,
)
from geometry.files.face_rings import first_with_same
from geometry.files.orientation import oriented
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.origin import whole_origin

__all__ = ["mend", "mend_polygons", "mended_polygons", "tidied"]

MAX_WELDED_STEPS = 10
"""Largest distance of two vertices that become one, over the tolerance of coincidence. Copies of one vertex are within
one or two steps of each other; vertices joined by more steps are a chain of short edges that has a shape."""


def mend(
    vertices: Any, faces: Iterable[Sequence[int]], *, flip: bool = False, coincidence: float = COINCIDENCE_TOLERANCE
) -> tuple[Mesh, tuple[str, ...]]:
    """The mesh described by positions (N, 3) and faces counted from 0, and a sentence for each thing that was mended.

    - Corners: a vertex that a face names twice in a row, or at its end again, counts once.
    - Faces with fewer than three corners are removed, and so are copies: faces with the same ring of vertices as an
      earlier one, whatever their first vertex and orientation, and connected parts of the mesh all of whose faces
      coincide with others.
    - Unused vertices are removed.
    - Vertices of open edges within `coincidence` times the mean edge length of each other become one (at the
      position of the first), which closes the gaps between faces that do not share their vertices; so do the ends of
      any edge as short as that. Faces that lose corners in this way are removed as above.
    - In each component connected over edges all faces get the same orientation: that of the majority, or of the first
      face if there is none; a component without boundary gets positive volume.
    `flip` reverses all faces at the end.
    Raises MeshError where that does not give a mesh: see the checks of geometry.files.face_checks; also for a surface
    with only one side. Messages count vertices and faces as given, and name the first with each defect; `elements` of
    the error are all of them, counted from 0.

    >>> from geometry.files import mend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]]
    >>> mesh, mended = mend(vertices, [[0, 1, 2, 3], [4, 7, 6, 5]])
    >>> mesh
    Mesh(6 vertices, 2 faces, 7 edges)
    >>> len(mended)  # vertices welded, a face reversed
    2
    """
    return mend_polygons(RawPolygons.from_faces(vertices, faces), flip=flip, coincidence=coincidence)


def mend_polygons(
    raw: RawPolygons, *, flip: bool = False, coincidence: float = COINCIDENCE_TOLERANCE
) -> tuple[Mesh, tuple[str, ...]]:
    """As `mend`, for the raw polygons that a file reader returns."""
    raw = mended_polygons(raw, coincidence)
    mesh = Mesh(raw.vertices, Combinatorics(raw.n_vertices, raw.corners, raw.face_starts))
    if flip:
        return mesh.reversed(), (*raw.mended, "all faces reversed, as requested")
    return mesh, raw.mended


def mended_polygons(raw: RawPolygons, coincidence: float = COINCIDENCE_TOLERANCE) -> RawPolygons:
    """As `mend`, but raw polygons are returned. Faces keep their order; a companion has its vertices in the new order,
    too. Raises MeshError also where vertices would be welded that are not at one point in the companion.
    """
    raw = _drop_unused(tidied(raw))
    origin = whole_origin(raw.vertices)
    mended = _mended_near_zero(replace(raw, vertices=raw.vertices - origin), coincidence)
    return replace(mended, vertices=mended.vertices + origin)


def _mended_near_zero(raw: RawPolygons, coincidence: float) -> RawPolygons:
    """Mending after the origin is subtracted, so that welding and orientation do not depend on the position of the
    mesh."""
    check_size(raw)
    raw = _without_copied_components(raw, coincidence)
    while (welded := _welded(raw, coincidence)) is not raw:
        raw = _without_copies(_with_three_corners(_without_welded_corners(welded), "after welding"))
    raw = _drop_unused(raw)
    check_touching(raw)
    check_duplicates(raw)
    check_manifold(raw)
    check_folds(raw)
    return oriented(raw)


def tidied(raw: RawPolygons) -> RawPolygons:
    """Without defects that the numbers of vertices show: repeated corners and faces, faces with fewer than three
    corners. Raises MeshError for vertices that are not finite, corners that do not exist, and where no face remains.
    """
    check_indices(raw)
    raw = _with_three_corners(_without_doubled_corners(raw), "in the file")
    check_touching(raw)
    return _without_copies(raw)


# --- corners and faces


def _without_doubled_corners(raw: RawPolygons) -> RawPolygons:
    """Without corners that repeat the vertex before them, or the first vertex at the end of a face."""
    doubled = _doubled(raw)
    if doubled.any():
        fault = _repetition_sentence(raw, raw.corner_face[doubled], "named a vertex twice in a row")
        raw = raw.without_corners(doubled, fault)
    closing = _closing(raw)
    if not closing.any():
        return raw
    sentence = f"{closing.sum()} of {raw.n_faces} faces named their first vertex again at the end; dropped"
    return raw.without_corners(closing, sentence)


def _without_welded_corners(raw: RawPolygons) -> RawPolygons:
    """The same after welding, where two corners have become one vertex."""
    doubled = _doubled(raw)
    rest = raw.without_corners(doubled)
    closing = _closing(rest)
    faces = np.concatenate([raw.corner_face[doubled], rest.corner_face[closing]])
    if not len(faces):
        return raw
    return rest.without_corners(closing, _repetition_sentence(raw, faces, "had corners at one place"))


def _doubled(raw: RawPolygons) -> BoolArray:
    """(C,) corners at the same vertex as the one before them."""
    doubled = np.zeros(len(raw.corners), dtype=bool)
    doubled[1:] = (raw.corners[1:] == raw.corners[:-1]) & (raw.corner_face[1:] == raw.corner_face[:-1])
    return doubled


def _closing(raw: RawPolygons) -> BoolArray:
    """(C,) last corners of faces at the same vertex as the first."""
    full = np.flatnonzero(raw.face_sizes > 1)
    last = raw.face_starts[full + 1] - 1
    closing = np.zeros(len(raw.corners), dtype=bool)
    closing[last] = raw.corners[last] == raw.corners[raw.face_starts[full]]
    return closing


def _repetition_sentence(raw: RawPolygons, faces: IntArray, fault: str) -> str:
    faces = np.unique(faces)
    named = f"{len(faces)} of {raw.n_faces} faces {fault}, where once is enough: {raw.face_names(faces)}"
    return f"{named} {raw.counting}"


def _with_three_corners(raw: RawPolygons, when: str) -> RawPolygons:
    """Without faces that have fewer than three corners."""
    small = raw.face_sizes < 3
    if not small.any():
        return raw
    faces = np.flatnonzero(small)
    named = f"{len(faces)} of {raw.n_faces} faces had fewer than three corners {when}; dropped: "
    check_without_faces(raw, small)
    return raw.without_faces(small, f"{named}{raw.face_names(faces)} {raw.counting}")


def _without_copies(raw: RawPolygons) -> RawPolygons:
    """Without faces that repeat the ring of vertices of an earlier face."""
    copies = first_with_same(raw.corners, raw.face_starts) != np.arange(raw.n_faces)
    return raw.without_faces(copies, _copies_sentence(raw, copies)) if copies.any() else raw


def _copies_sentence(raw: RawPolygons, copies: BoolArray) -> str:
    faces = np.flatnonzero(copies)
    named = f"{len(faces)} of {raw.n_faces} faces were written before; dropped: {raw.face_names(faces)}"
    return f"{named} {raw.counting}"


def _without_copied_components(raw: RawPolygons, coincidence: float) -> RawPolygons:
    """Without the components, connected over edges, all of whose faces coincide with faces of other components.
    Faces that two components have in common, such as boxes side by side, are not copies.
    """
    point_number = _point_numbers(raw, _reach(raw, coincidence))
    if len(np.unique(point_number)) == raw.n_vertices:
        return raw
    rings = point_number[raw.corners]
    keys = np.sort(raw.corner_face * raw.n_vertices + rings)
    has_coinciding_corners = np.zeros(raw.n_faces, dtype=bool)  # faces with two corners at one point
    has_coinciding_corners[keys[1:][keys[1:] == keys[:-1]] // raw.n_vertices] = True
    first = first_with_same(rings, raw.face_starts)
    order = np.argsort(raw.corner_edge, kind="stable")
    at_inner_edges = np.flatnonzero(np.diff(raw.corner_edge[order]) == 0)
    component = joined(
        raw.n_faces, raw.corner_face[np.stack([order[at_inner_edges], order[at_inner_edges + 1]], axis=1)]
    )
    copied = ~has_coinciding_corners & (component[first] != component)
    is_copied_component = np.bincount(component, ~copied) == 0
    is_copy = is_copied_component[component]
    return _drop_unused(raw.without_faces(is_copy, _copies_sentence(raw, is_copy))) if is_copy.any() else raw


def _point_numbers(raw: RawPolygons, reach: float) -> IntArray:
    """(N,) a number for the point of each vertex; vertices with the same number coincide, also in the companion."""
    point_number = clusters_within(raw.vertices, reach)
    if raw.companion is None:
        return point_number
    edges = raw.companion[raw.heads] - raw.companion[raw.corners]
    other = clusters_within(raw.companion, reach / _mean_edge(raw) * float(np.linalg.norm(edges, axis=1).mean()))
    return np.unique(np.stack([point_number, other], axis=1), axis=0, return_inverse=True)[1].ravel()


# --- vertices


def _drop_unused(raw: RawPolygons) -> RawPolygons:
    unused = np.count_nonzero(~raw.is_used)
    if not unused:
        return raw
    return raw.without_unused(f"{unused} of {raw.n_vertices} vertices belonged to no face; removed")


def _mean_edge(raw: RawPolygons) -> float:
    return max(float(raw.edge_lengths.mean()), float(np.finfo(float).tiny))


def _reach(raw: RawPolygons, coincidence: float) -> float:
    """The distance up to which vertices coincide; edges as short as that are left out of the mean edge length."""
    lengths = raw.edge_lengths
    longer = lengths[lengths > coincidence * lengths.mean()]
    return coincidence * float(longer.mean()) if len(longer) else 0.0


def _welded(raw: RawPolygons, coincidence: float) -> RawPolygons:
    """With coinciding vertices of open edges merged, and the ends of edges without length.
    Closed parts of a mesh that touch stay separate.
    """
    on_rim = np.zeros(raw.n_vertices, dtype=bool)
    on_rim[raw.corners[raw.is_open]] = on_rim[raw.heads[raw.is_open]] = True
    rim = np.flatnonzero(on_rim)
    reach = _reach(raw, coincidence)
    short = np.flatnonzero(raw.edge_lengths <= reach)
    rim_clusters = clusters_within(raw.vertices[rim], reach)
    at_rim = np.stack([rim, rim[np.unique(rim_clusters, return_index=True)[1][rim_clusters]]], axis=1)
    pairs = np.concatenate([at_rim, np.stack([raw.corners[short], raw.heads[short]], axis=1)])
    label = joined(raw.n_vertices, pairs)
    target = np.unique(label, return_index=True)[1][label]
    others = np.flatnonzero(target != np.arange(raw.n_vertices))
    if not len(others):
        return raw
    unit = _mean_edge(raw)
    moves = np.linalg.norm(raw.vertices - raw.vertices[target], axis=1)
    _check_chains(raw, target, moves, reach)
    _check_companion(raw, target, coincidence)
    sentence = (
        f"{len(others)} of {raw.n_vertices} vertices welded to others at most {moves.max() / unit:.1e} of the mean "
        f"edge length away (tolerance {coincidence:.0e})"
    )
    return raw.with_faces(target[raw.corners], raw.face_starts).without_unused(sentence)


def _check_chains(raw: RawPolygons, target: IntArray, moves: FloatArray, reach: float) -> None:
    """Raise MeshError where vertices would be merged that are farther apart than copies of one vertex."""
    far = np.flatnonzero(moves > MAX_WELDED_STEPS * reach)
    if not len(far):
        return
    worst = int(moves.argmax())
    unit = _mean_edge(raw)
    raise MeshError(
        f"vertices {raw.vertex_name(target[worst])} and {raw.vertex_name(worst)} are {moves[worst] / unit:.2g} of the "
        f"mean edge length apart, but joined by steps of at most {reach / unit:.2g}, which count as no length; make "
        f"these steps longer, or fewer{raw.likewise_vertices(far[far != worst])} {raw.counting}",
        elements=np.union1d(raw.origins[far], raw.origins[target[far]]).tolist(),
        value=float(moves[worst] / unit),
        bound=MAX_WELDED_STEPS * reach / unit,
    )


def _check_companion(raw: RawPolygons, target: IntArray, coincidence: float) -> None:
    """Raise MeshError where vertices would be merged that are apart in the companion."""
    if raw.companion is None:
        return
    edges = raw.companion[raw.heads] - raw.companion[raw.corners]
    bound = coincidence * float(np.linalg.norm(edges, axis=1).mean())
    apart = np.linalg.norm(raw.companion - raw.companion[target], axis=1)
    wrong = np.flatnonzero(apart > bound)
    if not len(wrong):
        return
    worst = int(apart.argmax())
    first, second = raw.vertex_name(target[worst]), raw.vertex_name(worst)
    raise MeshError(
        f"vertices {first} and {second} coincide and would be merged, but in the other mesh they are "
        f"{apart[worst]:.2g} apart, allowed {bound:.2g}: merge them in both files, or move them apart in both"
        f"{raw.likewise_vertices(wrong[wrong != worst])} {raw.counting}",
        elements=np.union1d(raw.origins[wrong], raw.origins[target[wrong]]).tolist(),
        value=float(apart[worst]),
        bound=bound,
    )

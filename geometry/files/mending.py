"""Put right what real mesh files get wrong, and say so: vertices, corners and faces too many, faces turned about."""

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
"""Largest distance of two vertices that become one, over the tolerance of coincidence. Copies of one vertex lie within
a step or two of each other; vertices joined by more such steps are a chain of short edges with its own shape."""


def mend(
    vertices: Any, faces: Iterable[Sequence[int]], *, flip: bool = False, coincidence: float = COINCIDENCE_TOLERANCE
) -> tuple[Mesh, tuple[str, ...]]:
    """The mesh that is meant by positions (N, 3) and faces counted from 0, and what had to be mended for it.

    - Corners: a vertex that a face names twice in a row, or at its end again, counts once.
    - Faces with fewer than three corners are dropped, and so is what is written again: faces with the same ring of
      vertices as one before, from wherever and whichever way they run, and pieces of the mesh all of whose faces
      lie on others.
    - Unused vertices are removed.
    - Vertices of open edges within `coincidence` times the mean edge length of each other become one (the first of them
      stays where it is), which closes the gaps between faces that do not share their vertices; so do the ends of
      any edge as short as that. What then has no corners left is dropped as above.
    - In each component connected over edges all faces are turned to agree: the way most of them run, or the
      first where they are even; a component without boundary gets positive volume.

    `flip` turns everything round at the end.

    Raises MeshError where that does not give a mesh: see the checks of geometry.files.face_checks; a surface with one
    side only. Sentences count vertices and faces as given, and name the first of a kind; the error's `elements` are all
    of them, counted from 0.

    >>> from geometry.files import mend
    >>> vertices = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 0], [2, 0, 0], [2, 1, 0], [1, 1, 0]]
    >>> mesh, mended = mend(vertices, [[0, 1, 2, 3], [4, 7, 6, 5]])
    >>> mesh
    Mesh(6 vertices, 2 faces, 7 edges)
    >>> len(mended)  # vertices welded, a face turned
    2
    """
    return mend_polygons(RawPolygons.from_faces(vertices, faces), flip=flip, coincidence=coincidence)


def mend_polygons(
    raw: RawPolygons, *, flip: bool = False, coincidence: float = COINCIDENCE_TOLERANCE
) -> tuple[Mesh, tuple[str, ...]]:
    """As `mend`, for what a file reader returns."""
    raw = mended_polygons(raw, coincidence)
    mesh = Mesh(raw.vertices, Combinatorics(raw.n_vertices, raw.corners, raw.face_starts))
    if flip:
        return mesh.reversed(), (*raw.mended, "all faces turned round, as asked")
    return mesh, raw.mended


def mended_polygons(raw: RawPolygons, coincidence: float = COINCIDENCE_TOLERANCE) -> RawPolygons:
    """As `mend`, before it becomes a mesh: faces keep their order, and a companion its vertices beside theirs.

    Raises MeshError also where vertices are to become one that are apart in the companion.
    """
    raw = _drop_unused(tidied(raw))
    origin = whole_origin(raw.vertices)
    mended = _mended_near_zero(replace(raw, vertices=raw.vertices - origin), coincidence)
    return replace(mended, vertices=mended.vertices + origin)


def _mended_near_zero(raw: RawPolygons, coincidence: float) -> RawPolygons:
    """What is welded and turned round must not depend on where a mesh lies, so its origin is taken out before."""
    check_size(raw)
    raw = _without_pieces_written_again(raw, coincidence)
    while (welded := _welded(raw, coincidence)) is not raw:
        raw = _without_copies(_with_three_corners(_without_welded_corners(welded), "after welding"))
    raw = _drop_unused(raw)
    check_touching(raw)
    check_duplicates(raw)
    check_manifold(raw)
    check_folds(raw)
    return oriented(raw)


def tidied(raw: RawPolygons) -> RawPolygons:
    """What the numbers of the vertices alone show: corners and faces that are written twice, faces that are none.

    Raises MeshError for vertices that are not finite, corners that do not exist, and where no face is left.
    """
    check_indices(raw)
    raw = _with_three_corners(_without_doubled_corners(raw), "in the file")
    check_touching(raw)
    return _without_copies(raw)


# --- corners and faces


def _without_doubled_corners(raw: RawPolygons) -> RawPolygons:
    """No face names a vertex twice in a row, nor its first one again at the end."""
    doubled = _doubled(raw)
    if doubled.any():
        fault = _once_enough(raw, raw.corner_face[doubled], "named a vertex twice in a row")
        raw = raw.without_corners(doubled, fault)
    closing = _closing(raw)
    if not closing.any():
        return raw
    sentence = f"{closing.sum()} of {raw.n_faces} faces named their first vertex again at the end; dropped"
    return raw.without_corners(closing, sentence)


def _without_welded_corners(raw: RawPolygons) -> RawPolygons:
    """The same where corners have become one."""
    doubled = _doubled(raw)
    rest = raw.without_corners(doubled)
    closing = _closing(rest)
    faces = np.concatenate([raw.corner_face[doubled], rest.corner_face[closing]])
    if not len(faces):
        return raw
    return rest.without_corners(closing, _once_enough(raw, faces, "had corners at one place"))


def _doubled(raw: RawPolygons) -> BoolArray:
    """(C,) corners at the same vertex as the one before them."""
    doubled = np.zeros(len(raw.corners), dtype=bool)
    doubled[1:] = (raw.corners[1:] == raw.corners[:-1]) & (raw.corner_face[1:] == raw.corner_face[:-1])
    return doubled


def _closing(raw: RawPolygons) -> BoolArray:
    """(C,) last corners at the same vertex as the first."""
    full = np.flatnonzero(raw.face_sizes > 1)
    last = raw.face_starts[full + 1] - 1
    closing = np.zeros(len(raw.corners), dtype=bool)
    closing[last] = raw.corners[last] == raw.corners[raw.face_starts[full]]
    return closing


def _once_enough(raw: RawPolygons, faces: IntArray, fault: str) -> str:
    faces = np.unique(faces)
    named = f"{len(faces)} of {raw.n_faces} faces {fault}, where once is enough: {raw.face_names(faces)}"
    return f"{named} {raw.counting}"


def _with_three_corners(raw: RawPolygons, when: str) -> RawPolygons:
    """The faces with three corners and more."""
    small = raw.face_sizes < 3
    if not small.any():
        return raw
    faces = np.flatnonzero(small)
    named = f"{len(faces)} of {raw.n_faces} faces had fewer than three corners {when}; dropped: "
    check_without_faces(raw, small)
    return raw.without_faces(small, f"{named}{raw.face_names(faces)} {raw.counting}")


def _without_copies(raw: RawPolygons) -> RawPolygons:
    """Each ring of vertices once, the first time that it is written."""
    copies = first_with_same(raw.corners, raw.face_starts) != np.arange(raw.n_faces)
    return raw.without_faces(copies, _written_again(raw, copies)) if copies.any() else raw


def _written_again(raw: RawPolygons, copies: BoolArray) -> str:
    faces = np.flatnonzero(copies)
    named = f"{len(faces)} of {raw.n_faces} faces were written before; dropped: {raw.face_names(faces)}"
    return f"{named} {raw.counting}"


def _without_pieces_written_again(raw: RawPolygons, coincidence: float) -> RawPolygons:
    """Without the components, connected over edges, all of whose faces lie on faces of others, corner on corner.

    Faces that two components share, as boxes that stand side by side do, are not copies.
    """
    place = _places(raw, _reach(raw, coincidence))
    if len(np.unique(place)) == raw.n_vertices:
        return raw
    rings = place[raw.corners]
    keys = np.sort(raw.corner_face * raw.n_vertices + rings)
    slit = np.zeros(raw.n_faces, dtype=bool)  # with two corners at one place
    slit[keys[1:][keys[1:] == keys[:-1]] // raw.n_vertices] = True
    first = first_with_same(rings, raw.face_starts)
    order = np.argsort(raw.corner_edge, kind="stable")
    meet = np.flatnonzero(np.diff(raw.corner_edge[order]) == 0)
    component = joined(raw.n_faces, raw.corner_face[np.stack([order[meet], order[meet + 1]], axis=1)])
    copied = ~slit & (component[first] != component)
    whole = np.bincount(component, ~copied) == 0
    again = whole[component]
    return _drop_unused(raw.without_faces(again, _written_again(raw, again))) if again.any() else raw


def _places(raw: RawPolygons, reach: float) -> IntArray:
    """(N,) a number for the place of each vertex, in the companion too."""
    place = clusters_within(raw.vertices, reach)
    if raw.companion is None:
        return place
    edges = raw.companion[raw.heads] - raw.companion[raw.corners]
    other = clusters_within(raw.companion, reach / _mean_edge(raw) * float(np.linalg.norm(edges, axis=1).mean()))
    return np.unique(np.stack([place, other], axis=1), axis=0, return_inverse=True)[1].ravel()


# --- vertices


def _drop_unused(raw: RawPolygons) -> RawPolygons:
    unused = np.count_nonzero(~raw.is_used)
    if not unused:
        return raw
    return raw.without_unused(f"{unused} of {raw.n_vertices} vertices belonged to no face; removed")


def _mean_edge(raw: RawPolygons) -> float:
    return max(float(raw.edge_lengths.mean()), float(np.finfo(float).tiny))


def _reach(raw: RawPolygons, coincidence: float) -> float:
    """The distance up to which vertices are one; edges as short as that say nothing of the size of the mesh."""
    lengths = raw.edge_lengths
    longer = lengths[lengths > coincidence * lengths.mean()]
    return coincidence * float(longer.mean()) if len(longer) else 0.0


def _welded(raw: RawPolygons, coincidence: float) -> RawPolygons:
    """Make one vertex of those of open edges that coincide, and of the ends of edges without length.

    Closed parts of a mesh that touch are left as they are.
    """
    on_rim = np.zeros(raw.n_vertices, dtype=bool)
    on_rim[raw.corners[raw.is_open]] = on_rim[raw.heads[raw.is_open]] = True
    rim = np.flatnonzero(on_rim)
    reach = _reach(raw, coincidence)
    short = np.flatnonzero(raw.edge_lengths <= reach)
    together = clusters_within(raw.vertices[rim], reach)
    at_rim = np.stack([rim, rim[np.unique(together, return_index=True)[1][together]]], axis=1)
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
    """What becomes one vertex is no longer than copies of one are apart."""
    far = np.flatnonzero(moves > MAX_WELDED_STEPS * reach)
    if not len(far):
        return
    worst = int(moves.argmax())
    unit = _mean_edge(raw)
    raise MeshError(
        f"vertices {raw.vertex_name(target[worst])} and {raw.vertex_name(worst)} are {moves[worst] / unit:.2g} of "
        f"the mean edge length apart, but joined by steps of at most {reach / unit:.2g}, which count as none; make "
        f"these longer, or fewer{raw.likewise_vertices(far[far != worst])} "
        f"{raw.counting}",
        elements=np.union1d(raw.origins[far], raw.origins[target[far]]).tolist(),
        value=float(moves[worst] / unit),
        bound=MAX_WELDED_STEPS * reach / unit,
    )


def _check_companion(raw: RawPolygons, target: IntArray, coincidence: float) -> None:
    """Vertices that become one must be one in the companion too."""
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
        f"vertices {first} and {second} lie at one point and would become one, but in the other mesh they are "
        f"{apart[worst]:.2g} apart, allowed {bound:.2g}: make them one vertex in both files, or move them apart in both"
        f"{raw.likewise_vertices(wrong[wrong != worst])} {raw.counting}",
        elements=np.union1d(raw.origins[wrong], raw.origins[target[wrong]]).tolist(),
        value=float(apart[worst]),
        bound=bound,
    )

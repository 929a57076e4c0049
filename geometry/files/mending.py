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
    COINCIDENCE,
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
from geometry.files.polygon_soup import PolygonSoup
from geometry.mesh import Combinatorics, Mesh
from geometry.mesh.origin import whole_origin

__all__ = ["mend", "mend_soup", "mended_soup", "tidied"]

# Vertices that are welded lie at most this many times the coincidence apart. Copies of one vertex lie within a step or
# two of each other; what goes on for longer in such steps is a chain of short edges, with a shape of its own.
LONGEST_CHAIN = 10


def mend(
    vertices: Any, faces: Iterable[Sequence[int]], *, flip: bool = False, coincidence: float = COINCIDENCE
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
    """
    return mend_soup(PolygonSoup.from_faces(vertices, faces), flip=flip, coincidence=coincidence)


def mend_soup(
    soup: PolygonSoup, *, flip: bool = False, coincidence: float = COINCIDENCE
) -> tuple[Mesh, tuple[str, ...]]:
    """As `mend`, for what a file reader returns."""
    soup = mended_soup(soup, coincidence)
    mesh = Mesh(soup.vertices, Combinatorics(soup.n_vertices, soup.corners, soup.face_starts))
    if flip:
        return mesh.reversed(), (*soup.mended, "all faces turned round, as asked")
    return mesh, soup.mended


def mended_soup(soup: PolygonSoup, coincidence: float = COINCIDENCE) -> PolygonSoup:
    """As `mend`, before it becomes a mesh: faces keep their order, and a companion its vertices beside theirs.

    Raises MeshError also where vertices are to become one that are apart in the companion.
    """
    soup = _drop_unused(tidied(soup))
    origin = whole_origin(soup.vertices)
    mended = _mended_near_zero(replace(soup, vertices=soup.vertices - origin), coincidence)
    return replace(mended, vertices=mended.vertices + origin)


def _mended_near_zero(soup: PolygonSoup, coincidence: float) -> PolygonSoup:
    """What is welded and turned round must not depend on where a mesh lies, so its origin is taken out before."""
    check_size(soup)
    soup = _without_pieces_written_again(soup, coincidence)
    while (welded := _welded(soup, coincidence)) is not soup:
        soup = _without_copies(_with_three_corners(_without_welded_corners(welded), "after welding"))
    soup = _drop_unused(soup)
    check_touching(soup)
    check_duplicates(soup)
    check_manifold(soup)
    check_folds(soup)
    return oriented(soup)


def tidied(soup: PolygonSoup) -> PolygonSoup:
    """What the numbers of the vertices alone show: corners and faces that are written twice, faces that are none.

    Raises MeshError for vertices that are not finite, corners that do not exist, and where no face is left.
    """
    check_indices(soup)
    soup = _with_three_corners(_without_doubled_corners(soup), "in the file")
    check_touching(soup)
    return _without_copies(soup)


# --- corners and faces


def _without_doubled_corners(soup: PolygonSoup) -> PolygonSoup:
    """No face names a vertex twice in a row, nor its first one again at the end."""
    doubled = _doubled(soup)
    if doubled.any():
        fault = _once_enough(soup, soup.corner_face[doubled], "named a vertex twice in a row")
        soup = soup.without_corners(doubled, fault)
    closing = _closing(soup)
    if not closing.any():
        return soup
    sentence = f"{closing.sum()} of {soup.n_faces} faces named their first vertex again at the end; dropped"
    return soup.without_corners(closing, sentence)


def _without_welded_corners(soup: PolygonSoup) -> PolygonSoup:
    """The same where corners have become one."""
    doubled = _doubled(soup)
    rest = soup.without_corners(doubled)
    closing = _closing(rest)
    faces = np.concatenate([soup.corner_face[doubled], rest.corner_face[closing]])
    if not len(faces):
        return soup
    return rest.without_corners(closing, _once_enough(soup, faces, "had corners at one place"))


def _doubled(soup: PolygonSoup) -> BoolArray:
    """(C,) corners at the same vertex as the one before them."""
    doubled = np.zeros(len(soup.corners), dtype=bool)
    doubled[1:] = (soup.corners[1:] == soup.corners[:-1]) & (soup.corner_face[1:] == soup.corner_face[:-1])
    return doubled


def _closing(soup: PolygonSoup) -> BoolArray:
    """(C,) last corners at the same vertex as the first."""
    full = np.flatnonzero(soup.face_sizes > 1)
    last = soup.face_starts[full + 1] - 1
    closing = np.zeros(len(soup.corners), dtype=bool)
    closing[last] = soup.corners[last] == soup.corners[soup.face_starts[full]]
    return closing


def _once_enough(soup: PolygonSoup, faces: IntArray, fault: str) -> str:
    faces = np.unique(faces)
    named = f"{len(faces)} of {soup.n_faces} faces {fault}, where once is enough: {soup.face_names(faces)}"
    return f"{named} {soup.counting}"


def _with_three_corners(soup: PolygonSoup, when: str) -> PolygonSoup:
    """The faces with three corners and more."""
    small = soup.face_sizes < 3
    if not small.any():
        return soup
    faces = np.flatnonzero(small)
    named = f"{len(faces)} of {soup.n_faces} faces had fewer than three corners {when}; dropped: "
    check_without_faces(soup, small)
    return soup.without_faces(small, f"{named}{soup.face_names(faces)} {soup.counting}")


def _without_copies(soup: PolygonSoup) -> PolygonSoup:
    """Each ring of vertices once, the first time that it is written."""
    copies = first_with_same(soup.corners, soup.face_starts) != np.arange(soup.n_faces)
    return soup.without_faces(copies, _written_again(soup, copies)) if copies.any() else soup


def _written_again(soup: PolygonSoup, copies: BoolArray) -> str:
    faces = np.flatnonzero(copies)
    named = f"{len(faces)} of {soup.n_faces} faces were written before; dropped: {soup.face_names(faces)}"
    return f"{named} {soup.counting}"


def _without_pieces_written_again(soup: PolygonSoup, coincidence: float) -> PolygonSoup:
    """Without the components, connected over edges, all of whose faces lie on faces of others, corner on corner.

    Faces that two components share, as boxes that stand side by side do, are not copies.
    """
    place = _places(soup, _reach(soup, coincidence))
    if len(np.unique(place)) == soup.n_vertices:
        return soup
    rings = place[soup.corners]
    keys = np.sort(soup.corner_face * soup.n_vertices + rings)
    slit = np.zeros(soup.n_faces, dtype=bool)  # with two corners at one place
    slit[keys[1:][keys[1:] == keys[:-1]] // soup.n_vertices] = True
    first = first_with_same(rings, soup.face_starts)
    order = np.argsort(soup.corner_edge, kind="stable")
    meet = np.flatnonzero(np.diff(soup.corner_edge[order]) == 0)
    component = joined(soup.n_faces, soup.corner_face[np.stack([order[meet], order[meet + 1]], axis=1)])
    copied = ~slit & (component[first] != component)
    whole = np.bincount(component, ~copied) == 0
    again = whole[component]
    return _drop_unused(soup.without_faces(again, _written_again(soup, again))) if again.any() else soup


def _places(soup: PolygonSoup, reach: float) -> IntArray:
    """(N,) a number for the place of each vertex, in the companion too."""
    place = clusters_within(soup.vertices, reach)
    if soup.companion is None:
        return place
    edges = soup.companion[soup.heads] - soup.companion[soup.corners]
    other = clusters_within(soup.companion, reach / _mean_edge(soup) * float(np.linalg.norm(edges, axis=1).mean()))
    return np.unique(np.stack([place, other], axis=1), axis=0, return_inverse=True)[1].ravel()


# --- vertices


def _drop_unused(soup: PolygonSoup) -> PolygonSoup:
    unused = np.count_nonzero(~soup.is_used)
    if not unused:
        return soup
    return soup.without_unused(f"{unused} of {soup.n_vertices} vertices belonged to no face; removed")


def _mean_edge(soup: PolygonSoup) -> float:
    return max(float(soup.edge_lengths.mean()), float(np.finfo(float).tiny))


def _reach(soup: PolygonSoup, coincidence: float) -> float:
    """The distance up to which vertices are one; edges as short as that say nothing of the size of the mesh."""
    lengths = soup.edge_lengths
    longer = lengths[lengths > coincidence * lengths.mean()]
    return coincidence * float(longer.mean()) if len(longer) else 0.0


def _welded(soup: PolygonSoup, coincidence: float) -> PolygonSoup:
    """Make one vertex of those of open edges that coincide, and of the ends of edges without length.

    Closed parts of a mesh that touch are left as they are.
    """
    on_rim = np.zeros(soup.n_vertices, dtype=bool)
    on_rim[soup.corners[soup.is_open]] = on_rim[soup.heads[soup.is_open]] = True
    rim = np.flatnonzero(on_rim)
    reach = _reach(soup, coincidence)
    short = np.flatnonzero(soup.edge_lengths <= reach)
    together = clusters_within(soup.vertices[rim], reach)
    at_rim = np.stack([rim, rim[np.unique(together, return_index=True)[1][together]]], axis=1)
    pairs = np.concatenate([at_rim, np.stack([soup.corners[short], soup.heads[short]], axis=1)])
    label = joined(soup.n_vertices, pairs)
    target = np.unique(label, return_index=True)[1][label]
    others = np.flatnonzero(target != np.arange(soup.n_vertices))
    if not len(others):
        return soup
    unit = _mean_edge(soup)
    moves = np.linalg.norm(soup.vertices - soup.vertices[target], axis=1)
    _check_chains(soup, target, moves, reach)
    _check_companion(soup, target, coincidence)
    sentence = (
        f"{len(others)} of {soup.n_vertices} vertices welded to others at most {moves.max() / unit:.1e} of the mean "
        f"edge length away (tolerance {coincidence:.0e})"
    )
    return soup.with_faces(target[soup.corners], soup.face_starts).without_unused(sentence)


def _check_chains(soup: PolygonSoup, target: IntArray, moves: FloatArray, reach: float) -> None:
    """What becomes one vertex is no longer than copies of one are apart."""
    far = np.flatnonzero(moves > LONGEST_CHAIN * reach)
    if not len(far):
        return
    worst = int(moves.argmax())
    unit = _mean_edge(soup)
    raise MeshError(
        f"vertices {soup.vertex_name(target[worst])} and {soup.vertex_name(worst)} are {moves[worst] / unit:.2g} of "
        f"the mean edge length apart, but joined by steps of at most {reach / unit:.2g}, which count as none; make "
        f"these longer, or fewer{soup.likewise_vertices(far[far != worst])} "
        f"{soup.counting}",
        elements=np.union1d(soup.origins[far], soup.origins[target[far]]).tolist(),
        value=float(moves[worst] / unit),
        bound=LONGEST_CHAIN * reach / unit,
    )


def _check_companion(soup: PolygonSoup, target: IntArray, coincidence: float) -> None:
    """Vertices that become one must be one in the companion too."""
    if soup.companion is None:
        return
    edges = soup.companion[soup.heads] - soup.companion[soup.corners]
    bound = coincidence * float(np.linalg.norm(edges, axis=1).mean())
    apart = np.linalg.norm(soup.companion - soup.companion[target], axis=1)
    wrong = np.flatnonzero(apart > bound)
    if not len(wrong):
        return
    worst = int(apart.argmax())
    first, second = soup.vertex_name(target[worst]), soup.vertex_name(worst)
    raise MeshError(
        f"vertices {first} and {second} lie at one point and would become one, but in the other mesh they are "
        f"{apart[worst]:.2g} apart, allowed {bound:.2g}: make them one vertex in both files, or move them apart in both"
        f"{soup.likewise_vertices(wrong[wrong != worst])} {soup.counting}",
        elements=np.union1d(soup.origins[wrong], soup.origins[target[wrong]]).tolist(),
        value=float(apart[worst]),
        bound=bound,
    )

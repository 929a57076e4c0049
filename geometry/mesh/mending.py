"""Put right what real mesh files get wrong, and say so: copies of vertices, unused ones, faces turned about."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any, NoReturn

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.errors import MeshError
from geometry.mesh.checks import (
    COINCIDENCE,
    check_duplicates,
    check_edges,
    check_folds,
    check_indices,
    check_manifold,
    check_touching,
)
from geometry.mesh.combinatorics import Combinatorics
from geometry.mesh.mesh import Mesh
from geometry.mesh.origin import whole_origin
from geometry.mesh.soup import PolygonSoup

__all__ = ["drop_closing_corners", "mend", "mend_soup", "mended_soup"]


def mend(
    vertices: Any, faces: Iterable[Sequence[int]], *, flip: bool = False, coincidence: float = COINCIDENCE
) -> tuple[Mesh, tuple[str, ...]]:
    """The mesh that is meant by positions (N, 3) and faces counted from 0, and what had to be mended for it.

    A last corner equal to the first is dropped. Vertices of open edges within `coincidence` times the mean edge
    length of each other become one (the first of them stays where it is), which closes the gaps between faces that
    do not share their vertices. Unused vertices are removed. In each component connected over edges all faces are
    turned to agree: the way most of them run, or the first where they are even; a component without boundary gets
    positive volume. `flip` turns everything round at the end.

    Raises MeshError where that does not give a mesh: see the checks of geometry.mesh.checks; a surface with one
    side only. Sentences count vertices and faces as given; the error's `elements` count from 0.
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
    check_indices(soup)
    soup = drop_closing_corners(soup)
    check_indices(soup)
    origin = whole_origin(soup.vertices[soup.is_used])
    mended = _mended_near_zero(replace(soup, vertices=soup.vertices - origin), coincidence)
    return replace(mended, vertices=mended.vertices + origin)


def _mended_near_zero(soup: PolygonSoup, coincidence: float) -> PolygonSoup:
    """What is welded and turned round must not depend on where a mesh lies, so its origin is taken out before."""
    check_touching(soup)
    soup = _drop_unused(soup)
    check_edges(soup, coincidence)
    soup = _weld(soup, coincidence)
    check_touching(soup)
    check_duplicates(soup)
    check_manifold(soup)
    check_folds(soup)
    return _orient(soup)


def drop_closing_corners(soup: PolygonSoup) -> PolygonSoup:
    """Faces written as closed polygons: the last corner repeats the first."""
    last = soup.face_starts[1:] - 1
    closed = soup.corners[soup.face_starts[:-1]] == soup.corners[last]
    if not closed.any():
        return soup
    keep = np.ones(len(soup.corners), dtype=bool)
    keep[last[closed]] = False
    starts = np.concatenate([[0], np.cumsum(soup.face_sizes - closed)])
    sentence = f"{closed.sum()} of {soup.n_faces} faces named their first vertex again at the end; dropped"
    return soup.with_faces(soup.corners[keep], starts, sentence)


def _drop_unused(soup: PolygonSoup) -> PolygonSoup:
    unused = np.count_nonzero(~soup.is_used)
    if not unused:
        return soup
    return soup.without_unused(f"{unused} of {soup.n_vertices} vertices belonged to no face; removed")


def _weld(soup: PolygonSoup, coincidence: float) -> PolygonSoup:
    """Make one vertex of those of open edges that coincide; closed parts of a mesh are left as they are."""
    on_rim = np.zeros(soup.n_vertices, dtype=bool)
    on_rim[soup.corners[soup.is_open]] = on_rim[soup.heads[soup.is_open]] = True
    rim = np.flatnonzero(on_rim)
    unit = float(soup.edge_lengths.mean())
    pairs = cKDTree(soup.vertices[rim]).query_pairs(coincidence * unit, output_type="ndarray")
    if not len(pairs):
        return soup
    graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(rim), len(rim)))
    clusters = connected_components(graph, directed=False)[1]
    target = np.arange(soup.n_vertices)
    target[rim] = rim[np.unique(clusters, return_index=True)[1][clusters]]
    _check_companion(soup, target, coincidence)
    moved = np.linalg.norm(soup.vertices - soup.vertices[target], axis=1).max() / unit
    sentence = (
        f"{(target != np.arange(soup.n_vertices)).sum()} of {soup.n_vertices} vertices welded to others at most "
        f"{moved:.1e} of the mean edge length away (tolerance {coincidence:.0e})"
    )
    return soup.with_faces(target[soup.corners], soup.face_starts).without_unused(sentence)


def _check_companion(soup: PolygonSoup, target: IntArray, coincidence: float) -> None:
    """Vertices that become one must be one in the companion too."""
    if soup.companion is None:
        return
    edges = soup.companion[soup.heads] - soup.companion[soup.corners]
    bound = coincidence * float(np.linalg.norm(edges, axis=1).mean())
    apart = np.linalg.norm(soup.companion - soup.companion[target], axis=1)
    worst = int(apart.argmax())
    if apart[worst] > bound:
        first, second = soup.vertex_name(target[worst]), soup.vertex_name(worst)
        raise MeshError(
            f"vertices {first} and {second} lie at one point of a boundary and would become one, but in the other mesh "
            f"they are {apart[worst]:.2g} apart, allowed {bound:.2g}: make them one vertex in both files, or move them "
            f"apart in both {soup.counting}",
            elements=[int(soup.origins[target[worst]]), int(soup.origins[worst])],
            value=float(apart[worst]),
            bound=bound,
        )


# --- orientation


def _orient(soup: PolygonSoup) -> PolygonSoup:
    """Turn faces so that neighbours agree and closed components have positive volume."""
    pairs, alike = _neighbours(soup)
    component, turned = _agreement(soup, pairs, alike)
    sizes = np.bincount(component)
    turned ^= (2 * np.bincount(component, turned) > sizes)[component]
    has_rim = np.zeros(len(sizes), dtype=bool)
    has_rim[component[soup.corner_face[soup.is_open]]] = True
    volumes = np.bincount(component, _volumes(soup) * np.where(turned, -1, 1))
    turned ^= (~has_rim & (volumes < 0))[component]
    if not turned.any():
        return soup
    at_rim, closed = turned & has_rim[component], turned & ~has_rim[component]
    sentences = []
    if at_rim.any():
        sentences.append(f"{at_rim.sum()} of {soup.n_faces} faces turned round to agree with their neighbours")
    if closed.any():
        sentences.append(f"{closed.sum()} of {soup.n_faces} faces turned round to face out of a closed surface")
    ends = (soup.face_starts[:-1] + soup.face_starts[1:] - 1)[soup.corner_face]
    here = np.arange(len(soup.corners))
    corners = soup.corners[np.where(turned[soup.corner_face], ends - here, here)]
    return soup.with_faces(corners, soup.face_starts, *sentences)


def _neighbours(soup: PolygonSoup) -> tuple[IntArray, BoolArray]:
    """The two corners (n, 2) at each inner edge, and whether both run along it the same way (n,)."""
    order = np.argsort(soup.corner_edge, kind="stable")
    inner = np.flatnonzero(np.diff(soup.corner_edge[order]) == 0)
    pairs = np.stack([order[inner], order[inner + 1]], axis=1)
    return pairs, soup.corners[pairs[:, 0]] == soup.corners[pairs[:, 1]]


def _agreement(soup: PolygonSoup, pairs: IntArray, alike: BoolArray) -> tuple[IntArray, BoolArray]:
    """Component of each face (F,), and whether it must be turned to agree with the first face of its component.

    Each face stands in the graph twice, as it is and turned; edges join what agrees. A component whose faces can
    agree falls into two mirror images, one with sides only holds both in one piece.
    """
    n = soup.n_faces
    left, right = soup.corner_face[pairs].T
    rows = np.concatenate([left, left + n])
    columns = np.concatenate([right + n * alike, right + n * ~alike])
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * n, 2 * n))
    labels = connected_components(graph, directed=False)[1]
    as_is, about = labels[:n], labels[n:]
    if (as_is == about).any():
        _raise_one_sided(soup, pairs, alike, np.flatnonzero(as_is == about)[0])
    _, first, component = np.unique(np.minimum(as_is, about), return_index=True, return_inverse=True)
    return component, as_is != as_is[first[component]]


def _raise_one_sided(soup: PolygonSoup, pairs: IntArray, alike: BoolArray, start: int) -> NoReturn:
    """Walk over the component breadth first, turning faces to agree, and name an edge where that fails."""
    left, right = soup.corner_face[pairs].T
    graph = coo_array((np.ones(len(pairs)), (left, right)), shape=(soup.n_faces, soup.n_faces)).tocsr()
    order, before = breadth_first_order(graph, start, directed=False)
    unlike = {}
    for i, j, same in zip(left.tolist(), right.tolist(), alike.tolist(), strict=True):
        unlike[i, j] = unlike[j, i] = same
    turned = np.zeros(soup.n_faces, dtype=bool)
    for face in order[1:].tolist():
        turned[face] = turned[before[face]] ^ unlike[int(before[face]), face]
    reached = np.isin(left, order)
    torn = np.flatnonzero(reached & (turned[left] ^ turned[right] ^ alike))[0]
    corner = pairs[torn, 0]
    tail, head = (soup.vertex_name(vertex) for vertex in (soup.corners[corner], soup.heads[corner]))
    faces = [int(left[torn]), int(right[torn])]
    raise MeshError(
        f"the surface has one side only (it is not orientable): with all other faces made to agree, faces "
        f"{soup.face_name(faces[0])} and {soup.face_name(faces[1])} do not at their edge from vertex {tail} to vertex "
        f"{head}; cut the surface there {soup.counting}",
        elements=faces,
    )


def _volumes(soup: PolygonSoup) -> FloatArray:
    """(F,) volume between each face and the mean of the vertices, positive where it runs counter-clockwise."""
    centred = soup.vertices - soup.vertices.mean(axis=0)
    here, ahead = centred[soup.corners], centred[soup.heads]
    starts = soup.face_starts[:-1]
    areas = np.add.reduceat(np.cross(here, ahead), starts, axis=0) / 2
    centroids = np.add.reduceat(here, starts, axis=0) / soup.face_sizes[:, None]
    volumes: FloatArray = np.einsum("fk,fk->f", areas, centroids) / 3
    return volumes

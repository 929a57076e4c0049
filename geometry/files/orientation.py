"""Faces that agree: neighbours run along their edge against each other, closed pieces face outwards."""

from __future__ import annotations

from typing import NoReturn

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from geometry.arrays import BoolArray, IntArray
from geometry.errors import MeshError
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh.ragged_arrays import next_in_row

__all__ = ["oriented"]

LEAST_RELATIVE_VOLUME = 1e-9
"""Volume of a closed piece over the sum of the sizes of its parts, below which rounding decides on its sign."""


def oriented(raw: RawPolygons) -> RawPolygons:
    """Turn faces so that neighbours agree and closed components have positive volume, if any."""
    pairs, alike = _neighbours(raw)
    component, turned = _agreement(raw, pairs, alike)
    sizes = np.bincount(component)
    turned ^= (2 * np.bincount(component, turned) > sizes)[component]
    has_rim = np.zeros(len(sizes), dtype=bool)
    has_rim[component[raw.corner_face[raw.is_open]]] = True
    turned ^= (~has_rim & (_outwards(raw, component, turned) < 0))[component]
    if not turned.any():
        return raw
    at_rim, closed = turned & has_rim[component], turned & ~has_rim[component]
    sentences = []
    if at_rim.any():
        sentences.append(f"{at_rim.sum()} of {raw.n_faces} faces turned round to agree with their neighbours")
    if closed.any():
        sentences.append(f"{closed.sum()} of {raw.n_faces} faces turned round to face out of a closed surface")
    ends = (raw.face_starts[:-1] + raw.face_starts[1:] - 1)[raw.corner_face]
    here = np.arange(len(raw.corners))
    corners = raw.corners[np.where(turned[raw.corner_face], ends - here, here)]
    return raw.with_faces(corners, raw.face_starts, *sentences)


def _neighbours(raw: RawPolygons) -> tuple[IntArray, BoolArray]:
    """The two corners (n, 2) at each inner edge, and whether both run along it the same way (n,)."""
    order = np.argsort(raw.corner_edge, kind="stable")
    inner = np.flatnonzero(np.diff(raw.corner_edge[order]) == 0)
    pairs = np.stack([order[inner], order[inner + 1]], axis=1)
    return pairs, raw.corners[pairs[:, 0]] == raw.corners[pairs[:, 1]]


def _agreement(raw: RawPolygons, pairs: IntArray, alike: BoolArray) -> tuple[IntArray, BoolArray]:
    """Component of each face (F,), and whether it must be turned to agree with the first face of its component.

    Each face stands in the graph twice, as it is and turned; edges join what agrees. A component whose faces can
    agree falls into two mirror images, one with sides only holds both in one piece.
    """
    n = raw.n_faces
    left, right = raw.corner_face[pairs].T
    rows = np.concatenate([left, left + n])
    columns = np.concatenate([right + n * alike, right + n * ~alike])
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * n, 2 * n))
    labels = connected_components(graph, directed=False)[1]
    as_is, about = labels[:n], labels[n:]
    if (as_is == about).any():
        _raise_one_sided(raw, pairs, alike, np.flatnonzero(as_is == about)[0])
    _, first, component = np.unique(np.minimum(as_is, about), return_index=True, return_inverse=True)
    return component, as_is != as_is[first[component]]


def _raise_one_sided(raw: RawPolygons, pairs: IntArray, alike: BoolArray, start: int) -> NoReturn:
    """Walk over the component breadth first, turning faces to agree, and name an edge where that fails."""
    left, right = raw.corner_face[pairs].T
    graph = coo_array((np.ones(len(pairs)), (left, right)), shape=(raw.n_faces, raw.n_faces)).tocsr()
    order, before = breadth_first_order(graph, start, directed=False)
    unlike = {}
    for i, j, same in zip(left.tolist(), right.tolist(), alike.tolist(), strict=True):
        unlike[i, j] = unlike[j, i] = same
    turned = np.zeros(raw.n_faces, dtype=bool)
    for face in order[1:].tolist():
        turned[face] = turned[before[face]] ^ unlike[int(before[face]), face]
    reached = np.isin(left, order)
    torn = np.flatnonzero(reached & (turned[left] ^ turned[right] ^ alike))[0]
    corner = pairs[torn, 0]
    tail, head = (raw.vertex_name(vertex) for vertex in (raw.corners[corner], raw.heads[corner]))
    faces = [int(left[torn]), int(right[torn])]
    raise MeshError(
        f"the surface has one side only (it is not orientable): with all other faces made to agree, faces "
        f"{raw.face_name(faces[0])} and {raw.face_name(faces[1])} do not at their edge from vertex {tail} to vertex "
        f"{head}; cut the surface there {raw.counting}",
        elements=raw.faces_of_file(np.array(faces)),
    )


def _outwards(raw: RawPolygons, component: IntArray, turned: BoolArray) -> IntArray:
    """(components,) 1 or -1, the sign of the volume within each component with its faces so turned, 0 for none.

    The volumes are those between each face and the middle of its component, so that it does not matter where that lies.
    """
    of_corner = component[raw.corner_face]
    counts = np.bincount(of_corner)
    positions = raw.vertices[raw.corners]
    first = positions[np.unique(of_corner, return_index=True)[1]][of_corner]  # sums of large numbers would round
    sums = [np.bincount(of_corner, along) for along in (positions - first).T]
    here = positions - first - np.stack(sums, axis=1)[of_corner] / counts[of_corner, None]
    ahead = here[next_in_row(raw.face_starts)]
    starts = raw.face_starts[:-1]
    areas = np.add.reduceat(np.cross(here, ahead), starts, axis=0)
    centroids = np.add.reduceat(here, starts, axis=0) / raw.face_sizes[:, None]
    parts = np.einsum("fk,fk->f", areas, centroids) * np.where(turned, -1, 1)
    sizes = np.linalg.norm(areas, axis=1) * np.linalg.norm(centroids, axis=1)
    volumes = np.bincount(component, parts)
    volumes[np.abs(volumes) <= LEAST_RELATIVE_VOLUME * np.bincount(component, sizes)] = 0
    return np.sign(volumes).astype(np.int64)

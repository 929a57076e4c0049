"""Consistent orientation: neighbours run along their common edge in opposite directions, closed parts face outwards."""

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
"""Volume of a closed part over the sum of the absolute volumes of its pyramids, below which it counts as zero, since
rounding decides on its sign."""


def oriented(raw: RawPolygons) -> RawPolygons:
    """With faces reversed so that neighbours agree and closed components have positive volume, if any."""
    pairs, same_direction = _neighbours(raw)
    component, is_reversed = _agreement(raw, pairs, same_direction)
    sizes = np.bincount(component)
    is_reversed ^= (2 * np.bincount(component, is_reversed) > sizes)[component]
    has_rim = np.zeros(len(sizes), dtype=bool)
    has_rim[component[raw.corner_face[raw.is_open]]] = True
    is_reversed ^= (~has_rim & (_outwards(raw, component, is_reversed) < 0))[component]
    if not is_reversed.any():
        return raw
    at_rim, closed = is_reversed & has_rim[component], is_reversed & ~has_rim[component]
    sentences = []
    if at_rim.any():
        sentences.append(f"{at_rim.sum()} of {raw.n_faces} faces reversed to agree with their neighbours")
    if closed.any():
        sentences.append(f"{closed.sum()} of {raw.n_faces} faces reversed to face out of a closed surface")
    ends = (raw.face_starts[:-1] + raw.face_starts[1:] - 1)[raw.corner_face]
    here = np.arange(len(raw.corners))
    corners = raw.corners[np.where(is_reversed[raw.corner_face], ends - here, here)]
    return raw.with_faces(corners, raw.face_starts, *sentences)


def _neighbours(raw: RawPolygons) -> tuple[IntArray, BoolArray]:
    """The two corners (n, 2) at each inner edge, and whether both run along it the same way (n,)."""
    order = np.argsort(raw.corner_edge, kind="stable")
    inner = np.flatnonzero(np.diff(raw.corner_edge[order]) == 0)
    pairs = np.stack([order[inner], order[inner + 1]], axis=1)
    return pairs, raw.corners[pairs[:, 0]] == raw.corners[pairs[:, 1]]


def _agreement(raw: RawPolygons, pairs: IntArray, same_direction: BoolArray) -> tuple[IntArray, BoolArray]:
    """Component of each face (F,), and whether it must be turned to agree with the first face of its component.

    Each face is in the graph twice, as it is and reversed; edges join orientations that agree. A component whose faces
    can agree falls into two mirror images; for a component with only one side both are connected.
    """
    n = raw.n_faces
    left, right = raw.corner_face[pairs].T
    rows = np.concatenate([left, left + n])
    columns = np.concatenate([right + n * same_direction, right + n * ~same_direction])
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * n, 2 * n))
    labels = connected_components(graph, directed=False)[1]
    labels_as_given, reversed_labels = labels[:n], labels[n:]
    if (labels_as_given == reversed_labels).any():
        _raise_one_sided(raw, pairs, same_direction, np.flatnonzero(labels_as_given == reversed_labels)[0])
    _, first, component = np.unique(
        np.minimum(labels_as_given, reversed_labels), return_index=True, return_inverse=True
    )
    return component, labels_as_given != labels_as_given[first[component]]


def _raise_one_sided(raw: RawPolygons, pairs: IntArray, same_direction: BoolArray, start: int) -> NoReturn:
    """Walk over the component breadth first, turning faces to agree, and name an edge where that fails."""
    left, right = raw.corner_face[pairs].T
    graph = coo_array((np.ones(len(pairs)), (left, right)), shape=(raw.n_faces, raw.n_faces)).tocsr()
    order, previous = breadth_first_order(graph, start, directed=False)
    must_differ = {}
    for i, j, same in zip(left.tolist(), right.tolist(), same_direction.tolist(), strict=True):
        must_differ[i, j] = must_differ[j, i] = same
    is_reversed = np.zeros(raw.n_faces, dtype=bool)
    for face in order[1:].tolist():
        is_reversed[face] = is_reversed[previous[face]] ^ must_differ[int(previous[face]), face]
    reached = np.isin(left, order)
    conflict = np.flatnonzero(reached & (is_reversed[left] ^ is_reversed[right] ^ same_direction))[0]
    corner = pairs[conflict, 0]
    tail, head = (raw.vertex_name(vertex) for vertex in (raw.corners[corner], raw.heads[corner]))
    faces = [int(left[conflict]), int(right[conflict])]
    raise MeshError(
        f"the surface has one side only (it is not orientable): with all other faces made to agree, faces "
        f"{raw.face_name(faces[0])} and {raw.face_name(faces[1])} do not at their edge from vertex {tail} to vertex "
        f"{head}; cut the surface there {raw.counting}",
        elements=raw.faces_of_file(np.array(faces)),
    )


def _outwards(raw: RawPolygons, component: IntArray, is_reversed: BoolArray) -> IntArray:
    """(components,) the sign of the volume of each component after the faces (F,) of `turned` are reversed; 0 for none.
    It is the sum of the pyramids between each face and the centre of its component, wherever that is.
    """
    corner_component = component[raw.corner_face]
    counts = np.bincount(corner_component)
    positions = raw.vertices[raw.corners]
    first = positions[np.unique(corner_component, return_index=True)[1]][
        corner_component
    ]  # sums of large numbers would lose digits
    sums = [np.bincount(corner_component, along) for along in (positions - first).T]
    here = positions - first - np.stack(sums, axis=1)[corner_component] / counts[corner_component, None]
    ahead = here[next_in_row(raw.face_starts)]
    starts = raw.face_starts[:-1]
    areas = np.add.reduceat(np.cross(here, ahead), starts, axis=0)
    centroids = np.add.reduceat(here, starts, axis=0) / raw.face_sizes[:, None]
    parts = np.einsum("fk,fk->f", areas, centroids) * np.where(is_reversed, -1, 1)
    sizes = np.linalg.norm(areas, axis=1) * np.linalg.norm(centroids, axis=1)
    volumes = np.bincount(component, parts)
    volumes[np.abs(volumes) <= LEAST_RELATIVE_VOLUME * np.bincount(component, sizes)] = 0
    return np.sign(volumes).astype(np.int64)

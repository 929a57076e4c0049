"""Whether the faces of a surface can be given one orientation, and an edge where they cannot."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from geometry.arrays import BoolArray, IntArray
from geometry.mesh.ragged_arrays import next_in_row, row_of_entry
from geometry.mesh.spanning_forests import spanning_forest

__all__ = ["agreement", "conflict", "wrong_edge"]


def agreement(n_faces: int, pairs: IntArray, same_direction: BoolArray) -> tuple[IntArray, BoolArray, BoolArray]:
    """The component of each face (F,), whether it must be reversed to agree with the first face of its component, and
    whether its component has one side only, so that its faces never agree.

    pairs (n, 2): the faces at each inner edge; same_direction (n,): whether both run along it the same way. Each face
    is in a graph twice, as it is and reversed; edges join orientations that agree. A component whose faces can agree
    falls into two mirror images; for a component with only one side both are connected.
    """
    n = n_faces
    left, right = pairs.T
    rows = np.concatenate([left, left + n])
    columns = np.concatenate([right + n * same_direction, right + n * ~same_direction])
    graph = coo_array((np.ones(len(rows)), (rows, columns)), shape=(2 * n, 2 * n))
    labels_as_given, reversed_labels = connected_components(graph, directed=False)[1].reshape(2, n)
    lowest = np.minimum(labels_as_given, reversed_labels)
    _, first, component = np.unique(lowest, return_index=True, return_inverse=True)
    is_reversed = labels_as_given != labels_as_given[first[component]]
    return component, is_reversed, labels_as_given == reversed_labels


def conflict(n_faces: int, pairs: IntArray, same_direction: BoolArray) -> int:
    """The first pair at whose edge the faces do not agree, when they are made to agree from face to face, breadth
    first. There is one if and only if a component has one side only."""
    is_reversed = np.zeros(n_faces, dtype=bool)
    for level in spanning_forest(n_faces, pairs).levels:
        is_reversed[level.children] = is_reversed[level.parents] ^ same_direction[level.edges]
    left, right = pairs.T
    return int(np.flatnonzero(is_reversed[left] ^ is_reversed[right] ^ same_direction)[0])


def wrong_edge(n_vertices: int, corners: IntArray, face_starts: IntArray) -> tuple[str, list[int]]:
    """A sentence about faces two of which run along an edge in the same direction, and the faces (k,) at that edge."""
    face, heads = row_of_entry(face_starts), corners[next_in_row(face_starts)]
    keys = np.minimum(corners, heads) * n_vertices + np.maximum(corners, heads)
    order = np.argsort(keys, kind="stable")
    starts = np.flatnonzero(np.diff(keys[order], prepend=-1))
    counts = np.diff(starts, append=len(order))
    crowded = np.flatnonzero(counts > 2)
    if len(crowded):
        at = order[starts[crowded[0]] : starts[crowded[0]] + counts[crowded[0]]]
        faces = sorted({int(each) for each in face[at]})
        named = f"{', '.join(str(each) for each in faces[:-1])} and {faces[-1]}"
        i, j = divmod(int(keys[at[0]]), n_vertices)
        return (
            f"the edge from vertex {i} to vertex {j} belongs to faces {named}, two at most are possible: the surface "
            "branches or crosses itself there; remove faces, or cut the surface into parts along this edge",
            faces,
        )
    inner = starts[counts == 2]
    at_edges = np.stack([order[inner], order[inner + 1]], axis=1)
    pairs, same = face[at_edges], corners[at_edges[:, 0]] == corners[at_edges[:, 1]]
    _, _, is_one_sided = agreement(len(face_starts) - 1, pairs, same)
    place = conflict(len(face_starts) - 1, pairs, same) if is_one_sided.any() else int(np.flatnonzero(same)[0])
    first, second = pairs[place].tolist()
    i, j = int(corners[at_edges[place, 0]]), int(heads[at_edges[place, 0]])
    if is_one_sided.any():
        return (
            f"the surface has one side only (it is not orientable): with all other faces made to agree, faces {first} "
            f"and {second} do not at their edge from vertex {i} to vertex {j}; cut the surface there",
            [first, second],
        )
    return (
        f"faces {first} and {second} both run from vertex {i} to vertex {j}: neighbours have different orientations; "
        "reverse one of them, or let geometry.files.mend(vertices, faces) do it",
        [first, second],
    )

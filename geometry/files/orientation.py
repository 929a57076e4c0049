"""Consistent orientation: neighbours run along their common edge in opposite directions, closed parts face outwards."""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from geometry.arrays import BoolArray, IntArray
from geometry.errors import MeshError
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh.orientability import agreement, conflict
from geometry.mesh.ragged_arrays import next_in_row

__all__ = ["oriented"]

LEAST_RELATIVE_VOLUME = 1e-9
"""Volume of a closed part over the sum of the absolute volumes of its pyramids, below which it counts as zero, since
rounding decides on its sign."""


def oriented(raw: RawPolygons) -> RawPolygons:
    """With faces reversed so that neighbours agree and closed components have positive volume, if any."""
    pairs, same_direction = _neighbours(raw)
    component, is_reversed, is_one_sided = agreement(raw.n_faces, raw.corner_face[pairs], same_direction)
    if is_one_sided.any():
        _raise_one_sided(raw, pairs, same_direction)
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


def _raise_one_sided(raw: RawPolygons, pairs: IntArray, same_direction: BoolArray) -> NoReturn:
    """Name an edge where faces do not agree when they are made to agree from face to face."""
    corner = pairs[conflict(raw.n_faces, raw.corner_face[pairs], same_direction)]
    tail, head = (raw.vertex_name(vertex) for vertex in (raw.corners[corner[0]], raw.heads[corner[0]]))
    faces = raw.corner_face[corner].tolist()
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

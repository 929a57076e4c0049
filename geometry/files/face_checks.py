"""Checks for defects that make faces unusable: zero-length edges, duplicates, folds, edges of three faces. Each error
names all faces with its defect."""

from __future__ import annotations

from typing import NoReturn, TypeAlias

import numpy as np

from geometry.arrays import BoolArray, IntArray
from geometry.errors import MeshError, listed
from geometry.files.meeting_outlines import Meeting, flattened, meetings
from geometry.files.overlaid_faces import overlaid_faces, same_vertices
from geometry.files.raw_polygons import RawPolygons
from geometry.mesh import MeshLike, as_mesh
from geometry.mesh.ragged_arrays import rows_by_size

__all__ = [
    "COINCIDENCE_TOLERANCE",
    "FOLD_CLEARANCE",
    "LARGEST_FILE_COORDINATE",
    "check_duplicates",
    "check_edges",
    "check_faces",
    "check_folds",
    "check_indices",
    "check_manifold",
    "check_size",
    "check_touching",
    "check_without_faces",
]

COINCIDENCE_TOLERANCE = 1e-4
"""Distance of two vertices over the mean edge length, below which they are one point. Files with six digits have copies
of a vertex up to 5e-5 apart, and the shortest edge of a known file is 0.19; at edges of 1.5 m it is 0.15 mm."""

FOLD_CLEARANCE = 1e-6
"""Distance of a corner from another edge of its face, over the mean edge length of the face, below which it lies on
that edge: coordinates with six or seven digits do not show on which side it is."""

_Found: TypeAlias = tuple[int, IntArray, Meeting]
"""A face, its vertices, and the place where its outline meets itself."""

LARGEST_FILE_COORDINATE = 1e60
"""Largest coordinate in a file; volumes and squared areas of larger ones leave the range of a double."""

LEAST_FILE_EXTENT = 1e-60
"""Smallest extent of a mesh in a file; volumes and squared areas of smaller ones leave the range of a double."""


def check_faces(
    mesh: MeshLike, *, coincidence: float = COINCIDENCE_TOLERANCE, clearance: float = FOLD_CLEARANCE
) -> None:
    """Raise MeshError where a face cannot be built at all; non-convex faces are accepted.

    Refused are edges shorter than `coincidence` times the mean edge length, two faces with the same vertices, faces
    that lie on one which has all their vertices, and folded faces: those whose boundary, seen along the vector area,
    crosses itself or has a corner within `clearance` times the face's mean edge length of another edge (spikes, faces
    without area). The message describes one face and names others with the same defect; `elements` are all of them.

    >>> from geometry import Mesh
    >>> from geometry.files import check_faces
    >>> bow = Mesh.from_faces([[0, 0, 0], [1, 1, 0], [1, 0, 0], [0, 1.5, 0]], [[0, 1, 2, 3]])
    >>> try:
    ...     check_faces(bow)
    ... except MeshError as error:
    ...     print(error.message.split(";")[0])
    face 0 crosses itself: its edge from vertex 0 to 1 meets its edge from 2 to 3
    """
    mesh = as_mesh(mesh)
    raw = RawPolygons.from_mesh(mesh)
    check_edges(raw, coincidence)
    check_duplicates(raw)
    check_folds(raw, clearance)


def check_indices(raw: RawPolygons) -> None:
    """Raise MeshError for coordinates that are not finite, no faces, and corners that do not exist."""
    not_finite = np.flatnonzero(~(np.abs(raw.vertices) <= LARGEST_FILE_COORDINATE).all(axis=1))
    if len(not_finite):
        raise MeshError(
            f"vertex {raw.vertex_name(not_finite[0])} is {tuple(raw.vertices[not_finite[0]].tolist())}: coordinates "
            f"must be finite numbers up to {LARGEST_FILE_COORDINATE:.0e}{raw.likewise_vertices(not_finite[1:])} "
            f"{raw.counting}",
            elements=raw.origins[not_finite].tolist(),
            bound=LARGEST_FILE_COORDINATE,
        )
    check_without_faces(raw, np.zeros(raw.n_faces, dtype=bool))
    wrong = np.flatnonzero((raw.corners < 0) | (raw.corners >= raw.n_vertices))
    if len(wrong):
        faces, vertex = np.unique(raw.corner_face[wrong]), int(raw.corners[wrong[0]])
        last = f"the {raw.n_vertices} vertices end at {raw.n_vertices - 1 + raw.count_from}"
        raise MeshError(
            f"face {raw.face_name(faces[0])} names vertex {vertex + raw.count_from}, but "
            f"{last if raw.n_vertices else 'there are no vertices'}{raw.likewise(faces[1:])} {raw.counting}",
            elements=raw.faces_of_file(faces),
            value=vertex,
            bound=raw.n_vertices - 1,
        )


def check_size(raw: RawPolygons) -> None:
    """Raise MeshError for a mesh so small that volumes and squared areas would leave the range of doubles."""
    size = float(np.ptp(raw.vertices, axis=0).max())
    if 0 < size < LEAST_FILE_EXTENT:
        raise MeshError(
            f"the longest extent of the mesh is {size:.1e}, at least {LEAST_FILE_EXTENT:.0e} is needed: "
            "write it in a smaller unit",
            value=size,
            bound=LEAST_FILE_EXTENT,
        )


def check_without_faces(raw: RawPolygons, is_removed: BoolArray) -> None:
    """Raise MeshError where no face remains without the removed ones (F,)."""
    if not raw.n_faces:
        raise MeshError(f"there are no faces (vertices: {raw.n_vertices}): a mesh needs polygons, not points or curves")
    if is_removed.all():
        faces = np.arange(raw.n_faces)
        raise MeshError(
            f"there are no faces: none of {raw.n_faces} has three separate corners, see "
            f"{raw.face_names(faces)}; export the mesh again {raw.counting}",
            elements=raw.faces_of_file(faces),
        )


def check_touching(raw: RawPolygons) -> None:
    """Raise MeshError where a face contains a vertex twice."""
    keys = np.sort(raw.corner_face * raw.n_vertices + raw.corners)
    twice = keys[1:][keys[1:] == keys[:-1]]
    if len(twice):
        face, vertex = divmod(int(twice[0]), raw.n_vertices)
        faces = np.unique(twice // raw.n_vertices)
        raise MeshError(
            f"face {raw.face_name(face)} touches itself: two of its corners are vertex {raw.vertex_name(vertex)} "
            f"or lie on it; split the face there or remove one of the corners{raw.likewise(faces[1:])} "
            f"{raw.counting}",
            elements=raw.faces_of_file(faces),
        )


def check_edges(raw: RawPolygons, coincidence: float = COINCIDENCE_TOLERANCE) -> None:
    """Raise MeshError for an edge shorter than `coincidence` times the mean edge length."""
    lengths = raw.edge_lengths / max(float(raw.edge_lengths.mean()), np.finfo(float).tiny)
    short = np.flatnonzero(lengths <= coincidence)
    if len(short):
        worst = short[0]
        faces = np.unique(raw.corner_face[short])
        tail, head = raw.corners[worst], raw.heads[worst]
        raise MeshError(
            f"face {raw.face_name(raw.corner_face[worst])}: its edge from vertex {raw.vertex_name(tail)} to vertex "
            f"{raw.vertex_name(head)} is {lengths[worst]:.2g} of the mean edge length long, more than "
            f"{coincidence:.2g} is needed; merge the two vertices or move them apart{raw.likewise(faces[1:])} "
            f"{raw.counting}",
            elements=raw.faces_of_file(faces),
            value=float(lengths[worst]),
            bound=coincidence,
        )


def check_duplicates(raw: RawPolygons) -> None:
    """Raise MeshError where two faces have the same vertices, or one lies on another that has all its vertices."""
    pairs = same_vertices(raw)
    if len(pairs):
        host = pairs[0, 0]
        raise MeshError(
            f"{_host_with_guests(raw, pairs, host)} have the same vertices ({raw.corner_names(host)}): remove one of "
            f"them{_likewise_groups(raw, pairs[pairs[:, 0] != host])} {raw.counting}",
            elements=raw.faces_of_file(pairs),
        )
    pairs = overlaid_faces(raw)
    if len(pairs):
        hosts = np.unique(pairs[:, 0])
        places = (_on_host(raw, pairs, host) for host in hosts)
        raise MeshError(
            f"{len(np.unique(pairs[:, 1]))} of {raw.n_faces} faces lie on others that have all their vertices: "
            f"{listed(places, len(hosts))}; remove either the former or the latter {raw.counting}",
            elements=raw.faces_of_file(pairs),
        )


def _host_with_guests(raw: RawPolygons, pairs: IntArray, host: int) -> str:
    return raw.face_names(np.append(host, pairs[pairs[:, 0] == host, 1]))


def _likewise_groups(raw: RawPolygons, pairs: IntArray) -> str:
    if not len(pairs):
        return ""
    hosts = np.unique(pairs[:, 0])
    groups = (_host_with_guests(raw, pairs, host).removeprefix("faces ") for host in hosts)
    return f"; likewise faces {listed(groups, len(hosts))}"


def _on_host(raw: RawPolygons, pairs: IntArray, host: int) -> str:
    guests = pairs[pairs[:, 0] == host, 1]
    return f"{listed(map(raw.face_name, guests), len(guests))} on {raw.face_name(host)}"


def check_manifold(raw: RawPolygons) -> None:
    """Raise MeshError for an edge with more than two faces."""
    corners = np.flatnonzero(np.bincount(raw.corner_edge)[raw.corner_edge] > 2)
    if not len(corners):
        return
    edges, firsts = np.unique(raw.corner_edge[corners], return_index=True)
    firsts = corners[firsts]  # the first corner at each such edge
    faces = raw.corner_face[corners[raw.corner_edge[corners] == edges[0]]]
    others = ""
    if len(edges) > 1:
        others = f"; likewise the edges {listed((_ends(raw, corner) for corner in firsts[1:]), len(edges) - 1)}"
    raise MeshError(
        f"the edge from vertex {_ends(raw, firsts[0], 'to vertex')} belongs to {raw.face_names(faces)}, two at most "
        f"are allowed: remove a face, or read the sheets as separate meshes{others} {raw.counting}",
        elements=raw.faces_of_file(raw.corner_face[corners]),
        value=len(faces),
        bound=2,
    )


def _ends(raw: RawPolygons, corner: int, to: str = "to") -> str:
    tail, head = raw.corners[corner], raw.heads[corner]
    return f"{raw.vertex_name(tail)} {to} {raw.vertex_name(head)}"


def check_folds(raw: RawPolygons, clearance: float = FOLD_CLEARANCE) -> None:
    """Raise MeshError for a face that crosses itself or folds back on itself; see `check_faces`."""
    folded, crossed = list[_Found](), list[_Found]()
    for faces, places in rows_by_size(raw.face_starts):
        polygons = raw.corners[places]
        for found, meetings_of_size in zip(
            (folded, crossed), meetings(flattened(raw.vertices[polygons]), clearance), strict=True
        ):
            found += [(int(faces[meeting.outline]), polygons[meeting.outline], meeting) for meeting in meetings_of_size]
    if folded:
        _raise_folded(raw, sorted(folded, key=_face), clearance)
    if crossed:
        _raise_crossed(raw, sorted(crossed, key=_face))


def _face(found: _Found) -> int:
    return found[0]


def _raise_folded(raw: RawPolygons, found: list[_Found], clearance: float) -> NoReturn:
    face, polygon, meeting = found[0]
    faces = np.array([each[0] for each in found])
    ends = [raw.vertex_name(polygon[(meeting.edge + step) % len(polygon)]) for step in (0, 1)]
    raise MeshError(
        f"face {raw.face_name(face)} folds back on itself: its vertex {raw.vertex_name(polygon[meeting.corner])} lies "
        f"{meeting.distance:.2g} of the face's mean edge length from its edge from {ends[0]} to {ends[1]}, more than "
        f"{clearance:.2g} is needed; remove the spike or the face{raw.likewise(faces[1:])} {raw.counting}",
        elements=raw.faces_of_file(faces),
        value=meeting.distance,
        bound=clearance,
    )


def _raise_crossed(raw: RawPolygons, found: list[_Found]) -> NoReturn:
    face, polygon, meeting = found[0]
    faces = np.array([each[0] for each in found])
    places = (meeting.corner, meeting.corner + 1, meeting.edge, meeting.edge + 1)
    names = [raw.vertex_name(polygon[place % len(polygon)]) for place in places]
    raise MeshError(
        f"face {raw.face_name(face)} crosses itself: its edge from vertex {names[0]} to {names[1]} meets its edge "
        f"from {names[2]} to {names[3]}; list its corners in their order around it{raw.likewise(faces[1:])} "
        f"{raw.counting}",
        elements=raw.faces_of_file(faces),
    )

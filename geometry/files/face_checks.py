"""What makes faces useless, all of a kind at once: zero-length edges, duplicates, folds, edges of three faces."""

from __future__ import annotations

from typing import NoReturn, TypeAlias

import numpy as np

from geometry.arrays import BoolArray, IntArray
from geometry.errors import MeshError, listed
from geometry.files.meeting_outlines import Meeting, flattened, meetings
from geometry.files.overlaid_faces import overlaid_faces, same_vertices
from geometry.files.polygon_soup import PolygonSoup
from geometry.mesh import MeshLike, as_mesh
from geometry.mesh.ragged_arrays import runs_by_size

__all__ = [
    "COINCIDENCE",
    "FOLD_CLEARANCE",
    "LARGEST",
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

# Two vertices nearer than this part of the mean edge length are one point. Files with six digits put copies of one
# vertex up to 5e-5 apart (catenoid3.off); the shortest true edge in the files we know is 0.19. At edges of 1.5 m it
# means 0.15 mm, which no workshop sees.
COINCIDENCE = 1e-4

# A corner nearer than this part of the face's mean edge length to an edge it does not belong to lies on that edge:
# coordinates with six or seven digits say nothing about which side it is on.
FOLD_CLEARANCE = 1e-6

_Found: TypeAlias = tuple[int, IntArray, Meeting]
"""A face, its vertices, and where its outline meets itself."""

# Volumes and squares of areas of larger coordinates would leave the range of a double.
LARGEST = 1e60

# The same downwards: squares of areas and volumes.
SMALLEST = 1e-60


def check_faces(mesh: MeshLike, *, coincidence: float = COINCIDENCE, clearance: float = FOLD_CLEARANCE) -> None:
    """Raise MeshError where a face cannot be built by anybody; non-convex faces are fine.

    Refused are edges shorter than `coincidence` times the mean edge length, two faces with the same vertices, faces
    that lie on one which has all their vertices, and folded faces: those whose boundary, seen along the vector area,
    crosses itself or has a corner within `clearance` times the face's mean edge length of another edge (spikes, faces
    without area). The sentence is about one face and names others of its kind; `elements` are all of them.
    """
    mesh = as_mesh(mesh)
    soup = PolygonSoup.from_mesh(mesh)
    check_edges(soup, coincidence)
    check_duplicates(soup)
    check_folds(soup, clearance)


def check_indices(soup: PolygonSoup) -> None:
    """Finite coordinates, at least one face, corners that exist."""
    broken = np.flatnonzero(~(np.abs(soup.vertices) <= LARGEST).all(axis=1))
    if len(broken):
        raise MeshError(
            f"vertex {soup.vertex_name(broken[0])} is {tuple(soup.vertices[broken[0]].tolist())}: coordinates must be "
            f"finite numbers up to {LARGEST:.0e}{soup.likewise_vertices(broken[1:])} {soup.counting}",
            elements=soup.origins[broken].tolist(),
            bound=LARGEST,
        )
    check_without_faces(soup, np.zeros(soup.n_faces, dtype=bool))
    wrong = np.flatnonzero((soup.corners < 0) | (soup.corners >= soup.n_vertices))
    if len(wrong):
        faces, vertex = np.unique(soup.corner_face[wrong]), int(soup.corners[wrong[0]])
        last = f"the {soup.n_vertices} vertices end at {soup.n_vertices - 1 + soup.count_from}"
        raise MeshError(
            f"face {soup.face_name(faces[0])} names vertex {vertex + soup.count_from}, but "
            f"{last if soup.n_vertices else 'there are no vertices'}{soup.likewise(faces[1:])} {soup.counting}",
            elements=soup.faces_of_file(faces),
            value=vertex,
            bound=soup.n_vertices - 1,
        )


def check_size(soup: PolygonSoup) -> None:
    """The mesh is not so small that squares of its lengths would lose their digits; a point is another matter."""
    size = float(np.ptp(soup.vertices, axis=0).max())
    if 0 < size < SMALLEST:
        raise MeshError(
            f"the mesh measures {size:.1e} where it is longest, and at least {SMALLEST:.0e} can be reckoned with: "
            "write it in a smaller unit",
            value=size,
            bound=SMALLEST,
        )


def check_without_faces(soup: PolygonSoup, gone: BoolArray) -> None:
    """There is a face left without those (F,) that are to be dropped."""
    if not soup.n_faces:
        raise MeshError(
            f"there are no faces (vertices: {soup.n_vertices}): a mesh needs polygons, not points or curves"
        )
    if gone.all():
        faces = np.arange(soup.n_faces)
        raise MeshError(
            f"there are no faces: none of {soup.n_faces} has three corners that are apart, see "
            f"{soup.face_names(faces)}; export the mesh again {soup.counting}",
            elements=soup.faces_of_file(faces),
        )


def check_touching(soup: PolygonSoup) -> None:
    """No face meets a vertex twice."""
    keys = np.sort(soup.corner_face * soup.n_vertices + soup.corners)
    twice = keys[1:][keys[1:] == keys[:-1]]
    if len(twice):
        face, vertex = divmod(int(twice[0]), soup.n_vertices)
        faces = np.unique(twice // soup.n_vertices)
        raise MeshError(
            f"face {soup.face_name(face)} touches itself: two of its corners are vertex {soup.vertex_name(vertex)} "
            f"or lie on it; split the face there or remove one of the corners{soup.likewise(faces[1:])} "
            f"{soup.counting}",
            elements=soup.faces_of_file(faces),
        )


def check_edges(soup: PolygonSoup, coincidence: float = COINCIDENCE) -> None:
    """No edge is shorter than `coincidence` times the mean edge length."""
    lengths = soup.edge_lengths / max(float(soup.edge_lengths.mean()), np.finfo(float).tiny)
    short = np.flatnonzero(lengths <= coincidence)
    if len(short):
        worst = short[0]
        faces = np.unique(soup.corner_face[short])
        tail, head = soup.corners[worst], soup.heads[worst]
        raise MeshError(
            f"face {soup.face_name(soup.corner_face[worst])}: its edge from vertex {soup.vertex_name(tail)} to vertex "
            f"{soup.vertex_name(head)} is {lengths[worst]:.2g} of the mean edge length long, more than "
            f"{coincidence:.2g} is needed; make the two one vertex or move them apart{soup.likewise(faces[1:])} "
            f"{soup.counting}",
            elements=soup.faces_of_file(faces),
            value=float(lengths[worst]),
            bound=coincidence,
        )


def check_duplicates(soup: PolygonSoup) -> None:
    """No two faces have the same vertices, and none lies on another that has all its vertices."""
    pairs = same_vertices(soup)
    if len(pairs):
        host = pairs[0, 0]
        raise MeshError(
            f"{_together(soup, pairs, host)} have the same vertices ({soup.corner_names(host)}): remove one of them"
            f"{_likewise_together(soup, pairs[pairs[:, 0] != host])} {soup.counting}",
            elements=soup.faces_of_file(pairs),
        )
    pairs = overlaid_faces(soup)
    if len(pairs):
        hosts = np.unique(pairs[:, 0])
        places = (_on_host(soup, pairs, host) for host in hosts)
        raise MeshError(
            f"{len(np.unique(pairs[:, 1]))} of {soup.n_faces} faces lie on others that have all their vertices: "
            f"{listed(places, len(hosts))}; remove the ones or the others {soup.counting}",
            elements=soup.faces_of_file(pairs),
        )


def _together(soup: PolygonSoup, pairs: IntArray, host: int) -> str:
    return soup.face_names(np.append(host, pairs[pairs[:, 0] == host, 1]))


def _likewise_together(soup: PolygonSoup, pairs: IntArray) -> str:
    if not len(pairs):
        return ""
    hosts = np.unique(pairs[:, 0])
    groups = (_together(soup, pairs, host).removeprefix("faces ") for host in hosts)
    return f"; likewise faces {listed(groups, len(hosts))}"


def _on_host(soup: PolygonSoup, pairs: IntArray, host: int) -> str:
    guests = pairs[pairs[:, 0] == host, 1]
    return f"{listed(map(soup.face_name, guests), len(guests))} on {soup.face_name(host)}"


def check_manifold(soup: PolygonSoup) -> None:
    """No edge has more than two faces."""
    corners = np.flatnonzero(np.bincount(soup.corner_edge)[soup.corner_edge] > 2)
    if not len(corners):
        return
    edges, firsts = np.unique(soup.corner_edge[corners], return_index=True)
    firsts = corners[firsts]  # at each such edge
    faces = soup.corner_face[corners[soup.corner_edge[corners] == edges[0]]]
    others = ""
    if len(edges) > 1:
        others = f"; likewise the edges {listed((_ends(soup, corner) for corner in firsts[1:]), len(edges) - 1)}"
    raise MeshError(
        f"the edge from vertex {_ends(soup, firsts[0], 'to vertex')} belongs to {soup.face_names(faces)}, two at most "
        f"are allowed: remove a face, or read the sheets as meshes of their own{others} {soup.counting}",
        elements=soup.faces_of_file(soup.corner_face[corners]),
        value=len(faces),
        bound=2,
    )


def _ends(soup: PolygonSoup, corner: int, to: str = "to") -> str:
    tail, head = soup.corners[corner], soup.heads[corner]
    return f"{soup.vertex_name(tail)} {to} {soup.vertex_name(head)}"


def check_folds(soup: PolygonSoup, clearance: float = FOLD_CLEARANCE) -> None:
    """No face crosses itself or folds back on itself; see `check_faces`."""
    folded, crossed = list[_Found](), list[_Found]()
    for faces, places in runs_by_size(soup.face_starts):
        polygons = soup.corners[places]
        for found, of_size in zip(
            (folded, crossed), meetings(flattened(soup.vertices[polygons]), clearance), strict=True
        ):
            found += [(int(faces[at.outline]), polygons[at.outline], at) for at in of_size]
    if folded:
        _raise_folded(soup, sorted(folded, key=_face), clearance)
    if crossed:
        _raise_crossed(soup, sorted(crossed, key=_face))


def _face(found: _Found) -> int:
    return found[0]


def _raise_folded(soup: PolygonSoup, found: list[_Found], clearance: float) -> NoReturn:
    face, polygon, at = found[0]
    faces = np.array([each[0] for each in found])
    ends = [soup.vertex_name(polygon[(at.edge + step) % len(polygon)]) for step in (0, 1)]
    raise MeshError(
        f"face {soup.face_name(face)} folds back on itself: its vertex {soup.vertex_name(polygon[at.corner])} lies "
        f"{at.distance:.2g} of the face's mean edge length from its edge from {ends[0]} to {ends[1]}, more than "
        f"{clearance:.2g} is needed; remove the spike or the face{soup.likewise(faces[1:])} {soup.counting}",
        elements=soup.faces_of_file(faces),
        value=at.distance,
        bound=clearance,
    )


def _raise_crossed(soup: PolygonSoup, found: list[_Found]) -> NoReturn:
    face, polygon, at = found[0]
    faces = np.array([each[0] for each in found])
    places = (at.corner, at.corner + 1, at.edge, at.edge + 1)
    names = [soup.vertex_name(polygon[place % len(polygon)]) for place in places]
    raise MeshError(
        f"face {soup.face_name(face)} crosses itself: its edge from vertex {names[0]} to {names[1]} meets its edge "
        f"from {names[2]} to {names[3]}; list its corners in their order around it{soup.likewise(faces[1:])} "
        f"{soup.counting}",
        elements=soup.faces_of_file(faces),
    )

"""What makes a face useless, said face by face: zero-length edges, duplicates, folds, edges of three faces."""

from __future__ import annotations

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.errors import MeshError
from geometry.mesh.mesh import Mesh
from geometry.mesh.soup import PolygonSoup

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
    "check_touching",
]

# Two vertices nearer than this part of the mean edge length are one point. Files with six digits put copies of one
# vertex up to 5e-5 apart (catenoid3.off); the shortest true edge in the files we know is 0.19. At edges of 1.5 m it
# means 0.15 mm, which no workshop sees.
COINCIDENCE = 1e-4

# A corner nearer than this part of the face's mean edge length to an edge it does not belong to lies on that edge:
# coordinates with six or seven digits say nothing about which side it is on.
FOLD_CLEARANCE = 1e-6

# Volumes and squares of areas of larger coordinates would leave the range of a double.
LARGEST = 1e60


def check_faces(mesh: Mesh, *, coincidence: float = COINCIDENCE, clearance: float = FOLD_CLEARANCE) -> None:
    """Raise MeshError at the first face that nobody can build; non-convex faces are fine.

    Refused are edges shorter than `coincidence` times the mean edge length, two faces with the same vertices, and
    folded faces: those whose boundary, seen along the vector area, crosses itself or has a corner within `clearance`
    times the face's mean edge length of another edge (spikes, faces without area).
    """
    soup = PolygonSoup.from_mesh(mesh)
    check_edges(soup, coincidence)
    check_duplicates(soup)
    check_folds(soup, clearance)


def check_indices(soup: PolygonSoup) -> None:
    """Finite coordinates, at least one face, three corners a face, corners that exist."""
    broken = np.flatnonzero(~(np.abs(soup.vertices) <= LARGEST).all(axis=1))
    if len(broken):
        raise MeshError(
            f"vertex {soup.vertex_name(broken[0])} is {tuple(soup.vertices[broken[0]].tolist())}: "
            f"coordinates must be finite numbers up to {LARGEST:.0e} {soup.counting}",
            elements=broken.tolist(),
            bound=LARGEST,
        )
    if soup.n_faces < 1:
        raise MeshError(
            f"there are no faces (vertices: {soup.n_vertices}): a mesh needs polygons, not points or curves"
        )
    small = np.flatnonzero(soup.face_sizes < 3)
    if len(small):
        size = int(soup.face_sizes[small[0]])
        raise MeshError(
            f"face {soup.face_name(small[0])} has {size} corner{'s' * (size != 1)}, at least 3 are needed: "
            f"remove it {soup.counting}",
            elements=small.tolist(),
            value=size,
            bound=3,
        )
    wrong = np.flatnonzero((soup.corners < 0) | (soup.corners >= soup.n_vertices))
    if len(wrong):
        face, vertex = int(soup.corner_face[wrong[0]]), int(soup.corners[wrong[0]])
        raise MeshError(
            f"face {soup.face_name(face)} names vertex {vertex + soup.count_from}, but the {soup.n_vertices} vertices "
            f"end at {soup.n_vertices - 1 + soup.count_from} {soup.counting}",
            elements=[face],
            value=vertex,
            bound=soup.n_vertices - 1,
        )


def check_touching(soup: PolygonSoup) -> None:
    """No face meets a vertex twice."""
    keys = np.sort(soup.corner_face * soup.n_vertices + soup.corners)
    twice = np.flatnonzero(keys[1:] == keys[:-1])
    if len(twice):
        face, vertex = divmod(int(keys[twice[0]]), soup.n_vertices)
        raise MeshError(
            f"face {soup.face_name(face)} touches itself: two of its corners are vertex {soup.vertex_name(vertex)} "
            f"or lie on it; split the face there or remove one of the corners {soup.counting}",
            elements=[face],
        )


def check_edges(soup: PolygonSoup, coincidence: float = COINCIDENCE) -> None:
    """No edge is shorter than `coincidence` times the mean edge length."""
    lengths = soup.edge_lengths / max(float(soup.edge_lengths.mean()), np.finfo(float).tiny)
    short = np.flatnonzero(lengths <= coincidence)
    if len(short):
        worst = short[0]
        tail, head = soup.corners[worst], soup.heads[worst]
        raise MeshError(
            f"face {soup.face_name(soup.corner_face[worst])}: its edge from vertex {soup.vertex_name(tail)} to vertex "
            f"{soup.vertex_name(head)} is {lengths[worst]:.2g} of the mean edge length long, more than "
            f"{coincidence:.2g} is needed; make the two one vertex or move them apart {soup.counting}",
            elements=np.unique(soup.corner_face[short]).tolist(),
            value=float(lengths[worst]),
            bound=coincidence,
        )


def check_duplicates(soup: PolygonSoup) -> None:
    """No two faces have the same vertices."""
    for size in np.unique(soup.face_sizes):
        faces = np.flatnonzero(soup.face_sizes == size)
        vertices = np.sort(soup.corners[soup.face_starts[faces][:, None] + np.arange(size)], axis=1)
        order = np.lexsort(vertices.T)
        same = np.flatnonzero((vertices[order][1:] == vertices[order][:-1]).all(axis=1))
        if len(same):
            first, second = sorted(faces[order[same[0] : same[0] + 2]].tolist())
            names = ", ".join(soup.vertex_name(vertex) for vertex in soup.corners[soup.corner_face == first])
            raise MeshError(
                f"faces {soup.face_name(first)} and {soup.face_name(second)} have the same vertices ({names}): "
                f"remove one of them {soup.counting}",
                elements=[first, second],
            )


def check_manifold(soup: PolygonSoup) -> None:
    """No edge has more than two faces."""
    counts = np.bincount(soup.corner_edge)
    crowded = np.flatnonzero(counts > 2)
    if len(crowded):
        corners = np.flatnonzero(soup.corner_edge == crowded[0])
        faces = soup.corner_face[corners].tolist()
        names = ", ".join(map(soup.face_name, faces[:-1])) + f" and {soup.face_name(faces[-1])}"
        tail, head = (soup.vertex_name(ends[corners[0]]) for ends in (soup.corners, soup.heads))
        raise MeshError(
            f"the edge from vertex {tail} to vertex {head} belongs to faces {names}, two at most are allowed: "
            f"remove a face, or read the sheets as meshes of their own {soup.counting}",
            elements=faces,
            value=len(faces),
            bound=2,
        )


def check_folds(soup: PolygonSoup, clearance: float = FOLD_CLEARANCE) -> None:
    """No face crosses itself or folds back on itself; see `check_faces`."""
    for size in np.unique(soup.face_sizes):
        faces = np.flatnonzero(soup.face_sizes == size)
        polygons = soup.corners[soup.face_starts[faces][:, None] + np.arange(size)]
        outlines = _flattened(soup.vertices[polygons])
        for step in range(1, int(size) - 1):
            distance = _distances(outlines, step)
            if (distance <= clearance).any():
                face, corner = np.argwhere(distance <= clearance)[0]
                ends = [soup.vertex_name(polygons[face, (corner + step + k) % size]) for k in (0, 1)]
                raise MeshError(
                    f"face {soup.face_name(faces[face])} folds back on itself: its vertex "
                    f"{soup.vertex_name(polygons[face, corner])} lies {distance[face, corner]:.2g} of the face's mean "
                    f"edge length from its edge from {ends[0]} to {ends[1]}, more than {clearance:.2g} is needed; "
                    f"remove the spike or the face {soup.counting}",
                    elements=[int(faces[face])],
                    value=float(distance[face, corner]),
                    bound=clearance,
                )
        for step in range(2, int(size) // 2 + 1):
            crossing = _crossings(outlines, step)
            if crossing.any():
                face, corner = np.argwhere(crossing)[0]
                names = [soup.vertex_name(polygons[face, (corner + k) % size]) for k in (0, 1, step, step + 1)]
                raise MeshError(
                    f"face {soup.face_name(faces[face])} crosses itself: its edge from vertex {names[0]} to {names[1]} "
                    f"meets its edge from {names[2]} to {names[3]}; list its corners in their order around it "
                    f"{soup.counting}",
                    elements=faces[np.flatnonzero(crossing.any(axis=1))].tolist(),
                )


def _flattened(polygons: FloatArray) -> FloatArray:
    """(n, k, 3) -> (n, k, 2): seen along the vector area, where each is largest, in its own mean edge lengths."""
    here = polygons - polygons.mean(axis=1, keepdims=True)
    lengths = np.linalg.norm(np.roll(here, -1, axis=1) - here, axis=2).mean(axis=1)
    here = here / lengths[:, None, None]
    normals = np.cross(here, np.roll(here, -1, axis=1)).sum(axis=1)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    flat = size[:, 0] < np.finfo(np.float32).eps  # no direction to look along: take the best plane
    if flat.any():
        scatter = np.einsum("nki,nkj->nij", here[flat], here[flat])
        normals[flat], size[flat] = np.linalg.eigh(scatter)[1][:, :, 0], 1.0
    normals /= size
    x_axis = np.cross(normals, np.eye(3)[np.argmin(np.abs(normals), axis=1)])
    x_axis /= np.linalg.norm(x_axis, axis=1, keepdims=True)
    axes = np.stack([x_axis, np.cross(normals, x_axis)], axis=2)
    outlines: FloatArray = here @ axes
    return outlines


def _distances(outlines: FloatArray, step: int) -> FloatArray:
    """(n, k) distance of each corner from the edge that begins `step` corners later."""
    start, end = np.roll(outlines, -step, axis=1), np.roll(outlines, -step - 1, axis=1)
    along, offset = end - start, outlines - start
    squares = np.einsum("nkc,nkc->nk", along, along)  # zero where an edge is seen end on
    shares = np.einsum("nkc,nkc->nk", offset, along)
    share = np.divide(shares, squares, out=np.zeros_like(squares), where=squares > 0)
    foot = np.clip(share, 0.0, 1.0)[:, :, None] * along
    distances: FloatArray = np.linalg.norm(offset - foot, axis=2)
    return distances


def _crossings(outlines: FloatArray, step: int) -> BoolArray:
    """(n, k) whether the edge from each corner crosses the edge that begins `step` corners later."""
    a, b, c, d = (np.roll(outlines, -shift, axis=1) for shift in (0, 1, step, step + 1))
    crossed: BoolArray = (_side(a, b, c) * _side(a, b, d) < 0) & (_side(c, d, a) * _side(c, d, b) < 0)
    return crossed


def _side(start: FloatArray, end: FloatArray, point: FloatArray) -> IntArray:
    """(n, k) 1 where the point is to the left of the line, -1 to the right."""
    along, offset = end - start, point - start
    return np.sign(along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0]).astype(np.int64)

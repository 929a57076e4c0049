"""STEP text of solids: one template per topology, filled from arrays over all solids that share it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabkit.errors import OutputError
from fabkit.parts import Topology
from geometry.arrays import BoolArray, FloatArray

__all__ = ["TOLERANCE_MM", "solid_entities", "solid_numbers"]

TOLERANCE_MM = 1e-7
"""What lies within this distance is one to the reader: two points, a point and its plane. OCCT's own, too."""

_POINT = "CARTESIAN_POINT('',(%s,%s,%s))"
_DIRECTION = "DIRECTION('',(%s,%s,%s))"


def solid_entities(topology: Topology, first: int) -> list[str]:
    """Entities `#<first>` and on of one closed solid, the first one its CLOSED_SHELL, to be filled in with a row of
    `solid_numbers` but for its measures.

    Lines and planes start at points of vertices, and the x direction of a plane is that of its face's first edge,
    so nothing is written twice.
    """
    entities = [""]

    def add(entity: str) -> str:
        entities.append(entity)
        return f"#<{first + len(entities) - 1}>"

    points = [add(_POINT) for _ in range(topology.n_vertices)]
    vertices = [add(f"VERTEX_POINT('',{point})") for point in points]
    directions: dict[tuple[int, int], str] = {}
    oriented: dict[tuple[int, int], str] = {}
    for low, high in topology.edges.tolist():
        direction = add(_DIRECTION)
        vector = add(f"VECTOR('',{direction},1.)")
        line = add(f"LINE('',{points[low]},{vector})")
        edge = add(f"EDGE_CURVE('',{vertices[low]},{vertices[high]},{line},.T.)")
        directions[low, high] = directions[high, low] = direction
        oriented[low, high] = add(f"ORIENTED_EDGE('',*,*,{edge},.T.)")
        oriented[high, low] = add(f"ORIENTED_EDGE('',*,*,{edge},.F.)")
    faces = []
    for face in range(topology.n_faces):
        loops = [loop.tolist() for loop in topology.loops(face)]
        start = tuple(loops[0][:2])
        placement = add(f"AXIS2_PLACEMENT_3D('',{points[start[0]]},{add(_DIRECTION)},{directions[start]})")
        plane = add(f"PLANE('',{placement})")
        bounds: list[str] = []
        for loop in loops:
            edges = ",".join(oriented[pair] for pair in zip(loop, loop[1:] + loop[:1], strict=True))
            edge_loop = add(f"EDGE_LOOP('',({edges}))")
            bounds.append(add(f"{'FACE_BOUND' if bounds else 'FACE_OUTER_BOUND'}('',{edge_loop},.T.)"))
        faces.append(add(f"ADVANCED_FACE('',({','.join(bounds)}),{plane},.T.)"))
    return [f"CLOSED_SHELL('',({','.join(faces)}))", *entities[1:]]


def solid_numbers(vertices: FloatArray, topology: Topology, names: Sequence[str]) -> FloatArray:
    """(k, m) numbers of k solids with vertices (k, n, 3): first volume in mm3, surface area in mm2 and centroid in mm;
    then points of vertices, directions of edges, normals of faces.

    Raises OutputError, with the name of the solid, where a number is not finite, an edge is shorter or a face narrower
    than TOLERANCE_MM, a face leaves its plane by more than that, or the volume is not positive.

    What fabkit.parts says about normals, volumes and centroids, in one pass, with coordinates in the first axis:
    three times as fast, and this is the larger half of the arithmetic of a file.
    """
    extents = np.abs(vertices).max(axis=(1, 2))
    _hold(np.isfinite(extents), names, extents, "has a vertex at {}")
    centre = vertices.mean(axis=1)
    points = np.ascontiguousarray(np.moveaxis(vertices - centre[:, None], 2, 0))
    along = points[:, :, topology.edges[:, 1]] - points[:, :, topology.edges[:, 0]]
    lengths = np.sqrt((along * along).sum(axis=0))
    shortest = lengths.min(axis=1)
    _hold(shortest > TOLERANCE_MM, names, shortest, f"has an edge of {{:.3g}} mm, needs over {TOLERANCE_MM:g} mm")

    corners = points[:, :, topology.corners]
    first = topology.loop_starts[topology.face_starts[:-1]]
    apex = corners[:, :, first[topology.corner_face]]
    here = corners - apex
    following = here[:, :, topology.next_corner]
    cross = np.stack([here[i - 2] * following[i - 1] - here[i - 1] * following[i - 2] for i in range(3)])
    double_areas = np.add.reduceat(cross, first, axis=2)
    areas = np.sqrt((double_areas * double_areas).sum(axis=0)) / 2
    reaches = np.sqrt(np.maximum.reduceat((here * here).sum(axis=0), first, axis=1))
    narrowest = (areas / reaches).min(axis=1)
    _hold(narrowest > TOLERANCE_MM, names, narrowest, f"has a face {{:.3g}} mm wide, needs over {TOLERANCE_MM:g} mm")
    normals = double_areas / (2 * areas)
    off = np.abs((here * normals[:, :, topology.corner_face]).sum(axis=0)).max(axis=1)
    _hold(off <= TOLERANCE_MM, names, off, f"has a face {{:.3g}} mm off its plane, allowed {TOLERANCE_MM:g} mm")

    cones = (apex * cross).sum(axis=0)
    volumes = cones.sum(axis=1) / 6
    _hold(volumes > 0, names, volumes, "encloses {:.3g} mm3; its faces must run counter-clockwise seen from outside")
    moments = np.einsum("kc,xkc->kx", cones, 3 * apex + here + following) / 24
    centroids = centre + moments / volumes[:, None]
    directions, normals = np.moveaxis(along / lengths, 0, 2), np.moveaxis(normals, 0, 2)
    columns = (volumes, areas.sum(axis=1), centroids, vertices, directions, normals)
    return np.concatenate([each.reshape(len(vertices), -1) for each in columns], axis=1)


def _hold(fine: BoolArray, names: Sequence[str], values: FloatArray, what: str) -> None:
    """Raise OutputError for the first solid that is not fine."""
    if not fine.all():
        worst = int(np.argmin(fine))
        raise OutputError(f"part {names[worst]} cannot be written: it {what.format(values[worst])}")

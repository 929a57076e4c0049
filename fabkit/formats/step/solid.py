"""STEP text of solids: one template per topology, filled from arrays over all solids that share it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fabkit.errors import OutputError
from fabkit.parts import Measures, SolidArray, Topology
from geometry.arrays import BoolArray, FloatArray

__all__ = ["STEP_ACCURACY_MM", "solid_entities", "solid_numbers"]

STEP_ACCURACY_MM = 1e-7
"""Accuracy of STEP files in mm, written into their header: a reader takes points that are closer for one
point, and a point that is closer to a plane as lying on it. It is also the default of OCCT."""

_POINT = "CARTESIAN_POINT('',(%s,%s,%s))"
_DIRECTION = "DIRECTION('',(%s,%s,%s))"


def solid_entities(topology: Topology, first: int) -> list[str]:
    """The entities of one closed solid, numbered from `first`; the first one is its CLOSED_SHELL. They are filled in
    with a row of `solid_numbers` without the measures at its beginning.

    Lines and planes refer to the points of vertices, and the x direction of a plane is that of its face's first edge,
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


def solid_numbers(batch: SolidArray, names: Sequence[str]) -> FloatArray:
    """(k, m) numbers of the k solids with these names: first the volume in mm3, the surface area in mm2 and the
    centroid in mm; then the points of vertices, directions of edges and normals of faces.

    Raises OutputError, with the name of the solid, where a number is not finite, an edge is shorter or a face narrower
    than STEP_ACCURACY_MM, a face is off its plane by more than that, or the volume is not positive.
    """
    t, of = batch.topology, Measures(batch.topology, batch.vertices)
    extents = np.abs(batch.vertices).max(axis=(1, 2))
    _require(np.isfinite(extents), names, extents, "has a vertex at {}")
    along = of.points[:, :, t.edges[:, 1]] - of.points[:, :, t.edges[:, 0]]
    lengths = np.sqrt((along * along).sum(axis=0))
    shortest = lengths.min(axis=1)
    _require(
        shortest > STEP_ACCURACY_MM,
        names,
        shortest,
        f"has an edge of {{:.3g}} mm, more than {STEP_ACCURACY_MM:g} mm are needed",
    )

    here = of.from_apex
    radii = np.sqrt(np.maximum.reduceat((here * here).sum(axis=0), t.first_corner, axis=1))
    narrowest = (of.areas / radii).min(axis=1)
    _require(
        narrowest > STEP_ACCURACY_MM,
        names,
        narrowest,
        f"has a face {{:.3g}} mm wide, more than {STEP_ACCURACY_MM:g} mm are needed",
    )
    deviations = np.abs(np.einsum("xkc,kcx->kc", here, of.normals[:, t.corner_face])).max(axis=1)
    _require(
        deviations <= STEP_ACCURACY_MM,
        names,
        deviations,
        f"has a face {{:.3g}} mm off its plane, allowed {STEP_ACCURACY_MM:g} mm",
    )

    volumes = of.volumes
    _require(volumes > 0, names, volumes, "encloses {:.3g} mm3; its faces must run counter-clockwise seen from outside")
    directions = np.moveaxis(along / lengths, 0, 2)
    columns = (volumes, of.areas.sum(axis=1), of.centroids, batch.vertices, directions, of.normals)
    return np.concatenate([each.reshape(len(volumes), -1) for each in columns], axis=1)


def _require(passes: BoolArray, names: Sequence[str], values: FloatArray, what: str) -> None:
    """Raise OutputError for the first solid whose value does not pass. what: the finding, with {} for the value."""
    if not passes.all():
        worst = int(np.argmin(passes))
        raise OutputError(f"part {names[worst]} cannot be written: it {what.format(values[worst])}")

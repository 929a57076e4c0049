"""STEP text of solids: one template per topology, filled from arrays over all solids that share it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from fabkit.errors import OutputError
from fabkit.formats.step.p_curves import p_curve_entities, p_curve_numbers
from fabkit.parts import SHAFT, Measures, Parts, SolidArray, Topology
from geometry.arrays import BoolArray, FloatArray, IntArray

__all__ = ["STEP_ACCURACY_MM", "Template", "by_template", "solid_entities", "solid_numbers"]

STEP_ACCURACY_MM = 1e-7
"""Accuracy of STEP files in mm, written into their header: a reader takes points that are closer for one
point, and a point that is closer to a plane as lying on it. It is also the default of OCCT."""

_POINT = "CARTESIAN_POINT('',(%s,%s,%s))"
_DIRECTION = "DIRECTION('',(%s,%s,%s))"

Template = tuple[Topology, tuple[bool, ...], tuple[str, ...]]
"""A topology; of the first ends of all rounds, then of the second ones, then of both ends of all fillets likewise,
which are oblique: the edges there are ellipses, not circles; and the names of the faces, if they have any."""


def by_template(parts: Parts[Any], rows: IntArray) -> list[tuple[Template, SolidArray]]:
    """The solids of these parts, by the template of their text; SolidArray.parts: places in rows."""
    found: list[tuple[Template, SolidArray]] = []
    for batch in parts.solids.by_topology(parts.shape[rows]):
        alike = np.zeros((len(batch.parts), 0), dtype=bool)
        if len(batch.topology.rounds) + len(batch.topology.fillets):
            of = Measures(batch.topology, batch.vertices)
            alike = np.concatenate([*np.abs(of.leans), *of.fillets.leans], axis=1) > STEP_ACCURACY_MM
        names = parts.kind.faces(parts.take(rows[batch.parts]), batch).tolist() if parts.kind.faces else []
        kinds: dict[Template, list[int]] = {}
        for k, oblique in enumerate(alike.tolist()):
            template = batch.topology, tuple(oblique), tuple(names[k]) if names else ()
            kinds.setdefault(template, []).append(k)
        found += [(template, batch[np.array(own)]) for template, own in kinds.items()]
    return found


def solid_entities(template: Template, first: int) -> list[str]:
    """The entities of one closed solid, numbered from `first`; the first one is its CLOSED_SHELL. They are filled in
    with a row of `solid_numbers` without the measures at its beginning.

    Lines and planes refer to the points of vertices, and the x direction of a plane is that of its face's first edge or
    towards the rim of its round, so nothing is written twice.
    """
    text = _SolidText(template, first)
    planes = np.setdiff1d(np.arange(text.topology.n_faces), text.topology.fillets[:, 0]).tolist()
    faces = [text.plane_face(face) for face in planes]
    rounds = [text.round_face(k) for k in range(len(text.topology.rounds))]
    fillets = [text.fillet_face(k) for k in range(len(text.topology.fillets))]
    return [f"CLOSED_SHELL('',({','.join([*faces, *rounds, *fillets])}))", *text.entities[1:]]


class _SolidText:
    """The entities of one solid: those of its vertices, straight edges and directions, and more with each face."""

    def __init__(self, template: Template, first: int) -> None:
        self.topology, self.oblique, self.names = template
        self.entities, self._first = [""], first
        t = self.topology
        centres = {*t.rounds[:, :3:2].ravel().tolist(), *t.fillets[:, 1:3].ravel().tolist()}
        self.points = [self.add(_POINT) for _ in range(t.n_vertices)]
        self.vertices = [
            "" if n in centres else self.add(f"VERTEX_POINT('',{point})") for n, point in enumerate(self.points)
        ]
        self.directions: dict[tuple[int, int], str] = {}
        self.oriented: dict[tuple[int, int], str] = {}
        for low, high in t.edges.tolist():
            self._add_line(low, high, self.add(_DIRECTION))
        self.axes = [self.add(_DIRECTION) for _ in t.rounds]
        self.across = [self.add(_DIRECTION) for _ in t.rounds]
        self.references = [self.add(_DIRECTION) for _ in t.fillets]
        self.normals = [self.add(_DIRECTION) for _ in range(t.n_faces)]
        self.cylinders: list[str] = []  # of all rounds
        self.circles: list[tuple[str, str]] = []  # of the ends of all rounds, in either direction
        for k, (*ends, low, high, _) in enumerate(t.rounds.tolist()):
            self._add_line(ends[1], ends[3], self.axes[k])
            place = self._placement(ends[0], self.axes[k], self.across[k])
            self.cylinders.append(self.add(f"CYLINDRICAL_SURFACE('',{place},%s)"))
            self.circles += [self._circle(k, 0, ends[0], ends[1], low), self._circle(k, 1, ends[2], ends[3], high)]
        for k in range(len(t.fillets)):
            self._add_arcs(k)

    def add(self, entity: str) -> str:
        self.entities.append(entity)
        return self._last

    @property
    def _last(self) -> str:
        return f"#<{self._first + len(self.entities) - 1}>"

    def _add_edge(self, low: int, high: int, curve: str) -> tuple[str, str]:
        edge = self.add(f"EDGE_CURVE('',{self.vertices[low]},{self.vertices[high]},{curve},.T.)")
        return self.add(f"ORIENTED_EDGE('',*,*,{edge},.T.)"), self.add(f"ORIENTED_EDGE('',*,*,{edge},.F.)")

    def _add_line(self, low: int, high: int, direction: str) -> None:
        vector = self.add(f"VECTOR('',{direction},1.)")
        self.directions[low, high] = self.directions[high, low] = direction
        line = self.add(f"LINE('',{self.points[low]},{vector})")
        self.oriented[low, high], self.oriented[high, low] = self._add_edge(low, high, line)

    def _circle(self, k: int, end: int, centre: int, rim: int, face: int) -> tuple[str, str]:
        """The edge of a round in a planar face, counter-clockwise seen from outside that face, and its reverse."""
        is_oblique = self.oblique[k + end * len(self.topology.rounds)]
        curve = self._curve(self._placement(centre, self.normals[face], self.across[k]), is_oblique)
        if is_oblique:
            self.entities += p_curve_entities(self._first + len(self.entities), curve, self.cylinders[k])
            curve = self._last
        return self._add_edge(rim, rim, curve)

    def _curve(self, place: str, is_oblique: bool) -> str:
        return self.add(f"{'ELLIPSE' if is_oblique else 'CIRCLE'}('',{place},%s{',%s' * is_oblique})")

    def _add_arcs(self, k: int) -> None:
        """Both arcs of a fillet, counter-clockwise seen from outside the planar faces in which they lie."""
        t, (_, *tips, sense) = self.topology, self.topology.fillets[k].tolist()
        first = 2 * len(t.rounds) + k
        corners = t.fillet_corners[k].tolist()
        for end, (tail, head) in enumerate((corners[1::-1], corners[:1:-1])):
            if sense != SHAFT:
                tail, head = head, tail
            place = self._placement(tips[end], self.normals[t.fillet_ends[k, end]], self.references[k])
            curve = self._curve(place, self.oblique[first + end * len(t.fillets)])
            self.oriented[tail, head], self.oriented[head, tail] = self._add_edge(tail, head, curve)

    def _placement(self, origin: int, z: str, x: str) -> str:
        return self.add(f"AXIS2_PLACEMENT_3D('',{self.points[origin]},{z},{x})")

    def plane_face(self, face: int) -> str:
        t, outer = self.topology, self.topology.outer_round[face]
        loops = [loop.tolist() for loop in t.loops(face)]
        bounds = [",".join(self.oriented[pair] for pair in pairwise([*loop, loop[0]])) for loop in loops]
        ends = [2 * k + end for k, end in np.argwhere(t.rounds[:, 4:6] == face).tolist()]
        bounds += [self.circles[n][0] for n in ends if n // 2 == outer]
        bounds += [self.circles[n][1] for n in ends if n // 2 != outer]
        x = self.across[outer] if outer >= 0 else self._along_first_side(loops[0])
        plane = self.add(f"PLANE('',{self._placement(t.face_vertex[face], self.normals[face], x)})")
        return self._face(bounds, plane, ".T.", self.names[face] if self.names else "")

    def _along_first_side(self, loop: list[int]) -> str:
        """The direction of the first straight side of a loop."""
        return next(self.directions[pair] for pair in pairwise([*loop, loop[0]]) if pair in self.directions)

    def fillet_face(self, k: int) -> str:
        t, (face, tip, _, sense) = self.topology, self.topology.fillets[k].tolist()
        (loop,) = (loop.tolist() for loop in t.loops(face))
        place = self._placement(tip, self.directions[loop[1], loop[2]], self.references[k])
        cylinder = self.add(f"CYLINDRICAL_SURFACE('',{place},%s)")
        bound = ",".join(self.oriented[pair] for pair in pairwise([*loop, loop[0]]))
        return self._face([bound], cylinder, ".T." if sense == SHAFT else ".F.")

    def round_face(self, k: int) -> str:
        """A cylinder as one face, which begins and ends at the line from rim to rim."""
        _, first_rim, _, second_rim, *faces, sense = self.topology.rounds[k].tolist()
        is_outer = [self.topology.outer_round[face] == k for face in faces]
        low, high = (self.circles[2 * k + end][int(is_outer[end])] for end in (0, 1))
        loop = [low, self.oriented[first_rim, second_rim], high, self.oriented[second_rim, first_rim]]
        return self._face([",".join(loop)], self.cylinders[k], ".T." if sense == SHAFT else ".F.")

    def _face(self, bounds: list[str], surface: str, same_sense: str, name: str = "") -> str:
        loops = [self.add(f"EDGE_LOOP('',({bound}))") for bound in bounds]
        added = [
            self.add(f"{'FACE_BOUND' if n else 'FACE_OUTER_BOUND'}('',{loop},.T.)") for n, loop in enumerate(loops)
        ]
        return self.add(f"ADVANCED_FACE('{name}',({','.join(added)}),{surface},{same_sense})")


def solid_numbers(template: Template, batch: SolidArray, names: Sequence[str]) -> FloatArray:
    """(k, m) numbers of the k solids with these names: first the volume in mm3, the surface area in mm2 and the
    centroid in mm; then the points of vertices (of a tip the centre of its fillet), directions of edges, axes, rims and
    faces, and radii.

    Raises OutputError, with the name of the solid, where a number is not finite, an edge is shorter or a face narrower
    than STEP_ACCURACY_MM, a face is off its plane by more than that, or the volume is not positive.
    """
    t, of = batch.topology, Measures(batch.topology, batch.vertices)
    extents = np.abs(batch.vertices).max(axis=(1, 2))
    _require(np.isfinite(extents), names, extents, "has a vertex at {}")
    along = of.points[:, :, t.edges[:, 1]] - of.points[:, :, t.edges[:, 0]]
    lengths = np.sqrt((along * along).sum(axis=0))
    shortest = lengths.min(axis=1, initial=np.inf)
    if len(t.rounds):
        shortest = np.minimum(shortest, np.minimum(of.shortest_sides, of.radii).min(axis=1))
    if len(t.fillets):
        shortest = np.minimum(shortest, of.fillets.radii.min(axis=1))
    _require(
        shortest > STEP_ACCURACY_MM,
        names,
        shortest,
        f"has an edge of {{:.3g}} mm, more than {STEP_ACCURACY_MM:g} mm are needed",
    )

    here = of.from_apex
    radii = np.sqrt(t.by_face(np.maximum, (here * here).sum(axis=0), empty=1.0))
    narrowest = (of.areas / radii).min(axis=1)
    _require(
        narrowest > STEP_ACCURACY_MM,
        names,
        narrowest,
        f"has a face {{:.3g}} mm wide, more than {STEP_ACCURACY_MM:g} mm are needed",
    )
    deviations = np.abs(np.einsum("xkc,kcx->kc", here, of.normals[:, t.corner_face])).max(axis=1, initial=0.0)
    if len(t.rounds):
        deviations = np.maximum(deviations, of.round_misfits.max(axis=1))
    if len(t.fillets):
        deviations = np.maximum(deviations, of.fillet_misfits.max(axis=1))
    _require(
        deviations <= STEP_ACCURACY_MM,
        names,
        deviations,
        f"has a face {{:.3g}} mm off its plane, allowed {STEP_ACCURACY_MM:g} mm",
    )

    volumes = of.volumes
    _require(volumes > 0, names, volumes, "encloses {:.3g} mm3; its faces must run counter-clockwise seen from outside")
    directions = np.moveaxis(along / lengths, 0, 2)
    points = batch.vertices
    if len(t.fillets):
        points = points.copy()
        points[:, t.fillets[:, 1:3]] = of.middles[:, None, None] + np.transpose(of.fillets.centres, (2, 3, 0, 1))
    columns = (volumes, of.surface_areas, of.centroids, points, directions, *_round_numbers(of, template[1]))
    return np.concatenate([each.reshape(len(volumes), -1) for each in columns], axis=1)


def _round_numbers(of: Measures, oblique: tuple[bool, ...]) -> list[FloatArray]:
    """Axes, directions of rims and references, normals of faces; of each round its radius, and the semi-axes
    of its edges with their places on it; semi-axes of the arcs of fillets, and radii of fillets."""
    n, m = len(of.topology.rounds), len(of.topology.fillets)
    if not n + m:
        return [of.normals]
    ends: list[FloatArray] = []
    arcs = of.fillets
    half_axes = np.sqrt((of.rims * of.rims).sum(axis=1))
    for k in range(n):
        radius = of.radii[:, k, None]
        ends.append(radius)
        for end in (0, 1):
            if oblique[k + end * n]:
                ends.append(half_axes[end, :, k, None])
            ends.append(radius)
            if oblique[k + end * n]:
                ends.append(p_curve_numbers(of, k, end))
    half_axes = np.sqrt(arcs.leans**2 + arcs.radii**2)
    for k in range(m):
        for end in (0, 1):
            is_oblique = oblique[2 * n + k + end * m]
            ends += [half_axes[end, :, k, None]] * is_oblique + [arcs.radii[:, k, None]]
    directions = [np.moveaxis(each, 0, 2) for each in (of.round_axes, of.round_across, arcs.reference)]
    return [*directions, of.normals, np.concatenate(ends, axis=1), arcs.radii]


def _require(passes: BoolArray, names: Sequence[str], values: FloatArray, what: str) -> None:
    """Raise OutputError for the first solid whose value does not pass. what: the finding, with {} for the value."""
    if not passes.all():
        worst = int(np.argmin(passes))
        raise OutputError(f"part {names[worst]} cannot be written: it {what.format(values[worst])}")

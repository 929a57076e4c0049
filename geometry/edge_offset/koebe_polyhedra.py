"""Koebe polyhedra: meshes with planar faces whose edges touch the unit sphere [Pottmann2007, 3.2, Fig. 9].

Each face meets the sphere in a circle that touches its edges. Each vertex is the apex of a cone that touches the
sphere along a circle. At the point of tangency of an edge the circles of its two faces touch, the circles of
its two vertices touch, and the one kind meets the other at right angles.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import ComplexArray, FloatArray, IntArray, floats, short_repr
from geometry.circle_patterns import CirclePattern, closed_circle_pattern, open_circle_pattern
from geometry.circle_patterns.planar_graphs import refuse_other_than_polyhedra
from geometry.edge_offset.centring import centring_similarity, centring_transformation
from geometry.errors import GeometryError, raise_worst
from geometry.gauss import edge_distances, edge_feet, face_distances
from geometry.mesh import Combinatorics, CombinatoricsLike, Mesh, as_combinatorics, as_gauss_image
from geometry.spheres import MoebiusTransformation, VertexCones
from geometry.spheres.stereographic import circle_planes, line_planes, pairs, poles

__all__ = ["KoebePolyhedron", "SphereCircles", "koebe", "lifted"]

EDGE_TANGENCY_TOLERANCE = 1e-9
"""Distance of an edge line from touching the sphere, and of a face from its plane over its mean edge length, that is
allowed: ten digits in a file are enough."""

OFF_AXIS_SHARE = 1e-6
"""Distance of a vertex from the axis, over the radius of its circle, above which it is not on the axis."""

LEAST_CIRCLE_DISTANCE = 1e-6
"""Least distance of the plane of a vertex circle from the origin: the vertex is at one over it, and its rounding grows
with the square."""

SMALLEST_CIRCLE_RADIUS = 1e-7
"""Smallest radius of a circle on the unit sphere: coordinates round by 1e-16, which is 1e-9 of it."""


@dataclass(frozen=True, eq=False)
class SphereCircles:
    """n circles on the unit sphere: the planes normal . x = distance; normals (n, 3) of length 1, distances (n,).

    >>> circles = SphereCircles([[0, 0, 1.0]], [0.6])
    >>> circles.centres.tolist(), circles.radii.round(9).tolist()
    ([[0.0, 0.0, 0.6]], [0.8])
    """

    __repr__ = short_repr

    normals: FloatArray
    distances: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "normals", floats(self.normals))
        object.__setattr__(self, "distances", floats(self.distances))

    @property
    def centres(self) -> FloatArray:
        """(n, 3) in the planes of the circles."""
        return floats(self.normals * self.distances[:, None])

    @property
    def radii(self) -> FloatArray:
        """(n,)"""
        return floats(np.sqrt(np.maximum((1 - self.distances) * (1 + self.distances), 0)))


@dataclass(frozen=True, eq=False)
class KoebePolyhedron:
    """A mesh S with planar faces whose edge lines touch the unit sphere, closed or open.

    Raises GeometryError, naming the worst edge or face, where an edge line misses the sphere or a face its plane by
    more than `tolerance` (of a face: over its mean edge length).

    >>> import numpy as np
    >>> from geometry.mesh.solids import cuboctahedron
    >>> mesh = cuboctahedron()
    >>> S = KoebePolyhedron(mesh * (1 / edge_distances(mesh)[0]))
    >>> S.tangency_points.shape, S.face_circles.radii.round(3).max().item()
    ((24, 3), 0.577)
    >>> moved = S.mapped(MoebiusTransformation.boost([0.3, 0, 0]))
    >>> bool(np.abs(edge_distances(moved.mesh) - 1).max() < 1e-9)
    True
    """

    __repr__ = short_repr

    mesh: Mesh
    tolerance: float = EDGE_TANGENCY_TOLERANCE

    def __post_init__(self) -> None:
        object.__setattr__(self, "mesh", as_gauss_image(self.mesh))
        S = self.mesh
        misses = np.abs(edge_distances(S) - 1)
        deviations = np.where(S.combinatorics.face_sizes > 3, S.planarity, 0.0)  # rounding of long thin triangles
        raise_worst(
            misses,
            "<=",
            self.tolerance,
            lambda edge, miss: (
                f"the line of {S.combinatorics.edge_name(edge)} misses the unit sphere by {miss:.1e}, allowed "
                f"{self.tolerance:.1e}: the mesh is not a Koebe polyhedron; make one of its combinatorics by koebe()"
            ),
        )
        raise_worst(
            deviations,
            "<=",
            self.tolerance,
            lambda face, deviation: (
                f"face {face} is off its plane by {deviation:.1e} of its mean edge length, allowed "
                f"{self.tolerance:.1e}: planarise the mesh first"
            ),
        )

    @cached_property
    def tangency_points(self) -> FloatArray:
        """(E, 3) where the edge lines touch the sphere."""
        return floats(edge_feet(self.mesh))

    @cached_property
    def face_circles(self) -> SphereCircles:
        """The circles in which the planes of the faces meet the sphere; normals point outwards."""
        return SphereCircles(self.mesh.face_normals, face_distances(self.mesh))

    @cached_property
    def vertex_circles(self) -> SphereCircles:
        """The circles along which the cones from the vertices touch the sphere; a vertex s is the pole of s . x = 1.

        Raises GeometryError for a vertex inside the sphere, where only one that belongs to no face can be.
        """
        axes, poles = self.vertex_cones.axes, self.vertex_cones.poles
        return SphereCircles(axes, 1 / np.linalg.norm(poles, axis=1))

    @cached_property
    def vertex_cones(self) -> VertexCones:
        """The cones from the vertices that touch the sphere; the edges lie on them."""
        return VertexCones(self.mesh.vertices, self.mesh.vertices)

    def normalised(self) -> KoebePolyhedron:
        """The Moebius image with the centre of the points of tangency at the origin [Springborn2005].

        It is unique up to rotations; for closed polyhedra the combinatorics determine it. Raises GeometryError where
        half of the points of tangency or more are nearly in one place, and for an open polyhedron with a vertex that
        has to go through infinity.
        """
        return self.mapped(centring_transformation(self.tangency_points))

    def mapped(self, transformation: MoebiusTransformation) -> KoebePolyhedron:
        """The Moebius image, a Koebe polyhedron of the same combinatorics [Pottmann2007, 3.2].

        Raises GeometryError, naming the vertex, where one goes to infinity or through it.
        """
        return KoebePolyhedron(transformation.map_mesh(self.mesh), self.tolerance)


def koebe(
    combinatorics: CombinatoricsLike,
    *,
    radii: Any = None,
    angles: Any = None,
    outer: int | None = None,
    coverage: float | None = None,
) -> KoebePolyhedron:
    """The Koebe polyhedron of these combinatorics [BobenkoSpringborn2004].

    A closed one is unique, but for Moebius transformations; its points of tangency have their centre at the origin,
    which leaves rotations. The graph must be planar, simple and 3-connected.

    An open one, a disc or a disc with holes, is what `open_circle_pattern` makes of `radii`, `angles` and `outer`,
    lifted to the sphere. coverage: above 0, at most 1, by default 0.5: the points of tangency have their centre at
    (0, 0, 1 - coverage), as have those that cover that part of the area of the sphere evenly, about the
    north pole. It is a Moebius transformation of S that the coverage decides.

    Raises MeshError, naming vertices or faces, where no polyhedron has these combinatorics. Raises GeometryError as
    `open_circle_pattern` does, for values given to a closed polyhedron, for a coverage out of range, for polygons
    nested so deeply that the smallest would be points, and for open patterns that overlap themselves so much that a
    vertex would be at infinity or beyond; those that overlap less are made.

    >>> import numpy as np
    >>> from geometry.mesh.tilings import hexagon_patch
    >>> S = koebe(hexagon_patch(4, 4), coverage=0.3)  # over three tenths of the sphere
    >>> bool(np.abs(edge_distances(S.mesh) - 1).max() < 1e-9)
    True
    """
    combinatorics = as_combinatorics(combinatorics)
    refuse_other_than_polyhedra(combinatorics)
    if combinatorics.is_boundary_edge.any():
        share = 0.5 if coverage is None else coverage
        if not 0 < share <= 1:
            raise GeometryError(
                f"the coverage is {share}: a number above 0 and at most 1 is needed", value=share, bound=1.0
            )
        return lifted(open_circle_pattern(combinatorics, radii=radii, angles=angles, outer=outer), share)
    given = {"radii": radii, "angles": angles, "outer": outer, "coverage": coverage}
    for name, value in given.items():
        if value is not None:
            raise GeometryError(f"{name} given for a closed polyhedron, which has no boundary: leave {name} out")
    return lifted(closed_circle_pattern(combinatorics), 1.0)


def lifted(pattern: CirclePattern, coverage: float) -> KoebePolyhedron:
    """A pattern of the plane on the sphere, its points of tangency centred at (0, 0, 1 - coverage).

    The first vertex that is not on the z axis is over the positive x axis.

    Raises GeometryError where the circle of a vertex would be half of the sphere or more. That is where an open pattern
    overlaps itself: else the cap of a circle contains no point of tangency, nor what was infinity in the plane, and
    were it half of the sphere, the centre would be beyond its plane, below the origin.
    """
    c = pattern.combinatorics
    z0, t0 = centring_similarity(pattern.tangency_points, coverage)
    factor = _turn(pattern, z0) / t0
    z, radii = (pattern.centres - z0) * factor, pattern.radii / t0
    with np.errstate(invalid="ignore"):
        normals, distances = circle_planes(pairs(z), radii)
    _refuse_points(c, z, radii)
    if pattern.edge_at_infinity is not None:
        lines, planes = _lines_at_infinity(pattern, z0, factor)
        normals[lines], distances[lines] = planes
    raise_worst(
        distances[: c.n_vertices],
        ">=",
        LEAST_CIRCLE_DISTANCE,
        lambda vertex, distance: (
            f"the plane of the circle of vertex {vertex} is at distance {distance:.2g} from the middle of the "
            f"sphere, at least {LEAST_CIRCLE_DISTANCE:.0e} is needed for its cone to have an apex: the circle pattern "
            "overlaps itself, ask for radii or angles that vary less along the boundary"
        ),
    )
    # counter-clockwise in the plane is counter-clockwise seen from inside the sphere: reflect it
    vertices = poles(normals[: c.n_vertices], distances[: c.n_vertices]) * [1, 1, -1]
    return KoebePolyhedron(Mesh(vertices, c))


def _refuse_points(c: Combinatorics, centres: ComplexArray, radii: FloatArray) -> None:
    """Raises GeometryError where a circle is so small on the sphere that coordinates cannot tell its points."""
    distances = np.abs(centres)
    with np.errstate(invalid="ignore"):
        on_sphere = 2 * radii / np.hypot(2 * distances, (distances - radii) * (distances + radii) - 1)
    small = int(np.nanargmin(on_sphere))
    if on_sphere[small] < SMALLEST_CIRCLE_RADIUS:
        what = f"vertex {small}" if small < c.n_vertices else f"face {small - c.n_vertices}"
        raise GeometryError(
            f"the circle of {what} has radius {on_sphere[small]:.1e} on the unit sphere, at least "
            f"{SMALLEST_CIRCLE_RADIUS:.0e} is needed to tell its points apart: polygons are nested too deeply there, "
            f"or too "
            "few around a long neck",
            elements=[small if small < c.n_vertices else small - c.n_vertices],
            value=float(on_sphere[small]),
            bound=SMALLEST_CIRCLE_RADIUS,
        )


def _turn(pattern: CirclePattern, z0: complex) -> complex:
    """The rotation, a complex number, that puts the first vertex which is not over z0 over the positive x axis."""
    n = pattern.combinatorics.n_vertices
    away = pattern.centres[:n] - z0
    first = int(np.argmax(np.abs(away) > OFF_AXIS_SHARE * np.nan_to_num(pattern.vertex_radii, posinf=0)))
    return complex(np.conj(away[first]) / np.abs(away[first]))


def _lines_at_infinity(
    pattern: CirclePattern, z0: complex, factor: complex
) -> tuple[IntArray, tuple[FloatArray, FloatArray]]:
    """The four circles that are lines, and normals (4, 3) and distances (4,) of their planes, for z -> (z - z0) factor.

    Opposite sides of the rectangle are parallel, neighbours perpendicular.
    """
    c, edge = pattern.combinatorics, pattern.edge_at_infinity
    lines = np.concatenate([c.edges[edge], c.n_vertices + c.edge_faces[edge]])
    touching = [np.flatnonzero((c.edges == v).any(axis=1)) for v in c.edges[edge]]
    touching += [np.flatnonzero((c.edge_faces == f).any(axis=1)) for f in c.edge_faces[edge]]
    on_line = [(pattern.tangency_points[edges[edges != edge]] - z0) * factor for edges in touching]
    middles = np.array([p.mean() for p in on_line])
    spreads = np.array([np.square(p - p.mean()).sum() for p in on_line])
    along = np.sqrt(spreads[:2].sum() - spreads[2:].sum())
    normals = np.array([1j, 1j, 1, 1]) * along / np.abs(along)
    outwards = (normals.conj() * (middles - middles.mean())).real
    normals = np.where(outwards > 0, normals, -normals)
    planes = line_planes(pairs(normals), (normals.conj() * middles).real)
    return lines, planes

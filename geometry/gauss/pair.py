"""The pair: a mesh M and its Gauss image S, parallel to it, with the same faces [Pottmann2007, 2 to 4]."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol, TypeAlias

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import GeometryError, described, raise_worst
from geometry.gauss.distances import DISTANCE_TOLERANCE, edge_distances, edge_feet, face_distances, vertex_distances
from geometry.gauss.lean import axis_lean
from geometry.mesh import Mesh, MeshLike, as_gauss_image, as_mesh
from geometry.parallel.blending import weight_ranges
from geometry.parallel.edge_parallelity import check_parallel, edge_factors
from geometry.spheres import LaguerreTransformation

__all__ = ["PARALLEL_TOLERANCE", "Pair", "PairLike", "as_pair", "points_inwards"]

PARALLEL_TOLERANCE = 1e-9
"""Largest distance that an end of an edge of S may lie off the direction of its edge of M; S has unit size."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A mesh M and its Gauss image S over the same `Combinatorics`, parallel up to `PARALLEL_TOLERANCE`.

    mesh: M, of any size, whose edges have a length; gauss_image: S, of unit size, about the origin. S may be exact or
    not, and edges of S may have no length or run against those of M. Distances are those of S from the origin, in the
    directions of M: where all edges, faces or vertices have distance 1, M has an exact offset of that kind
    [Pottmann2007, Prop. 2]. `nearest_parallel_pair` makes a pair of two meshes that lost their last digits.

    Raises MeshError where the faces differ or an edge of M has no length, and ParallelityError, naming the worst edge,
    where M and S are not parallel.

    >>> from geometry.mesh import solids
    >>> S = solids.cube()  # its faces touch the unit sphere
    >>> pair = Pair(S * 700.0, S)
    >>> pair.face_distances.round(9).tolist()
    [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
    >>> pair.offset_mesh(100.0).mean_edge_length
    1600.0
    >>> pair.is_inwards, Pair(S * 700.0, S * -1.0).is_inwards
    (False, True)
    """

    __repr__ = short_repr

    mesh: Mesh
    gauss_image: Mesh

    def __post_init__(self) -> None:
        object.__setattr__(self, "mesh", as_mesh(self.mesh))
        object.__setattr__(self, "gauss_image", as_gauss_image(self.gauss_image))
        check_parallel(self.mesh, self.gauss_image, PARALLEL_TOLERANCE, what="the Gauss image")
        if self.gauss_image.combinatorics is not self.mesh.combinatorics:
            object.__setattr__(self, "gauss_image", self.mesh.with_vertices(self.gauss_image.vertices))

    # --- measures

    @cached_property
    def vertex_distances(self) -> FloatArray:
        """(N,) distances of the vertices of S from the origin."""
        return floats(vertex_distances(self.gauss_image))

    @cached_property
    def edge_feet(self) -> FloatArray:
        """(E, 3) the nearest points to the origin of the edge lines of S: the points of tangency, where the lines touch
        the sphere."""
        return floats(edge_feet(self.gauss_image, self.mesh.edge_directions))

    @cached_property
    def edge_distances(self) -> FloatArray:
        """(E,) distances of the edge lines of S from the origin; times d, the heights of beams."""
        return floats(edge_distances(self.gauss_image, self.mesh.edge_directions))

    @cached_property
    def face_distances(self) -> FloatArray:
        """(F,) signed distances of the face planes of S from the origin, along the normals of M."""
        return floats(face_distances(self.gauss_image, self.mesh.face_normals))

    @cached_property
    def edge_factors(self) -> FloatArray:
        """(E,) the factors lambda of s_j - s_i = lambda (m_j - m_i), one over the unit of M [Pottmann2007, (1)]."""
        return floats(edge_factors(self.mesh, self.gauss_image))

    @property
    def reversed_edges(self) -> BoolArray:
        """(E,) which edges of M run against those of S: of these the edge factor is negative."""
        reversed_edges: BoolArray = self.edge_factors < 0
        return reversed_edges

    @property
    def mixed_vertices(self) -> IntArray:
        """(k,) the vertices around which some edges run as in S and some against, as on a saddle [Pottmann2007, 3.2]:
        beams end at two levels there."""
        edges = self.mesh.combinatorics.edges
        return integers(np.intersect1d(edges[self.edge_factors < 0], edges[self.edge_factors > 0]))

    @cached_property
    def leans(self) -> FloatArray:
        """(N,) angles in radians between the node axes s_i and the normals of M; see `axis_lean`."""
        return floats(axis_lean(self.mesh, self.gauss_image.vertices))

    @cached_property
    def is_inwards(self) -> bool:
        """Whether S points to the inside of M; see `points_inwards`."""
        return points_inwards(self.mesh, self.gauss_image)

    @property
    def distance_range(self) -> tuple[float, float]:
        """The distances d between which no edge of M + d S collapses: beyond them, one runs against that of M."""
        low, high = weight_ranges(np.array([1.0, 0.0]), np.stack([np.ones(self.mesh.n_edges), self.edge_factors]))[1]
        return float(low), float(high)

    def deviations(self, kind: str) -> FloatArray:
        """How far the distances of the edges (E,), faces (F,) or vertices (N,) of S from the origin are from 1, for the
        kinds "edge", "face" and "vertex"; those of faces without sign, as faces of M may be reversed."""
        if kind == "edge":
            return floats(np.abs(self.edge_distances - 1))
        if kind == "face":
            return floats(np.abs(np.abs(self.face_distances) - 1))
        return floats(np.where(self.mesh.combinatorics.is_used, np.abs(self.vertex_distances - 1), 0.0))

    def moves_from(self, mesh: Mesh, gauss_image: Mesh) -> tuple[FloatArray, FloatArray]:
        """(N,) how far M and (N,) S are from meshes with the same vertices: M over the mean edge length of `mesh`."""
        of_mesh = np.linalg.norm(self.mesh.vertices - mesh.vertices, axis=1) / mesh.mean_edge_length
        return floats(of_mesh), floats(np.linalg.norm(self.gauss_image.vertices - gauss_image.vertices, axis=1))

    # --- other pairs

    def offset_mesh(self, distance: float) -> Mesh:
        """M + d S, parallel to M too."""
        return self.mesh + self.gauss_image * distance

    def translated(self, vector: Any) -> Pair:
        """M moved by a vector (3,); S, which lies about the origin, does not move."""
        return Pair(self.mesh.translated(vector), self.gauss_image)

    def tilted(self, vector: Any) -> Pair:
        """S moved by a vector (3,): a Gauss image of M too, to which node axes lean [Pottmann2007, 4.4]."""
        return Pair(self.mesh, self.gauss_image.translated(vector))

    def reversed(self) -> Pair:
        """The faces of both reversed; vertices do not move."""
        return Pair(self.mesh.reversed(), self.gauss_image.reversed())

    def part(self, faces: IntArray) -> Pair:
        """Some of the faces (k,) of both; see `Mesh.part`."""
        return Pair(self.mesh.part(faces), self.gauss_image.part(faces))

    def outwards(self) -> Pair:
        """With the faces oriented to the side to which S points: `reversed` where S points inwards, else the pair
        itself."""
        return self.reversed() if self.is_inwards else self

    def laguerre(self, transformation: LaguerreTransformation, *, tolerance: float = DISTANCE_TOLERANCE) -> Pair:
        """M', S' from an S that is exact of any kind; S' is of the same kind [Pottmann2007, Prop. 4].

        The edges, the faces or the vertices of S have distance 1 from the origin up to `tolerance`. For other S
        give a larger one: M' and S' are parallel and planar all the same, but the distances change.
        M + d S goes to M' + d (c S' + u), with u and c the last column of A.
        Where the matrix has a negative determinant, the faces of both meshes are turned over, so that S' points
        outwards; their edges are then renumbered.

        Raises GeometryError where S is of no kind, naming the worst element of the nearest; and where a vertex of S'
        goes to infinity or through it, naming the vertex. Raises as `Pair` does where rounding leaves M' and S' not
        parallel, or an edge of M' without length.
        """
        self._check_kind(tolerance)
        apices, poles = transformation.map_lines(self.mesh.vertices, self.gauss_image.vertices, what="vertex")
        c = self.mesh.combinatorics
        c = c.reversed() if transformation.gauss_map.reverses_orientation else c
        return Pair(Mesh(apices, c), Mesh(poles, c))

    def _check_kind(self, tolerance: float) -> None:
        c = self.mesh.combinatorics
        kinds = {
            plural: self.deviations(kind)
            for plural, kind in [("edges", "edge"), ("faces", "face"), ("vertices", "vertex")]
        }
        names = {"edges": c.edge_name, "faces": "face {}".format, "vertices": "vertex {}".format}
        kind = min(kinds, key=lambda name: float(kinds[name].max()))
        raise_worst(
            kinds[kind],
            "<=",
            tolerance,
            lambda element, off: (
                f"the Gauss image is of no exact kind: it is nearest to having all {kind} at distance 1 from the "
                f"origin, but {names[kind](element)} is {off:.1e} off, allowed {tolerance:.0e}; take an exact Gauss "
                "image, or allow for more"
            ),
        )


class HasPair(Protocol):
    """An object that holds a pair: OptimisedPair, OffsetMesh, SupportStructure, Fins, or your own class."""

    @property
    def pair(self) -> Pair: ...


PairLike: TypeAlias = "Pair | HasPair"
"""A pair, or an object that holds one as `.pair`."""


def as_pair(given: Any) -> Pair:
    """The pair of an argument: a Pair itself, or `.pair` of an object that holds one. Raises GeometryError otherwise.

    >>> from geometry import Pair, SupportStructure
    >>> from geometry.mesh.solids import cube
    >>> pair = Pair(cube() * 700.0, cube())
    >>> as_pair(SupportStructure(pair, 120.0)) is pair
    True
    """
    pair = getattr(given, "pair", given)
    if not isinstance(pair, Pair):
        raise GeometryError(
            f"a Pair is needed, not {described(given)}: make one of a mesh and its Gauss image by "
            "Pair(mesh, gauss_image), or of a planar mesh by approximate_pair(mesh)"
        )
    return pair


def points_inwards(mesh: MeshLike, gauss_image: MeshLike) -> bool:
    """Whether S points to the inside of M: most feet of its edges lie below the faces of M beside them.

    For two meshes that may be parallel to a few digits only, such as those of files; of a `Pair` ask `is_inwards`.

    >>> from geometry.mesh import solids
    >>> points_inwards(solids.cube(), solids.cube()), points_inwards(solids.cube(), solids.cube() * -1.0)
    (False, True)
    """
    mesh = as_mesh(mesh)
    gauss_image = as_gauss_image(gauss_image)
    c = mesh.combinatorics
    feet = edge_feet(gauss_image, mesh.edge_directions)
    facing = np.einsum("ck,ck->c", feet[c.corner_edge], mesh.face_normals[c.corner_face])
    return bool(np.count_nonzero(facing < 0) > np.count_nonzero(facing > 0))

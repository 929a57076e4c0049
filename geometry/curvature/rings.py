"""Rings: meshes of generalised rotational symmetry about the z axis, quads and hexagons alike [Pottmann2007, 5].

A ring is a connected set of edges that are not in planes through the axis; the edges between rings are in such planes,
and are called meridian. Quads as in [Pottmann2007, Fig. 17] are of this kind, with a horizontal polyline for a ring,
and so are hexagons with rotational symmetry whose zigzags go around the axis. A mesh parallel to such a mesh S has the
rings nu_j s + tau_j e_z of S.

The plane of a face meets the axis in its apex, and all meridian edge lines of the face pass through it. So the face is
the difference of two fans from the apex, one over its edges in either ring, and the parallel face is the
difference of the same fans scaled by nu_j and nu_{j+1}. With A and B the areas of the fans, on the one side of S,

    area(F) = nu_{j+1}^2 B - nu_j^2 A,    area(F, sigma(F)) = nu_{j+1} B - nu_j A,

so H_F = H means that G_{j+1} B = G_j A for G = H nu^2 + nu: a first integral. Minimal meshes have nu_{j+1} B = nu_j A,
and no equation is to be solved.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from geometry.arrays import BoolArray, FloatArray, IntArray, floats, integers
from geometry.errors import MeshError, raise_worst
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_sums

__all__ = ["ROW_TOLERANCE", "Rings"]

MERIDIAN_SINE = 1e-9
"""Sine of the angle between the meridian planes of the ends of an edge, below which the edge counts as meridian."""

LEAST_RELATIVE_DIFFERENCE = 1e-9
"""Difference over the sum of its two terms, below which it is too inaccurate to divide by."""

ROW_TOLERANCE = 1e-9
"""Relative difference of the ratio A / B between faces of a row that is allowed: meshes count as exact to this."""


@dataclass(frozen=True, eq=False)
class Rings:
    """The rings 0 .. n_rings - 1 of a mesh S, and its rows of faces, row j between the rings j and j + 1.

    Raises MeshError where S is not of this kind: rings that do not follow each other one by one, a face that is not
    between two of them, a vertex on the axis, faces of a row that are not alike.
    """

    mesh: Mesh

    # --- combinatorics

    @cached_property
    def is_meridian(self) -> BoolArray:
        """(E,) whether an edge is in a plane through the axis."""
        i, j = self.mesh.combinatorics.edges.T
        flat, radii = self.mesh.vertices[:, :2], self.radii
        crossed = flat[i, 0] * flat[j, 1] - flat[i, 1] * flat[j, 0]
        meridian: BoolArray = np.abs(crossed) <= MERIDIAN_SINE * radii[i] * radii[j]
        return meridian

    @cached_property
    def radii(self) -> FloatArray:
        """(N,) distances of the vertices from the axis."""
        radii = np.linalg.norm(self.mesh.vertices[:, :2], axis=1)
        raise_worst(
            radii,
            ">",
            MERIDIAN_SINE * self.mesh.mean_edge_length,
            lambda vertex, _: (
                f"vertex {vertex} is on the z axis, about which the mesh is to be symmetric: open it there"
            ),
            error=MeshError,
        )
        return np.asarray(radii)

    @cached_property
    def of_vertices(self) -> IntArray:
        """(N,) the ring of each vertex; ring 0 is at the end with the lesser vertex number."""
        c = self.mesh.combinatorics
        i, j = c.edges[~self.is_meridian].T
        n, raw = connected_components(coo_array((np.ones(len(i)), (i, j)), shape=(c.n_vertices,) * 2), directed=False)
        links = np.unique(np.sort(raw[c.edges[self.is_meridian]], axis=1), axis=0)
        degrees = np.bincount(links.ravel(), minlength=n)
        graph = coo_array((np.ones(len(links)), tuple(links.T)), shape=(n, n)).tocsr()
        ends = np.flatnonzero(degrees == 1)
        if len(links) != n - 1 or degrees.max(initial=0) > 2 or len(ends) != 2:
            raise MeshError(
                f"edges that are not in planes through the z axis form {n} pieces, with {len(links)} pairs of "
                "neighbours: in a mesh of rotational symmetry they are rings, each next to the one before; turn the "
                "axis of the mesh to the z axis"
            )
        order = breadth_first_order(graph, raw[np.isin(raw, ends)][0], directed=False, return_predecessors=False)
        if len(order) != n:
            raise MeshError(f"the rings of the mesh are not connected: only {len(order)} of {n} are in one piece")
        return integers(np.argsort(order)[raw])

    @property
    def n_rings(self) -> int:
        return int(self.of_vertices.max()) + 1

    @cached_property
    def rows(self) -> IntArray:
        """(F,) the row of each face."""
        c = self.mesh.combinatorics
        per_corner = self.of_vertices[c.corners]
        low, high = (f.reduceat(per_corner, c.face_starts[:-1]) for f in (np.minimum, np.maximum))
        wrong = np.flatnonzero(high != low + 1)
        if len(wrong):
            raise MeshError(
                f"face {wrong[0]} has corners in the rings {low[wrong[0]]} to {high[wrong[0]]}: each face must lie "
                "between two neighbouring rings, in planes through the z axis at either side",
                elements=wrong.tolist(),
            )
        return integers(low)

    @cached_property
    def first_faces(self) -> IntArray:
        """(n_rings - 1,) a face of each row."""
        return integers(np.unique(self.rows, return_index=True)[1])

    @cached_property
    def meridian_edges(self) -> IntArray:
        """(n_rings - 1, 2) an edge from ring j to ring j + 1 for each row, of its first face."""
        c = self.mesh.combinatorics
        starts = np.flatnonzero(self._side == 2)  # corners whose half-edge runs up
        faces = c.corner_face[starts]
        place = np.searchsorted(faces, self.first_faces)
        up = starts[place]
        return integers(np.stack([c.corners[up], c.corners[c.next_corner[up]]], axis=1))

    @cached_property
    def _side(self) -> IntArray:
        """(C,) of the half-edge of a corner: 0 in the lower ring, 1 in the upper one, 2 running up, 3 running down."""
        c = self.mesh.combinatorics
        here, there = self.of_vertices[c.corners], self.of_vertices[c.corners[c.next_corner]]
        in_ring = np.where(here == self.rows[c.corner_face], 0, 1)
        return integers(np.where(here == there, in_ring, np.where(there > here, 2, 3)))

    # --- measures

    @cached_property
    def ratios(self) -> FloatArray:
        """(n_rings - 1,) A / B of each row: the areas of the fans, seen along the axis."""
        c = self.mesh.combinatorics
        here, there = self.mesh.vertices[c.corners], self.mesh.vertices[c.corners[c.next_corner]]
        fans = here[:, 0] * there[:, 1] - here[:, 1] * there[:, 0]
        lower, upper = (face_sums(c, np.where(self._side == side, fans, 0.0)) for side in (0, 1))
        ratios = -lower / upper
        expected = ratios[self.first_faces][self.rows]
        raise_worst(
            np.abs(ratios / expected - 1),
            "<=",
            ROW_TOLERANCE,
            lambda face, off: (
                f"face {face} differs from others of its row: the areas it spans with the z axis, over its "
                f"two rings, are in a ratio that differs by {off:.1e}, allowed {ROW_TOLERANCE:.0e}; the rings must be "
                "symmetric, or horizontal polylines that are scaled copies of each other"
            ),
            error=MeshError,
        )
        return np.asarray(ratios[self.first_faces])

    @cached_property
    def profiles(self) -> FloatArray:
        """(n_rings - 1, 2, 2) radius and height of the lower and the upper end of a meridian edge of each row.

        The radius of the upper end is negative where it is beyond the axis.
        """
        ends = self.mesh.vertices[self.meridian_edges]
        along = ends[:, 0, :2] / np.linalg.norm(ends[:, 0, :2], axis=1, keepdims=True)
        return np.stack([np.einsum("jek,jk->je", ends[:, :, :2], along), ends[:, :, 2]], axis=2)

    @cached_property
    def folds(self) -> IntArray:
        """Rings at which the meridians turn back by more than a right angle, as where S folds over itself."""
        steps = self.profiles[:, 1] - self.profiles[:, 0]
        return integers(np.flatnonzero(np.einsum("jk,jk->j", steps[1:], steps[:-1]) < 0) + 1)

    # --- parallel meshes

    def parallel_mesh(self, factors: FloatArray, mean: float) -> Mesh:
        """M with the rings nu_j s + tau_j e_z, for factors nu (n_rings,) that give it H = mean.

        The middle of its least and greatest height is at z = 0. Raises GeometryError for edges without end.
        """
        stretch = self._meridian_factors(factors, mean)
        (_, lower), (_, upper) = self.profiles.transpose(1, 2, 0)
        rises = stretch * (upper - lower) - factors[1:] * upper + factors[:-1] * lower
        shifts = np.concatenate([[0.0], np.cumsum(rises)])
        vertices = factors[self.of_vertices, None] * self.mesh.vertices
        vertices[:, 2] += shifts[self.of_vertices]
        vertices[:, 2] -= (vertices[:, 2].min() + vertices[:, 2].max()) / 2
        return self.mesh.with_vertices(vertices)

    def _meridian_factors(self, factors: FloatArray, mean: float) -> FloatArray:
        """(n_rings - 1,) lambda of the meridian edges, from radii, or from areas if that rounds less."""
        nu, after = factors[:-1], factors[1:]
        (r, _), (s, _) = self.profiles.transpose(1, 2, 0)
        p, q, v, w = self._row_areas
        wide = nu * v + after * w
        terms = np.stack([mean * wide / 2, (v + w) / 4])
        below = terms.sum(axis=0)
        above = mean * (nu**2 * p + after**2 * q) + nu * p + after * q + wide / 4
        by_radius = np.abs(s - r) / (np.abs(s) + np.abs(r))  # how many digits a quotient keeps
        by_face = np.abs(below) / np.abs(terms).sum(axis=0)
        raise_worst(
            np.maximum(by_radius, by_face),
            ">",
            LEAST_RELATIVE_DIFFERENCE,
            lambda row, _: (
                f"the meridian edges of row {row} of the mesh would be infinitely long: its inflection is there, while "
                "the Gauss image does not come nearer to the axis; take another radius, or more rows"
            ),
        )
        use_radius = by_radius >= by_face
        numerator = np.where(use_radius, after * s - nu * r, -above)
        return np.asarray(numerator / np.where(use_radius, s - r, below))

    @cached_property
    def _row_areas(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """For a face of each row: what its two chords cut off below and above, and each chord times the height.

        A chord joins the ends of the meridian edges that are in one ring; half the sum of the latter two is the area of
        the trapezoid between the chords.
        """
        c, mesh = self.mesh.combinatorics, self.mesh
        ends = mesh.vertices[self.meridian_edges]
        normals = mesh.face_normals[self.first_faces]
        parts: list[FloatArray] = []
        for side, sign in ((0, 1.0), (1, -1.0)):
            chosen = np.flatnonzero((self._side == side) & np.isin(c.corner_face, self.first_faces))
            rows = self.rows[c.corner_face[chosen]]
            here, there = mesh.vertices[c.corners[chosen]], mesh.vertices[c.corners[c.next_corner[chosen]]]
            fans = np.cross(here - ends[rows, side], there - ends[rows, side]) / 2
            chords = sign * np.cross(there - here, (ends[:, 1] - ends[:, 0])[rows])
            for vectors in (fans, chords):
                values = np.einsum("ck,ck->c", vectors, normals[rows])
                parts.append(floats(np.bincount(rows, values, minlength=len(self.first_faces))))
        return parts[0], parts[2], parts[1], parts[3]

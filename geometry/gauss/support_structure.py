"""The geometric support structure between two parallel meshes: node axes, transverse quads, heights, twist."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geometry.arrays import FloatArray, floats, short_repr
from geometry.errors import GeometryError, MeshError, finite_number, raise_worst
from geometry.gauss.axes import axis_directions
from geometry.gauss.lean import closed_mesh_advice
from geometry.gauss.pair import Pair, as_pair
from geometry.mesh import Mesh
from geometry.parallel.edge_parallelity import perpendicular_part

__all__ = ["SupportStructure"]

LEAST_QUAD_HEIGHT = 1e-3
"""Least height of a transverse quad over the nominal one: below it, the node axis lies in the edge."""


@dataclass(frozen=True, eq=False)
class SupportStructure:
    """The quads m_i, m_j, m_j + d s_j, m_i + d s_i over the edges of M [Pottmann2007, 2.1].

    pair: M and S, which points outwards; distance d > 0. Raises GeometryError where d is not positive, MeshError where
    a node axis lies in an edge.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import dome
    >>> structure = SupportStructure(Pair(dome(8, 3) * 10, dome(8, 3)), distance=0.2)
    >>> structure.quads.shape  # a transverse quad for each edge
    (56, 4, 3)
    >>> bool(structure.twists.max() < 1e-9), round((0.2 * structure.heights).max().item(), 3)  # beam height
    (True, 0.2)
    """

    __repr__ = short_repr

    pair: Pair
    distance: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "pair", as_pair(self.pair))
        finite_number("the distance between the two meshes", self.distance)
        if self.distance <= 0:
            raise GeometryError(f"the distance between the two meshes is {self.distance:g}, it must be above 0")
        self._check_heights()

    @property
    def mesh(self) -> Mesh:
        return self.pair.mesh

    @property
    def gauss_image(self) -> Mesh:
        return self.pair.gauss_image

    @cached_property
    def _transverse(self) -> FloatArray:
        """(E, 2, 3) the components of s_i and s_j perpendicular to the edge."""
        ends, t = self.gauss_image.vertices[self.mesh.combinatorics.edges], self.mesh.edge_directions
        return floats(perpendicular_part(ends, t[:, None]))

    @cached_property
    def axes(self) -> FloatArray:
        """(N, 3) unit node axes, outwards; zero for vertices that belong to no edge. [Pottmann2007, Prop. 1]"""
        return axis_directions(self.mesh, self.gauss_image.vertices)

    @property
    def heights(self) -> FloatArray:
        """(E,) distance of each edge line of S from the origin; times d, the height of the transverse quad."""
        return self.pair.edge_distances

    @cached_property
    def height_directions(self) -> FloatArray:
        """(E, 3) unit directions u in the central plane, perpendicular to the edge, outwards."""
        return floats(self._transverse.mean(axis=1) / self.heights[:, None])

    @cached_property
    def width_directions(self) -> FloatArray:
        """(E, 3) unit normals b = t x u of the central planes; they point to the right face."""
        return floats(np.cross(self.mesh.edge_directions, self.height_directions))

    @cached_property
    def twists(self) -> FloatArray:
        """(E,) angle in radians between the planes that the edge spans with the node axes at its two ends."""
        first, second = self._transverse[:, 0], self._transverse[:, 1]
        crossed = np.linalg.norm(np.cross(first, second), axis=1)
        return floats(np.arctan2(crossed, np.einsum("ek,ek->e", first, second)))

    @cached_property
    def offset_mesh(self) -> Mesh:
        """M + d S."""
        return self.pair.offset_mesh(self.distance)

    @cached_property
    def quads(self) -> FloatArray:
        """(E, 4, 3) corners of the transverse quads."""
        i, j = self.mesh.combinatorics.edges.T
        m, outer = self.mesh.vertices, self.offset_mesh.vertices
        return floats(np.stack([m[i], m[j], outer[j], outer[i]], axis=1))

    def _check_heights(self) -> None:
        advice = closed_mesh_advice(self.mesh)
        raise_worst(
            self.heights,
            ">=",
            LEAST_QUAD_HEIGHT,
            lambda edge, height: (
                f"the node axes at {self.mesh.combinatorics.edge_name(edge)} lie in the edge: its height is "
                f"{height:.1e} of the nominal one, at least {LEAST_QUAD_HEIGHT:.0e} is needed; "
                + (
                    advice
                    or "give more weight to the vertices when computing the Gauss image, or change the mesh there"
                )
            ),
            error=MeshError,
        )

"""A mesh with planar faces on a design surface, in one call."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats, short_repr
from geometry.layout import Boundary, LaidMesh, lay_quads
from geometry.mesh import Mesh
from geometry.meshing import Guides, OptimisedMesh, planarise
from geometry.surface import Surface, refined

__all__ = ["RemeshedSurface", "remesh"]


@dataclass(frozen=True, eq=False)
class RemeshedSurface:
    """A mesh with planar faces on a surface, and how it was made.

    surface: the smooth surface through the vertices of the given triangles, on which vertices glided.
    laid: the mesh as laid, with its lines, singular vertices and quality. planarised: the planar mesh, and how far
    vertices moved for it.

    >>> from geometry import Surface, remesh
    >>> from geometry.mesh import shapes
    >>> barrel = Surface(shapes.rotational_mesh([[2, 0.3 * k] for k in range(10)], 30, closed=False))
    >>> found = remesh(barrel, edge_length=0.5)
    >>> bool((found.surface_distances < 0.02).all()), len(found.laid.singularities)
    (True, 0)
    """

    __repr__ = short_repr

    surface: Surface
    laid: LaidMesh
    planarised: OptimisedMesh

    @property
    def mesh(self) -> Mesh:
        """The mesh with planar faces."""
        return self.planarised.mesh

    @cached_property
    def surface_distances(self) -> FloatArray:
        """(N,) distances of the vertices from the surface."""
        feet, _ = self.surface.closest(self.mesh.vertices)
        return floats(np.linalg.norm(self.mesh.vertices - feet, axis=1))


def remesh(
    surface: Surface,
    *,
    n_faces: int | None = None,
    edge_length: float | None = None,
    affine: Any = None,
    boundary: Boundary | Sequence[Boundary] = "open",
    strokes: Sequence[Any] = (),
    finer_where_curved: float = 1.0,
    fairness: float = 0.3,
) -> RemeshedSurface:
    """A mesh of planar, mostly quadrilateral faces on a surface, along a network of conjugate curves.

    n_faces or edge_length, affine, boundary, strokes, finer_where_curved: see `lay_quads`. fairness: see `Guides`;
    vertices glide on the surface, those at the boundary along it.

    Raises as `lay_quads` does, and as `planarise` does where the laid mesh has no planar one near it.

    >>> import numpy as np
    >>> from geometry import Surface
    >>> from geometry.mesh import shapes
    >>> plan = shapes.grid(20, 20).vertices / 10 - [1, 1, 0]
    >>> saddle = shapes.grid(20, 20).with_vertices(plan + [0, 0, 1] * (plan[:, :1] ** 2 / 2 - plan[:, 1:2] ** 2 / 4))
    >>> planar = remesh(Surface(saddle), n_faces=100)
    >>> bool(planar.mesh.planarity.max() < 1e-12), round(planar.laid.quality.quad_share, 1)
    (True, 1.0)
    """
    laid = lay_quads(
        surface,
        n_faces=n_faces,
        edge_length=edge_length,
        affine=affine,
        boundary=boundary,
        strokes=strokes,
        finer_where_curved=finer_where_curved,
    )
    smooth = refined(surface)
    return RemeshedSurface(
        smooth, laid, planarise(laid.mesh, Guides(surface=smooth, fairness=fairness, keep_boundary=True))
    )

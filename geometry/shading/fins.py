"""Fins: plates along the edges of M, between M + d1 S and M + d2 S."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from geometry.arrays import FloatArray, floats, short_repr
from geometry.errors import GeometryError, MeshError, raise_worst
from geometry.gauss import Pair, as_pair
from geometry.mesh import Mesh

__all__ = ["Fins"]

PANEL_PLANE_TOLERANCE = 1e-6
"""Distance of a corner of a panel from its plane that is allowed, over the mean edge length of the panel."""

LEAST_FIN_EDGE = -1e-9
"""Least signed length of an edge of M + d S over that of M; an edge may shrink to a point."""


@dataclass(frozen=True, eq=False)
class Fins:
    """The planar quads between M + d1 S and M + d2 S over the edges of M [Pottmann2007, Figs 1, 15].

    pair: M, whose faces are the panels, and S, which may be translated off the unit sphere, but points outwards at
    every corner of every panel. d1 = lower < d2 = upper, d2 > 0.

    Raises GeometryError for other distances, MeshError where a panel is not planar, a fin does not rise from a panel or
    crosses itself.

    >>> from geometry.mesh.shapes import dome
    >>> fins = Fins(Pair(dome(12, 3), dome(12, 3)), 0.0, 0.1)
    >>> fins.quads.shape
    (84, 4, 3)
    """

    __repr__ = short_repr

    pair: Pair
    lower: float
    upper: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "pair", as_pair(self.pair))
        if not (self.lower < self.upper and 0 < self.upper < np.inf and self.lower > -np.inf):
            raise GeometryError(
                f"fins from distance {self.lower:g} to {self.upper:g} cast no shadow: the first must be below the "
                "second, and that above 0",
                value=float(self.upper),
                bound=max(float(self.lower), 0.0),
            )
        self._check_planes()
        self._check_rises()
        self._check_lengths()

    @property
    def mesh(self) -> Mesh:
        return self.pair.mesh

    def tilted(self, shift: Any) -> Fins:
        """The fins over the Gauss image S + x, with the vector x = shift (3,)."""
        return replace(self, pair=self.pair.tilted(shift))

    @cached_property
    def quads(self) -> FloatArray:
        """(E, 4, 3) corners: along the lower edge, back along the upper one."""
        i, j = self.mesh.combinatorics.edges.T
        low, high = (self.pair.offset_mesh(d).vertices for d in (self.lower, self.upper))
        return floats(np.stack([low[i], low[j], high[j], high[i]], axis=1))

    @cached_property
    def areas(self) -> FloatArray:
        """(E,) of the fins, one side."""
        first, second = self.quads[:, 2] - self.quads[:, 0], self.quads[:, 3] - self.quads[:, 1]
        return floats(np.linalg.norm(np.cross(first, second), axis=1) / 2)

    @cached_property
    def rises(self) -> FloatArray:
        """(C,) n_F . s at each corner of each panel: how far S rises above its plane."""
        c = self.mesh.combinatorics
        normals = self.mesh.face_normals[c.corner_face]
        return floats(np.einsum("ck,ck->c", normals, self.pair.gauss_image.vertices[c.corners]))

    def _check_planes(self) -> None:
        raise_worst(
            self.mesh.planarity,
            "<=",
            PANEL_PLANE_TOLERANCE,
            lambda face, value: (
                f"face {face} is off its plane by {value:.1e} of its mean edge length, allowed "
                f"{PANEL_PLANE_TOLERANCE:.0e}: "
                "planarise the mesh first"
            ),
            error=MeshError,
        )

    def _check_rises(self) -> None:
        c, corner = self.mesh.combinatorics, int(self.rises.argmin())
        value = float(self.rises[corner])
        if not value > 0:
            raise MeshError(
                f"at vertex {c.corners[corner]} the Gauss image rises {value:.2e} above the plane of face "
                f"{c.corner_face[corner]}, it must be above 0, or fins lie behind their panel: take a Gauss image "
                "that points outwards there, or one translated less",
                elements=[int(c.corner_face[corner])],
                value=value,
                bound=0.0,
            )

    def _check_lengths(self) -> None:
        factors = self.pair.edge_factors
        for d in (self.lower, self.upper):
            edge = int((1 + d * factors).argmin())
            value = float(1 + d * factors[edge])
            if value < LEAST_FIN_EDGE:
                raise MeshError(
                    f"the fin at {self.mesh.combinatorics.edge_name(edge)} crosses itself: at distance {d:g} its edge "
                    f"is {value:.3g} of that of the mesh, at least 0 is needed; keep distances within "
                    f"{abs(1 / factors[edge]):.4g} of 0 on that side",
                    elements=[edge],
                    value=value,
                    bound=0.0,
                )

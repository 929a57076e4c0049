"""Parts as viewers show them: names, colours, solids and placements, and red bars in the place of beams left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from fabkit.errors import OutputError
from fabkit.kinds import BEAM
from fabkit.parts import LEFT_OUT_COLOUR, Assembly, Parts, Solids, prism_topology, prism_vertices
from geometry.arrays import FloatArray, IntArray

__all__ = ["Placed", "Surface", "left_out_bars", "placed_parts"]

GLASS_OPACITY = 0.35
"""Opacity of glass panels, from 0 (invisible) to 1."""
LEFT_OUT_BAR_THICKNESS = 0.03
"""Thickness of the red bar in the place of a beam that is left out, over the length of its edge: visible, but too thin
to be taken for a beam."""


@dataclass(frozen=True)
class Surface:
    """name: of a material. colour: sRGB.

    >>> from fabkit.formats.shown import Surface
    >>> Surface("panel glass", (0.5, 0.7, 0.8)).opacity < Surface("beam steel", (0.5, 0.5, 0.5)).opacity
    True
    """

    name: str
    colour: tuple[float, float, float]

    @property
    def opacity(self) -> float:
        return GLASS_OPACITY if "glass" in self.name.lower() else 1.0


@dataclass(frozen=True, eq=False)
class Placed:
    """Things to show. shape, surface (n,): which of the solids, and of the surfaces, each has. translations (n, 3) in
    mm, rotations (n, 4) as quaternions x, y, z, w. elements: of the mesh, -1 without one.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.shown import placed_parts
    >>> placed = placed_parts(built.assembly["beams"])
    >>> placed.names[:2], placed.rotations.shape
    (['B001', 'B002'], (30, 4))
    """

    names: Sequence[str]
    elements: IntArray
    solids: Solids
    shape: IntArray
    surfaces: Sequence[Surface]
    surface: IntArray
    translations: FloatArray
    rotations: FloatArray


def placed_parts(parts: Parts[Any]) -> Placed:
    """The parts of a kind, by their marks.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.shown import placed_parts
    >>> [surface.name for surface in placed_parts(built.assembly["panels"]).surfaces]
    ['panel glass 44.2']
    """
    turned = np.zeros((0, 4))
    if len(parts):
        turned = Rotation.from_matrix(parts.axes.transpose(0, 2, 1)).as_quat(canonical=True)
    return Placed(
        names=parts.marks,
        elements=parts.elements,
        solids=parts.solids,
        shape=parts.shape,
        surfaces=[Surface(f"{parts.kind.name} {each.name}", parts.kind.colour) for each in parts.materials],
        surface=parts.material,
        translations=parts.origins,
        rotations=turned,
    )


def left_out_bars(assembly: Assembly, lines: FloatArray | None) -> Placed:
    """Square bars about lines (n, 2, 3), in mm near zero: the ends of the edges of the beams that are left out, in the
    order of `assembly.left_out`.

    Raises `OutputError` where there is not one line for each beam.

    >>> from fabkit.formats.shown import left_out_bars
    >>> from fabkit.parts import Assembly, LeftOut
    >>> assembly = Assembly("roof", (), (LeftOut("beam", 7, "beam 7 has no room"),))
    >>> left_out_bars(assembly, np.array([[[0.0, 0, 0], [1000, 0, 0]]])).names
    ['left out: edge 7']
    """
    missing = [left.element for left in assembly.left_out if left.kind == BEAM.name]
    lines = np.zeros((0, 2, 3)) if lines is None else np.asarray(lines, dtype=np.float64)
    if lines.shape != (len(missing), 2, 3):
        raise OutputError(
            f"{len(missing)} beams are left out, so left_out_lines must have the shape ({len(missing)}, 2, 3), "
            f"found {lines.shape}; give the two end points of each of their edges"
        )
    along = lines[:, 1] - lines[:, 0]
    lengths = np.linalg.norm(along, axis=1)
    half = LEFT_OUT_BAR_THICKNESS / 2 * lengths[:, None]
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    local = prism_vertices(square * half[:, :, None], 0.0, lengths)
    least = np.eye(3)[np.abs(along).argmin(axis=1)]
    x = np.cross(least, along)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    z = along / lengths[:, None]
    return Placed(
        names=[f"left out: edge {element}" for element in missing],
        elements=np.full(len(missing), -1),
        solids=Solids.alike(lines[:, :1] + local @ np.stack([x, np.cross(z, x), z], axis=1), prism_topology(4)),
        shape=np.arange(len(missing)),
        surfaces=[Surface("left out", LEFT_OUT_COLOUR)],
        surface=np.zeros(len(missing), dtype=np.int64),
        translations=np.zeros((len(missing), 3)),
        rotations=np.tile([0.0, 0.0, 0.0, 1.0], (len(missing), 1)),
    )

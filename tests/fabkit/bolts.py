"""A kind of part that fabkit does not have: a bolt on each node block, with six corners, one of which is a nose. This
file is all there is of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fabkit.kinds.columns import counted, files, marks_and_counts, marks_at, masses, materials
from fabkit.parts import (
    Column,
    Details,
    Kind,
    Material,
    Measure,
    Parts,
    Ragged,
    Solids,
    Surroundings,
    Symmetry,
    Turns,
    prism_topology,
    prism_vertices,
    shifted,
)
from geometry.arrays import FloatArray, IntArray

__all__ = ["BOLT", "BoltDetails", "bolts"]

STEEL = Material("8.8", 7850.0)
RADIUS, NOSE, HEIGHT = 6.0, 7.0, 10.0


@dataclass(frozen=True, eq=False)
class BoltDetails(Details):
    """Of n bolts, which stand along z, a corner of the head on the x-axis.

    thread (n,): its name. torque_nm (n,). stamps: a number on each of the six sides, from that corner on; 0 follows the
    nose.
    """

    thread: npt.NDArray[Any]
    torque_nm: FloatArray
    stamps: Ragged


def bolts(vertices: IntArray, origins: FloatArray, axes: FloatArray, *, turned: IntArray) -> Parts[BoltDetails]:
    """Bolts at these vertices in these places, each turned by a number (n,) of sixths of a circle."""
    n = len(vertices)
    angles = np.pi / 3 * np.arange(6)
    stamps = (np.arange(6) + turned[:, None]) % 6
    radii = np.where(stamps == 0, NOSE, RADIUS)[..., None]
    heads = prism_vertices(radii * np.stack([np.cos(angles), np.sin(angles)], axis=1), 0.0, HEIGHT)
    x, y = np.cos(np.pi / 3 * turned), np.sin(np.pi / 3 * turned)
    ahead = x[:, None] * axes[:, 0] + y[:, None] * axes[:, 1]
    aside = x[:, None] * axes[:, 1] - y[:, None] * axes[:, 0]
    return Parts.each_its_own(
        BOLT,
        vertices,
        Solids.alike(heads, prism_topology(6)),
        origins=origins,
        axes=np.stack([ahead, aside, axes[:, 2]], axis=1),
        material=STEEL,
        details=BoltDetails(np.full(n, "M12", dtype=object), 80.0 + vertices, Ragged.of(list(stamps), dtype=np.int64)),
    )


def _turns(parts: Parts[BoltDetails], corners: FloatArray) -> Turns:
    """With each corner of the head on the x-axis."""
    along = corners[:, :6, :2] / np.linalg.norm(corners[:, :6, :2], axis=2, keepdims=True)
    return Turns(np.zeros_like(along), along, shifted(np.tile(np.arange(6), (len(parts), 1)), 6))


def _columns(parts: Parts[BoltDetails], around: Surroundings) -> list[Column]:
    nodes = marks_at(around.assembly["nodes"], parts.elements)
    return [
        *marks_and_counts(parts),
        Column("Thread", None, parts.details.thread[parts.firsts].tolist()),
        materials(parts),
        counted("Nodes", parts, nodes),
        *masses(parts),
        files(parts, "parts/{}.step"),
    ]


BOLT = Kind(
    name="bolt",
    group="bolts",
    element="vertex",
    letter="S",
    colour=(0.9, 0.8, 0.1),
    form="block",
    empty_details=BoltDetails(np.zeros(0, dtype=object), np.zeros(0), Ragged.of([], dtype=np.int64)),
    symmetry=Symmetry(("stamps",), (), _turns),
    columns=_columns,
    measures=lambda parts: [Measure("bolts", "Torque", "Nm", 0, parts.details.torque_nm)],
    labels=lambda parts, around: [f"{thread} bolt" for thread in parts.details.thread],
)

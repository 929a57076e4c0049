"""Solids of all sorts, and parts made of them, for what reads and writes single parts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from hypothesis import strategies as st

from fabkit.kinds import NODE, NodeDetails
from fabkit.parts import Frame, Material, Part, Solid, Topology, prism_topology, prism_vertices
from geometry.arrays import FloatArray
from tests.fabkit.assemblies import altered

__all__ = ["STEEL", "frame", "node", "prism", "prisms", "star", "topology", "tube"]

STEEL = Material("S355", 7850.0)


def prism(outline: Sequence[Sequence[float]] | FloatArray, height: float) -> Solid:
    """A prism over a polygon, its lower side in the plane z = 0."""
    return Solid(prism_vertices(np.asarray(outline, dtype=float), 0.0, height), prism_topology(len(outline)))


def tube(outer: float = 60.0, inner: float = 30.0, height: float = 100.0) -> Solid:
    """A square block with a square hole through it: two faces have an inner loop."""
    square = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
    vertices = [prism_vertices(square * width / 2, 0.0, height) for width in (outer, inner)]
    loops = [[[3, 2, 1, 0], [8, 9, 10, 11]], [[4, 5, 6, 7], [15, 14, 13, 12]]]
    for k in range(4):
        after = (k + 1) % 4
        loops.append([[k, after, after + 4, k + 4]])
        loops.append([[8 + after, 8 + k, 12 + k, 12 + after]])
    return Solid(np.concatenate(vertices), topology(16, loops))


def topology(n_vertices: int, faces: Sequence[Sequence[Sequence[int]]]) -> Topology:
    """From the loops of each face."""
    loops = [loop for face in faces for loop in face]
    return Topology(
        n_vertices,
        np.concatenate(loops),
        np.cumsum([0, *map(len, loops)]),
        np.cumsum([0, *map(len, faces)]),
    )


def star(n_points: int = 5, outer: float = 80.0, inner: float = 30.0, height: float = 20.0) -> Solid:
    """A prism over a star, which is not convex."""
    angles = np.pi * np.arange(2 * n_points) / n_points
    radii = np.where(np.arange(2 * n_points) % 2, inner, outer)
    return prism(np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1), height)


def frame(seed: int, reach: float = 1e4) -> Frame:
    """A frame anywhere, turned any way."""
    rng = np.random.default_rng(seed)
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return Frame(rng.normal(size=3) * reach, axes * np.linalg.det(axes))


def node(mark: str, solid: Solid, placement: Frame | None = None, element: int = 0, **changes: Any) -> Part:
    details = NodeDetails(
        beams=(), azimuths_deg=(), inclinations_deg=(), setbacks_mm=(), uncovered_percent=(), height_mm=0.0,
        top_step_mm=0.0, axis_misalignment_mm=0.0,
    )  # fmt: skip
    place = placement or Frame.world()
    made = Part(kind=NODE, mark=mark, solid=solid, placement=place, material=STEEL, element=element, details=details)
    return altered(made, **changes)


@st.composite
def prisms(draw: st.DrawFn) -> Solid:
    """Prisms over star-shaped polygons, from a tenth of a millimetre to tens of metres, turned, and far away."""
    n = draw(st.integers(3, 14))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    angles = 2 * np.pi * (np.arange(n) + rng.uniform(-0.2, 0.2, n)) / n
    radii = rng.uniform(0.4, 1.0, n)
    outline = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    size = 10 ** draw(st.floats(-1, 4))
    local = prism_vertices(outline, 0.0, rng.uniform(0.1, 3.0)) * size
    away = Frame(
        rng.uniform(-1, 1, 3) * size * draw(st.sampled_from([0.0, 1.0, 100.0])), frame(int(rng.integers(99))).axes
    )
    return Solid(away.to_world(local), prism_topology(n))

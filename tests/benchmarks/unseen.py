"""Twenty surfaces that nothing was tuned to, laid with the same defaults: `python tests/benchmarks/unseen.py [faces]`.

Freeform patches, minimal surfaces, saddles, holes, corners, wavy and oblique boundaries, small bumps, and a noisy scan.
Columns as in `laying.py`; ! marks what misses its bound, which is meant for 1 000 faces. The share of quads cannot be
held where lines meet a long boundary obliquely. The last row counts the surfaces that keep each bound. Names of
surfaces may follow the number of faces.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numerics import table
from rich.console import Console
from scipy.interpolate import RectBivariateSpline

sys.path.insert(0, str(Path(__file__).parents[2]))

from laying import COLUMNS, row

from geometry.arrays import FloatArray
from geometry.errors import GeometryError
from geometry.surface import Surface
from tests.geometry.design_surfaces import chart, disc

Point = Callable[[FloatArray, FloatArray], tuple[FloatArray, ...]]


def patch(seed: int, controls: int = 6, height: float = 0.35) -> Surface:
    """A bicubic B-spline over a rectangle, with random heights of its control points."""
    rng = np.random.default_rng(seed)
    spline = RectBivariateSpline(
        np.linspace(0, 1, controls), np.linspace(0, 1, controls), rng.normal(size=(controls,) * 2)
    )
    return chart(60, 44, lambda u, v: (3 * u, 2.2 * v, height * spline(u, v, grid=False)))


def graph(height: Callable[[FloatArray, FloatArray], FloatArray], a: float = 1.0, b: float = 1.0) -> Surface:
    """Over a rectangle of 2 a by 2 b about the origin."""
    n, m = int(50 * np.sqrt(a / b)), int(50 * np.sqrt(b / a))

    def point(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        x, y = a * (2 * u - 1), b * (2 * v - 1)
        return x, y, height(x, y)

    return chart(n, m, point)


def ring(inner: float, height: Callable[[FloatArray, FloatArray], FloatArray], shift: float = 0.0) -> Surface:
    """Over a disc with a round hole, which may be off its centre."""

    def point(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        radius = inner + (1 - inner) * v
        x, y = radius * np.cos(2 * np.pi * u) + shift * (1 - v), radius * np.sin(2 * np.pi * u)
        return x, y, height(x, y)

    return chart(96, 28, point, rings="u")


def wavy() -> Surface:
    """A paraboloid within a wavy boundary."""
    mesh = disc(34, lambda x, y: 0 * x).mesh
    x, y = mesh.vertices.T[:2]
    share = 1 + 0.12 * np.hypot(x, y) * np.sin(7 * np.arctan2(y, x))
    x, y = share * x, share * y
    return Surface(mesh.with_vertices(np.stack([x, y, -0.5 * x**2 - 0.25 * y**2], axis=1)))


def catenoid(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    z = 2 * v - 1
    return np.cosh(z) * np.cos(2 * np.pi * u), np.cosh(z) * np.sin(2 * np.pi * u), z


def cut_catenoid(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """Its ends are oblique to the lines."""
    z, angle = (2 * v - 1) * (1 + 0.3 * np.cos(2 * np.pi * u)), 2 * np.pi * u
    return np.cosh(z) * np.cos(angle), np.cosh(z) * np.sin(angle), z


def enneper(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """Over a square that is turned, so that lines meet its sides obliquely."""
    a, b = 1.4 * (u - 0.5) + 0.5 * (v - 0.5), 1.4 * (v - 0.5) - 0.5 * (u - 0.5)
    return a - a**3 / 3 + a * b**2, -b + b**3 / 3 - b * a**2, a**2 - b**2


def helicoid(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    return (0.3 + v) * np.cos(4 * u), (0.3 + v) * np.sin(4 * u), 1.2 * u


def canopy(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """A bent and twisted strip."""
    x, y = 4 * (u - 0.5), (v - 0.5) * (1.2 + 0.6 * np.cos(5 * u))
    return x, y + 0.2 * x**2, 0.5 * np.cos(1.2 * x) - 0.6 * y**2 + 0.25 * x * y


def trefoil_tube(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
    """A closed tube whose radius varies about a wavy ring."""
    a, b = 2 * np.pi * u, 2 * np.pi * v
    r = 0.8 + 0.15 * np.cos(3 * a)
    return (3 + r * np.cos(b)) * np.cos(a), (3 + r * np.cos(b)) * np.sin(a), r * np.sin(b) + 0.3 * np.sin(2 * a)


def scan() -> Surface:
    """A shell with noise of a hundredth of a triangle's edge."""
    mesh = graph(lambda x, y: 0.6 - 0.3 * x**2 - 0.2 * y**2 + 0.1 * x * y**2, 1.2).mesh
    noise = np.random.default_rng(5).standard_normal(mesh.vertices.shape)
    return Surface(mesh.with_vertices(mesh.vertices + 0.01 * mesh.mean_edge_length * noise))


UNSEEN: dict[str, Callable[[], Surface]] = {
    "patch 1": lambda: patch(1),
    "patch 2": lambda: patch(2),
    "patch 3": lambda: patch(3, controls=5),
    "patch 4": lambda: patch(4, controls=7, height=0.2),
    "patch 5": lambda: patch(5, controls=4, height=0.5),
    "sin sin": lambda: graph(lambda x, y: 0.5 * np.sin(1.7 * x) * np.sin(1.7 * y), 1.5),
    "eggs": lambda: graph(lambda x, y: 0.12 * np.sin(4 * x) * np.sin(4 * y), 1.5),
    "cos + cos": lambda: graph(lambda x, y: 0.3 * np.cos(2.2 * x) + 0.3 * np.cos(2.2 * y), 1.4),
    "hypar": lambda: graph(lambda x, y: 0.6 * x * y),
    "hypar, long": lambda: graph(lambda x, y: 0.4 * x * y + 0.1 * x**2, 1.8),
    "catenoid": lambda: chart(80, 40, catenoid, rings="u"),
    "catenoid, cut": lambda: chart(80, 40, cut_catenoid, rings="u"),
    "Enneper, turned": lambda: chart(50, 50, enneper),
    "helicoid": lambda: chart(60, 36, helicoid),
    "saddle with hole": lambda: ring(0.3, lambda x, y: 0.5 * x**2 - 0.4 * y**2, 0.2),
    "dome with hole": lambda: ring(0.25, lambda x, y: -0.6 * x**2 - 0.4 * y**2 + 0.1 * x**3, 0.3),
    "wavy paraboloid": wavy,
    "canopy": lambda: chart(90, 36, canopy),
    "bump": lambda: graph(lambda x, y: -0.15 * (x**2 + 2 * y**2) + 0.1 * np.exp(-12 * (x**2 + y**2))),
    "tube": lambda: chart(150, 48, trefoil_tube, rings="uv"),
    "scan": scan,
    "disc of four waves": lambda: disc(34, lambda x, y: 0.15 * (x**4 - 6 * x**2 * y**2 + y**4) + 0.3 * x**2),
}


def main(n_faces: int, names: list[str]) -> None:
    made = table(f"{n_faces} faces wanted", *COLUMNS)
    notes: list[str] = []
    held = [0] * len(COLUMNS)
    for name in names or UNSEEN:
        try:
            cells = row(name, UNSEEN[name](), n_faces)[0]
        except GeometryError as error:
            cells = [name, "!"]
            notes.append(f"{name}: {error.message}")
        made.add_row(*cells)
        for k in range(len(COLUMNS)):
            held[k] += k < len(cells) and "!" not in cells[k] and len(cells) == len(COLUMNS)
    made.add_row(f"hold of {len(names or UNSEEN)}", *(str(count) for count in held[1:]))
    console = Console(width=170)
    console.print(made)
    for note in notes:
        console.print(note)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000, sys.argv[2:])

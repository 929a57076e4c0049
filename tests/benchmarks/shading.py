"""How exact and how fast shade is: `python tests/benchmarks/shading.py [rays]`.

An evaluation and the translation with most shade of 289 panels under 20 suns, the latter against a grid of translations
on a sample of panels; how evaluations grow; 300 panels against rays, so many from each quarter of a panel.
Seconds are processor time. Set OPENBLAS_NUM_THREADS=1 where cores are shared.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from rich.console import Console
from rich.table import Table

from geometry.gauss import approximate_pair
from geometry.mesh import Mesh, shapes
from geometry.shading import Fins, Suns, cast_shadows, most_shade
from geometry.shading.panel_shadows import Blinds, shadow_areas
from tests.geometry.shadow_rays import shaded_shares

T = TypeVar("T")

SHIFT = (0.2, 0.5, 0.3)
HEIGHTS = (0.2, 0.4, 0.8)
SIZES = (256, 1024, 4096)


def timed(work: Callable[[], T]) -> tuple[T, float]:
    begun = time.process_time()
    result = work()
    return result, time.process_time() - begun


def roof(nx: int, ny: int) -> Mesh:
    """nx x ny planar quads about 1 long, no two alike: a curved translation surface, seen in a perspective."""
    u, v, radius = np.arange(nx + 1.0) - nx / 2, np.arange(ny + 1.0) - ny / 2, 2.0 * nx
    first = np.stack([u, 0 * u, -(u**2) / (2 * radius)], axis=1)
    second = np.stack([0 * v, v, 0.02 * v - v**2 / (2.5 * radius)], axis=1)
    mesh = shapes.translation_surface(first, second)
    return mesh.with_vertices(mesh.vertices / (1 + mesh.vertices[:, :2] @ [[0.1 / radius], [0.07 / radius]]))


def day(n: int) -> Suns:
    hours = np.linspace(-1.2, 1.2, n)
    height = np.radians(12 + 48 * np.cos(hours) ** 2)
    return Suns(np.stack([np.cos(height) * np.sin(hours), -np.cos(height) * np.cos(hours), np.sin(height)], axis=1))


def against_rays(rays: int) -> Table:
    table = Table(title=f"300 panels, 20 suns, {4 * rays} rays a panel")
    for column in ("d1", "d2", "x", "total per sun off by", "a panel off by", "a panel off by, mean"):
        table.add_column(column)
    mesh, suns = roof(20, 15), day(20)
    pair = approximate_pair(mesh)
    for lower, upper, shift in ((0.0, 0.4, (0.0, 0.0, 0.0)), (0.15, 0.6, SHIFT)):
        shading = cast_shadows(Fins(pair.tilted(shift), lower, upper), suns)
        shares = shaded_shares(mesh, shading.fins.quads, suns.directions, rays)
        totals = np.nansum(shares * shading.panel_areas, axis=1)
        off = np.abs(shares - shading.shares)
        worst = np.abs(shading.shadow_areas.sum(axis=1) / totals - 1).max()
        table.add_row(
            f"{lower}", f"{upper}", str(shift), f"{worst:.1e}", f"{np.nanmax(off):.1e}", f"{np.nanmean(off):.1e}"
        )
    return table


def evaluations() -> Table:
    table = Table("panels", "d2", "seconds", "share", "shadow per fin area", title="20 suns: one evaluation")
    suns = day(20)
    for n_faces in (289, *SIZES):
        n = round(n_faces**0.5)
        mesh = roof(n, n)
        pair = approximate_pair(mesh)
        for height in HEIGHTS if n_faces == 289 else HEIGHTS[1:2]:
            shading, seconds = timed(lambda p=pair, h=height: cast_shadows(Fins(p, 0.0, h), suns))
            table.add_row(
                f"{n_faces}",
                f"{height}",
                f"{seconds:.2f}",
                f"{shading.share:.3f}",
                f"{shading.shadow_per_fin_area:.3f}",
            )
    return table


def most() -> Table:
    table = Table(title="289 panels, 20 suns: the translation with most shade")
    columns = ("d1", "d2", "seconds", "x", "|x|", "share before", "after", "fin area", "shadow per fin area")
    for column in (*columns, "sample", "best of a grid there"):
        table.add_column(column)
    mesh, suns = roof(17, 17), day(20)
    pair, sample = approximate_pair(mesh), np.arange(0, 289, 12)
    for lower, upper in ((0.0, 0.3), (0.1, 0.4), (0.0, 1.2)):
        fins = Fins(pair, lower, upper)
        found, seconds = timed(lambda fins=fins: most_shade(fins, suns))
        areas = np.linalg.norm(mesh.vector_areas[sample], axis=1)
        whole = (found.before.facing[:, sample] * areas).sum()

        def share(x: np.ndarray, fins: Fins = fins, whole: float = whole) -> float:
            return float(
                shadow_areas(mesh, sample, Blinds.of(mesh, fins.tilted(x).quads, opaque=False), suns.directions).sum()
                / whole
            )

        grid = [x for x in translations() if risen(fins, x)]
        before, after = found.before, found.after
        table.add_row(
            f"{lower}",
            f"{upper}",
            f"{seconds:.1f}",
            np.array2string(found.shift, precision=3),
            f"{np.linalg.norm(found.shift):.3f}",
            f"{before.share:.4f}",
            f"{after.share:.4f}",
            f"{before.fins.areas.sum():.0f}, {after.fins.areas.sum():.0f}",
            f"{before.shadow_per_fin_area:.3f}, {after.shadow_per_fin_area:.3f}",
            f"{share(found.shift):.4f}",
            f"{max(share(x) for x in grid):.4f} of {len(grid)}",
        )
    return table


def translations() -> np.ndarray:
    """(n, 3) a grid in the ball of radius .99, and its places moved out to the sphere."""
    places = np.linspace(-0.99, 0.99, 7)
    grid = np.stack(np.meshgrid(places, places, places), axis=3).reshape(-1, 3)
    lengths = np.linalg.norm(grid, axis=1)
    outer = 0.99 * grid[lengths > 0] / lengths[lengths > 0, None]
    return np.concatenate([grid[lengths <= 0.99], np.unique(outer.round(12), axis=0)])


def risen(fins: Fins, x: np.ndarray) -> bool:
    normals = fins.mesh.face_normals[fins.mesh.combinatorics.corner_face]
    return bool((fins.rises + normals @ x).min() > 0)


if __name__ == "__main__":
    console = Console(width=160)
    console.print(evaluations())
    console.print(most())
    console.print(against_rays(int(sys.argv[1]) if len(sys.argv) > 1 else 1000))

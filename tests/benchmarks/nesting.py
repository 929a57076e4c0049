"""How long nesting takes and how many sheets it needs: `python tests/benchmarks/nesting.py [seconds for best]`.

Quads about 1.4 m on sheets of 6000 x 3210 mm, gap 10 mm, border 15 mm. The bound is the area of the panels over that
of the sheets less their borders; no nest reaches it.
"""

from __future__ import annotations

import math
import sys
import time
from typing import Literal

import numpy as np

from fabkit.kinds import PANEL, PanelDetails
from fabkit.parts import Finish, Frame, Material, Part, Parts, Solid, prism_topology, prism_vertices
from fabkit.production.nesting.nests import Sheet
from fabkit.production.nesting.sheet_nesting import nest_panels

GLASS = Material("glass", 2500.0)


def random_panels(n: int, n_corners: int = 4, seed: int = 0) -> Parts[PanelDetails]:
    """n polygons about 1400 mm across, no two alike."""
    rng = np.random.default_rng(seed)
    around = 2 * np.pi * (np.arange(n_corners) + 0.5) / n_corners
    regular = np.stack([np.cos(around), np.sin(around)], axis=1) * 1400 / (2 * np.sin(np.pi / n_corners))
    if n_corners > 4:
        regular /= 1.6
    outlines = regular + rng.normal(0.0, 120.0, (n, n_corners, 2))
    return Parts.of(PANEL, [_panel(f"P{k + 1}", outline) for k, outline in enumerate(outlines)])


def _panel(mark: str, outline: np.ndarray) -> Part:
    n = len(outline)
    edges = np.roll(outline, -1, axis=0) - outline
    solid = Solid(prism_vertices(outline, 0.0, 8.0), prism_topology(n))
    details = PanelDetails(
        layer=0,
        pane=0,
        finish=Finish(),
        thickness_mm=8.0, underside_mm=0.0, area_mm2=solid.volume_mm3 / 8.0,
        edge_lengths_mm=tuple(np.linalg.norm(edges, axis=1)), corner_angles_deg=(0.0,) * n,
        dihedrals_deg=(0.0,) * n, least_seats_mm=(0.0,) * n, largest_seats_mm=(0.0,) * n, steps_mm=(0.0,) * n,
        beams=(0,) * n, neighbours=(-1,) * n,
    )  # fmt: skip
    return Part(kind=PANEL, mark=mark, solid=solid, placement=Frame.world(), material=GLASS, element=0, details=details)


def main(seconds: float = 10.0) -> None:
    sheet = Sheet(6000.0, 3210.0)
    inside = (sheet.length_mm - 30) * (sheet.width_mm - 30)
    print("corners panels bound  mode  seconds sheets utilisation engine")
    modes: tuple[Literal["quick", "best"], ...] = ("quick", "best")
    for n_corners in (4, 6, 3):
        for n in (100, 1000):
            panels = random_panels(n, n_corners)
            bound = math.ceil(panels.details.area_mm2.sum() / inside)
            for mode in modes:
                start = time.perf_counter()
                nest = nest_panels(panels, sheet, gap_mm=10, border_mm=15, mode=mode, seconds=seconds)
                spent = time.perf_counter() - start
                print(f"{n_corners:7} {n:6} {bound:5}  {mode:5} {spent:7.2f} {nest.n_sheets:6} "
                      f"{nest.utilisation:11.3f} {nest.engine}")  # fmt: skip


if __name__ == "__main__":
    main(*(float(argument) for argument in sys.argv[1:]))

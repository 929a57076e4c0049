"""Fins as shading: how much of each panel they keep in the shade [Pottmann2007, 4.4 and Fig. 15].

Fins stand over the glass of figure 1, between M + d1 (S + x) and M + d2 (S + x): (a) x = 0, (b) x with the most shade;
both are drawn from the STEP files of their builds. Below, the panels without fins: from gold, in the sun, to blue, in
the shade, on average over the suns that they face. Fins over S + x are larger; the shadow per area of fins shows what
is due to their direction alone.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb

from docs.tools.drawing import GLASS, GOLD, Note, Panel, Shapes, View, draw_page, faces
from docs.tools.step_shapes import StepShapes
from examples.figure_01_layers_and_fins import LOWER_MM, UPPER_MM, built_with, roof, shaded, suns
from fabkit.pipeline import Built
from geometry.arrays import FloatArray
from geometry.shading import Fins, Shading, cast_shadows

LIT, DARK = "#f2c14e", "#1f3f66"


@cache
def upright() -> Built:
    return built_with()


@cache
def shade(letter: str) -> Shading:
    """What the fins of (a) and (b) shade."""
    pair, direction = shaded().structure.pair, (0.0, 0.0, 0.0) if letter == "a" else shaded().summary.fin_direction
    return cast_shadows(Fins(pair.tilted(direction), LOWER_MM, UPPER_MM), suns())


def mean_shares(shading: Shading) -> FloatArray:
    """(F,) part of each panel that fins shade, over all suns that reach it, by their weights."""
    weights = shading.suns.weights
    return np.asarray(weights @ shading.shadow_areas / (weights @ shading.sunlit_areas))


def main() -> dict[str, float]:
    found: dict[str, float] = {}
    for letter in "ab":
        shares = mean_shares(shade(letter))
        found |= {
            f"share in the shade, ({letter})": shade(letter).share,
            f"least share of a panel, ({letter})": float(shares.min()),
            f"largest share of a panel, ({letter})": float(shares.max()),
            f"shadow per area of fins, ({letter})": shade(letter).shadow_per_fin_area,
        }
    return found


def coloured(shading: Shading) -> Shapes:
    share = mean_shares(shading)[:, None]
    return faces(roof(), (1 - share) * np.array(to_rgb(LIT)) + share * np.array(to_rgb(DARK)), width=0.6)


def draw(path: Path) -> None:
    view, panels = View(-62, 30), []
    for left, letter, built in ((20, "a", upright()), (720, "b", shaded())):
        step = StepShapes.written(built.assembly)
        layers = [*step.shapes("panels", GLASS), *step.shapes("fins", GOLD)]
        panels += [
            Panel(layers, view, (left, 10, 660, 400)),
            Panel(coloured(shade(letter)), view, (left, 470, 660, 370)),
        ]
    letters = [Note(350, 440, "(a)"), Note(1050, 440, "(b)")]
    draw_page(path, 1400, 860, panels, letters)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_15.png")
    print(main())

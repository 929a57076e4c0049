"""Fins as shading: how much of each panel they keep in the shade [Pottmann2007, 4.4 and Fig. 15].

Fins stand over the glass of figure 1, between M + d1 (S + x) and M + d2 (S + x): (a) x = 0, (b) x with the most shade.
Below, the panels without fins: from gold, in the sun, to blue, in the shade, on average over the suns that they face.
Fins over S + x are larger; the shadow per area of fins shows what is due to their direction alone.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.colors import to_rgb

from docs.tools.drawing import GLASS, Note, Panel, Shapes, View, draw_page, faces
from examples.figure_01_layers_and_fins import plates, roof, shaded
from geometry.arrays import FloatArray
from geometry.shading import Shading

LIT, DARK = "#f2c14e", "#1f3f66"


def mean_shares(shading: Shading) -> FloatArray:
    """(F,) part of each panel that fins shade, over all suns that reach it, by their weights."""
    weights = shading.suns.weights
    return np.asarray(weights @ shading.shadow_areas / (weights @ shading.sunlit_areas))


def main() -> dict[str, float]:
    found, before = shaded(), mean_shares(shaded().before)
    after = mean_shares(found.after)
    return {
        "share in the shade, (a)": found.before.share,
        "share in the shade, (b)": found.after.share,
        "least share of a panel, (a)": float(before.min()),
        "least share of a panel, (b)": float(after.min()),
        "largest share of a panel, (a)": float(before.max()),
        "largest share of a panel, (b)": float(after.max()),
        "shadow per area of fins, (a)": found.before.shadow_per_fin_area,
        "shadow per area of fins, (b)": found.after.shadow_per_fin_area,
    }


def coloured(shading: Shading) -> Shapes:
    share = mean_shares(shading)[:, None]
    return faces(roof(), (1 - share) * np.array(to_rgb(LIT)) + share * np.array(to_rgb(DARK)), width=0.6)


def draw(path: Path) -> None:
    view, panels = View(-62, 30), []
    for left, shading in ((20, shaded().before), (720, shaded().after)):
        fins = [*faces(roof(), GLASS, width=0.5), *plates(shading.fins, slice(None), 0.03)]
        panels += [Panel(fins, view, (left, 10, 660, 400)), Panel(coloured(shading), view, (left, 470, 660, 370))]
    letters = [Note(350, 440, "(a)"), Note(1050, 440, "(b)")]
    draw_page(path, 1400, 860, panels, letters)


if __name__ == "__main__":
    draw(Path(__file__).parents[1] / "docs" / "gallery" / "figure_15.png")
    print(main())

"""Materials of OBJ: a small library file beside the mesh, which holds the colours of the faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray
from geometry.colours import ElementColours

__all__ = ["COLOUR_STEPS", "Materials", "face_materials"]

COLOUR_STEPS = 64
"""Number of colours, and so of materials, to which the values of faces are rounded: more cannot be distinguished by
eye."""


@dataclass(frozen=True, eq=False)
class Materials:
    """library: the name of the library file; text: its content; of_faces: the name of the material of each face."""

    library: str
    text: str
    of_faces: list[str]


def face_materials(colours: ElementColours, library: str) -> Materials:
    """A material for each colour of the faces.

    Colours that show values are rounded to the middle of one of COLOUR_STEPS equal steps of their scale; the names of
    these materials give the limits of their step.
    """
    if colours.scale is None or colours.values is None:
        eight_bits, index = np.unique(np.rint(colours.rgb * 255).astype(int), axis=0, return_inverse=True)
        names = [f"colour_{red:02x}{green:02x}{blue:02x}" for red, green, blue in eight_bits.tolist()]
        return _materials(library, names, eight_bits / 255, index.ravel())
    limits = np.linspace(colours.scale.low, colours.scale.high, COLOUR_STEPS + 1)
    step = np.clip(np.searchsorted(limits, colours.values, side="right") - 1, 0, COLOUR_STEPS - 1)
    steps, index = np.unique(np.where(np.isnan(colours.values), -1, step), return_inverse=True)
    names = [f"{limits[k]:.6g}_to_{limits[k + 1]:.6g}" if k >= 0 else "without_value" for k in steps]
    middles = np.where(steps >= 0, (limits[steps] + limits[steps + 1]) / 2, np.nan)
    return _materials(library, names, colours.scale.colours(middles), index)


def _materials(library: str, names: list[str], rgb: FloatArray, index: IntArray) -> Materials:
    """Materials of these names and colours (n, 3), of which face k has number index[k]."""
    lines = []
    for name, (red, green, blue) in zip(names, rgb.tolist(), strict=True):
        lines += [
            f"newmtl {name}",
            f"Kd {red:.6f} {green:.6f} {blue:.6f}",
            "Ka 0 0 0",
            "Ks 0 0 0",
            "d 1",
            "illum 1",
            "",
        ]
    return Materials(library, "\n".join(lines), [names[k] for k in index])

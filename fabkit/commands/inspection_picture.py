"""A picture of an inspection with several panels: curvatures, planarity, beam heights and lean as colours."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from fabkit.commands.inspection import Inspection
from fabkit.errors import ProjectError
from geometry.arrays import FloatArray
from geometry.colours import Elements
from geometry.curvature import face_curvatures
from geometry.mesh import Mesh
from geometry.pictures import default_view, plot

__all__ = ["check_picture", "draw_inspection"]

PANEL_SIZE = (5.6, 4.2)
"""Largest width and height of a panel with its colour bar, in inches."""

PANELS_IN_ROW = 3
"""Number of panels side by side."""

PIXELS_PER_INCH = 110
"""Resolution of the picture."""

MM_PER_M = 1000.0
"""Millimetres in a metre: curvatures are shown per metre, or per mean edge length, which is 1000 mm where a mesh has no
size."""

SHOWN_PERCENT = 98.0
"""Percentile of the curvatures at which the colours end; they begin at 100 minus it. A few faces bend far more than
others."""


@dataclass(frozen=True, eq=False)
class _Panel:
    title: str
    mesh: Mesh
    on: Elements = "faces"
    values: FloatArray | None = None
    label: str = ""
    value_range: tuple[float, float] | None = None


def check_picture(path: Path) -> None:
    """Raise ProjectError where matplotlib is missing, or the path is not that of a PNG."""
    if path.suffix.lower() != ".png":
        raise ProjectError(f"--picture {path}: the picture is a PNG, so choose a name that ends in .png")
    if find_spec("matplotlib") is None:
        raise ProjectError("--picture needs the package matplotlib: pip install 'fabkit[plot]'")


def draw_inspection(found: Inspection, path: Path) -> None:
    """Write a PNG with all known quantities; the inspection may have stopped early."""
    from matplotlib.figure import Figure

    panels = list(_panels(found))
    columns = min(PANELS_IN_ROW, len(panels))
    rows = -(-len(panels) // columns)
    width, height = PANEL_SIZE
    figure = Figure((width * columns, height * rows), dpi=PIXELS_PER_INCH, layout="compressed")
    places = figure.subplots(rows, columns, squeeze=False).ravel()
    view = default_view(found.file.mesh)
    for panel, axes in zip(panels, places, strict=False):
        plot(
            panel.mesh,
            panel.values,
            on=panel.on,
            value_range=panel.value_range,
            title=panel.title,
            label=panel.label,
            view=view,
            axes=axes,
        )
    for axes in places[len(panels) :]:
        axes.remove()
    figure.savefig(path, format="png", bbox_inches="tight", pad_inches=0.2)


def _panels(found: Inspection) -> Iterator[_Panel]:
    mesh, structure = found.file.mesh, found.structure
    missing = ", without Gauss image" if structure is None else ""
    yield _Panel(f"{found.file.path.name}: {mesh.n_faces} faces{missing}", mesh)
    yield _Panel("Planarity as read", mesh, "faces", mesh.planarity, "over the mean edge")
    if structure is None:
        return
    curvatures = face_curvatures(structure.pair)
    length = "m" if found.is_sized else "mean edge"
    for title, values, label in (
        ("Mean curvature H", curvatures.mean * MM_PER_M, f"1 / {length}"),
        ("Gaussian curvature K", curvatures.gaussian * MM_PER_M**2, f"1 / {length}²"),
    ):
        low, high = np.percentile(values, [100 - SHOWN_PERCENT, SHOWN_PERCENT]).tolist()
        yield _Panel(title, structure.mesh, "faces", values, label, (low, high))
    yield _Panel("Beam heights", structure.mesh, "edges", structure.heights, "over the nominal height")
    yield _Panel("Lean of node axes", structure.mesh, "vertices", np.degrees(structure.pair.leans), "degrees")

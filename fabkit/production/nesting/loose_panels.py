"""Panels from outlines alone, without a mesh, which are nested and drawn like those of a structure."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from fabkit.errors import NestingError
from fabkit.kinds import PANEL, PanelDetails
from fabkit.parts import Finish, Material, Parts, Ragged, Solids
from fabkit.production.nesting.nests import outline_areas
from geometry.errors import described, finite_number

__all__ = ["panels_from_outlines"]


def panels_from_outlines(
    outlines: Mapping[str, npt.ArrayLike], *, thickness_mm: float, material: Material
) -> Parts[PanelDetails]:
    """One panel for each outline, with the key as its mark; corners (k, 2) in mm, seen with the outer side up.

    Clockwise outlines are reversed, so that the outer side stays up; a last corner that repeats the first one is
    removed. Raises NestingError unless an outline has k >= 3 corners of two finite numbers, and for a thickness that is
    not above 0; GeometryError where it is not a number. `nest_panels` refuses outlines that cross themselves.

    >>> import numpy as np
    >>> from fabkit.parts import Material
    >>> from fabkit.production import Sheet, nest_panels, sheet_drawings
    >>> outlines = {f"T{k}": [[0, 0], [900, 0], [0, 400 + 50 * k]] for k in range(6)}
    >>> panels = panels_from_outlines(outlines, thickness_mm=10, material=Material("glass", 2500))
    >>> nest = nest_panels(panels, Sheet(3210, 2250), gap_mm=10, border_mm=15)
    >>> [drawing.name for drawing in sheet_drawings(nest, panels)], round(panels.masses_kg.sum())
    (['sheet-001'], 35)
    """
    if not isinstance(outlines, Mapping):
        raise NestingError(
            f"the outlines are {described(outlines)}: a dict from marks to corners is needed, such as "
            "{'P1': [(0, 0), (900, 0), (0, 400)]}"
        )
    if not isinstance(material, Material):
        raise NestingError(f"the material is {described(material)}: write Material('glass', 2500), density in kg/m3")
    if finite_number("the thickness in mm", thickness_mm) <= 0:
        raise NestingError(f"the thickness is {thickness_mm} mm: a number above 0 is needed")
    rows = Ragged.of([_corners(name, outline) for name, outline in outlines.items()], shape=(2,))
    sides = rows.rolled(np.ones(len(rows), dtype=np.int64)).values - rows.values
    back = -rows.with_values(sides).rolled(rows.sizes - 1).values
    cross, dot = sides[:, 0] * back[:, 1] - sides[:, 1] * back[:, 0], (sides * back).sum(axis=1)
    n = len(rows)
    thickness = np.full(n, float(thickness_mm))
    none, unknown = np.full(len(rows.values), -1), rows.with_values(np.full(len(rows.values), np.nan))
    return Parts(
        kind=PANEL,
        elements=np.arange(n),
        solids=Solids.prisms(rows, np.zeros(n), thickness),
        shape=np.arange(n),
        origins=np.zeros((n, 3)),
        axes=np.tile(np.eye(3), (n, 1, 1)),
        materials=(material,),
        material=np.zeros(n, dtype=np.int64),
        mark_names=tuple(outlines),
        mark=np.arange(n),
        details=PanelDetails(
            layer=np.zeros(n, dtype=np.int64),
            pane=np.zeros(n, dtype=np.int64),
            finish=np.full(n, Finish(), dtype=object),
            thickness_mm=thickness,
            underside_mm=np.zeros(n),
            area_mm2=outline_areas(rows),
            edge_lengths_mm=rows.with_values(np.linalg.norm(sides, axis=1)),
            corner_angles_deg=rows.with_values(np.degrees(np.arctan2(cross, dot)) % 360),
            dihedrals_deg=unknown,
            least_seats_mm=unknown,
            largest_seats_mm=unknown,
            steps_mm=unknown,
            beams=rows.with_values(none),
            neighbours=rows.with_values(none),
        ),
    )


def _corners(name: str, outline: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(k, 2) corners in mm, counter-clockwise, beginning with the first one given."""
    try:
        corners = np.asarray(outline, dtype=np.float64)
    except (TypeError, ValueError):
        raise NestingError(f"the outline of {name} has corners that are not all two numbers: give x, y in mm") from None
    if corners.ndim == 2 and len(corners) and np.array_equal(corners[0], corners[-1]):
        corners = corners[:-1]
    if not np.isfinite(corners).all():
        raise NestingError(f"the outline of {name} has coordinates that are not finite: give x, y in mm")
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise NestingError(f"the outline of {name} has shape {corners.shape}: give three or more corners x, y in mm")
    following = np.roll(corners, -1, axis=0)
    is_clockwise = (corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]).sum() < 0
    return np.roll(corners[::-1], 1, axis=0) if is_clockwise else corners

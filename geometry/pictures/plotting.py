"""`plot`: a mesh with numbers as colours, in axes of matplotlib."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.arrays import FloatArray
from geometry.colours import ColourScale, ElementColours, Elements, element_colours
from geometry.errors import GeometryError, described, finite_number
from geometry.mesh import Mesh, MeshLike, as_mesh
from geometry.pictures.mesh_polygons import mesh_polygons
from geometry.pictures.rendering import Polygons, View, fit, render

if TYPE_CHECKING:  # matplotlib is an extra, and large
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

__all__ = ["default_view", "plot"]

GLASS = np.array([214, 228, 236]) / 255
"""Colour of the outside of faces without values."""

LINEN = np.array([234, 223, 206]) / 255
"""Colour of their inside."""

INK = np.array([36, 48, 58]) / 255
"""Colour of edges of faces without values."""

CHALK = np.array([252, 252, 250]) / 255
"""Colour of edges between faces with values, which may be dark."""

CHALK_STRENGTH = 0.55
"""How far this colour covers that of the faces, so that edges do not outshine them."""

PAPER = np.array([247, 247, 245]) / 255
"""Colour of faces where edges show values."""

PICTURE_SIZE = (9.0, 6.0)
"""Width and height in inches of a figure that `plot` makes, of 100 pixels each."""

EDGE_WIDTHS = (0.3, 0.7)
"""Least and largest width in pixels that an edge takes from each of its faces."""

BEAM_WIDTHS = (1.0, 4.0)
"""The same of edges that show values."""

LEAST_CLEAR_EDGE_PIXELS = 12.0
"""Mean length in pixels from which on edges are drawn in their full colour; shorter ones would hide the faces."""

LONG_PLAN = 1.2
"""Ratio of length and width in plan from which on a mesh is seen from its longer side."""


def plot(
    mesh: MeshLike,
    values: Any = None,
    *,
    colours: Any = None,
    on: Elements | None = None,
    value_range: tuple[float, float] | None = None,
    title: str = "",
    label: str = "",
    view: tuple[float, float] | None = None,
    edges: bool = True,
    axes: Axes | None = None,
    path: str | PathLike[str] | None = None,
) -> Axes:
    """A shaded picture of a mesh, with numbers as colours and a bar that explains them.

    values: (F,) of faces, (N,) of vertices or (E,) of edges; see `geometry.colours.ColourScale` for their colours, and
    for value_range. colours: instead of values, (n, 3) integers up to 255 or other numbers up to 1. on: "faces",
    "vertices" or "edges", where the mesh has as many of two kinds. title stands above the picture, label at the bar.
    view: degrees about z from the x axis, and degrees above the horizon, from where one looks; see `default_view`.
    edges: whether they are drawn. axes: where to draw, as from `matplotlib.pyplot.subplots`; by default in a figure of
    its own, which `matplotlib.pyplot.show` shows. path: a file to write the figure to, such as a PNG.

    Returns the axes; `axes.figure` is the figure. What is hidden is hidden by depth, pixel by pixel.
    Raises GeometryError where matplotlib is missing, values fit no elements or several, or the file cannot be written.

    >>> from matplotlib.figure import Figure
    >>> from geometry.mesh import shapes
    >>> dome = shapes.dome(8, 3)
    >>> axes = plot(dome, dome.vertices[:, 2], label="height", axes=Figure((2, 2)).add_subplot())
    >>> [drawn.get_ylabel() for drawn in axes.figure.axes]  # the picture and its bar
    ['', 'height']
    """
    mesh = as_mesh(mesh)
    painted = element_colours(
        mesh, values, colours, on=on, value_range=value_range, choices=("faces", "vertices", "edges")
    )
    if axes is None:
        axes = _figure(shown=path is None).add_subplot()
    axes.set_axis_off()
    axes.set_title(title)
    if painted and painted.scale and painted.values is not None:
        _add_bar(axes, painted.values, painted.scale, label)
    _add_picture(axes, mesh, painted, _view(mesh, view), edges)
    if path is not None:
        _save(axes.figure, Path(path))
    return axes


def _view(mesh: Mesh, given: tuple[float, float] | None) -> View:
    if given is None:
        return View(*default_view(mesh))
    if np.shape(given) != (2,):
        raise GeometryError(f"the view is {described(given)}: two angles in degrees are needed, such as (-60, 35)")
    azimuth, elevation = given
    return View(finite_number("the azimuth of the view", azimuth), finite_number("its elevation", elevation))


def default_view(mesh: MeshLike) -> tuple[float, float]:
    """Where `plot` looks from, if no view is given: degrees about z from the x axis, and degrees above the horizon.

    From above, towards the longer side in plan; from in front where a mesh stands upright as a facade does.

    >>> from geometry.mesh import shapes
    >>> azimuth, elevation = default_view(shapes.grid(9, 3))
    >>> round(azimuth), elevation
    (-65, 35.0)
    """
    mesh = as_mesh(mesh)
    normal = mesh.vector_areas.sum(axis=0) / np.linalg.norm(mesh.vector_areas, axis=1).sum()
    if np.linalg.norm(normal[:2]) > max(0.5, abs(normal[2])):
        return float(np.degrees(np.arctan2(normal[1], normal[0]))) + 25.0, 15.0
    plan = mesh.vertices[mesh.combinatorics.is_used, :2]
    lengths, directions = np.linalg.eigh(np.cov(plan.T))
    if lengths[1] < LONG_PLAN**2 * lengths[0]:
        return -60.0, 35.0
    across = directions[:, 0] * (1 if directions[1, 0] < 0 else -1)  # from the south, where one stands before a plan
    return float(np.degrees(np.arctan2(across[1], across[0]))) + 25.0, 35.0


def _figure(*, shown: bool) -> Figure:
    """A new figure; one that is shown is known to pyplot, which keeps it."""
    try:
        import matplotlib.figure
    except ImportError as error:
        raise GeometryError("pictures need the package matplotlib: pip install 'fabkit[plot]'") from error
    if not shown:
        return matplotlib.figure.Figure(figsize=PICTURE_SIZE, dpi=100, layout="constrained")
    import matplotlib.pyplot

    return matplotlib.pyplot.figure(figsize=PICTURE_SIZE, dpi=100, layout="constrained")


def _add_bar(axes: Axes, values: FloatArray, scale: ColourScale, label: str) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import ListedColormap, Normalize
    from matplotlib.ticker import ScalarFormatter

    low, high = scale.low, scale.high
    if low == high:
        low, high = low - max(abs(low), 1.0) / 2, high + max(abs(high), 1.0) / 2
    shades = ListedColormap(scale.colours(np.linspace(low, high, 256)))
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    extend = ends[bool((values < scale.low).any()), bool((values > scale.high).any())]
    source, ticks = ScalarMappable(Normalize(low, high), shades), ScalarFormatter(useMathText=True)
    bar = axes.figure.colorbar(source, ax=axes, shrink=0.7, aspect=24, label=label, extend=extend, format=ticks)
    bar.outline.set_visible(False)
    if scale.low == scale.high:
        bar.set_ticks([scale.low])
    if np.isnan(values).any():
        bar.ax.set_title("grey: no value", fontsize="small", loc="left")


def _add_picture(axes: Axes, mesh: Mesh, painted: ElementColours | None, view: View, edges: bool) -> None:
    """Render as many pixels as the axes have."""
    if axes.figure.get_figure(root=True).get_layout_engine() is not None:
        axes.figure.get_figure(root=True).draw_without_rendering()
    box = axes.get_window_extent()
    width, height = max(int(box.width), 1), max(int(box.height), 1)
    camera = fit(view, mesh.vertices[mesh.combinatorics.is_used], width, height)
    polygons = _polygons(mesh, painted, edges, mesh.mean_edge_length * camera.scale)
    image = render(polygons, camera, width, height, shadows=painted is None)  # which would pass for values
    opacity = image[:, :, 3:]
    image[:, :, :3] = np.divide(image[:, :, :3], opacity, out=np.ones_like(image[:, :, :3]), where=opacity > 0)
    rows, columns = (np.flatnonzero(opacity.any(axis=(other, 2))) for other in (1, 0))
    seen = image[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]  # so that the title stands close to it
    axes.imshow(np.clip(seen, 0, 1), interpolation="antialiased")


def _polygons(mesh: Mesh, painted: ElementColours | None, edges: bool, edge_pixels: float) -> list[Polygons]:
    """The faces with the colours of their elements; edge_pixels: the mean length of an edge."""
    c = mesh.combinatorics
    everywhere = np.ones((c.n_corners, 1))
    front, back = everywhere * GLASS, everywhere * LINEN
    least, largest = EDGE_WIDTHS
    strength = float(np.clip(edge_pixels / LEAST_CLEAR_EDGE_PIXELS, 0, 1)) if edges else 0.0
    if painted and painted.on == "edges":
        front = back = everywhere * PAPER
        ink, strength, (least, largest) = painted.rgb[c.corner_edge], 1.0, BEAM_WIDTHS
    else:
        ink = everywhere * INK
        if painted:
            front = back = painted.rgb[c.corner_face if painted.on == "faces" else c.corners]
            ink, strength = everywhere * CHALK, strength * CHALK_STRENGTH
    width = float(np.clip(edge_pixels / 20, least, largest)) if strength else 0.0
    ink, at_boundary = front + strength * (ink - front), c.is_boundary_edge[c.corner_edge]
    if painted and painted.on != "edges":
        ink[at_boundary] = (front[at_boundary] + INK) / 2  # chalk is not seen against the paper
    widths = width * np.where(at_boundary, 2.0, 1.0)
    if painted and painted.on == "vertices" and painted.values is not None:  # colours do not lie between colours
        front = back = painted.values[c.corners, None]
        return mesh_polygons(mesh, front, back, widths=widths, ink=ink, scale=painted.scale)
    return mesh_polygons(mesh, front, back, widths=widths, ink=ink)


def _save(figure: Figure | SubFigure, path: Path) -> None:
    try:
        figure.get_figure(root=True).savefig(path, dpi="figure")
    except (OSError, ValueError) as error:
        raise GeometryError(f"the picture {path} cannot be written: {error}") from error

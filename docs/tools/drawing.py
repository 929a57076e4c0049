"""Pages of figures: shapes in a restrained palette, panels side by side, labels; rendered as `geometry.plot` does."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TypeAlias

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from PIL import Image

from geometry.arrays import FloatArray
from geometry.mesh import Mesh
from geometry.pictures.mesh_polygons import flat_normals, mesh_polygons
from geometry.pictures.rendering import Polygons, View, fit, render

__all__ = [
    "BLUE",
    "CLAY",
    "GLASS",
    "GOLD",
    "INK",
    "LINEN",
    "SAGE",
    "STEEL",
    "Label",
    "Note",
    "Panel",
    "Polygons",
    "Shapes",
    "View",
    "balls",
    "bars",
    "draw_page",
    "faces",
    "mixed",
    "polygons",
    "sphere",
    "tubes",
]

Shapes: TypeAlias = list[Polygons]

INK, STEEL = "#24303a", "#a2aeb8"
GLASS, LINEN = "#d6e4ec", "#eadfce"
BLUE, CLAY, GOLD, SAGE = "#3f7ea6", "#c96f4a", "#dcaa4b", "#7fa38a"


def _rgb(colour: str | FloatArray) -> FloatArray:
    return np.array(to_rgb(colour) if isinstance(colour, str) else colour)


def mixed(colours: Sequence[str], shares: FloatArray, *, white: float = 0.35) -> str:
    """A blend of colours, with some white."""
    return str(to_hex(white + (1 - white) * (shares @ np.array([to_rgb(colour) for colour in colours]))))


def polygons(
    corners: FloatArray,
    colour: str | FloatArray,
    *,
    back: str | FloatArray | None = None,
    width: float | FloatArray = 0.0,
    normals: FloatArray | None = None,
    ink: str = INK,
    opacity: float = 1.0,
) -> Polygons:
    """Polygons (n, k, 3). width: of their outlines in pixels, within each polygon. normals (n, k, 3): smooth."""
    n, k = corners.shape[:2]
    front, behind = (_spread(shade, n, k) for shade in (colour, colour if back is None else back))
    outline = np.broadcast_to(np.asarray(width, dtype=float), (n, k))
    normals = flat_normals(corners) if normals is None else normals
    return Polygons(corners, normals, front, behind, outline, _spread(ink, n, k), opacity)


def _spread(colour: str | FloatArray, n: int, k: int) -> FloatArray:
    """(n, k, 3) one colour, or colours (n, 3) of polygons, at their corners."""
    return np.broadcast_to(_rgb(colour)[..., None, :], (n, k, 3))


def faces(
    mesh: Mesh,
    colour: str | FloatArray = GLASS,
    *,
    back: str = LINEN,
    width: float = 0.7,
    opacity: float = 1.0,
    special: Mapping[str, Iterable[int]] | None = None,
) -> Shapes:
    """The faces of a mesh with their edges, in one colour or colours (F, 3); special: faces with a colour of their own,
    on both sides. Boundaries are drawn twice as wide, since only one face draws them."""
    c = mesh.combinatorics
    colours, backs = (np.broadcast_to(_rgb(shade), (mesh.n_faces, 3)).copy() for shade in (colour, back))
    for shade, chosen in (special or {}).items():
        colours[list(chosen)] = backs[list(chosen)] = _rgb(shade)
    widths = width * np.where(c.is_boundary_edge[c.corner_edge], 2.0, 1.0)
    ink = np.broadcast_to(_rgb(INK), (c.n_corners, 3))
    fronts, behind = colours[c.corner_face], backs[c.corner_face]
    return mesh_polygons(mesh, fronts, behind, widths=widths, ink=ink, opacity=opacity)


def bars(
    quads: FloatArray,
    across: FloatArray,
    colour: str,
    *,
    first: str | None = None,
    third: str | None = None,
    width: float = 0.5,
) -> Shapes:
    """Solids from flat quads (n, 4, 3), thickened by `across` (n, 3) to either side; first, third: colours of what
    stands over these sides of the quads."""
    left, right = quads - across[:, None], quads + across[:, None]
    sides = [np.stack([left[:, i], left[:, (i + 1) % 4], right[:, (i + 1) % 4], right[:, i]], axis=1) for i in range(4)]
    shades = [colour, colour, first or colour, colour, third or colour, colour]
    colours = np.repeat([to_rgb(shade) for shade in shades], len(quads), axis=0)
    return [polygons(np.concatenate([right[:, ::-1], left, *sides]), colours, width=width)]


def tubes(segments: FloatArray, radius: float, colour: str, *, sides: int = 16, cap_width: float = 0.0) -> Shapes:
    """Round bars along segments (n, 2, 3); cap_width: of the lines around their ends."""
    along = segments[:, 1] - segments[:, 0]
    least = np.eye(3)[np.abs(along).argmin(axis=1)]
    x = np.cross(along, least)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(along, x) / np.linalg.norm(along, axis=1, keepdims=True)
    angles = 2 * np.pi / sides * np.arange(sides + 1)
    out = np.cos(angles)[:, None, None] * x + np.sin(angles)[:, None, None] * y
    low, high = segments[:, 0] + radius * out, segments[:, 1] + radius * out
    corners = np.stack([low[:-1], low[1:], high[1:], high[:-1]], axis=2).reshape(-1, 4, 3)
    normals = np.stack([out[:-1], out[1:], out[1:], out[:-1]], axis=2).reshape(-1, 4, 3)
    caps = np.concatenate([low[:-1, ::-1].swapaxes(0, 1)[:, ::-1], high[:-1].swapaxes(0, 1)])
    return [polygons(corners, colour, normals=normals), polygons(caps, colour, width=cap_width)]


def balls(centres: FloatArray, radius: float, colour: str) -> Shapes:
    """Small round dots in space."""
    ball, normals = _ball(16)
    corners = centres[:, None, None] + radius * ball
    return [polygons(corners.reshape(-1, 4, 3), colour, normals=np.tile(normals, (len(centres), 1, 1)))]


def sphere(radius: float, colour: str, *, opacity: float = 1.0) -> Shapes:
    """A sphere about the origin."""
    ball, normals = _ball(48)
    return [polygons(radius * ball, colour, normals=normals, opacity=opacity)]


def _ball(n: int) -> tuple[FloatArray, FloatArray]:
    """Quads (2 n n, 4, 3) on the unit sphere, and their normals."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 2 * n + 1), np.linspace(0, np.pi, n + 1), indexing="ij")
    points = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=2)
    corners = np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2).reshape(-1, 4, 3)
    return corners, corners


# --- the page


@dataclass(frozen=True, eq=False)
class Label:
    """Text at a point in space, moved by pixels (right, up)."""

    point: FloatArray
    text: str
    offset: tuple[float, float] = (0.0, 0.0)
    colour: str = INK
    size: float = 21.0


@dataclass(frozen=True, eq=False)
class Panel:
    """Shapes as seen from a view, in a box (left, top, width, height) of the page in pixels.

    They fill the box, unless scale gives the pixels per unit of length.
    """

    shapes: Shapes
    view: View
    box: tuple[int, int, int, int]
    labels: Sequence[Label] = ()
    scale: float | None = None


@dataclass(frozen=True)
class Note:
    """Text on the page, at pixels from its left and top."""

    x: float
    y: float
    text: str
    size: float = 21.0


def draw_page(path: Path, width: int, height: int, panels: Sequence[Panel], notes: Sequence[Note] = ()) -> None:
    """Write a PNG of width x height pixels."""
    page = np.ones((height, width, 3))
    with matplotlib.rc_context({"mathtext.fontset": "stix", "font.family": "STIXGeneral"}):
        figure = Figure(figsize=(width / 100, height / 100), dpi=100)
        axes = figure.add_axes((0, 0, 1, 1))
        axes.set(xlim=(0, width), ylim=(height, 0))
        axes.axis("off")
        for panel in panels:
            left, top, w, h = panel.box
            camera = fit(
                panel.view, np.concatenate([s.corners.reshape(-1, 3) for s in panel.shapes]), w, h, panel.scale
            )
            image = render(panel.shapes, camera, w, h)
            page[top : top + h, left : left + w] *= 1 - image[:, :, 3:]
            page[top : top + h, left : left + w] += image[:, :, :3]
            for label in panel.labels:
                x, y = camera.project(label.point)[:2]
                right, up = label.offset
                _add_text(axes, left + x + right, top + y - up, label.text, label.size, label.colour)
        for note in notes:
            _add_text(axes, note.x, note.y, note.text, note.size, INK)
        figure.figimage(page, zorder=-1)
        buffer = BytesIO()
        figure.savefig(buffer, format="png")
    Image.open(buffer).convert("RGB").quantize(256, kmeans=4, dither=Image.Dither.NONE).save(path, optimize=True)


def _add_text(axes: Axes, x: float, y: float, text: str, size: float, colour: str) -> None:
    axes.text(x, y, text, size=size * 0.72, color=colour, ha="center", va="center")

"""A mesh and its Gauss image side by side, or a mesh along two families of lines, as SVG: faces painted from the back
to the front, in even light."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh
from geometry.mesh.polygons import face_centroids

__all__ = ["lines_picture", "pair_picture"]

_PICTURE_SIDE, _PICTURE_MARGIN, _CAPTION_HEIGHT = 560.0, 30.0, 56.0
"""Side of the square picture of one mesh, its margin, and the height of the caption, in pixels."""
_EYE_AZIMUTH, _EYE_ELEVATION = np.radians(-60.0), np.radians(24.0)
"""Direction towards the eye: angle from the x-axis about z, and angle above the xy-plane, in radians."""
_LIGHT = np.array([0.35, 0.5, 0.8])
"""Direction towards the light: to the right, upwards, towards the eye."""
_OUTSIDE, _INSIDE = np.array([222, 230, 236]), np.array([214, 196, 168])
"""Colours of the two sides of a face, red, green and blue from 0 to 255."""
_DARKEST_SHADE = 0.45
"""Brightness of faces turned away from the light, over that of faces turned to it."""


def pair_picture(mesh: Mesh, gauss_image: Mesh, reversed_edges: BoolArray, caption: str) -> str:
    """The text of an SVG file: M on the left, S over the outline of the unit sphere on the right.

    reversed_edges (E,): drawn in red in both. The outside is grey, the inside sand; of S, which may run over itself
    with its faces turned, the side away from the centre is the outside. Seen from above at an angle, z upwards.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.drawings import pair_picture
    >>> pair = built.structure.pair
    >>> svg = pair_picture(pair.mesh, pair.gauss_image, pair.reversed_edges, "A dome")
    >>> svg.startswith("<svg"), svg.count('class="f"')
    (True, 24)
    """
    width, height = 2 * _PICTURE_SIDE, _PICTURE_SIDE + _CAPTION_HEIGHT
    radius = float(np.linalg.norm(gauss_image.vertices, axis=1).max())
    scale = (_PICTURE_SIDE / 2 - _PICTURE_MARGIN) / radius
    red = [("r", reversed_edges)]
    middle = f"{1.5 * _PICTURE_SIDE:.1f}"
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" role="img">',
            "<style>path{stroke-linejoin:round;stroke-linecap:round}.f{stroke:#46525c;stroke-width:.6}"
            ".r{fill:none;stroke:#c8202c;stroke-width:1.2}text{font:15px sans-serif;fill:#333;"
            "text-anchor:middle}</style>",
            f'<rect width="{width:.0f}" height="{height:.0f}" fill="#fff"/>',
            _painted(
                mesh, [("r", reversed_edges)], _fitted(_seen(mesh.vertices), _PICTURE_SIDE / 2), mesh.face_normals
            ),
            f'<circle cx="{middle}" cy="{_PICTURE_SIDE / 2:.1f}" r="{scale:.1f}" fill="#f4f5f6" stroke="#b9c0c6"/>',
            _painted(
                gauss_image,
                red,
                _seen(gauss_image.vertices) * scale + [1.5 * _PICTURE_SIDE, _PICTURE_SIDE / 2, 0],
                face_centroids(gauss_image.vertices, gauss_image.combinatorics),
            ),
            f'<text x="{_PICTURE_SIDE / 2:.1f}" y="{_PICTURE_SIDE + 12:.0f}">M</text>'
            f'<text x="{middle}" y="{_PICTURE_SIDE + 12:.0f}">S</text>',
            f'<text x="{_PICTURE_SIDE:.1f}" y="{_PICTURE_SIDE + 40:.0f}">{escape(caption)}</text>',
            "</svg>",
            "",
        ]
    )


def lines_picture(mesh: Mesh, first: BoolArray, second: BoolArray, vertices: IntArray) -> str:
    """An SVG element of a mesh whose edges of two families (E,) are blue and orange, some vertices (k,) red dots."""
    seen = _fitted(_seen(mesh.vertices), _PICTURE_SIDE / 2)
    low, high = seen[:, 1].min() - _PICTURE_MARGIN / 2, seen[:, 1].max() + _PICTURE_MARGIN / 2
    dots = "".join(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5"/>' for x, y in seen[vertices, :2].tolist())
    return (
        f'<svg viewBox="0 {low:.0f} {_PICTURE_SIDE:.0f} {high - low:.0f}" role="img">'
        f"{_painted(mesh, [('a', first), ('b', second)], seen, mesh.face_normals)}{dots}</svg>"
    )


def _seen(points: FloatArray) -> FloatArray:
    """(..., 3) to the right, downwards, and away from the eye."""
    c, s = np.cos(_EYE_AZIMUTH), np.sin(_EYE_AZIMUTH)
    eye = np.array([c * np.cos(_EYE_ELEVATION), s * np.cos(_EYE_ELEVATION), np.sin(_EYE_ELEVATION)])
    right = np.array([-s, c, 0.0])
    found: FloatArray = points @ np.stack([right, -np.cross(eye, right), -eye], axis=1)
    return found


def _fitted(seen: FloatArray, middle: float) -> FloatArray:
    """Scaled and moved into a square about the middle."""
    low, high = seen.min(axis=0), seen.max(axis=0)
    scale = (_PICTURE_SIDE - 2 * _PICTURE_MARGIN) / max(float((high - low)[:2].max()), np.finfo(float).tiny)
    found: FloatArray = (seen - (low + high) / 2) * scale + [middle, _PICTURE_SIDE / 2, 0.0]
    return found


def _painted(mesh: Mesh, marked: Sequence[tuple[str, BoolArray]], seen: FloatArray, outwards: FloatArray) -> str:
    """The faces at the points seen (N, 3), the farthest first, each with its edges over it. marked: classes of edges
    (E,) that are drawn once more. outwards (F, 3): directions to the outside of each face."""
    c = mesh.combinatorics
    depths = np.round(face_centroids(seen, c)[:, 2], 3)  # of faces in one place the last one is on top
    order = np.argsort(-depths, kind="stable").tolist()
    colours = _colours(mesh.face_normals, outwards)
    points = [f"{x:.1f} {y:.1f}" for x, y in seen[:, :2].tolist()]
    ahead = c.corners[c.next_corner].tolist()
    corners, starts = c.corners.tolist(), c.face_starts.tolist()
    sides = [(name, edges[c.corner_edge].tolist()) for name, edges in marked]
    lines = []
    for face in order:
        run = range(starts[face], starts[face + 1])
        outline = "L".join(points[corners[k]] for k in run)
        lines.append(f'<path class="f" fill="{colours[face]}" d="M{outline}z"/>')
        for name, is_marked in sides:
            path = "".join(f"M{points[corners[k]]}L{points[ahead[k]]}" for k in run if is_marked[k])
            if path:
                lines.append(f'<path class="{name}" d="{path}"/>')
    return "\n".join(lines)


def _colours(normals: FloatArray, outwards: FloatArray) -> list[str]:
    """Of each face, from its normal (F, 3) to either side."""
    x, y, z = _seen(normals).T
    to_eye = np.where(z <= 0, 1, -1)
    outside = np.einsum("fi,fi->f", normals, outwards) * to_eye >= 0
    towards = np.stack([x, -y, -z], axis=1) * to_eye[:, None]
    bright = _DARKEST_SHADE + (1 - _DARKEST_SHADE) * np.clip(towards @ (_LIGHT / np.linalg.norm(_LIGHT)), 0, 1)
    shades = np.where(outside[:, None], _OUTSIDE, _INSIDE) * bright[:, None]
    return [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in np.round(shades).astype(int).tolist()]

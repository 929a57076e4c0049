"""Koebe polyhedra with rotational symmetry about the z axis, in closed form.

On the sphere, a boost along the axis moves Mercator latitudes u = artanh z by a constant, and takes circles to circles.
A rotational Koebe polyhedron consists of the images of one row of faces under powers of such a boost, with or without
half a turn of a face in between: the number of faces around determines the boost, since neighbouring face circles must
touch. So the number of faces around determines the height of the rows, and the number of rows how near the band comes
to the poles, which it never reaches.

Vertices are poles of vertex circles: as vectors (s, 1) of Lorentz space, those of two vertices whose edge touches the
sphere have <a, b>^2 = <a, a> <b, b>.
"""

from __future__ import annotations

from enum import Enum

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, integers
from geometry.errors import GeometryError
from geometry.mesh import Combinatorics, Mesh

__all__ = ["BandTiling", "rotational_koebe", "rows_within"]

LARGEST_MERCATOR_LATITUDE = 12.0
"""Largest Mercator latitude: 1e-5 from the pole, where faces are as small and lose five digits."""


class BandTiling(Enum):
    """Which faces go around the axis.

    >>> [tiling.value for tiling in BandTiling]
    ['quads', 'pointy-top hexagons', 'flat-top hexagons']
    >>> rotational_koebe(BandTiling.POINTY_TOP_HEXAGONS, around=12, rows=4).n_faces
    48
    """

    QUADS = "quads"
    """Trapezoids, two edges horizontal and two in planes through the axis."""

    POINTY_TOP_HEXAGONS = "pointy-top hexagons"
    """Hexagons with two edges in planes through the axis and zigzags around it, as in [Pottmann2007, Fig. 18]."""

    FLAT_TOP_HEXAGONS = "flat-top hexagons"
    """Hexagons with a horizontal edge at the bottom and at the top."""


def rotational_koebe(
    tiling: BandTiling,
    around: int,
    rows: int,
    *,
    latitude: float = 0.0,
    folds: int = 0,
    capped: bool = False,
    level_ends: bool = False,
) -> Mesh:
    """A band of `rows` rows of `around` faces each, all edge lines at distance 1 from the origin.

    rows: at least 1, of flat-top hexagons 2. latitude: of the middle of the band, in radians; 0 for a band that is
    symmetric to the equator. folds: how often the band turns back at its end and runs over itself, as the Gauss image
    of a surface with inflections does; not for pointy-top hexagons, where that cannot be. capped: closed by two regular
    polygons; quads without folds only. level_ends: the zigzags at both ends of pointy-top hexagons are cut off by
    horizontal edges, so that quads can be joined to them, see `gauss.join_pairs`; hexagons there become pentagons.

    Counter-clockwise seen from outside, except where a fold turned the band over. Rows run from south to north, each
    counter-clockwise about the z axis. An annulus, or a sphere when capped.

    Raises GeometryError for numbers out of range, and for what does not exist for a tiling.

    >>> import numpy as np
    >>> from geometry.gauss import edge_distances
    >>> band = rotational_koebe(BandTiling.QUADS, around=12, rows=4)
    >>> band.n_faces, bool(np.abs(edge_distances(band) - 1).max() < 1e-9)
    (48, True)
    """
    _check(tiling, around, rows, latitude, folds, capped)
    if level_ends and tiling is not BandTiling.POINTY_TOP_HEXAGONS:
        raise GeometryError(
            "only pointy-top hexagons have zigzags at their ends that could be cut off: leave out level_ends"
        )
    steps, signs = (_folded(layers, folds) for layers in _layers(tiling, rows))
    step, seed = _seed(tiling, around)
    turns = _turns(tiling, len(steps))
    if level_ends:
        steps, signs, turns = steps[1:-1], signs[1:-1].copy(), turns[1:-1]
        signs[[0, -1]] *= np.sin(np.pi / around) / seed[0, 2]  # where the horizontal edges touch the sphere
    mercator = np.arctanh(np.sin(latitude)) + step * steps
    if np.abs(mercator).max() > LARGEST_MERCATOR_LATITUDE:
        raise GeometryError(
            f"the band of {rows} rows comes nearer to the poles than {2 * np.exp(-LARGEST_MERCATOR_LATITUDE):.0e}: "
            f"take fewer, or more "
            "faces around, or a lower latitude",
            value=float(np.abs(mercator).max()),
            bound=LARGEST_MERCATOR_LATITUDE,
        )
    combinatorics = _level_ended(around, rows) if level_ends else _combinatorics(tiling, around, len(steps), capped)
    return Mesh(_placed(seed, mercator, signs, turns, around), combinatorics)


def rows_within(tiling: BandTiling, around: int, latitude: float) -> int:
    """The most rows of a band symmetric to the equator, all of whose edges touch the sphere within +- latitude.

    Raises GeometryError where no band fits.

    >>> import numpy as np
    >>> rows_within(BandTiling.QUADS, around=24, latitude=np.radians(60))
    10
    """
    _check(tiling, around, 2, latitude, 0, False)
    latitude = min(abs(latitude), float(np.arcsin(np.tanh(LARGEST_MERCATOR_LATITUDE))))  # beyond, no band is made
    step = _seed(tiling, around)[0]
    reach = np.arctanh(np.sin(latitude)) / step * (1 + 1e-12)  # so that an edge at the latitude itself counts as within
    rows = int(2 * reach) - (tiling is BandTiling.FLAT_TOP_HEXAGONS)
    if rows < (2 if tiling is BandTiling.FLAT_TOP_HEXAGONS else 1):
        raise GeometryError(
            f"no band of {around} faces around fits between the latitudes +-{latitude:.3f}: take more faces "
            "around, or a higher latitude",
            value=latitude,
        )
    return rows


def _check(tiling: BandTiling, around: int, rows: int, latitude: float, folds: int, capped: bool) -> None:
    if not isinstance(tiling, BandTiling):
        raise GeometryError(f"the tiling is {tiling!r}: one of {', '.join(map(str, BandTiling))} is needed")
    few = 2 if tiling is BandTiling.FLAT_TOP_HEXAGONS else 1  # flat-top hexagons of one row only have no edge in common
    for name, number, least in [("faces around", around, 3), ("rows", rows, few), ("folds", folds, 0)]:
        if not isinstance(number, (int, np.integer)) or number < least:
            raise GeometryError(
                f"{number} {name} are asked for, an integer from {least} upwards is needed", value=number, bound=least
            )
    if not abs(latitude) < np.pi / 2:
        raise GeometryError(
            f"the latitude {latitude} is not between those of the poles, -pi/2 and pi/2",
            value=latitude,
            bound=np.pi / 2,
        )
    if folds and tiling is BandTiling.POINTY_TOP_HEXAGONS:
        raise GeometryError(
            "a band of pointy-top hexagons cannot turn back over itself: every second one of its zigzag's corners "
            "would "
            "need its vertical edge on the other side; take flat-top hexagons or quads"
        )
    if capped and (folds or tiling is not BandTiling.QUADS):
        raise GeometryError("only a band of quads without folds ends in plane polygons, with which it can be capped")


def _layers(tiling: BandTiling, rows: int) -> tuple[FloatArray, FloatArray]:
    """Mercator latitudes of the layers of vertices, in steps from the middle of the band, and their signs (+1, -1)."""
    if tiling is BandTiling.POINTY_TOP_HEXAGONS:
        steps = np.arange(-1.0, rows + 1).repeat(2)[1:-1]
        return floats(steps - (rows - 1) / 2), floats(np.tile([1.0, -1.0], rows + 1))
    n = rows + 1 if tiling is BandTiling.QUADS else rows + 2
    return floats(np.arange(n) - (n - 1) / 2), floats(np.ones(n))


def _folded(layers: FloatArray, folds: int) -> FloatArray:
    """Layers, and again from the last one to the first, and so on."""
    turns = [layers[::-1][1:] if turn % 2 else layers[1:] for turn in range(1, folds + 1)]
    return np.concatenate([layers, *turns])


def _seed(tiling: BandTiling, around: int) -> tuple[float, FloatArray]:
    """The boost from row to row, and vertices (k, 4) of a layer at the equator as poles (s, 1), at azimuth 0.

    For pointy-top hexagons the upper end of a vertical edge; the lower end mirrors it.
    """
    c, s = np.cos(np.pi / around), np.sin(np.pi / around)
    if tiling is BandTiling.QUADS:
        return float(2 * np.arctanh(s)), np.array([[1 / c, 0, 0, 1]])
    if tiling is BandTiling.POINTY_TOP_HEXAGONS:
        cosh = (1 + c - c * c) / c**2
        sinh = np.sqrt((cosh - 1) * (cosh + 1))
        # the edge to the lower end of the next vertical edge, half a face on, touches the sphere
        t = (cosh - c) / (sinh + np.sqrt(sinh**2 - (cosh - 1) * (cosh - c)))
        return float(np.arccosh(cosh)), np.array([[1, 0, t, 1]])
    cosh = (1 + np.sqrt(5 + 4 * c)) / (2 + 2 * c)
    y = (cosh - c) / (s + np.sqrt(s**2 + (1 - c) * (cosh - c)))  # likewise, to the horizontal edge of the next layer
    return float(np.arccosh(cosh)), np.array([[1, -y, 0, 1], [1, y, 0, 1]])


def _turns(tiling: BandTiling, n_layers: int) -> IntArray:
    """By how many halves of a face each layer is turned against the first."""
    layers = np.arange(n_layers)
    return integers(
        {BandTiling.QUADS: 0 * layers, BandTiling.POINTY_TOP_HEXAGONS: (layers + 1) // 2}.get(tiling, layers)
    )


def _placed(seed: FloatArray, mercator: FloatArray, signs: FloatArray, turns: IntArray, around: int) -> FloatArray:
    """(N, 3) the seed vertices boosted to each layer's latitude, and turned to each of its places around."""
    sinh, cosh = np.sinh(mercator)[:, None], np.cosh(mercator)[:, None]
    x, y, z, w = seed.T
    z = signs[:, None] * z
    weights = cosh * w + sinh * z
    x, y, z = x / weights, y / weights, (sinh * w + cosh * z) / weights
    angles = (np.pi / around * (2 * np.arange(around) + turns[:, None]))[:, :, None]
    x, y, z = x[:, None], y[:, None], z[:, None]
    turned = [np.cos(angles) * x - np.sin(angles) * y, np.sin(angles) * x + np.cos(angles) * y, z + 0 * angles]
    return np.stack(turned, axis=-1).reshape(-1, 3)


def _combinatorics(tiling: BandTiling, around: int, n_layers: int, capped: bool) -> Combinatorics:
    """Vertices by layers, in each by places around; those of flat-top hexagons in pairs."""
    here = np.arange(around)
    there, before = np.roll(here, -1), np.roll(here, 1)
    if tiling is BandTiling.QUADS:
        rows, stride, n = n_layers - 1, around, around * n_layers
        face = [here, there, around + there, around + here]
    elif tiling is BandTiling.POINTY_TOP_HEXAGONS:
        rows, stride, n = n_layers // 2 - 1, 2 * around, around * n_layers
        face = [k * around + m for k, m in enumerate([here, here, here, before])]
        face += [2 * around + before, around + before]
    else:
        rows, stride, n = n_layers - 2, 2 * around, 2 * around * n_layers
        face = [2 * here, 2 * here + 1, stride + 2 * here, 2 * stride + 2 * before + 1]
        face += [2 * stride + 2 * before, stride + 2 * before + 1]
    corners = (stride * np.arange(rows)[:, None, None] + np.stack(face, axis=1)).ravel()
    sizes = np.full(rows * around, len(face))
    if capped:
        corners = np.concatenate([corners, here[::-1], n - around + here])
        sizes = np.concatenate([sizes, [around, around]])
    return Combinatorics(n, corners, np.concatenate([[0], np.cumsum(sizes)]))


def _level_ended(around: int, rows: int) -> Combinatorics:
    """Pointy-top hexagons without the tips at both ends: the faces of the band, without the vertices of two layers."""
    c = _combinatorics(BandTiling.POINTY_TOP_HEXAGONS, around, 2 * (rows + 1), capped=False)
    kept = (c.corners >= around) & (c.corners < c.n_vertices - around)
    sizes = np.add.reduceat(kept.astype(np.int64), c.face_starts[:-1])
    return Combinatorics(c.n_vertices - 2 * around, c.corners[kept] - around, np.concatenate([[0], np.cumsum(sizes)]))

"""Pictures of the report, as inline SVG."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from itertools import accumulate, pairwise

import numpy as np

from fabkit.parts import Curves, Measure
from fabkit.production import CUT, MARK, SHEET, Drawing
from geometry.arrays import FloatArray

__all__ = ["histogram", "sheet_pictures"]

_HISTOGRAM_WIDTH, _HISTOGRAM_HEIGHT, _HISTOGRAM_BASE, _HISTOGRAM_MARGIN = 220, 96, 78, 6
"""Size of a histogram, level of its horizontal axis from the top, and margin on both sides, in pixels."""
_MAX_BARS = 30
"""Largest number of bars of a histogram; a round width may make them fewer."""


def histogram(measure: Measure) -> str:
    """A histogram of the values of the parts, with the median and the extremes in words."""
    values = measure.values[~np.isnan(measure.values)]
    title = f"{escape(measure.title)} <span class='unit'>{escape(measure.unit)}</span>"
    if len(values) == 0:
        return f"<figure><h3>{title}</h3><figcaption>no values</figcaption></figure>"
    smallest, median, largest = (_decimal(v, measure.decimals) for v in (values.min(), np.median(values), values.max()))
    if smallest == largest:
        return f"<figure><h3>{title}</h3><figcaption>{smallest} for all {len(values)}</figcaption></figure>"
    edges = _edges(float(values.min()), float(values.max()))
    counts = np.histogram(values, edges)[0]
    caption = f"{smallest} to {largest}, median {median}"
    return f"<figure><h3>{title}</h3>{_bars(counts, edges)}<figcaption>{caption}</figcaption></figure>"


def _bars(counts: np.typing.NDArray[np.int64], edges: FloatArray) -> str:
    inner = _HISTOGRAM_WIDTH - 2 * _HISTOGRAM_MARGIN
    step = inner / len(counts)
    heights = (_HISTOGRAM_BASE - 14) * counts / counts.max()
    bars = "".join(
        f"<rect x='{_HISTOGRAM_MARGIN + n * step + 0.5:.1f}' y='{_HISTOGRAM_BASE - height:.1f}' width='{step - 1:.1f}'"
        f" height='{height:.1f}'>"
        f"<title>{edges[n]:.6g} to {edges[n + 1]:.6g}: {count}</title></rect>"
        for n, (count, height) in enumerate(zip(counts.tolist(), heights.tolist(), strict=True))
        if count
    )
    peak = int(counts.argmax())
    at = _HISTOGRAM_MARGIN + (peak + 0.5) * step
    anchor = "start" if at < 20 else "end" if at > _HISTOGRAM_WIDTH - 20 else "middle"
    return (
        f"<svg viewBox='0 0 {_HISTOGRAM_WIDTH} {_HISTOGRAM_HEIGHT}' role='img'>{bars}"
        f"<text x='{at:.1f}' y='10' text-anchor='{anchor}'>{counts.max()}</text>"
        f"<path class='axis' d='M{_HISTOGRAM_MARGIN} {_HISTOGRAM_BASE + 0.5}H{_HISTOGRAM_WIDTH - _HISTOGRAM_MARGIN}'/>"
        f"<text x='{_HISTOGRAM_MARGIN}' y='{_HISTOGRAM_HEIGHT - 6}'>{edges[0]:.6g}</text>"
        f"<text x='{_HISTOGRAM_WIDTH - _HISTOGRAM_MARGIN}'"
        f" y='{_HISTOGRAM_HEIGHT - 6}' text-anchor='end'>{edges[-1]:.6g}</text></svg>"
    )


def _edges(smallest: float, largest: float) -> FloatArray:
    """Bounds of the bars of a histogram, which have a round width (1, 2 or 5 times a power of ten) and cover all
    values."""
    rough = (largest - smallest) / _MAX_BARS
    power = 10.0 ** np.floor(np.log10(rough))
    width = power * next(step for step in (1, 2, 5, 10) if step * power >= rough)
    first, last = np.floor(smallest / width), np.ceil(largest / width)
    edges: FloatArray = np.arange(first, last + 1) * width
    edges[[0, -1]] = min(edges[0], smallest), max(edges[-1], largest)  # rounding must not lose a value
    return edges


def _decimal(value: float, decimals: int) -> str:
    """The number with this many decimals, and no minus before a zero."""
    text = f"{value:.{decimals}f}"
    return text[1:] if text.startswith("-") and float(text) == 0 else text


def sheet_pictures(sheets: Sequence[Drawing]) -> list[str]:
    """Thumbnails of nested sheets, which the page shows larger; points are rounded to whole millimetres."""
    layers = (SHEET, CUT, MARK)
    paths = (_paths([sheet.layers[layer] for sheet in sheets]) for layer in layers)
    return [
        _sheet_picture(sheet, dict(zip(layers, own, strict=True)))
        for sheet, own in zip(sheets, zip(*paths, strict=True), strict=True)
    ]


def _sheet_picture(drawing: Drawing, paths: Mapping[str, str]) -> str:
    (stock,) = drawing.layers[SHEET]
    left, bottom = stock.min(axis=0)
    length, width = stock.max(axis=0) - stock.min(axis=0)
    edge = 0.01 * length
    box = f"{left - edge:.0f} {-bottom - width - edge:.0f} {length + 2 * edge:.0f} {width + 2 * edge:.0f}"
    drawn = "".join(f"<path class='{layer.lower()}' d='{path}'/>" for layer, path in paths.items())
    panels = drawing.layers[CUT]
    used = np.abs(_areas(panels)).sum() / (length * width)
    count = f"{len(panels)} panel{'' if len(panels) == 1 else 's'}"
    return (
        f"<figure><button type='button'><svg viewBox='{box}'>{drawn}</svg></button>"
        f"<figcaption>{escape(drawing.name)}: {count}, {100 * used:.0f} % used</figcaption></figure>"
    )


def _paths(several: Sequence[Curves]) -> list[str]:
    """Each as an SVG path in relative steps, with y downwards."""
    curves = Curves.joined(several)
    points = np.round(curves.values * [1, -1]).astype(np.int64)
    steps = np.diff(points, axis=0, prepend=0)
    steps[curves.starts[:-1]] = points[curves.starts[:-1]]
    words = [f"{x} {y}" for x, y in steps.tolist()]
    starts, closed = curves.starts.tolist(), curves.is_closed.tolist()
    texts = [
        f"M{words[start]}l{' '.join(words[start + 1 : end - is_closed])}{'z' if is_closed else ''}"
        for start, end, is_closed in zip(starts[:-1], starts[1:], closed, strict=True)
    ]
    return ["".join(texts[start:end]) for start, end in pairwise(accumulate(map(len, several), initial=0))]


def _areas(closed: Curves) -> FloatArray:
    """(k,) signed areas within closed curves."""
    (x, y), (next_x, next_y) = closed.values[:-1].T, closed.values[1:].T
    inside = closed.row[:-1] == closed.row[1:]
    twice = (x * next_y - next_x * y) * inside
    areas: FloatArray = np.bincount(closed.row[:-1], twice, minlength=len(closed)) / 2
    return areas

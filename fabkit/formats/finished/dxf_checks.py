"""DXF files of a finished folder against the solids of its parts and what its tables say."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from fabkit.errors import OutputError
from fabkit.formats.finished.dxf_files import OUTLINE_TOLERANCE_MM, Curve, DxfFile, stem_of
from fabkit.formats.finished.part_geometry import PartSolid
from fabkit.production import CUT, MARK, SHEET
from fabkit.production.strokes import ARROW, text_strokes
from geometry.arrays import FloatArray

__all__ = ["are_texts", "check_around", "check_panel", "check_plate", "check_sheet", "check_titles", "marks_on"]

STROKE_TOLERANCE_MM = 1e-6
"""Largest distance in mm of a point of a stroke from that of the same letter, turned and scaled; 9 decimals are
written."""

TOWARDS_EYE_COSINE = 0.9
"""Cosine of the angle between the z axis and a normal up to which a plate is drawn with z upwards."""

Texts = Sequence[Collection[str]]
"""For each text in turn, those that it may be."""


def check_around(files: Mapping[str, DxfFile]) -> Iterator[str]:
    """What is around the entities is the same in all files of a folder."""
    texts: dict[tuple[str, ...], list[str]] = defaultdict(list)
    for name, file in files.items():
        texts[file.around].append(name)
    usual = max(texts.values(), key=len, default=[])
    for names in texts.values():
        if names is not usual:
            yield f"the head of {', '.join(names[:5])} is not that of the other DXF files"


def check_titles(files: Mapping[str, DxfFile], kinds: Mapping[str, str], project: str) -> Iterator[str]:
    """Titles name the project and the file, and are otherwise the same where the material is. kinds: by file."""
    known: dict[str, Counter[str]] = defaultdict(Counter)
    patterns: dict[str, str] = {}
    for name, file in files.items():
        said, stem = "".join(file.title), stem_of(name)
        own = stem if "sheets/" not in name else f"sheet {int(stem.rpartition('-')[2])} of {len(files)}"
        bare, own = said.replace(" ", ""), own.replace(" ", "")
        if not bare.startswith(project.replace(" ", "")) or own not in bare:
            yield f"{name} has the title {said!r}, in which {stem} or the project is not named"
        elif name in kinds:
            patterns[name] = bare.replace(own, "*")
            known[kinds[name]][patterns[name]] += 1
    for name, pattern in patterns.items():
        ((usual, count),) = known[kinds[name]].most_common(1)
        if pattern != usual and count > 1:
            yield f"{name} has the title {''.join(files[name].title)!r}, unlike others of its material"


def marks_on(mark: str, labels: str, neighbours: Collection[str] = (), n_edges: int = 0) -> Texts:
    """What is engraved on a panel. neighbours: the marks of those across its edges, each of which may be named."""
    if labels == "none":
        return ()
    if labels == "corner":
        return ([mark + ARROW],)
    return ([mark], [ARROW, *(ARROW + each for each in neighbours)], *[neighbours] * n_edges)


def are_texts(strokes: Sequence[FloatArray], texts: Texts, size: float | None = None) -> bool:
    """Whether the strokes are these texts, one after the other. Those from the third on may be left out. size: of the
    letters in mm; None for any."""
    at = 0
    for number, choices in enumerate(texts):
        for text in sorted(choices, key=len, reverse=True):
            counts, points = _letters(text)
            own = strokes[at : at + len(counts)]
            if tuple(map(len, own)) == counts and _is_similar(np.concatenate(own), points, size):
                at += len(counts)
                break
        else:
            if number < 2:
                return False
    return at == len(strokes)


@lru_cache(maxsize=16384)
def _letters(text: str) -> tuple[tuple[int, ...], npt.NDArray[np.complex128]]:
    """Numbers of points of the strokes of a text, and the points, about their middle."""
    try:
        curves, _ = text_strokes([text])
    except OutputError:
        return (0,), np.zeros(0, dtype=complex)
    points = curves.values[:, 0] + 1j * curves.values[:, 1]
    return tuple(np.diff(curves.starts).tolist()), points - points.mean()


def _is_similar(points: FloatArray, letters: npt.NDArray[np.complex128], size: float | None) -> bool:
    own = points[:, 0] + 1j * points[:, 1]
    own -= own.mean()
    factor = np.vdot(letters, own) / np.vdot(letters, letters).real
    is_sized = size is None or abs(factor - size) <= STROKE_TOLERANCE_MM
    return bool(is_sized and np.abs(own - factor * letters).max() <= STROKE_TOLERANCE_MM and factor != 0)


def check_panel(name: str, file: DxfFile, outline: FloatArray, texts: Texts) -> Iterator[str]:
    """The contour of a panel's drawing against its solid, and what is engraved."""
    cut = file.curves.get(CUT, [])
    if len(cut) != 1 or not cut[0][0] or not _same(cut[0][1], outline):
        yield f"the contour of {name} is not that of the solid of its panel"
    if not all(_is_within(points, outline) for _, points in file.curves.get(MARK, [])):
        yield f"{name} has a mark beside its contour"
    yield from _check_marks(name, file, texts)


def _check_marks(name: str, file: DxfFile, texts: Texts) -> Iterator[str]:
    strokes = file.curves.get(MARK, [])
    if any(is_closed for is_closed, _ in strokes) or not are_texts([points for _, points in strokes], texts):
        wanted = " and ".join(next(iter(choices)) for choices in texts[:1]) or "nothing"
        yield f"what is engraved on {name} is not {wanted}"
    others = (file.curves.keys() | file.circles.keys()) - {CUT, MARK, SHEET}
    if others:
        yield f"{name} has layers {', '.join(sorted(others))}"


def check_plate(name: str, file: DxfFile, solid: PartSolid, texts: Texts) -> Iterator[str]:
    """The contour and the holes of a plate's drawing against its solid, seen along the normal of one of its faces."""
    cut, rings = file.curves.get(CUT, []), [ring for own in file.circles.values() for ring in own]
    views = np.unique(np.round([*solid.normals, *solid.rounds[:, 3:6]], 9) + 0.0, axis=0)
    if not all(is_closed for is_closed, _ in cut) or not any(_fits(cut, rings, solid, view) for view in views):
        yield f"the contour or a hole of {name} is not that of the solid of its plate"
    yield from _check_marks(name, file, texts)


def _fits(cut: list[Curve], rings: list[FloatArray], solid: PartSolid, normal: FloatArray) -> bool:
    """Whether the curves and circles are those of a solid that is seen along a normal, from either side."""
    up = np.array([0.0, 1.0, 0.0] if abs(normal[2]) > TOWARDS_EYE_COSINE else [0.0, 0.0, 1.0])
    x = np.cross(up, normal)
    length = float(np.linalg.norm(x))
    if length == 0.0:
        return False
    axes = np.stack([x / length, np.cross(normal, x / length)], axis=1)
    for side in ([1.0, 1.0], [-1.0, 1.0]):
        corners, centres = (points @ axes * side for points in (solid.corners, solid.rounds[:, :3]))
        circles = np.concatenate([centres, solid.rounds[:, 6:]], axis=1)
        if all(_near(points, corners) for _, points in cut) and all(_near(ring[None], circles) for ring in rings):
            return True
    return False


def _near(points: FloatArray, others: FloatArray) -> bool:
    """Whether each of the points is one of the others."""
    if not len(others):
        return False
    return bool(np.abs(points[:, None] - others).max(axis=2).min(axis=1).max() <= OUTLINE_TOLERANCE_MM)


def check_sheet(
    name: str, file: DxfFile, rows: list[dict[str, str]], outlines: Mapping[str, FloatArray], texts: Texts
) -> Iterator[str]:
    """The contours of a sheet against the places that the table of pieces has for it."""
    curves = file.curves
    cut = [points for is_closed, points in curves.get(CUT, []) if is_closed]
    if len(cut) != len(curves.get(CUT, [])) or len(cut) != len(rows):
        yield f"{name} has {len(curves.get(CUT, []))} contours, pieces.csv has {len(rows)} pieces there"
    if len(curves.get(SHEET, [])) != 1:
        yield f"{name} has {len(curves.get(SHEET, []))} outlines of its sheet, one is needed"
    for row in rows:
        turn = np.radians(float(row["Sheet turn (deg)"]))
        x, y = float(row["Sheet x (mm)"]), float(row["Sheet y (mm)"])
        turning = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
        placed = outlines[row["Mark"]] @ turning + [x, y]
        if not any(_same(points, placed) for points in cut):
            yield f"{row['Piece']} is not on {name} where pieces.csv has it"
    strokes = [points for _, points in curves.get(MARK, [])]
    inside = all(any(_is_within(own, each) for each in cut) for own in strokes)
    if not inside or not are_texts(strokes, texts):
        yield f"what is engraved on the panels of {name} is not their marks"


def _is_within(points: FloatArray, outline: FloatArray) -> bool:
    return bool((outline.min(axis=0) <= points).all() and (points <= outline.max(axis=0)).all())


def _same(points: FloatArray, outline: FloatArray) -> bool:
    return points.shape == outline.shape and bool(np.abs(points - outline).max() <= OUTLINE_TOLERANCE_MM)

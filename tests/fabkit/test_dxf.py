"""DXF files, read back by ezdxf and by GDAL."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from io import StringIO
from itertools import combinations
from pathlib import Path

import ezdxf
import numpy as np
import pytest
from ezdxf.lldxf.encoding import decode_dxf_unicode
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon, box

from fabkit.errors import OutputError
from fabkit.formats.drawings.dxf import write_dxf, write_dxfs
from fabkit.kinds import PanelDetails
from fabkit.parts import Curves, Parts
from fabkit.production.drawing import CUT, MARK, SHEET, Drawing, sheet_drawings
from fabkit.production.nesting.nests import Sheet
from fabkit.production.nesting.sheet_nesting import nest_panels
from geometry.arrays import FloatArray
from tests.fabkit.plates import outlines, plates

VERSIONS = ("R2010", "R12", "R2018")
ogrinfo = shutil.which("ogrinfo")


def pieces() -> Parts[PanelDetails]:
    rng = np.random.default_rng(7)
    base = np.array([[0, 0], [900, 0], [1000, 700], [400, 900.0]])
    return plates([base + rng.normal(0, 60, (4, 2)) for _ in range(9)])


def nested(panels: Parts[PanelDetails]) -> tuple[Drawing, ...]:
    nest = nest_panels(panels, Sheet(3000.0, 2000.0), gap_mm=5, border_mm=10)
    return sheet_drawings(nest, panels)


def text_of(drawing: Drawing, version: str) -> str:
    stream = StringIO()
    write_dxf(stream, drawing, version=version)  # type: ignore[arg-type]
    return stream.getvalue()


def polylines(document: ezdxf.document.Drawing, layer: str) -> list[tuple[bool, FloatArray]]:
    """Closed or not, and points, of all entities of a layer."""
    found = []
    for entity in document.modelspace().query(f'*[layer=="{layer}"]'):
        if entity.dxftype() == "LWPOLYLINE":
            found.append((entity.closed, np.array([point[:2] for point in entity.get_points()])))
        else:
            assert entity.dxftype() == "POLYLINE"
            found.append((entity.is_closed, np.array([tuple(point)[:2] for point in entity.points()])))
    return found


@pytest.mark.parametrize("version", VERSIONS)
@settings(deadline=None, max_examples=15)
@given(some=st.lists(outlines(), min_size=1, max_size=8))
def test_ezdxf_reads_back_panels_that_lie_apart_inside_their_sheets(some: list[FloatArray], version: str) -> None:
    panels = plates(some)
    areas = []
    for drawing in nested(panels):
        document = ezdxf.read(StringIO(text_of(drawing, version)))
        audit = document.audit()
        assert not audit.errors
        assert not audit.fixes
        assert {entity.dxf.layer for entity in document.modelspace()} == {CUT, MARK, SHEET}
        cut = [Polygon(points) for closed, points in polylines(document, CUT) if closed]
        assert len(cut) == len(polylines(document, CUT))
        assert all(box(10, 10, 2990, 1990).buffer(1e-6).contains(shape) for shape in cut)
        assert all(one.distance(other) >= 5 - 1e-6 for one, other in combinations(cut, 2))
        areas += [shape.area for shape in cut]
        ((closed, stock),) = polylines(document, SHEET)
        assert closed
        assert Polygon(stock).area == 6e6
        for (closed, points), curve in zip(polylines(document, MARK), drawing.layers[MARK], strict=True):
            assert closed == bool((curve[0] == curve[-1]).all())
            np.testing.assert_allclose(points, curve[: len(points)], atol=1e-9)  # as written
    np.testing.assert_allclose(sorted(areas), sorted(panel.details.area_mm2 for panel in panels), rtol=1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_the_head_of_the_file(version: str, tmp_path: Path) -> None:
    drawing = nested(pieces())[0]
    write_dxf(tmp_path / "sheet.dxf", drawing, version=version)  # type: ignore[arg-type]
    assert (tmp_path / "sheet.dxf").read_bytes() == text_of(drawing, version).encode()
    assert text_of(drawing, version).startswith("999\nContours are nominal, without allowance for the kerf")
    document = ezdxf.readfile(tmp_path / "sheet.dxf")
    assert document.acad_release == version
    assert [document.layers.get(name).dxf.color for name in (CUT, MARK, SHEET)] == [1, 5, 8]
    assert tuple(document.header["$EXTMIN"])[:2] == (0, 0)
    assert tuple(document.header["$EXTMAX"])[:2] == (3000, 2000)
    (view,) = document.viewports.get("*Active")
    assert tuple(view.dxf.center)[:2] == (1500, 1000)
    assert view.dxf.height == pytest.approx(3150)
    handles = [int(entity.dxf.handle, 16) for entity in document.modelspace()]
    assert int(document.header["$HANDSEED"], 16) > max(handles)
    if version != "R12":
        assert document.header["$INSUNITS"] == 4
        assert [value for _, value in document.header.custom_vars.properties] == list(drawing.notes)
        assert {entity.dxftype() for entity in document.modelspace()} == {"LWPOLYLINE"}
        layout = document.modelspace().dxf
        assert tuple(layout.extmax)[:2] == (3000, 2000)


@pytest.mark.parametrize("version", VERSIONS)
def test_many_files_are_as_each_alone(version: str, tmp_path: Path) -> None:
    """Also one of circles alone, and one whose layers are others."""
    square = Curves.of([[[0, 0], [9, 0], [9, 9], [0, 0]]])
    rings = Drawing("ring", {CUT: Curves.of([])}, title=("one", "two"), circles={CUT: np.array([[5.0, 6.0, 2.0]])})
    drawings = [*nested(pieces()), rings, Drawing("square", {SHEET: square, MARK: Curves.of([])})]
    write_dxfs(tmp_path, drawings, version=version, suffix="-x.dxf")  # type: ignore[arg-type]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"{each.name}-x.dxf" for each in drawings)
    for each in drawings:
        assert (tmp_path / f"{each.name}-x.dxf").read_bytes() == text_of(each, version).encode()
    document = ezdxf.readfile(tmp_path / "ring-x.dxf")
    assert document.header["$EXTMIN"][0] == 3
    assert tuple(document.header["$EXTMAX"])[:2] == (7, 8)


@pytest.mark.parametrize("curves", [[], [[[0.0, 0.0], [np.nan, 1.0]]]])
def test_a_drawing_of_nothing_is_refused(curves: list[list[list[float]]]) -> None:
    with pytest.raises(OutputError, match="P7 has no curves"):
        text_of(Drawing("P7", {CUT: Curves.of(curves)}), "R2010")


def test_lines_are_open_and_rings_closed() -> None:
    ring = np.array([[0.0, 0.0], [10.0, 0.0], [5.0, 8.0], [0.0, 0.0]])
    line = np.array([[1.0, 1.0], [2.0, 1.0]])
    drawing = Drawing("P001", {CUT: Curves.of([ring]), MARK: Curves.of([line])})
    document = ezdxf.read(StringIO(text_of(drawing, "R2010")))
    ((closed, points),) = polylines(document, CUT)
    assert closed
    np.testing.assert_array_equal(points, ring[:3])
    ((closed, points),) = polylines(document, MARK)
    assert not closed
    np.testing.assert_array_equal(points, line)


def test_other_processes_write_the_same_bytes() -> None:
    code = """if True:
        import sys
        from fabkit.formats.drawings.dxf import write_dxf
        from fabkit.parts import Curves
        from fabkit.production import Drawing
        import numpy as np
        drawing = Drawing("P001", {"CUT": Curves.of([np.eye(3)[[0, 1, 2, 0], :2]])}, ("a note",))
        for version in ("R2010", "R12"):
            write_dxf(sys.stdout, drawing, version=version)
    """
    # under these seeds the sets of ezdxf run in different orders
    runs = [
        subprocess.Popen([sys.executable, "-c", code], stdout=-1, stderr=-1, env={**os.environ, "PYTHONHASHSEED": s})
        for s in ("0", "7")
    ]
    texts, said = zip(*(run.communicate() for run in runs), strict=True)
    assert said == (b"", b"")  # ezdxf would log that R12 has no unit
    assert texts[0].count(b"EOF") == 2
    assert texts == texts[:1] * len(runs)


@pytest.mark.skipif(ogrinfo is None, reason="no ogrinfo")
@pytest.mark.parametrize("version", VERSIONS)
def test_gdal_reads_the_same_panels(version: str, tmp_path: Path) -> None:
    assert ogrinfo is not None
    panels = pieces()[:3]  # on one sheet: ogrinfo takes its time
    areas = []
    for drawing in nested(panels):
        write_dxf(tmp_path / "sheet.dxf", drawing, version=version)  # type: ignore[arg-type]
        run = subprocess.run([ogrinfo, "-ro", "-al", "-q", "-where", "Layer='CUT'", tmp_path / "sheet.dxf"],
                             capture_output=True, text=True, check=True)  # fmt: skip
        rings = re.findall(r"(?:LINESTRING|POLYGON) Z? ?\(+([^)]*)\)", run.stdout)
        assert len(rings) == run.stdout.count("OGRFeature")
        for ring in rings:
            points = np.array([point.split()[:2] for point in ring.split(",")], dtype=float)
            np.testing.assert_array_equal(points[0], points[-1])
            areas.append(Polygon(points).area)
    # ogrinfo prints fifteen digits
    np.testing.assert_allclose(sorted(areas), sorted(panel.details.area_mm2 for panel in panels), rtol=1e-9)


@pytest.mark.parametrize("version", VERSIONS)
def test_long_titles_are_wrapped_and_lie_in_the_extents(version: str, tmp_path: Path) -> None:
    title = r"\_/ \U+0041 \M+1 " + 30 * "Bahnhofsdach "
    outline = Curves.of([np.array([[0.0, 0], [40, 0], [40, 100], [0, 100], [0, 0]])])
    write_dxf(tmp_path / "a.dxf", Drawing("a", {CUT: outline}, (), (title, "end")), version=version)  # type: ignore[arg-type]
    document = ezdxf.readfile(tmp_path / "a.dxf")
    lines = document.modelspace().query("TEXT")
    assert " ".join(line.dxf.text for line in lines) == rf"\_/ /U+0041 /M+1 {title[17:]}end"
    right, top = tuple(document.header["$EXTMAX"])[:2]
    assert top == 100
    assert right == max(line.dxf.insert.x + line.dxf.height * len(line.dxf.text) for line in lines) > 40


@pytest.mark.parametrize("version", VERSIONS)
def test_the_title_stands_below_the_sheet(version: str, tmp_path: Path) -> None:
    title = "Dach (\u00df), 100 %% \U0001f3e0"
    panels = pieces()
    nest = nest_panels(panels, Sheet(3000.0, 2000.0), gap_mm=5, border_mm=10)
    drawings = sheet_drawings(nest, panels, labels="corner", title=title)
    for number, drawing in enumerate(drawings, start=1):
        write_dxf(tmp_path / "a.dxf", drawing, version=version)  # type: ignore[arg-type]
        document = ezdxf.readfile(tmp_path / "a.dxf")
        audit = document.audit()
        assert not audit.errors
        assert not audit.fixes
        project, first, second = document.modelspace().query("TEXT")
        assert decode_dxf_unicode(project.plain_text()) == "Dach (\u00df), 100 % % ?"
        assert first.plain_text() == f"8 mm glass, sheet {number} of {len(drawings)}"
        assert second.plain_text() == "arrow: from corner 1 along edge 1, the longest"
        assert first.dxf.layer == second.dxf.layer == "TITLE"
        assert project.dxf.insert.y + project.dxf.height < 0
        assert first.dxf.insert.y + first.dxf.height < project.dxf.insert.y
        assert second.dxf.insert.y + second.dxf.height < first.dxf.insert.y
        assert tuple(document.header["$EXTMIN"])[:2] == tuple(second.dxf.insert)[:2]

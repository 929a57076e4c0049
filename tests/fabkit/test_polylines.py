"""Polylines in OBJ and DXF files: written and read back, also by others; what is none is one sentence."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import numpy as np
import pytest
import trimesh

from fabkit.errors import FabkitError, OutputError
from fabkit.formats.polylines import read_polylines, write_polylines

LINES = (
    np.array([[0.0, 0, 0], [1, 0, 0.25], [1, 1, 1 / 3]]),
    np.array([[5.0, 5, 5], [6, 5, 5]]),
)


@pytest.mark.parametrize("name", ["lines.obj", "lines.dxf"])
def test_polylines_come_back(tmp_path: Path, name: str) -> None:
    write_polylines(tmp_path / name, LINES)
    found = read_polylines(tmp_path / name)
    assert [line.tolist() for line in found] == [line.tolist() for line in LINES]


def test_others_read_them(tmp_path: Path) -> None:
    write_polylines(tmp_path / "lines.dxf", LINES[:1], LINES[1:])
    polylines = list(ezdxf.readfile(tmp_path / "lines.dxf").modelspace())
    assert [len(list(each.points())) for each in polylines] == [3, 2]
    assert [each.dxf.layer for each in polylines] == ["lines-1", "lines-2"]
    write_polylines(tmp_path / "lines.obj", LINES)
    scene = trimesh.load_scene(tmp_path / "lines.obj", process=False)
    assert [len(each.vertices) for each in scene.geometry.values()] in ([5], [3, 2])


def test_curves_of_dxf_files_are_flattened(tmp_path: Path) -> None:
    document = ezdxf.new()
    model = document.modelspace()
    model.add_line((0, 0, 1), (1, 1, 1))
    model.add_lwpolyline([(0, 0), (1, 0), (1, 1)])
    model.add_arc((0, 0), 2, 0, 90)
    model.add_text("not a curve")
    document.saveas(tmp_path / "strokes.dxf")
    line, corner, arc = read_polylines(tmp_path / "strokes.dxf")
    assert line.tolist() == [[0, 0, 1], [1, 1, 1]]
    assert corner.tolist() == [[0, 0, 0], [1, 0, 0], [1, 1, 0]]
    middles = (arc[1:] + arc[:-1]) / 2
    assert np.abs(np.linalg.norm(middles, axis=1) - 2).max() < 4e-3
    assert arc[[0, -1]] == pytest.approx(np.array([[2, 0, 0], [0, 2, 0]]), abs=1e-9)


def test_indices_of_obj_files_may_be_relative(tmp_path: Path) -> None:
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 1 0 0 1.0\nl -2 -1\nv 2 2 2\nl 3/1 1/2\n")
    assert [line.tolist() for line in read_polylines(tmp_path / "a.obj")] == [
        [[0, 0, 0], [1, 0, 0]],
        [[2, 2, 2], [0, 0, 0]],
    ]


@pytest.mark.parametrize(
    ("name", "text", "sentence"),
    [
        ("a.obj", "v 0 0 0\nl 1 2\n", "line 2 of .*'l 1 2', which is not a valid l element"),
        ("a.obj", "v 0 0 0\nl 1 0\n", "line 2 of .*which is not a valid l element"),
        ("a.obj", "v 0 0 0\nl 1 -2\n", "line 2 of .*which is not a valid l element"),
        ("a.obj", "v 0 0\n", "line 1 of .*which is not a valid v element"),
        ("a.obj", "v 0 0 x\n", "line 1 of .*which is not a valid v element"),
        ("a.obj", "v 0 0 0\n", "contains no polyline: `l` elements"),
        ("a.dxf", "nothing\n", "is not a readable DXF file"),
        ("a.stl", "", "read from .obj and .dxf files"),
    ],
)
def test_what_is_none_is_one_sentence(tmp_path: Path, name: str, text: str, sentence: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(FabkitError, match=sentence):
        read_polylines(tmp_path / name)


def test_what_cannot_be_read_or_written_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(FabkitError, match="cannot be read: No such file"):
        read_polylines(tmp_path / "none.obj")
    with pytest.raises(OutputError, match="written to"):
        write_polylines(tmp_path / "lines.svg", LINES)
    with pytest.raises(OutputError, match="cannot be written"):
        write_polylines(tmp_path / "none" / "lines.obj", LINES)

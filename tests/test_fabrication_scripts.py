"""The scripts for fabrication in examples/ run, and what they write is read back."""

from __future__ import annotations

import csv
import runpy
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import ezdxf
import pytest

from geometry.files import write_mesh
from geometry.mesh import shapes
from tests.fabkit.part21 import StepText

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def script(name: str) -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_outlines_alone_are_nested() -> None:
    found = script("nest_only")["main"]()
    names = {row["name"] for row in rows_of(EXAMPLES / "outlines.csv")}
    sheets = sorted(Path("sheets").iterdir())
    assert len(sheets) == found["sheets"]
    contours = [len(ezdxf.readfile(sheet).modelspace().query('LWPOLYLINE[layer=="CUT"]')) for sheet in sheets]
    assert sum(contours) == found["panes"] == len(names)


def test_parts_of_a_kind_of_ones_own_are_in_the_folder() -> None:
    found = script("own_kind")["main"]()
    rows = rows_of(Path("capped-dome/caps.csv"))
    assert sum(int(row["Count"]) for row in rows if row["Mark"] != "Total") == found["caps"]
    step = StepText(Path("capped-dome/model.step").read_text(encoding="ascii"))
    caps = [each for each in step.all("NEXT_ASSEMBLY_USAGE_OCCURRENCE") if each.values[1].startswith("C0")]
    assert len(caps) == found["caps"]


def test_a_folder_of_meshes_is_built_or_the_reason_is_in_the_table() -> None:
    Path("meshes").mkdir()
    write_mesh("meshes/dome.obj", shapes.dome(8, 2) * 4.0)
    write_mesh("meshes/small.obj", shapes.dome(8, 2) * 0.1)
    Path("meshes/torn.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", encoding="ascii")
    rows = script("batch")["main"](Path("meshes"))
    assert [row[:2] for row in rows] == [
        ("dome.obj", "40 beams, 24 nodes, 16 panels"),
        ("small.obj", "refused"),
        ("torn.obj", "refused"),
    ]
    assert "35% of the edge" in rows[1][2]
    assert "vertex 9" in rows[2][2]
    assert [tuple(row.values()) for row in rows_of(Path("built/table.csv"))] == rows
    assert Path("built/dome/model.step").is_file()
    assert not Path("built/small").exists()


@pytest.mark.kernel
@pytest.mark.parametrize("kernel", ["build123d", "cadquery"])
def test_brackets_are_set_into_their_nodes(kernel: str) -> None:
    if find_spec(kernel) is None:
        pytest.skip(f"{kernel} is not installed")
    names = script(f"bracket_{kernel}")
    removed = names["main"]()
    assert sorted(removed) == ["N001", "N002", "N003"]
    gap = names["CLEARANCE_MM"]
    slot = (names["THICKNESS_MM"] + 2 * gap) * (names["TENON_WIDTH_MM"] + 2 * gap) * (names["TENON_DEPTH_MM"] + gap)
    assert list(removed.values()) == pytest.approx([slot] * 3, rel=1e-6)
    for name in ("bracket", *(f"{mark}-slotted" for mark in removed)):
        text = Path(f"brackets/{name}.step").read_text(encoding="utf-8")
        assert text.count("MANIFOLD_SOLID_BREP(") == 1
        holes = text.count("CYLINDRICAL_SURFACE(")
        assert holes == 1 if name == "bracket" else holes <= 1  # for the shackle; nodes may have a dot near facet 1

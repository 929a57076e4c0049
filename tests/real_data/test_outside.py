"""Programs that know nothing of fabkit make real structures from their folders alone; marks of real nodes."""

from __future__ import annotations

from pathlib import Path

import pytest

from fabkit import Project, build, design
from fabkit.production import share_equal_parts
from fabkit.rules import MarkRules
from tests.fabkit.test_outside import WELDED, WITHIN_MM, said_by
from tests.real_data.meshes import CONICAL, DATA, needs_data

pytestmark = needs_data


def test_a_welded_roof_is_made_from_its_folder_alone(tmp_path: Path) -> None:
    out, only = tmp_path / "out", ["step", "parts", "tables"]
    build(Project(mesh=DATA / CONICAL, mean_edge_mm=1500, out=out, documents=only, **WELDED))
    put, set_out = said_by("put_together.py", out), said_by("set_out.py", out)
    assert (put["n_beams"], set_out["n"]) == (2226, 1147)
    assert max(put["beams"], put["others"], set_out["blocks"], set_out["heights"], set_out["facets"]) < WITHIN_MM


@pytest.mark.parametrize(("far_end_mm", "least", "most"), [(10_000, 200, 320), (0.5, 900, 1147)])
def test_plain_blocks_share_marks_by_their_corners_and_not_by_directions(
    far_end_mm: float, least: int, most: int
) -> None:
    """Blocks alike to half a millimetre hide 20 to 40 mm at the far ends of beams, unless directions count."""
    bars = {"beams": {"width_mm": 50, "height_mm": 120}, "connection": {"kind": "contact"}}
    tops = {"nodes": {"top": "enclosing"}, "nesting": {"mode": "off"}}
    built = design(Project(mesh=DATA / CONICAL, mean_edge_mm=1500, **bars, **tops))
    nodes = share_equal_parts(built.nominal, within_mm=0.5, rules=MarkRules(far_end_mm=far_end_mm))["nodes"]
    assert least < len(nodes.mark_names) < most
    corners, far_ends = nodes.hidden_mm.max(axis=0)
    assert 0.4 < corners <= 0.5
    assert 20 < far_ends < 40 if far_end_mm > 1 else 0 < far_ends <= 0.5

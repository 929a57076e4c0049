"""Edge work and coatings: which pane has them, and what differs in them has marks of its own."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO
from typing import Any

import ezdxf
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fabkit import Project, design
from fabkit.errors import ProjectError
from fabkit.formats.drawings import write_dxf
from fabkit.parts import Assembly, Finish, Parts
from fabkit.production import cut_list, panel_drawings, sheet_drawings
from fabkit.production.marks import mark_points, share_equal_parts
from fabkit.rules import LayerRules, MarkRules
from geometry.mesh.shapes import dome
from tests.fabkit.plates import plates

GLASS = 2500.0
SKEW = np.array([[0.0, 0.0], [900.0, 0.0], [700.0, 400.0], [150.0, 500.0]])
plies = st.sampled_from(["8", "44.2", "64.2", "444.22", "6T"])


def project(**layer: Any) -> Project:
    return Project(mesh=dome(6, 2), mean_edge_mm=1500, layers=[layer])


@given(st.lists(plies, min_size=1, max_size=3), st.data())
def test_a_surface_belongs_to_the_pane_and_side_that_counting_from_outside_gives(
    panes: list[str], data: st.DataObject
) -> None:
    counts = [3 if pane == "444.22" else 2 if "." in pane else 1 for pane in panes]
    every = [
        (pane, "outside" if k == 0 else "inside" if k == 2 * count - 1 else "interlayer")
        for pane, count in enumerate(counts)
        for k in range(2 * count)
    ]
    surface = data.draw(st.integers(1, len(every)))
    rules = LayerRules(build_up="/16Ar/".join(panes), coating=surface)
    for number, (finish, material) in enumerate(zip(rules.finishes, rules.pane_materials(GLASS), strict=True)):
        has_it = number == every[surface - 1][0]
        assert (finish.coating, finish.coated_side) == ((surface, every[surface - 1][1]) if has_it else (0, ""))
        assert ("coated" in material.name) == has_it
        assert finish.has_equal_faces == (not has_it and panes[number] != "64.2")


@pytest.mark.parametrize(
    ("layer", "sentence"),
    [
        ({"build_up": "8/16Ar/44.2", "coating": 7}, r"coating is 7, but 8/16Ar/44.2 has surfaces 1 \(outside\) to 6"),
        ({"build_up": "8", "coating": 0}, "coating is 0, but 8 has surfaces"),
        ({"thickness_mm": 3, "coating": [1, 2]}, "coating names two surfaces of pane 0"),
        ({"coating": "outside"}, r"layers.0.coating.0 is 'outside'"),
        ({"edge_work": "grounded"}, "edge_work is 'grounded'.*'ground'"),
    ],
)
def test_finishes_that_are_none_get_one_sentence(layer: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ProjectError, match=sentence):
        project(**layer)


def test_the_list_and_the_drawings_state_the_finish() -> None:
    built = design(project(build_up="8/16Ar/44.2", edge_work="polished", coating=2))
    table = cut_list(built.assembly, built.nest)["panels"]
    rows = [dict(zip(table.columns, row, strict=True)) for row in table.texts]
    said = {
        tuple(row[name] for name in ("Material", "Build-up", "Edge work", "Coating", "Coated side")) for row in rows
    }
    assert said == {
        ("glass coated inside", "glass 8/16Ar/44.2", "polished", "2", "inside"),
        ("glass 44.2", "glass 8/16Ar/44.2", "polished", "", ""),
    }
    titles = []
    for drawing in panel_drawings(built.assembly, title="roof"):
        stream = StringIO()
        write_dxf(stream, drawing)
        read = ezdxf.read(StringIO(stream.getvalue()))
        titles.append(" ".join(text.dxf.text for text in read.modelspace().query("TEXT")))
    first = "roof 8 mm glass coated inside, in glass 8/16Ar/44.2, edges polished, coating #2, panel P001"
    assert titles[0].startswith(first)
    assert titles[-1].startswith("roof 8.76 mm glass 44.2, in glass 8/16Ar/44.2, edges polished, panel P")
    assert built.nest is not None
    sheets = sheet_drawings(built.nest, built.assembly["panels"], title="roof")
    assert {sheet.title[1].split(", ")[0] for sheet in sheets} == {"8 mm glass coated inside", "8.76 mm glass 44.2"}


def with_finishes(*finishes: Finish) -> Parts[Any]:
    """An outline and its mirror image, and so on, with these finishes."""
    mirrored = SKEW[::-1] * [1, -1]
    panels = plates([SKEW if k % 2 == 0 else mirrored for k in range(len(finishes))])
    every = np.empty(len(finishes), dtype=object)
    every[:] = finishes
    return replace(panels, details=replace(panels.details, finish=every))


@pytest.mark.parametrize(
    ("finish", "n_marks"),
    [
        (Finish(), 1),
        (Finish(edge_work="ground"), 1),
        (Finish(coating=2, coated_side="inside", has_equal_faces=False), 2),
        (Finish(build_up="glass 64.2", has_equal_faces=False), 2),
    ],
)
def test_mirrored_panes_share_a_mark_only_where_both_faces_are_equal(finish: Finish, n_marks: int) -> None:
    assembly = Assembly("two", (with_finishes(finish, finish),))
    shared = share_equal_parts(assembly, rules=MarkRules(mirrored_panes=True))["panels"]
    assert len(shared.mark_names) == n_marks
    assert shared.turned_over.tolist() == [False, n_marks == 1]


def test_panes_with_different_finishes_have_marks_of_their_own_and_keep_them() -> None:
    ground, plain = Finish(edge_work="ground"), Finish()
    assembly = Assembly("four", (with_finishes(plain, plain, ground, ground),))
    shared = share_equal_parts(assembly)["panels"]
    assert len(shared.mark_names) == 4
    kept = {"panels": mark_points(shared)}
    again = share_equal_parts(Assembly("four", (with_finishes(ground, plain, plain, ground),)), kept=kept)["panels"]
    assert again.marks == [shared.marks[k] for k in (2, 1, 0, 3)]


def test_mirrored_panes_are_refused_where_no_pane_has_two_equal_faces() -> None:
    settings: dict[str, Any] = {"mesh": dome(6, 2), "mean_edge_mm": 1500, "marks": {"mirrored_panes": True}}
    with pytest.raises(ProjectError, match=r"the two faces of every pane differ \(surface 2 is coated\)"):
        Project(**settings, layers=[{"build_up": "8", "coating": 2}])
    with pytest.raises(ProjectError, match="the plies of the laminate differ"):
        Project(**settings, layers=[{"build_up": "64.2"}])
    assert Project(**settings, layers=[{"build_up": "8/16Ar/8", "coating": 2}]).marks.mirrored_panes  # the inner pane


@pytest.mark.parametrize(
    ("thickness", "mass"),  # kg/m2 by hand: 2.5 for a mm of glass, 1.07 for one of PVB
    [(8.76, 20.8132), (13.52, 31.6264), (6.38, 15.4066), (21.52, 51.6264), (8.0, 20.0), (10.0, 25.0), (9.5, 23.75)],
)
def test_a_thickness_that_only_a_laminate_has_counts_its_foils(thickness: float, mass: float) -> None:
    (material,) = LayerRules(thickness_mm=thickness).pane_materials(GLASS)
    assert material.density_kg_m3 * thickness * 1e-3 == pytest.approx(mass, rel=1e-12)
    (other,) = LayerRules(thickness_mm=thickness, material="acrylic").pane_materials(1190.0)
    assert other.density_kg_m3 == 1190.0

"""What pieces with one mark have in common, how marks are numbered, and how they are kept."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit import Built, Project, build, design
from fabkit.checking import violations
from fabkit.errors import DetailingError, FolderError, ProjectError
from fabkit.formats.finished import kept_marks
from fabkit.kinds import panel_outlines
from fabkit.parts import Assembly, Parts
from fabkit.production.marks import KeptMarks, element_ranks, mark_points, share_equal_parts
from fabkit.production.pieces import mark_table
from fabkit.rules import MarkOrder, MarkRules
from geometry.mesh import Mesh, shapes
from tests.fabkit.plates import plates

SIZES: dict[str, Any] = {
    "beams": {"width_mm": 50, "height_mm": 120},
    "connection": {"kind": "contact"},
    "nesting": {"mode": "off"},
    "mean_edge_mm": 1500,
}


def worn(seed: int, share: float = 0.002) -> Mesh:
    """A dome whose equal parts differ by some millimetres."""
    dome = shapes.dome(8, 3)
    noise = np.random.default_rng(seed).uniform(-share, share, dome.vertices.shape)
    return dome.with_vertices(dome.vertices + noise)


@pytest.fixture(scope="module")
def rough() -> Built:
    return design(Project(mesh=worn(1), **SIZES))


def corners(parts: Parts[Any], which: np.ndarray) -> list[np.ndarray]:
    """Of the solids of these parts, placed."""
    return [parts.origins[k] + parts.solids[int(parts.shape[k])].vertices @ parts.axes[k] for k in which.tolist()]


@settings(max_examples=15)
@given(st.floats(0.05, 8.0), st.floats(0.05, 20.0))
def test_what_is_hidden_is_said_and_within_the_tolerances(rough: Built, within: float, far_end: float) -> None:
    """Found from the placed corners alone, whatever their numbers are; and from the azimuths of the facets."""
    shared = share_equal_parts(rough.nominal, within_mm=within, rules=MarkRules(far_end_mm=far_end))
    for before, after in zip(rough.nominal.groups, shared.groups, strict=True):
        assert after.hidden_mm[:, 0].max() <= within
        assert after.hidden_mm[:, 1].max() <= far_end
        every = np.arange(len(before))
        for k, (one, other) in enumerate(zip(corners(before, every), corners(after, every), strict=True)):
            apart = np.abs(one[:, None] @ after.axes[k].T - other[None] @ after.axes[k].T).max(axis=2)
            assert apart.min(axis=1).max() <= after.hidden_mm[k, 0] + 1e-9
    nodes, beams = shared["nodes"], shared["beams"]
    models = nodes.firsts[nodes.mark]
    lengths = np.zeros(beams.elements.max() + 1)
    lengths[beams.elements] = beams.details.long_point_mm
    for k, model in enumerate(models.tolist()):
        azimuths, of_model = (np.radians(nodes.details.azimuths_deg[j]) for j in (k, model))
        off = 2 * np.abs(np.sin((azimuths - of_model) / 2)) * lengths[nodes.details.beams[k]]
        assert off.max() <= nodes.hidden_mm[k, 1] * 2**0.5 + 1e-6


def test_directions_part_nodes_that_corners_do_not(rough: Built) -> None:
    counts = [
        len(share_equal_parts(rough.nominal, within_mm=1.0, rules=MarkRules(far_end_mm=far))["nodes"].mark_names)
        for far in (10_000, 5, 0.1)
    ]
    assert counts[0] < counts[1] < counts[2]


@pytest.mark.parametrize("order", ["elements", "rings", "rows"])
def test_marks_are_numbered_in_the_order_that_is_asked(rough: Built, order: str) -> None:
    mesh = rough.structure.mesh
    ranks = element_ranks(mesh, order)  # type: ignore[arg-type]
    shared = share_equal_parts(rough.nominal, rules=MarkRules(prefix="NO1-", start=98), ranks=ranks)
    for parts in shared.groups:
        assert sorted(ranks[parts.kind.element]) == list(range(len(ranks[parts.kind.element])))
        firsts = np.full(len(parts.mark_names), len(ranks[parts.kind.element]))
        np.minimum.at(firsts, parts.mark, ranks[parts.kind.element][parts.elements])
        assert (np.diff(firsts) > 0).all()
        names = [f"NO1-{parts.kind.letter}{98 + k:03d}" for k in range(len(firsts))]
        assert list(parts.mark_names) == names


def test_rings_run_inwards_and_rows_along_the_longer_side() -> None:
    flat = shapes.grid(5, 3)
    rings = element_ranks(flat, "rings")["vertex"].reshape(6, 4)
    assert set(rings[1:-1, 1:-1].ravel().tolist()) == set(range(16, 24))
    rows = element_ranks(flat, "rows")["face"]
    middles = flat.vertices[np.array(flat.combinatorics.faces)].mean(axis=1)[np.argsort(rows)]
    assert (np.diff(middles[:, 0]).reshape(-1)[[0, 1, 2, 3]] > 0).all()
    assert middles[:5, 1].tolist() == [middles[0, 1]] * 5
    closed = Mesh.from_faces([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    assert element_ranks(closed, "rings")["vertex"][0] == 0


@settings(max_examples=20)
@given(st.integers(3, 12), st.integers(2, 5), st.integers(0, 2**32 - 1))
def test_rings_of_a_dome_with_an_opening_run_once_around_each(n: int, n_rings: int, seed: int) -> None:
    """Wherever it is turned: n nodes and panels a ring from the long boundary to the opening; n beams of each ring, and
    then n that lead inwards; all go around in the same sense, and beside those of the ring before."""
    upright = shapes.dome(n, n_rings)
    rotation, triangle = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    rotation *= np.sign(np.diag(triangle)) * np.sign(np.linalg.det(rotation) * np.prod(np.sign(np.diag(triangle))))
    ranks = element_ranks(upright.with_vertices(upright.vertices @ rotation.T), "rings")
    c = upright.combinatorics
    middles = {
        "vertex": upright.vertices,
        "edge": upright.vertices[c.edges].mean(axis=1),
        "face": upright.vertices[np.array(c.faces)].mean(axis=1),
    }
    for element, points in middles.items():
        rings = points[np.argsort(ranks[element])].reshape(-1, n, 3)
        assert np.ptp(rings[:, :, 2], axis=1).max() < 1e-9  # a ring is level
        assert (np.diff(rings[:, 0, 2]) > 0).all()
        angles = np.arctan2(rings[:, :, 1], rings[:, :, 0])
        steps = np.mod(np.diff(angles, axis=1), 2 * np.pi)
        assert np.allclose(steps, 2 * np.pi / n)
        starts = np.mod(angles[1:, 0] - angles[:-1, 0] + np.pi, 2 * np.pi) - np.pi
        assert np.abs(starts).max() <= 2 * np.pi / n + 1e-9


def changed(parts: Parts[Any], rng: np.random.Generator) -> tuple[Parts[Any], np.ndarray]:
    """The parts with some of their solids changed by up to 5 mm, and which are not."""
    which = rng.choice(len(parts), 3, replace=False)
    vertices = parts.solids.vertices
    moves = np.where(np.isin(vertices.row, which)[:, None], rng.uniform(-5, 5, vertices.values.shape), 0.0)
    solids = replace(parts.solids, vertices=vertices.with_values(vertices.values + moves))
    return replace(parts, solids=solids), np.setdiff1d(np.arange(len(parts)), which)


def test_what_marks_hide_is_no_trouble_of_the_design(rough: Built) -> None:
    assert violations(rough.nominal) == ()
    shared = share_equal_parts(rough.nominal, within_mm=3.0, rules=MarkRules(far_end_mm=9.0))
    assert max(parts.hidden_mm.max() for parts in shared.groups) > 1
    found = violations(shared)
    assert found
    assert all("have the solids of their marks here" in each.sentence for each in found)
    exact = share_equal_parts(rough.nominal, within_mm=1e-7)
    assert violations(exact) == ()


@settings(max_examples=10)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-3, 0.5, 3.0]), st.sampled_from(["elements", "rings"]))
def test_what_does_not_change_keeps_its_mark(rough: Built, seed: int, within: float, order: MarkOrder) -> None:
    """Whatever else changes; and marks of what is no more are not given again, not even two builds later."""
    rules, ranks = MarkRules(far_end_mm=3 * within), element_ranks(rough.structure.mesh, order)

    def shared(assembly: Assembly, kept: dict[str, KeptMarks]) -> Assembly:
        return share_equal_parts(assembly, within_mm=within, rules=rules, ranks=ranks, kept=kept)

    first = shared(rough.nominal, {})
    kept = {parts.kind.group: mark_points(parts) for parts in first.groups}
    rng = np.random.default_rng(seed)
    others = {parts.kind.group: changed(parts, rng) for parts in rough.nominal.groups}
    second = shared(Assembly("other", tuple(parts for parts, _ in others.values())), kept)
    for old, new in zip(first.groups, second.groups, strict=True):
        same = others[old.kind.group][1]
        assert [old.marks[k] for k in same.tolist()] == [new.marks[k] for k in same.tolist()]
        assert new.hidden_mm[:, 0].max() <= 2 * within
        fresh = set(new.mark_names) - set(old.mark_names)
        assert all(int(name[1:]) > len(old.mark_names) for name in fresh)
    rows = mark_table(second, kept).rows
    known = {row[1] for row in rows}
    assert known >= {name for parts in first.groups for name in parts.mark_names}
    back = shared(rough.nominal, kept)
    assert [parts.marks for parts in back.groups] == [parts.marks for parts in first.groups]


def test_a_mark_whose_first_part_is_gone_is_still_that_of_the_others(rough: Built) -> None:
    """The others are then described as the earlier one was: from the same end, facet or edge."""
    regular = design(Project(mesh=shapes.dome(8, 3), **SIZES))
    kept = {parts.kind.group: mark_points(parts) for parts in regular.assembly.groups}
    for parts in regular.nominal.groups:
        others = parts.take(np.setdiff1d(np.arange(len(parts)), regular.assembly[parts.kind.group].firsts))
        shared = share_equal_parts(Assembly("rest", (others,)), kept=kept)[parts.kind.group]
        expected = dict(
            zip(
                regular.assembly[parts.kind.group].elements.tolist(),
                regular.assembly[parts.kind.group].marks,
                strict=True,
            )
        )
        assert shared.marks == [expected[element] for element in others.elements.tolist()]
        every = np.arange(len(others))
        for one, other in zip(corners(others, every), corners(shared, every), strict=True):
            assert np.abs(one[:, None] - other).max(axis=2).min(axis=1).max() < 1e-6
        for name, each in mark_points(shared).points.items():
            assert np.abs(each.corners - kept[parts.kind.group].points[name].corners).max() < 1e-6


def test_marks_are_kept_from_a_folder(tmp_path: Path) -> None:
    only = {**SIZES, "documents": ["tables"], "tables": {"separator": ";", "decimal": ","}}
    first = build(Project(mesh=worn(1), out=tmp_path / "first", **only))
    read = kept_marks(tmp_path / "first")
    for parts in first.assembly.groups:
        for name, each in mark_points(parts).points.items():
            other = read[parts.kind.group].points[name]
            assert other.shape == each.shape
            assert np.abs(other.corners - each.corners).max() < 1e-9
    marks = {"keep": tmp_path / "first", "prefix": "B-"}
    second = build(Project(mesh=worn(1), out=tmp_path / "second", marks=marks, **only))
    assert [parts.marks for parts in second.assembly.groups] == [parts.marks for parts in first.assembly.groups]
    assert '"keep"' not in (tmp_path / "second" / "manifest.json").read_text()
    third = build(Project(mesh=worn(2), out=tmp_path / "third", marks=marks, **only))
    fresh = {mark for parts in third.assembly.groups for mark in parts.mark_names if mark.startswith("B-")}
    assert fresh
    assert not fresh & set(read)


def edit(folder: Path, one: str, other: str) -> None:
    path = folder / "mark_points.csv"
    assert one in path.read_text()
    path.write_text(path.read_text().replace(one, other))


@pytest.mark.parametrize(
    ("damage", "sentence"),
    [
        (lambda folder: (folder / "mark_points.csv").write_text("Mark,x\nB001,1"), r"kept: .* is cut off"),
        (lambda folder: edit(folder, ",corner,", ",cornr,"), r"cannot be kept: .* damaged, near 'cornr'"),
        (lambda folder: edit(folder, "B001", "../../B001"), r"damaged, near '../../B001'"),
        (lambda folder: edit(folder, "-120.000000000", "1e999"), "damaged, near '1e999'"),
        (lambda folder: edit(folder, "-120.000000000", "one"), "damaged, near 'one'"),
        (lambda folder: edit(folder, "-120.000000000", "-120.000000001"), r"kept: mark_points.csv there was changed"),
        (lambda folder: (folder / "placements.csv").unlink(), r"kept: placements.csv is missing"),
        (lambda folder: (folder / "manifest.json").unlink(), "has no manifest.json"),
        (lambda folder: folder.rename(folder.parent / "elsewhere"), "is not a folder"),
        (
            lambda folder: (folder / "manifest.json").write_text(
                (folder / "manifest.json").read_text().replace('"mark_points.csv"', '"marks.csv"')
            ),
            "has no mark_points.csv, so its marks cannot be kept: it is of another version",
        ),
    ],
)
def test_a_folder_whose_marks_cannot_be_kept_is_named(tmp_path: Path, damage: Any, sentence: str) -> None:
    out = tmp_path / "first"
    build(Project(mesh=shapes.dome(4, 1), out=out, documents=["tables"], **SIZES))
    damage(out)
    with pytest.raises(FolderError, match=sentence):
        build(Project(mesh=shapes.dome(4, 1), out=tmp_path / "second", marks={"keep": out}, **SIZES))
    assert not (tmp_path / "second").exists()


def test_nothing_is_built_into_the_folder_whose_marks_are_kept(tmp_path: Path) -> None:
    out = tmp_path / "first"
    build(Project(mesh=shapes.dome(4, 1), out=out, documents=["tables"], **SIZES))
    with pytest.raises(ProjectError, match=r"lies in .*first, the folder whose marks"):
        build(Project(mesh=shapes.dome(4, 1), out=out / "second", marks={"keep": out}, **SIZES))
    assert not (out / "second").exists()


def test_kept_marks_of_one_kind_are_no_names_of_another() -> None:
    built = design(Project(mesh=shapes.dome(4, 1), **SIZES))
    nodes = mark_points(built.assembly["nodes"]).points.values()
    kept = {"nodes": KeptMarks({f"xb{number:03d}": each for number, each in enumerate(nodes, start=1)})}
    with pytest.raises(DetailingError, match=r"the mark xb001 of a node would be .* XB001 of a beam"):
        share_equal_parts(built.nominal, rules=MarkRules(prefix="X"), kept=kept)


def test_a_prefix_that_makes_marks_numbers_is_refused() -> None:
    with pytest.raises(ProjectError, match=r"takes marks such as 12E001 for numbers.*'12-'"):
        Project(mesh=shapes.dome(4, 1), marks={"prefix": "12"}, **SIZES)
    assert Project(mesh=shapes.dome(4, 1), marks={"prefix": "12-"}, **SIZES).marks.prefix == "12-"


@pytest.mark.parametrize("prefix", ["a/b", "=1", "-A", "x" * 17, "é", "a b", "a.", "_", "\n"])
def test_a_prefix_that_no_file_can_have_is_refused(prefix: str) -> None:
    with pytest.raises(ProjectError, match=r"marks.prefix is .*names of files"):
        Project(mesh=shapes.dome(4, 1), marks={"prefix": prefix}, **SIZES)


@pytest.mark.parametrize("rules", [{"far_end_mm": 0}, {"far_end_mm": float("nan")}, {"start": 0}, {"order": "spiral"}])
def test_rules_that_mean_nothing_are_refused(rules: dict[str, Any]) -> None:
    with pytest.raises(ProjectError, match=rf"marks.{next(iter(rules))} is"):
        Project(mesh=shapes.dome(4, 1), marks=rules, **SIZES)


@settings(max_examples=15)
@given(st.integers(3, 7), st.integers(0, 2**32 - 1))
def test_mirrored_panes_are_one_mark_where_the_rules_say_so(n: int, seed: int) -> None:
    """In place before and after; and records of edges and corners are those of the edges and corners in their place."""
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, n) * 0.3 + 2 * np.pi * np.arange(n) / n)
    outline = np.stack([900 * np.cos(angles), 700 * np.sin(angles)], axis=1)
    mirrored = np.roll(outline[::-1] * [1, -1], int(rng.integers(n)), axis=0)
    panels = plates([outline, mirrored])
    assembly = Assembly("panes", (panels,))
    apart = share_equal_parts(assembly, within_mm=1e-6)["panels"]
    assert len(apart.mark_names) == 2
    assert not apart.turned_over.any()
    shared = share_equal_parts(assembly, within_mm=1e-6, rules=MarkRules(mirrored_panes=True))["panels"]
    assert shared.marks == ["P001", "P001"]
    assert shared.turned_over.tolist() == [False, True]
    every = np.arange(2)
    for one, other in zip(corners(panels, every), corners(shared, every), strict=True):
        assert np.abs(one[:, None] - other).max(axis=2).min(axis=1).max() < 1e-6
    assert np.linalg.det(shared.axes) == pytest.approx([1.0, 1.0])
    own = shared.details
    for name in ("edge_lengths_mm", "corner_angles_deg"):
        one, other = getattr(own, name)
        assert one == pytest.approx(other, abs=1e-6)


def twins() -> Mesh:
    """A translational surface of oblique quads, and its mirror image beside it."""
    u, v = np.arange(4.0), np.arange(3.0)
    one = np.stack([u, 0 * u, -0.05 * (u - 1) ** 2 + 0.004 * u**3], axis=1)
    other = np.stack([0.3 * v, v, -0.06 * v**2 + 0.005 * v**3], axis=1)
    points = (one[:, None] + other[None]).reshape(-1, 3)
    faces = [[3 * i + j, 3 * i + j + 3, 3 * i + j + 4, 3 * i + j + 1] for i in range(3) for j in range(2)]
    mirrored = [[len(points) + k for k in face[::-1]] for face in faces]
    return Mesh.from_faces(np.concatenate([points, points * [-1, 1, 1] - [2, 0, 0]]), faces + mirrored)


def test_panels_turned_over_are_cut_and_placed_right() -> None:
    """The contour of the mark, as it is cut, lies turned over where the panel is; on sheets all of a mark lie alike."""
    built = design(Project(mesh=twins(), mean_edge_mm=1200, marks={"mirrored_panes": True}))
    panels, nominal = built.assembly["panels"], built.nominal["panels"]
    assert len(panels.mark_names) == 6
    assert panels.turned_over.sum() == 6
    upwards = (panels.axes[:, 2] * nominal.axes[:, 2]).sum(axis=1)
    assert np.array_equal(upwards > 0, ~panels.turned_over)
    outlines, every = panel_outlines(panels), np.arange(len(panels))
    for k, planned in enumerate(corners(nominal, every)):
        contour = np.pad(outlines[k], ((0, 0), (0, 1)))
        thickness = nominal.details.thickness_mm[k]
        cut = np.concatenate([contour, contour + np.array([0, 0, thickness])])
        made = panels.origins[k] + cut @ panels.axes[k]
        apart = np.linalg.norm(planned[:, None] - made, axis=2)
        assert max(apart.min(axis=0).max(), apart.min(axis=1).max()) <= 3**0.5 * panels.hidden_mm[k, 0] + 1e-6
    assert built.nest is not None
    on_sheets = [[] for _ in range(built.nest.n_sheets)]  # type: list[list[Any]]
    for outline, place in zip(outlines, built.nest.placements, strict=True):
        turned = shapely.affinity.rotate(shapely.Polygon(outline), place.angle_deg, origin=(0, 0))
        on_sheets[place.sheet].append(shapely.affinity.translate(turned, *place.offset_mm))
    for own in on_sheets:
        assert shapely.union_all(own).area == pytest.approx(sum(each.area for each in own))
        assert min(each.bounds[0] for each in own) >= 0

"""STEP files as text: the tree of products, their instances, and what is refused."""

from __future__ import annotations

import io
import re
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabkit.errors import OutputError
from fabkit.formats.step.files import instance_name, stream_step, write_part_steps, write_step
from fabkit.kinds import NODE
from fabkit.parts import Assembly, Frame, Material, Part, Parts, Solid
from geometry.errors import GeometryError
from tests.fabkit.assemblies import by_name, with_parts
from tests.fabkit.gridshell import gridshell
from tests.fabkit.part21 import StepText, coordinates, written
from tests.fabkit.solids import frame, node, prism, star, tube


@pytest.fixture(scope="module")
def assembly() -> Assembly:
    return gridshell(4, 3)


@pytest.fixture(scope="module")
def file(assembly: Assembly) -> StepText:
    return written(assembly)


def test_structure_is_a_tree_of_instances(assembly: Assembly, file: StepText) -> None:
    assert set(file.references()) <= set(file.instances)
    children: dict[str, list[tuple[str, str]]] = {}
    for occurrence in file.all("NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
        assert occurrence.values[0] == occurrence.values[1]
        parent, child = (product(file, definition) for definition in occurrence.values[3:5])
        children.setdefault(parent, []).append((occurrence.values[1], child))
    groups = by_name(assembly)
    assert children.pop(assembly.name) == [(name, name) for name in groups]
    for name, parts in groups.items():
        assert children.pop(name) == [(instance_name(part), part.mark) for part in parts]
    assert not children


def test_files_of_the_marks_are_written_beside_the_model(assembly: Assembly, tmp_path: Path) -> None:
    found = []
    for name, write in (
        ("alone", lambda folder: write_part_steps(folder, assembly.groups)),
        ("beside", lambda folder: write_step(io.StringIO(), assembly, parts_folder=folder)),
    ):
        (folder := tmp_path / name).mkdir()
        write(folder)
        found.append({path.name: path.read_bytes() for path in folder.iterdir()})
    assert found[0] == found[1]
    assert len(found[0]) == sum(len(parts.mark_names) for parts in assembly.groups)


def product(file: StepText, definition: int) -> str:
    formation = file[definition].values[2]
    return str(file[file[formation].values[2]].values[0])


def test_equal_parts_are_one_product(assembly: Assembly, file: StepText) -> None:
    marks = {part.mark for part in assembly.parts()}
    assert len(marks) < len(list(assembly.parts()))  # or this tests nothing
    names = [each.values[0] for each in file.all("PRODUCT")]
    assert sorted(names) == sorted([assembly.name, *by_name(assembly), *marks])
    assert len(file.all("MANIFOLD_SOLID_BREP")) == len(marks)


def test_instances_have_unique_names(file: StepText) -> None:
    names = Counter(each.values[1] for each in file.all("NEXT_ASSEMBLY_USAGE_OCCURRENCE"))
    assert max(names.values()) == 1


def test_placements(assembly: Assembly, file: StepText) -> None:
    placed = {}
    for link in file.all("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
        leaves = dict(file[link.values[0]].values)
        occurrence = file[file[link.values[1]].values[2]].values
        child, parent = leaves["REPRESENTATION_RELATIONSHIP"][2:]
        start, end = file[leaves["REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION"][0]].values[2:]
        assert start in file[child].values[1]
        assert end in file[parent].values[1]
        assert file[child].values[2] != file[parent].values[2]  # two contexts, as the standard asks
        placed[occurrence[1]] = file[end].values[1:]
        assert [coordinates(file, each).tolist() for each in file[start].values[1:]] == [
            [0, 0, 0],
            [0, 0, 1],
            [1, 0, 0],
        ]
    for part in assembly.parts():
        origin, z, x = (coordinates(file, each) for each in placed[instance_name(part)])
        assert np.array_equal(origin, part.placement.origin)
        assert np.array_equal([x, z], part.placement.axes[[0, 2]])


def test_each_kind_has_its_colour(assembly: Assembly, file: StepText) -> None:
    kinds = {part.mark: part.kind for part in assembly.parts()}
    rendered = {"COLOUR_RGB"}
    for styled in file.all("STYLED_ITEM"):
        (at,) = styled.values[1]
        while file[at].kind not in rendered:
            (at,) = list(file.references(file[at].values))
        assert tuple(file[at].values[1:]) == kinds[file[styled.values[2]].values[0]].colour
    assert len(file.all("STYLED_ITEM")) == len(kinds)
    assert len(file.all("COLOUR_RGB")) == 3


@pytest.mark.parametrize("kept", ["beams", "nodes", "panels"])
def test_empty_groups_are_left_out(assembly: Assembly, kept: str) -> None:
    others: dict[str, Any] = {name: () for name in by_name(assembly) if name != kept}
    file = written(with_parts(assembly, **others))
    assert set(file.references()) <= set(file.instances)
    assert set(others).isdisjoint(each.values[0] for each in file.all("PRODUCT"))


def test_shapes_come_once_however_far_apart_their_parts_are() -> None:
    parts = [node(f"N{n % 90}", prism([[0, 0], [50, 0], [0, 50 + n % 90]], 10.0), frame(n), n) for n in range(270)]
    stream = io.StringIO()
    stream_step(stream, "many", [Parts.of(NODE, parts)])
    file = StepText(stream.getvalue())
    assert len(file.all("MANIFOLD_SOLID_BREP")) == 90
    assert len(file.all("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION")) == 271


def test_same_parts_same_bytes(assembly: Assembly) -> None:
    first, second = io.StringIO(), io.StringIO()
    write_step(first, assembly)
    write_step(second, gridshell(4, 3))
    assert first.getvalue() == second.getvalue()


def test_file_holds_what_a_stream_gets(assembly: Assembly, tmp_path: Path) -> None:
    stream = io.StringIO()
    write_step(stream, assembly)
    write_step(tmp_path / "model.step", assembly)
    assert (tmp_path / "model.step").read_bytes() == stream.getvalue().encode("ascii")
    assert [each.name for each in tmp_path.iterdir()] == ["model.step"]


class Sink(io.StringIO):
    """Forgets what is written."""

    def write(self, text: str) -> int:
        return len(text)


def test_memory_does_not_grow_with_the_text() -> None:
    outline = np.array([[0.0, 0.0], [50.0, 0.0], [60.0, 40.0], [0.0, 50.0]])

    def parts(n: int) -> Iterator[Parts[Any]]:
        for some in range(0, n, 50):
            few = (node(f"N{k}", prism(outline, 10.0 + k), None, k) for k in range(some, some + 50))
            yield Parts.of(NODE, few)

    def peak(n: int) -> int:
        tracemalloc.start()
        stream_step(Sink(), "many", parts(n))
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return size

    peak(1500)  # templates, caches, and a garbage collector in its stride
    assert (peak(6000) - peak(3000)) / 3000 < 500  # bytes a part: its mark, ids and a hash; its text is 8000


# Refusals


def refused(parts: list[Part], message: str, **options: Any) -> None:
    with pytest.raises(OutputError, match=message):
        stream_step(io.StringIO(), "structure", [Parts.of(NODE, parts)], **options)


def test_one_mark_for_two_solids_is_refused() -> None:
    refused([node("N1", tube()), node("N1", tube(height=101.0), None, 5)], "mark N1 is that of two .* N1 v5")
    refused([node("N1", tube()), node("N1", tube(), material=Material("oak", 700.0))], "mark N1 is that of two")
    apart = [node(f"A{n}", star(3, 50 + n)) for n in range(200)]
    refused([node("N1", tube()), *apart, node("N1", tube(height=101.0))], "mark N1 is that of two")


@pytest.mark.parametrize("mark", ["Träger", "", "a\tb"])
def test_marks_that_are_no_names_are_refused(mark: str) -> None:
    refused([node(mark, tube())], "not printable ASCII")


@pytest.mark.parametrize("mark", ["structure", "nodes", "panels"])
def test_marks_of_other_products_are_refused(mark: str) -> None:
    """Whichever of the two is written first."""
    groups = [Parts.of(NODE, [node(mark, tube())]), gridshell(1, 1)["panels"]]
    for some in (groups, groups[::-1]):
        with pytest.raises(OutputError, match="name of the structure or a group"):
            stream_step(io.StringIO(), "structure", some)


def test_structure_is_not_called_like_a_group(assembly: Assembly) -> None:
    with pytest.raises(OutputError, match="'beams'"):
        write_step(io.StringIO(), replace(assembly, name="beams"))


def test_no_parts_are_refused() -> None:
    refused([], "no parts")


def test_unknown_schema_is_refused() -> None:
    refused([node("N1", tube())], "'AP203'; choose AP242 or AP214", schema="AP203")


def test_mirrored_placement_is_refused() -> None:
    refused([node("N1", tube()), node("N1", tube(), Frame(np.zeros(3), -np.eye(3)), 8)], "N1 v8 is not a rigid motion")
    refused([node("N1", tube(), Frame(np.zeros(3), 1.001 * np.eye(3)))], "not a rigid motion")


def test_numbers_that_are_not_finite_are_refused() -> None:
    refused([node("N1", tube(), Frame(np.array([0, np.nan, 0]), np.eye(3)))], "N1 v0 is not a rigid motion")
    with pytest.raises(GeometryError, match="density of aether in kg/m3 is inf: a finite number is needed"):
        Material("aether", np.inf)


def moved(solid: Solid, vertex: int, by: tuple[float, float, float]) -> Solid:
    vertices = solid.vertices.copy()
    vertices[vertex] += by
    return Solid(vertices, solid.topology)


def test_faces_off_their_plane_are_refused() -> None:
    block = prism([[0, 0], [1000, 0], [1000, 500], [0, 500]], 20.0)
    written(node("N1", moved(block, 5, (0, 0, 1e-8))))
    refused(
        [node("N1", block), node("N2", moved(block, 5, (0, 0, 1e-5)))], "part N2 .* off its plane, allowed 1e-07 mm"
    )


def test_broken_solids_are_refused() -> None:
    block = prism([[0, 0], [10, 0], [10, 10], [0, 10]], 20.0)
    refused([node("N1", Solid(block.vertices * [1, 1, -1], block.topology))], "part N1 .* encloses -2e\\+03 mm3")
    refused([node("N1", Solid(block.vertices * [1, 1, 1e-10], block.topology))], "an edge of 2e-09 mm")
    refused([node("N1", Solid(block.vertices * [1, 0, 1], block.topology))], "an edge of 0 mm")
    refused([node("N1", moved(block, 2, (np.nan, 0, 0)))], "part N1 .* vertex at nan")
    refused([node("N1", moved(block, 2, (np.inf, 0, 0)))], "part N1 .* vertex at inf")
    flat = prism([[0, 0], [10, 0], [20, 0]], 5.0)
    refused([node("N1", flat)], "part N1 .* a face .* mm wide, more than 1e-07 mm are needed")


def test_missing_folder_is_refused(assembly: Assembly, tmp_path: Path) -> None:
    with pytest.raises(OutputError, match=r"nowhere.* does not exist"):
        write_step(tmp_path / "nowhere" / "model.step", assembly)
    (tmp_path / "taken").mkdir()
    with pytest.raises(OutputError, match="taken cannot be written"):
        write_step(tmp_path / "taken", assembly)
    assert [each.name for each in tmp_path.iterdir()] == ["taken"]


def test_a_failure_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "model.step"
    path.write_text("old")
    with pytest.raises(OutputError):
        stream_step(path, "structure", [Parts.of(NODE, [node("N1", tube()), node("N1", star())])])
    assert path.read_text() == "old"
    assert [each.name for each in tmp_path.iterdir()] == ["model.step"]


def test_pieces_of_a_mark_at_one_mesh_element_have_names_of_their_own() -> None:
    twice = [
        node("N1", prism([[0, 0], [9, 0], [0, 9]], 5.0), frame(k), element) for k, element in enumerate([4, 7, 4, 4])
    ]
    parts = Parts.of(NODE, twice)
    assert parts.piece_names == ["N1 v4", "N1 v7", "N1 v4.2", "N1 v4.3"]
    text = io.StringIO()
    stream_step(text, "roof", [parts])
    found = re.findall(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\('([^']*)'", text.getvalue())
    assert sorted(found) == sorted([*parts.piece_names, "nodes"])

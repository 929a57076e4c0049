"""STEP files as text: syntax, references, topology, geometry, structure, names, refusals. No kernel."""

from __future__ import annotations

import io
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.errors import OutputError
from fabkit.export.palette import PALETTE
from fabkit.export.step import instance_name, stream_step, write_part_step, write_step
from fabkit.export.step_text import Block, reals, string
from fabkit.parts import Assembly, Frame, Material, Part, Solid, prism_topology
from geometry.arrays import FloatArray
from tests.fabkit.gridshell import gridshell
from tests.fabkit.part21 import StepText
from tests.fabkit.solids import frame, node, prism, prisms, star, topology, tube

TOLERANCE = 1e-7
"""mm, what the files state as their uncertainty."""


@pytest.fixture(scope="module")
def assembly() -> Assembly:
    return gridshell(4, 3)


@pytest.fixture(scope="module")
def file(assembly: Assembly) -> StepText:
    return written(assembly)


def written(item: Assembly | Part, **options: Any) -> StepText:
    stream = io.StringIO()
    if isinstance(item, Part):
        write_part_step(stream, item, **options)
    else:
        write_step(stream, item, **options)
    return StepText(stream.getvalue())


def coordinates(file: StepText, identifier: int) -> FloatArray:
    return np.array(file[identifier].values[1])


def face_loops(file: StepText, face: int) -> list[list[tuple[int, int]]]:
    """For each loop of an ADVANCED_FACE its oriented edges as (edge, vertex it starts from)."""
    loops = []
    for bound in file[face].values[1]:
        loop_id, sense = file[bound].values[1:]
        assert sense is True
        oriented = [file[each].values for each in file[loop_id].values[1]]
        loops.append([(edge, file[edge].values[1 if along else 2]) for _, _, _, edge, along in oriented])
    return loops


# Text


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1))
def test_reals_read_back_as_the_same_doubles(values: list[float]) -> None:
    texts = reals(np.array(values))
    instance = StepText(
        f"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=X(({','.join(texts)}));\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    read = instance[1].values[0]
    assert all(isinstance(value, float) for value in read)  # an integer would have no decimal point
    assert read == values


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.0, "0.0"),
        (-0.0, "0.0"),
        (1.0, "1.0"),
        (-2e-7, "-2.E-7"),
        (1.5e-300, "1.5E-300"),
        (0.1 + 0.2, "0.30000000000000004"),
    ],
)
def test_real(value: float, text: str) -> None:
    assert reals(np.array([7.0, value, 7.0])) == ["7.0", text, "7.0"]


@pytest.mark.parametrize(
    ("text", "encoded"),
    [
        ("B12 e37", "B12 e37"),
        ("it's", "it''s"),
        ("a\\b", "a\\\\b"),
        ("Möbius", "M\\X2\\00F6\\X0\\bius"),
        ("屋根", "\\X2\\5C4B6839\\X0\\"),
        ("a\nb", "a\\X2\\000A\\X0\\b"),
        ("\U0001d538", "\\X2\\D835DD38\\X0\\"),
    ],
)
def test_string(text: str, encoded: str) -> None:
    assert string(text) == encoded


@pytest.mark.parametrize("n_entities", [1, 9, 10, 11, 100, 101, 250])
@pytest.mark.parametrize("free_id", [1, 9, 10, 99, 100, 101, 12345])
def test_ids_of_a_block_are_its_own(n_entities: int, free_id: int) -> None:
    block = Block([f"X('%s',#7,#<{n_entities - 1 - n}>)" for n in range(n_entities)])
    first = block.first_id(free_id)
    assert free_id <= first < free_id + 100
    lines = block.text(first, [f"#{n}" for n in range(n_entities)]).splitlines()
    for n, line in enumerate(lines):
        assert line == f"#{first + n}=X('#{n}',#7,#{first + n_entities - 1 - n});"
    assert n_entities <= block.n_ids < n_entities + 100


# One part


@settings(max_examples=60, deadline=None)
@given(prisms())
def test_file_of_a_prism(solid: Solid) -> None:
    check_part_file(node("N1", solid))


@pytest.mark.parametrize("solid", [tube(), star(), star(40), prism([[0, 0], [0.1, 0], [0, 0.1]], 0.1)])
def test_file_of_a_solid(solid: Solid) -> None:
    check_part_file(node("N1", solid, frame(1)))


def check_part_file(part: Part) -> None:
    """Everything that makes the file one closed solid, the one it was made from."""
    file, solid = written(part), part.solid
    assert set(file.references()) <= set(file.instances)
    assert "NEXT_ASSEMBLY_USAGE_OCCURRENCE" not in {instance.kind for instance in file.instances.values()}
    assert len(file.all("PRODUCT")) == len(file.all("MANIFOLD_SOLID_BREP")) == len(file.all("CLOSED_SHELL")) == 1
    points = np.array([coordinates(file, vertex.values[1]) for vertex in file.all("VERTEX_POINT")])
    assert np.array_equal(points, solid.vertices)
    check_edges(file)
    check_faces(file, solid)
    check_validation_properties(file, solid)


def check_edges(file: StepText) -> None:
    used = Counter((each.values[3], each.values[4]) for each in file.all("ORIENTED_EDGE"))
    edges = {number: each.values for number, each in file.instances.items() if each.kind == "EDGE_CURVE"}
    assert used == Counter({(edge, sense): 1 for edge in edges for sense in (True, False)})
    for _, start, end, curve, same_sense in edges.values():
        origin, vector = file[curve].values[1:]
        direction_id, magnitude = file[vector].values[1:]
        direction = coordinates(file, direction_id)
        span = coordinates(file, file[end].values[1]) - coordinates(file, file[start].values[1])
        assert same_sense is True
        assert magnitude == 1
        assert origin == file[start].values[1]
        assert abs(direction @ direction - 1) < 1e-14  # rounding of three squares
        assert np.abs(span - span @ direction * direction).max() < TOLERANCE
        assert span @ direction > 0


def check_faces(file: StepText, solid: Solid) -> None:
    """The faces are those of the solid, in their planes, material to the left of each loop; they close the shell."""
    (shell,) = file.all("CLOSED_SHELL")
    volume = 0.0
    assert len(shell.values[1]) == solid.topology.n_faces == len(file.all("ADVANCED_FACE"))
    vertex_ids = [number for number, instance in file.instances.items() if instance.kind == "VERTEX_POINT"]
    for number, face in enumerate(shell.values[1]):
        _, bounds, plane, same_sense = file[face].values
        assert same_sense is True
        assert [file[bound].kind for bound in bounds] == ["FACE_OUTER_BOUND"] + ["FACE_BOUND"] * (len(bounds) - 1)
        origin, axis, x = (coordinates(file, each) for each in file[file[plane].values[1]].values[1:])
        assert abs(axis @ axis - 1) < 1e-14
        assert abs(axis @ x) < 1e-6  # need not be exact: readers take the part of x across the axis
        for k, loop in enumerate(face_loops(file, face)):
            assert [vertex_ids.index(start) for _, start in loop] == solid.topology.loops(number)[k].tolist()
            ring = np.array([coordinates(file, file[start].values[1]) for _, start in loop]) - origin
            assert np.abs(ring @ axis).max() < TOLERANCE
            area = np.cross(ring, np.roll(ring, -1, axis=0)).sum(axis=0) / 2
            assert area @ axis > 0 if k == 0 else area @ axis < 0
            volume += (origin - solid.vertices[0]) @ area / 3
    assert volume == pytest.approx(solid.volume_mm3, rel=1e-9)


def check_validation_properties(file: StepText, solid: Solid) -> None:
    (definition,) = [
        each for each in file.all("PROPERTY_DEFINITION") if each.values[0] == "geometric validation property"
    ]
    (link,) = [each for each in file.all("PROPERTY_DEFINITION_REPRESENTATION") if file[each.values[0]] == definition]
    volume, area, centre = (file[item].values for item in file[link.values[1]].values[1])
    size = np.ptp(solid.vertices, axis=0).max()
    edges = [solid.vertices[loop] for face in range(solid.topology.n_faces) for loop in solid.topology.loops(face)]
    vector_areas = [np.cross(ring - ring[0], np.roll(ring - ring[0], -1, axis=0)).sum(axis=0) / 2 for ring in edges]
    signs = np.sign([v @ n for v, n in zip(vector_areas, loop_normals(solid), strict=True)])
    assert file[definition.values[2]].kind == "PRODUCT_DEFINITION_SHAPE"
    assert volume[:2] == ["volume measure", pytest.approx(solid.volume_mm3, rel=1e-12)]
    assert area[:2] == ["surface area measure", pytest.approx(signs @ np.linalg.norm(vector_areas, axis=1), rel=1e-9)]
    assert centre[0] == "centre point"
    assert np.abs(centre[1] - solid.centroid).max() < 1e-12 * (size + np.abs(solid.vertices).max())
    for measure, exponent in ((volume, 3.0), (area, 2.0)):
        (element,) = file[measure[2]].values[0]
        unit, power = file[element].values
        assert power == exponent
        assert dict(file[unit].values)["SI_UNIT"] == [".MILLI.", ".METRE."]


def loop_normals(solid: Solid) -> list[FloatArray]:
    return [solid.normals[face] for face in range(solid.topology.n_faces) for _ in solid.topology.loops(face)]


def test_part_says_what_it_is() -> None:
    part = node("N7", tube(), material=Material("C24 'x'", 420.0))
    file = written(part, author="A. N. Öther", organisation="Shop", time_stamp="2024-05-06T07:08:09")
    assert file.all("PRODUCT")[0].values[:3] == ["N7", "N7", "node"]
    assert file.all("MANIFOLD_SOLID_BREP")[0].values[0] == "N7"
    assert "FILE_NAME('N7','2024-05-06T07:08:09',('A. N. \\X2\\00D6\\X0\\ther'),('Shop')," in file.header
    assert file.all("DESCRIPTIVE_REPRESENTATION_ITEM")[0].values[1] == "C24 'x'"
    (density,) = [each for each in file.all("MEASURE_REPRESENTATION_ITEM") if each.values[0] == "density measure"]
    assert density.values[1] == 0.42  # g/cm3
    assert file.all("COLOUR_RGB")[0].values[1:] == list(PALETTE["node"])
    (styled,) = file.all("STYLED_ITEM")
    assert file[styled.values[2]].kind == "MANIFOLD_SOLID_BREP"


@pytest.mark.parametrize(
    ("schema", "name"), [("AP242", "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING"), ("AP214", "AUTOMOTIVE_DESIGN")]
)
def test_schema(schema: str, name: str) -> None:
    assert f"FILE_SCHEMA(('{name}" in written(node("N1", tube()), schema=schema).header


# Structure


def test_structure_is_a_tree_of_instances(assembly: Assembly, file: StepText) -> None:
    assert set(file.references()) <= set(file.instances)
    children: dict[str, list[tuple[str, str]]] = {}
    for occurrence in file.all("NEXT_ASSEMBLY_USAGE_OCCURRENCE"):
        assert occurrence.values[0] == occurrence.values[1]
        parent, child = (product(file, definition) for definition in occurrence.values[3:5])
        children.setdefault(parent, []).append((occurrence.values[1], child))
    groups = assembly.groups()
    assert children.pop(assembly.name) == [(name, name) for name in groups]
    for name, parts in groups.items():
        assert children.pop(name) == [(instance_name(part), part.mark) for part in parts]
    assert not children


def product(file: StepText, definition: int) -> str:
    formation = file[definition].values[2]
    return str(file[file[formation].values[2]].values[0])


def test_equal_parts_are_one_product(assembly: Assembly, file: StepText) -> None:
    marks = {part.mark for part in assembly.parts()}
    assert len(marks) < len(list(assembly.parts()))  # or this tests nothing
    names = [each.values[0] for each in file.all("PRODUCT")]
    assert sorted(names) == sorted([assembly.name, *assembly.groups(), *marks])
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
        assert tuple(file[at].values[1:]) == PALETTE[kinds[file[styled.values[2]].values[0]]]
    assert len(file.all("STYLED_ITEM")) == len(kinds)
    assert len(file.all("COLOUR_RGB")) == 3


@pytest.mark.parametrize("kept", ["beams", "nodes", "panels"])
def test_empty_groups_are_left_out(assembly: Assembly, kept: str) -> None:
    others: dict[str, Any] = {name: () for name in assembly.groups() if name != kept}
    file = written(replace(assembly, **others))
    assert set(file.references()) <= set(file.instances)
    assert set(others).isdisjoint(each.values[0] for each in file.all("PRODUCT"))


def test_shapes_come_once_however_far_apart_their_parts_are() -> None:
    parts = [node(f"N{n % 90}", prism([[0, 0], [50, 0], [0, 50 + n % 90]], 10.0), frame(n), n) for n in range(270)]
    stream = io.StringIO()
    stream_step(stream, "many", parts)
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

    def parts(n: int) -> Iterator[Part]:
        return (node(f"N{k}", prism(outline, 10.0 + k), None, k) for k in range(n))

    def peak(n: int) -> int:
        tracemalloc.start()
        stream_step(Sink(), "many", parts(n))
        size = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return size

    peak(100)  # templates and caches
    assert (peak(1500) - peak(500)) / 1000 < 500  # bytes a part: its mark, ids and a hash; its text is 8000


# Refusals


def refused(parts: list[Part], message: str, **options: Any) -> None:
    with pytest.raises(OutputError, match=message):
        stream_step(io.StringIO(), "structure", parts, **options)


def test_one_mark_for_two_solids_is_refused() -> None:
    refused([node("N1", tube()), node("N1", tube(height=101.0), None, 5)], "mark N1 stands for two .* N1 v5")
    refused([node("N1", tube()), node("N1", tube(), material=Material("oak", 700.0))], "mark N1 stands for two")
    apart = [node(f"A{n}", star(3, 50 + n)) for n in range(200)]
    refused([node("N1", tube()), *apart, node("N1", tube(height=101.0))], "mark N1 stands for two")


@pytest.mark.parametrize("mark", ["Träger", "", "a\tb"])
def test_marks_that_are_no_names_are_refused(mark: str) -> None:
    refused([node(mark, tube())], "not printable ASCII")


@pytest.mark.parametrize("mark", ["structure", "nodes", "panels"])
def test_marks_of_other_products_are_refused(mark: str) -> None:
    refused([node(mark, tube())], "name of the structure or a group")


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
    refused([node("N1", tube(), material=Material("aether", np.inf))], "not finite")


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
    refused([node("N1", flat)], "part N1 .* a face .* mm wide, needs over 1e-07 mm")


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
        stream_step(path, "structure", [node("N1", tube()), node("N1", star())])
    assert path.read_text() == "old"
    assert [each.name for each in tmp_path.iterdir()] == ["model.step"]


def test_helpers_make_closed_solids() -> None:
    assert tube(60, 30, 100).volume_mm3 == pytest.approx((60**2 - 30**2) * 100)
    assert topology(8, [[loop.tolist()] for k in range(6) for loop in prism_topology(4).loops(k)]).n_faces == 6

"""STEP files as text: words, and the file of one part: references, topology, geometry, properties."""

from __future__ import annotations

from collections import Counter
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fabkit.errors import OutputError
from fabkit.formats.step.files import write_part_step, write_part_steps
from fabkit.formats.step.text import Block, reals, string
from fabkit.kinds import NODE
from fabkit.parts import Material, Part, Parts, Solid, prism_topology
from geometry.arrays import FloatArray
from tests.fabkit.part21 import StepText, coordinates, written
from tests.fabkit.solids import frame, node, prism, prisms, star, topology, tube

TOLERANCE = 1e-7
"""mm, what the files state as their uncertainty."""


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


@settings(deadline=None)
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
        ("\U0001d538", "\\X4\\0001D538\\X0\\"),
        ("\uffff\U0001d538a\U0001f600\U0001f601", "\\X2\\FFFF\\X0\\\\X4\\0001D538\\X0\\a\\X4\\0001F6000001F601\\X0\\"),
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
    check_context(file)
    check_edges(file)
    check_faces(file, solid)
    check_validation_properties(file, solid)


def check_context(file: StepText) -> None:
    """Millimetres, radians, and how far apart two points must be."""
    (shape,) = file.all("ADVANCED_BREP_SHAPE_REPRESENTATION")
    context = dict(file[shape.values[2]].values)
    assert context["GEOMETRIC_REPRESENTATION_CONTEXT"] == [3]
    units = [dict(file[each].values)["SI_UNIT"] for each in context["GLOBAL_UNIT_ASSIGNED_CONTEXT"][0]]
    assert units == [[".MILLI.", ".METRE."], [None, ".RADIAN."], [None, ".STERADIAN."]]
    (uncertainty,) = context["GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT"][0]
    assert file[uncertainty].values[:3] == [
        TOLERANCE,
        context["GLOBAL_UNIT_ASSIGNED_CONTEXT"][0][0],
        "distance_accuracy_value",
    ]


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
    assert file.all("PRODUCT")[0].values[:3] == ["N7", "N7 node", "node"]
    assert file.all("MANIFOLD_SOLID_BREP")[0].values[0] == "N7"
    assert "FILE_NAME('N7','2024-05-06T07:08:09',('A. N. \\X2\\00D6\\X0\\ther'),('Shop')," in file.header
    assert file.all("DESCRIPTIVE_REPRESENTATION_ITEM")[0].values[1] == "C24 'x'"
    (density,) = [each for each in file.all("MEASURE_REPRESENTATION_ITEM") if each.values[0] == "density measure"]
    assert density.values[1] == 0.42  # g/cm3
    assert file.all("COLOUR_RGB")[0].values[1:] == list(NODE.colour)
    (styled,) = file.all("STYLED_ITEM")
    assert file[styled.values[2]].kind == "MANIFOLD_SOLID_BREP"


@pytest.mark.parametrize(
    ("schema", "name"), [("AP242", "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING"), ("AP214", "AUTOMOTIVE_DESIGN")]
)
def test_schema(schema: str, name: str) -> None:
    assert f"FILE_SCHEMA(('{name}" in written(node("N1", tube()), schema=schema).header


def test_many_files_are_as_each_alone(tmp_path: Path) -> None:
    recycled = Material("100 % 'recycled' %s", 2400.0)
    parts = [node("N1", tube()), node("N-2'", star(), material=recycled), node("N3", tube(70.0), material=recycled)]
    parts += [node("N4", star(7)), node("N5", tube(height=90.0))]
    write_part_steps(tmp_path, [Parts.of(NODE, parts)])
    found = {path.name: path.read_text() for path in tmp_path.iterdir()}
    for part in parts:
        write_part_step(stream := StringIO(), part)
        assert found.pop(f"{part.mark}.step") == stream.getvalue()
    assert not found


def test_a_mark_that_is_no_name_gets_no_file(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="'N\u00e9' is not printable ASCII"):
        write_part_steps(tmp_path, [Parts.of(NODE, [node("N\u00e9", tube())])])
    assert not list(tmp_path.iterdir())


def test_helpers_make_closed_solids() -> None:
    assert tube(60, 30, 100).volume_mm3 == pytest.approx((60**2 - 30**2) * 100)
    assert topology(8, [[loop.tolist()] for k in range(6) for loop in prism_topology(4).loops(k)]).n_faces == 6

"""What somebody new does wrong in Python ends in one sentence that says what to write instead."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from typer.testing import CliRunner

import geometry
from fabkit import Project, build, design
from fabkit.commands.command_line import app
from fabkit.errors import DetailingError
from fabkit.kinds import plain_kind
from fabkit.parts import Details, Material, Parts, Solids, prism_topology, prism_vertices
from fabkit.production import Sheet, nest_panels, panels_from_outlines
from geometry.files import write_mesh
from geometry.functionals import close_to
from geometry.mesh.shapes import dome, grid

MESH: Any = dome(8, 3)
SPACE: Any = geometry.ParallelSpace(MESH)
GLASS: Any = Material("glass", 2500)
OUTLINES: Any = {"P1": [(0, 0), (900, 0), (0, 400)]}
ANY: Any = geometry


def nest(sheet: Any, gap: Any = 5.0) -> None:
    nest_panels(panels_from_outlines(OUTLINES, thickness_mm=8, material=GLASS), sheet, gap_mm=gap, border_mm=5.0)


def outlines(shapes: Any, thickness: Any = 8.0, material: Any = GLASS) -> None:
    panels_from_outlines(shapes, thickness_mm=thickness, material=material)


@pytest.mark.parametrize(
    ("mistake", "sentence"),
    [
        (lambda: ANY.offset(MESH, "0.2"), "the distance of the offset is '0.2': a finite number is needed"),
        (lambda: ANY.offset(0.2, MESH), "the distance of the offset is a value of type Mesh: a finite number"),
        (lambda: ANY.offset(MESH, [0.1, 0.2]), "the distance of the offset is a value of type list"),
        (lambda: ANY.offset(MESH, np.array([0.1, 0.2])), r"the distance of the offset is an array of shape \(2,\)"),
        (lambda: ANY.SupportStructure(geometry.Pair(MESH * 10.0, MESH), "0.1"), "two meshes is '0.1': a finite"),
        (lambda: SPACE.blend([MESH, MESH], [0.5, 0.5]), "the weight of mesh 0 is a value of type Mesh"),
        (lambda: SPACE.blend([1.0], [grid(2, 2)]), "do not have the same faces"),
        (lambda: geometry.Pair(MESH, MESH.with_vertices(MESH.vertices * [1, 2, 1])), r"ParallelSpace\(mesh\)\.project"),
        (lambda: ANY.functionals.close_to(MESH), "such as mesh.vertices, not a value of type Mesh"),
        (lambda: SPACE.minimise([(1.0, close_to(MESH.vertices[:3]))]), "make it for all vertices of this mesh"),
        (lambda: ANY.Guides(fairness="0.3"), "fairness is '0.3': a finite number is needed"),
        (lambda: ANY.Effort(max_steps="5"), "max_steps is '5': a finite number is needed"),
        (lambda: ANY.planarise(MESH, {"fairness": 0.3}), r"a value of type dict: write Guides\(fairness=0\.3"),
        (lambda: ANY.planarise(MESH, effort=50), r"a value of type int: write Effort\(max_steps=100\)"),
        (lambda: ANY.as_mesh(trimesh.Scene()), r"a scene of trimesh becomes one mesh by scene\.to_mesh\(\)"),
        (lambda: ANY.approximate_pair(trimesh.creation.icosphere(1)), "lay planar quads on this surface by `remesh`"),
        (lambda: ANY.plot(MESH, MESH.planarity, view=30), "two angles in degrees are needed"),
        (lambda: ANY.plot(MESH, MESH.planarity, view=(30, "up")), "its elevation is 'up'"),
        (lambda: Material("steel", "7850"), "the density of steel in kg/m3 is '7850'"),  # type: ignore[arg-type]
        (lambda: Material("steel", -1.0), "the density of steel is -1.0 kg/m3: a number above 0"),
        (lambda: Material(7850, "steel"), "the name of a material is a value of type int"),  # type: ignore[arg-type]
        (lambda: outlines([[(0, 0), (1, 0), (0, 1)]]), "a value of type list: a dict from marks to corners"),
        (lambda: outlines({"P1": [(0, 0), (900, np.nan), (0, 400)]}), "P1 has coordinates that are not finite"),
        (lambda: outlines({"P1": [(0, 0), (900, "a"), (0, 400)]}), "P1 has corners that are not all two numbers"),
        (lambda: outlines(OUTLINES, thickness="8"), "the thickness in mm is '8'"),
        (lambda: outlines(OUTLINES, thickness=0.0), "the thickness is 0.0 mm: a number above 0"),
        (lambda: outlines(OUTLINES, material="glass"), r"a value of type str: write Material\('glass', 2500\)"),
        (lambda: nest((3210, 2250)), r"a value of type tuple: write Sheet\(length_mm=3210"),
        (lambda: nest(Sheet("3210", 2250)), r"\('3210', 2250, 5.0, 5.0\): give numbers, in mm"),  # type: ignore[arg-type]
        (lambda: nest(Sheet(3210, 2250), gap="5"), "'5', 5.0.: give numbers, in mm"),
        (lambda: ANY.offset(MESH, float("nan")), "the distance of the offset is nan"),
        (lambda: Project(mesh="roof.obj", unit="meter"), "^unit is 'meter': input should be 'mm', 'cm', 'm'"),  # type: ignore[arg-type]
        (lambda: Project(mesh="roof.obj", units="m"), "^unknown key 'units' in the project; did you mean unit"),  # type: ignore[call-arg]
        (lambda: Project(unit="m"), "^mesh is missing"),  # type: ignore[call-arg]
        (lambda: Project(mesh="roof.obj"), "^either the unit of the mesh or the length of its mean edge is needed"),
        (lambda: Project(mesh=MESH, unit="m", beams={"width": 60}), r"unknown key 'width' in \[beams\]; did you mean"),  # type: ignore[arg-type]
        (lambda: build("roof.obj"), r"a value of type str: write Project\(mesh='roof\.obj'"),  # type: ignore[arg-type]
        (lambda: design("roof.obj"), r"a value of type str: write Project\(mesh='roof\.obj'"),  # type: ignore[arg-type]
    ],
)
def test_a_mistake_ends_in_one_sentence(mistake: Callable[[], object], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence) as caught:  # the base of the errors of both packages
        mistake()
    assert type(caught.value).__module__.split(".")[0] in ("fabkit", "geometry")
    assert "\n" not in str(caught.value)


def test_numbers_of_other_types_stay_numbers() -> None:
    exact = geometry.offset(MESH, 0.1).mesh.vertices
    for distance in (np.float64(0.1), np.array(0.1)):
        assert np.array_equal(geometry.offset(MESH, distance).mesh.vertices, exact)  # type: ignore[arg-type]


def test_results_are_shown_in_one_line() -> None:
    built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    counts = "Assembly(structure: 30 beams, 18 nodes, 12 panels)"
    assert (repr(built), repr(built.assembly)) == (f"Built({counts})", counts)
    assert repr(built.assembly["beams"]) == "Parts(30 beams, 5 marks)"
    assert all(len(repr(each)) <= 120 for each in (built.summary, built.nest))


def test_parts_of_ones_own_that_overlap_are_to_be_moved() -> None:
    built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    nodes = built.assembly["nodes"]
    block = prism_vertices(50.0 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]), 0.0, 40.0)
    lamps = Parts.each_its_own(
        plain_kind("lamp", letter="L"),
        nodes.elements,
        Solids.alike(np.tile(block, (len(nodes), 1, 1)), prism_topology(4)),
        nodes.origins,  # inside the node blocks
        nodes.axes,
        Material("aluminium", 2700),
        Details(),
    )
    with pytest.raises(DetailingError, match=r"share volume.*change the origins, the axes or the size of each lamp"):
        built.with_parts(lamps)


def refused(*arguments: str | Path) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 2, result.output
    return " ".join(result.stderr.split())


def test_a_suffix_that_cannot_be_written_is_refused_before_work_begins(tmp_path: Path) -> None:
    missing = tmp_path / "missing.stl"  # it would be the next thing to fail
    assert "one of .obj, .off, .ply is needed" in refused("mesh", missing, "--faces", "80", "-o", tmp_path / "out.stl")
    assert "one of .html, .htm is needed" in refused("mesh", missing, "--study", tmp_path / "study.pdf")


def test_text_without_quotes_in_a_project_file(tmp_path: Path) -> None:
    (tmp_path / "p.toml").write_text("mesh = 'roof.obj'\nunit = m\n")
    assert "texts stand in quotes, as in unit = 'm'" in refused("build", tmp_path / "p.toml")


def test_a_mesh_of_triangles_is_sent_to_the_command_that_lays_quads(tmp_path: Path) -> None:
    ball = tmp_path / "ball.obj"
    sphere = geometry.as_mesh(trimesh.creation.icosphere(1))
    write_mesh(ball, sphere.with_vertices(sphere.vertices * [1, 2, 3]))  # without exact offsets
    assert "by `remesh`, or by `fabkit mesh`" in refused("curvature", ball, "-o", tmp_path / "out.csv")
    assert "or here by --faces or --edge-length" in refused("build", ball, "--unit", "m", "-o", tmp_path / "out")


def test_a_laid_mesh_that_folds_names_the_options_of_laying(tmp_path: Path) -> None:
    from fabkit.fitness.shape import folded
    from geometry.errors import FoldedError

    error = FoldedError("face 3 folded over", "lay it along other lines", elements=[3], value=177.0, bound=90.0)
    assert "--smooth" in folded(error, on_surface=True).cure
    assert "project file" in folded(error).cure

"""Exact surfaces from the CAD kernel: nearest points and normals are those of the faces, and meshes are the same as on
fine triangles."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from fabkit.commands.command_line import app
from fabkit.errors import FabkitError
from fabkit.formats.surfaces.exact_surfaces import ExactSurface, exact_surface
from fabkit.formats.surfaces.shape_files import read_shape
from geometry import Surface, read_mesh, remesh
from geometry.arrays import FloatArray
from tests.fabkit.occt import HAS_KERNEL

kernel = pytest.mark.kernel
needs_kernel = pytest.mark.skipif(not HAS_KERNEL, reason="build123d or CadQuery is not installed")


def run(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def spline(low: float = -5.0, high: float = 5.0, *, fold: float = 0.3) -> Any:
    """A face of the kernel through a grid of points, x from low to high."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.GeomAPI import GeomAPI_PointsToBSplineSurface
    from OCP.gp import gp_Pnt

    try:
        from OCP.collections import Array2_gp_Pnt as Points  # since OCCT 8
    except ModuleNotFoundError:
        from OCP.TColgp import TColgp_Array2OfPnt as Points
    grid = Points(1, 9, 1, 9)
    for i, x in enumerate(np.linspace(low, high, 9).tolist(), start=1):
        for j, y in enumerate(np.linspace(-5, 5, 9).tolist(), start=1):
            grid.SetValue(i, j, gp_Pnt(1000 * x, 1000 * y, 1000 * (0.06 * x * x - 0.04 * y * y + fold * np.sin(x / 2))))
    return BRepBuilderAPI_MakeFace(GeomAPI_PointsToBSplineSurface(grid).Surface(), 1e-6).Face()


def ball(radius: float = 5000.0) -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeSphere

    return BRepPrimAPI_MakeSphere(radius).Face()


def torus() -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeTorus

    return BRepPrimAPI_MakeTorus(5000.0, 2000.0).Face()


def tube() -> Any:
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

    return BRepPrimAPI_MakeCylinder(3000.0, 9000.0).Face()


def pierced_ball() -> Any:
    """A cap of a sphere with a hole: one trimmed face."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    above = BRepPrimAPI_MakeBox(gp_Pnt(-9e3, -9e3, 2e3), gp_Pnt(9e3, 9e3, 9e3)).Shape()
    hole = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(800, 0, 0), gp_Dir(0, 0, 1)), 900.0, 9e3).Shape()
    return BRepAlgoAPI_Cut(BRepAlgoAPI_Common(ball(), above).Shape(), hole).Shape()


def written(shape: Any, path: Path) -> Path:
    from OCP.BRepTools import BRepTools
    from OCP.IGESControl import IGESControl_Writer
    from OCP.STEPControl import STEPControl_AsIs, STEPControl_Writer

    if path.suffix == ".brep":
        assert BRepTools.Write_s(shape, str(path))
    elif path.suffix == ".igs":
        writer = IGESControl_Writer()
        writer.AddShape(shape)
        assert writer.Write(str(path))
    else:
        writer = STEPControl_Writer()
        writer.Transfer(shape, STEPControl_AsIs)
        writer.Write(str(path))
    return path


def in_triangles(shape: Any, n_faces: float = 1500) -> ExactSurface:
    return exact_surface(shape, lambda area: float(np.sqrt(area / n_faces)))


def near(surface: Surface, seed: int = 1) -> FloatArray:
    """Points off the surface by up to 300 mm."""
    rng = np.random.default_rng(seed)
    mesh = surface.triangulated
    centres = mesh.vertices[mesh.combinatorics.corners.reshape(-1, 3)].mean(axis=1)
    picked = rng.choice(len(centres), 200)
    return np.asarray(centres[picked] + rng.uniform(-300, 300, (200, 1)) * mesh.face_normals[picked])


@kernel
@needs_kernel
def test_nearest_points_are_those_of_the_sphere_the_torus_and_the_cylinder() -> None:
    for shape in (ball(), torus(), tube()):
        surface = in_triangles(shape)
        points = near(surface)
        feet, normals = surface.closest(points)
        distances, gradients = surface.distances(points)
        if surface.mesh.combinatorics.euler_characteristic == 2:
            outwards = points / np.linalg.norm(points, axis=1, keepdims=True)
            exact = np.linalg.norm(points, axis=1) - 5000
        elif not surface.mesh.combinatorics.boundary_loops:
            flat = points * [1, 1, 0]
            ring = 5000 * flat / np.linalg.norm(flat, axis=1, keepdims=True)
            outwards = (points - ring) / np.linalg.norm(points - ring, axis=1, keepdims=True)
            exact = np.linalg.norm(points - ring, axis=1) - 2000
        else:
            flat = points * [1, 1, 0]
            outwards = flat / np.linalg.norm(flat, axis=1, keepdims=True)
            exact = np.linalg.norm(flat, axis=1) - 3000
        assert np.abs(distances - exact).max() < 1e-4
        assert np.einsum("ni,ni->n", normals, outwards).min() > 1 - 1e-7  # feet are up to .3 mm aside
        assert np.abs(gradients - normals).max() == 0
        assert np.abs(feet + distances[:, None] * normals - points).max() < 0.3  # of 300 mm, across the normal


@kernel
@needs_kernel
@pytest.mark.parametrize("suffix", [".step", ".igs", ".brep"])
def test_files_of_each_kind_are_read(tmp_path: Path, suffix: str) -> None:
    surface = in_triangles(read_shape(written(spline(), tmp_path / f"roof{suffix}")).shape)
    direct = in_triangles(spline())
    assert surface.mesh.n_faces == pytest.approx(direct.mesh.n_faces, rel=0.05)
    points = near(direct)
    assert surface.closest(points)[0] == pytest.approx(direct.closest(points)[0], abs=0.1)


@kernel
@needs_kernel
def test_edges_are_of_the_length_that_is_asked_for() -> None:
    for shape in (spline(), tube(), ball()):
        mesh = exact_surface(shape, lambda _: 300.0).mesh
        assert mesh.edge_lengths.max() < 1.31 * 300


@kernel
@needs_kernel
def test_the_mesh_is_that_of_fine_triangles() -> None:
    for shape, chi in ((spline(), 1), (pierced_ball(), 0), (torus(), 0)):
        surface = in_triangles(shape, 3000)
        fine = Surface(in_triangles(shape, 5000).mesh)  # some 20 000 triangles
        exact, triangles = remesh(surface, n_faces=400), remesh(fine, n_faces=400)
        assert exact.mesh.combinatorics.euler_characteristic == chi
        assert sorted(exact.laid.singular_indices) == sorted(triangles.laid.singular_indices)
        assert exact.mesh.n_faces == pytest.approx(triangles.mesh.n_faces, rel=0.03)
        assert exact.mesh.planarity.max() < 1e-12
        assert exact.surface_distances.max() < 0.1 * exact.mesh.mean_edge_length


GMSH = shutil.which("gmsh")

ROOF_OF_GMSH = """
SetFactory("OpenCASCADE");
Point(1) = {-5000, -4000, 900}; Point(2) = {5000, -4000, 400}; Point(3) = {5000, 4000, 1200};
Point(4) = {-5000, 4000, 0}; Point(5) = {-1500, -4600, 2600}; Point(6) = {2000, -4300, 2200};
Point(7) = {5600, -1200, 1900}; Point(8) = {5200, 1500, 2600}; Point(9) = {1500, 4500, 2500};
Point(10) = {-2000, 4700, 2900}; Point(11) = {-5300, 1300, 1700}; Point(12) = {-5500, -1500, 2100};
BSpline(1) = {1, 5, 6, 2}; BSpline(2) = {2, 7, 8, 3}; BSpline(3) = {3, 9, 10, 4}; BSpline(4) = {4, 11, 12, 1};
Curve Loop(1) = {1, 2, 3, 4};
BSpline Surface(1) = {1};
Cylinder(1) = {1500, 500, -1000, 0, 0, 9000, 1100};
BooleanDifference{ Surface{1}; Delete; }{ Volume{1}; Delete; }
"""


@kernel
@needs_kernel
@pytest.mark.skipif(GMSH is None, reason="gmsh is not installed")
def test_nurbs_faces_of_gmsh_give_the_mesh_of_its_own_fine_triangles(tmp_path: Path) -> None:
    """A trimmed B-spline face with a hole: gmsh makes the STEP file and, independently of us, the triangles."""
    assert GMSH is not None
    (tmp_path / "roof.geo").write_text(ROOF_OF_GMSH)
    for options in (["-0", "-o", "roof.step"], ["-2", "-clmin", "280", "-clmax", "280", "-o", "roof.stl"]):
        subprocess.run([GMSH, "roof.geo", *options, "-v", "0"], cwd=tmp_path, check=True, capture_output=True)
    surface = in_triangles(read_shape(tmp_path / "roof.step").shape, 3000)
    fine = Surface(read_mesh(tmp_path / "roof.stl").mesh)
    feet = surface.closest(fine.mesh.vertices)[0]
    assert np.linalg.norm(feet - fine.mesh.vertices, axis=1).max() < 1  # mm, of 10 m
    exact, triangles = remesh(surface, n_faces=400), remesh(fine, n_faces=400)
    for found in (exact, triangles):
        assert found.mesh.combinatorics.euler_characteristic == 0
        assert found.mesh.planarity.max() < 1e-12
        length = found.mesh.mean_edge_length
        assert np.quantile(found.surface_distances, 0.95) < 0.03 * length
        assert found.surface_distances.max() < 0.1 * length
        assert np.quantile(found.planarised.moves, 0.95) < 0.08 * length
    assert sorted(exact.laid.singular_indices) == sorted(triangles.laid.singular_indices)
    assert exact.mesh.n_faces == pytest.approx(triangles.mesh.n_faces, rel=0.03)


@kernel
@needs_kernel
@pytest.mark.parametrize(("unit", "told"), [("MM", ""), ("M", "metres"), ("INCH", "inches"), ("FT", "feet")])
@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_the_unit_of_a_file_is_read_and_reported(tmp_path: Path, suffix: str, unit: str, told: str) -> None:
    from OCP.IGESControl import IGESControl_Writer
    from OCP.Interface import Interface_Static

    path = tmp_path / f"roof{suffix}"
    if suffix == ".igs":
        writer = IGESControl_Writer(unit, 0)
        writer.AddShape(spline())
        assert writer.Write(str(path))
    else:
        written(spline(), path)  # which makes the setting known to the kernel
        Interface_Static.SetCVal_s("write.step.unit", unit)
        try:
            written(spline(), path)
        finally:
            Interface_Static.SetCVal_s("write.step.unit", "MM")
    file = read_shape(path)
    assert list(file.notes) == ([f"lengths are in {told} in the file, and were read in mm"] if told else [])
    size = np.ptp(in_triangles(file.shape).mesh.vertices, axis=0)
    assert size == pytest.approx(np.ptp(in_triangles(spline()).mesh.vertices, axis=0), rel=1e-3)


@kernel
@needs_kernel
def test_files_without_faces_and_with_solids(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    monkeypatch.chdir(tmp_path)
    written(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(1, 2, 3)).Edge(), Path("wire.step"))
    Path("empty.step").write_text(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
        "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
    )
    Path("nothing.step").write_bytes(b"")
    for name, sentence in (
        ("wire.step", "wire.step has no faces: export the surface, not its curves or points"),
        ("empty.step", "empty.step holds no shape that the CAD kernel reads"),
        ("nothing.step", "nothing.step cannot be read by the CAD kernel"),
        ("none.step", "there is no file none.step"),
    ):
        refused = run("mesh", name, "--faces", 100, "-o", "mesh.obj")
        assert refused.exit_code == 2, refused.output
        assert sentence in " ".join(refused.stderr.split())
        assert not Path("mesh.obj").exists()
    written(BRepPrimAPI_MakeBox(3000.0, 2000.0, 1000.0).Solid(), Path("box.step"))
    assert read_shape(Path("box.step")).notes == ("1 solid in the file: its whole skin is taken as the surface",)


@kernel
@needs_kernel
def test_faces_are_sewn_and_moved_together() -> None:
    from OCP.BRep import BRep_Builder
    from OCP.TopoDS import TopoDS_Compound

    both, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(both)
    for face in (spline(-5, 0, fold=0.0), spline(0, 5, fold=0.0)):
        builder.Add(both, face)
    surface = in_triangles(both)
    assert len(surface.faces) == 2
    assert len(surface.mesh.combinatorics.boundary_loops) == 1
    assert surface.mesh.combinatorics.euler_characteristic == 1
    moved = surface.moved(0.001, np.array([10.0, 0, 0]))
    points = near(surface)
    feet, normals = surface.closest(points)
    there, same = moved.closest(points * 0.001 + [10, 0, 0])
    assert there == pytest.approx(feet * 0.001 + [10, 0, 0], abs=1e-9)
    assert same == pytest.approx(normals, abs=1e-9)
    assert surface.reversed().closest(points)[1] == pytest.approx(-normals, abs=1e-9)
    assert surface.reversed().mesh.face_normals.mean(axis=0) == pytest.approx(-surface.mesh.face_normals.mean(axis=0))


@kernel
@needs_kernel
def test_a_step_file_is_built(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    written(spline(), Path("roof.step"))
    done = run("build", "roof.step", "--unit", "mm", "--edge-length", 1000, "-o", "built", "--skip-unbuildable")
    assert done.exit_code == 0, done.output
    surface = json.loads(Path("built/manifest.json").read_text())["surface"]
    assert surface["distance_mm"]["p95"] < 30
    assert run("mesh", "roof.step", "--edge-length", 1000, "-o", "roof.obj").exit_code == 0
    for options, sentence in (
        (["--unit", "mm"], "holds surfaces, and no mesh"),
        (["--unit", "m", "--faces", 100], "have a unit and are read in mm"),
        (["--unit", "mm", "--faces", 100, "--smooth", 5], "holds exact surfaces: leave it out"),
    ):
        refused = run("build", "roof.step", *options, "-o", "other")
        assert refused.exit_code == 2
        assert sentence in " ".join(refused.stderr.split())
    Path("bad.step").write_text("ISO-10303-21;\n")
    with pytest.raises(FabkitError, match=r"bad\.step cannot be read by the CAD kernel"):
        read_shape(Path("bad.step"))


@pytest.mark.skipif(HAS_KERNEL, reason="a kernel is installed")
def test_without_a_kernel_the_cure_is_named(tmp_path: Path) -> None:
    (tmp_path / "roof.step").write_text("ISO-10303-21;\n")
    with pytest.raises(FabkitError, match=r'pip install "fabkit\[build123d\]"'):
        read_shape(tmp_path / "roof.step")

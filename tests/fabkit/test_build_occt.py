"""The roof that ships, built and read back by OCCT: every part of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from examples import figure_19_cmc_pieces as figure_19
from fabkit import Project, build
from fabkit.formats.step.files import instance_name
from geometry.files import write_mesh
from geometry.mesh.shapes import dome
from tests.fabkit.assemblies import by_name
from tests.fabkit.occt import HAS_KERNEL, read_step

ROOF = Path(__file__).parents[2] / "examples" / "roof.obj"

pytestmark = [pytest.mark.kernel, pytest.mark.skipif(not HAS_KERNEL, reason="neither build123d nor CadQuery is here")]


def test_every_part_is_a_valid_solid_of_our_volume_in_its_place(tmp_path: Path) -> None:
    built = build(Project(mesh=ROOF, unit="m", out=tmp_path / "roof", nesting={"mode": "off"}, equal_within_mm=1e-7))
    leaves = {leaf.path: leaf for leaf in read_step(tmp_path / "roof" / "model.step")}
    groups = by_name(built.assembly)
    assert len(leaves) == sum(len(parts) for parts in groups.values())
    for group, parts in groups.items():
        for part in parts:
            leaf = leaves["roof", group, instance_name(part)]
            assert leaf.product.split()[0] == part.mark
            assert leaf.n_solids == 1
            assert leaf.body.valid
            assert leaf.body.closed
            assert leaf.body.volume == pytest.approx(part.solid.volume_mm3, rel=1e-9)
            # OCCT's own integrals lose some digits 40 m from the origin
            assert np.abs(leaf.body.centroid - part.placement.to_world(part.solid.centroid)).max() < 1e-5
    for mark in ("B001", "N007", "P288"):
        (leaf,) = read_step(tmp_path / "roof" / "parts" / f"{mark}.step")
        assert leaf.product.split()[0] == mark
        assert leaf.body.valid


def test_joined_pieces_are_built_from_their_files(tmp_path: Path) -> None:
    """Figure 19 of the paper: hexagons, pentagons and quads with one Gauss image, bulges some 9 m wide."""
    pair = figure_19.found().pair
    write_mesh(tmp_path / "M.obj", pair.mesh * 6000.0)
    write_mesh(tmp_path / "S.obj", pair.gauss_image)
    files = {"mesh": tmp_path / "M.obj", "gauss_image": tmp_path / "S.obj"}
    built = build(Project(**files, unit="mm", out=tmp_path / "out", nesting={"mode": "off"}))  # type: ignore[arg-type]
    mesh = built.structure.mesh
    leaves = read_step(tmp_path / "out" / "model.step")
    assert len(leaves) == mesh.n_faces + mesh.n_edges + mesh.n_vertices
    assert all(leaf.body.valid and leaf.body.closed and leaf.n_solids == 1 for leaf in leaves)
    assert built.summary.largest_move_mm == 0.0
    assert built.structure.heights.min() > 0.98 * np.median(built.structure.heights)


@pytest.mark.parametrize("distance", [-600.0, 650.0])
def test_layers_struts_and_fins_are_valid_solids_of_our_volume(distance: float, tmp_path: Path) -> None:
    """Struts of the outer layer stand on trimmed blocks, so that they are cut obliquely."""
    settings = {
        "beams": {"section": "rhs 120x60x5"},
        "nodes": {"top": "trimmed"},
        "layers": [{"joint_mm": 80, "thickness_mm": 10, "seat_mm": 12, "least_bearing_mm": -80}],
        "second_layer": {"distance_mm": distance, "strut": "chs 33.7x3"},
        "fins": {"from_mm": 120, "to_mm": 350, "direction": [0.3, -0.2, 0.0]},
        "marks": {"far_end_mm": 1e-6},
    }
    if distance > 0:
        settings.pop("fins")  # they would stand where the outer layer does
    built = build(
        Project(mesh=dome(8, 3), mean_edge_mm=2000, out=tmp_path / "roof", nesting={"mode": "off"}, **settings)  # type: ignore[arg-type]
    )
    assert (built.assembly["struts"].details.cut_angle_deg.max() > 0.1) == (distance > 0)
    leaves = {leaf.path: leaf for leaf in read_step(tmp_path / "roof" / "model.step")}
    for group, parts in by_name(built.assembly).items():
        for part in parts:
            body = leaves["structure", group, instance_name(part)].body
            assert body.valid
            assert body.closed
            assert body.volume == pytest.approx(part.solid.volume_mm3, rel=1e-9)

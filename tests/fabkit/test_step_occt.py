"""STEP files read back by OCCT, the kernel of build123d, CadQuery, FreeCAD and gmsh."""

from __future__ import annotations

from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from fabkit.formats.step.entities import Schema
from fabkit.formats.step.files import instance_name, stream_step, write_part_step, write_step
from fabkit.kinds import NODE
from fabkit.parts import Assembly, Frame, Part, Parts, Solid, prism_topology, prism_vertices
from tests.fabkit.assemblies import by_name
from tests.fabkit.gridshell import gridshell
from tests.fabkit.occt import HAS_KERNEL, Placed, read_step
from tests.fabkit.round_solids import SOLIDS as ROUND_SOLIDS
from tests.fabkit.solids import frame, node, prism, star, tube

pytestmark = [pytest.mark.kernel, pytest.mark.skipif(not HAS_KERNEL, reason="neither build123d nor CadQuery is here")]

NAME = "Möbius' roof \\ 屋根"


@pytest.fixture(scope="module")
def assembly() -> Assembly:
    return gridshell(4, 3, name=NAME)


@pytest.fixture(scope="module", params=get_args(Schema))
def leaves(
    assembly: Assembly, request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> list[Placed]:
    path = tmp_path_factory.mktemp("step") / "model.step"
    write_step(path, assembly, schema=request.param)
    return read_step(path)


def check_body(leaf: Placed, part: Part, placement: Frame) -> None:
    """One valid closed solid, the part's own, where it belongs, and what the file states about it."""
    body, solid = leaf.body, part.solid
    reach = np.abs(solid.vertices).max() + np.abs(placement.origin).max()
    assert leaf.n_solids == 1
    assert body.valid
    assert body.closed
    assert body.n_faces == solid.topology.n_faces + len(solid.topology.rounds)
    assert body.volume == pytest.approx(solid.volume_mm3, rel=1e-9)
    # OCCT's own integrals lose some digits far from the origin
    assert np.abs(body.centroid - placement.to_world(solid.centroid)).max() < 1e-10 * reach
    assert leaf.stated is not None
    assert leaf.stated[0] == pytest.approx(body.volume, rel=1e-9)
    assert leaf.stated[1] == pytest.approx(body.area, rel=1e-9)
    assert np.abs(leaf.stated[2] - solid.centroid).max() < 1e-12 * reach
    assert leaf.density == pytest.approx(part.material.density_kg_m3 * 1e-6)  # OCCT gives g/mm3
    assert leaf.colour == pytest.approx(part.kind.colour, abs=1e-6)  # kept in single precision


def test_tree_and_names(assembly: Assembly, leaves: list[Placed]) -> None:
    expected = [
        ((NAME, group, instance_name(part)), part.mark) for group, parts in by_name(assembly).items() for part in parts
    ]
    assert [(leaf.path, leaf.product.split()[0]) for leaf in leaves] == expected
    assert not any(leaf.product[-1].isdigit() for leaf in leaves)


def test_bodies(assembly: Assembly, leaves: list[Placed]) -> None:
    for leaf, part in zip(leaves, assembly.parts(), strict=True):
        check_body(leaf, part, part.placement)


SOLIDS = {
    "tube": tube(),
    "star": star(),
    "sixty corners": star(30, 2000, 1500, 12),
    "tiny": prism([[0, 0], [0.1, 0], [0, 0.1]], 0.1),
    "tiny hole": tube(50.0, 0.01, 2.0),
    "long and thin": prism([[0, 0], [30000, 0], [30000, 3], [0, 3]], 0.5),
    "far": Solid(frame(3, 1e6).to_world(tube().vertices), tube().topology),
    "turned": Solid(frame(4, 1.0).to_world(prism([[0, 0], [90, 10], [20, 70]], 33.0).vertices), prism_topology(3)),
    **ROUND_SOLIDS,
}


@pytest.mark.parametrize("name", SOLIDS)
def test_part_file_is_one_product(name: str, tmp_path: Path) -> None:
    part = node("N1", SOLIDS[name], frame(5))
    write_part_step(tmp_path / "N1.step", part)
    (leaf,) = read_step(tmp_path / "N1.step")
    assert (leaf.path, leaf.product) == (("N1 node",), "N1 node")
    check_body(leaf, part, Frame.world())


def test_solids_of_all_sorts_in_one_file(tmp_path: Path) -> None:
    parts = [node(f"N{n}", solid, frame(n, 1e5), n) for n, solid in enumerate(SOLIDS.values())]
    stream_step(tmp_path / "all.step", "all", [Parts.of(NODE, parts)])
    for leaf, part in zip(read_step(tmp_path / "all.step"), parts, strict=True):
        assert leaf.path == ("all", "nodes", instance_name(part))
        check_body(leaf, part, part.placement)


def test_random_prisms(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    parts: list[Part] = []
    for n in range(60):
        corners = int(rng.integers(3, 13))
        angles = 2 * np.pi * np.arange(corners) / corners
        outline = np.stack([np.cos(angles), np.sin(angles)], axis=1) * rng.uniform(10, 2000, (corners, 1))
        vertices = prism_vertices(outline, 0.0, rng.uniform(1, 2000))
        parts.append(node(f"N{n}", Solid(vertices, prism_topology(corners)), frame(n), n))
    stream_step(tmp_path / "prisms.step", "prisms", [Parts.of(NODE, parts)])
    for leaf, part in zip(read_step(tmp_path / "prisms.step"), parts, strict=True):
        check_body(leaf, part, part.placement)

"""Parts handed to build123d and CadQuery, each tested where it is installed."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest

from fabkit import Project, design
from fabkit.errors import FabkitError
from fabkit.formats.kernels import to_build123d, to_cadquery
from fabkit.formats.step.files import instance_name
from fabkit.parts import Assembly, Frame, Part
from geometry.mesh.shapes import dome
from tests.fabkit.assemblies import assembled, by_name
from tests.fabkit.gridshell import gridshell
from tests.fabkit.occt import measure, solids_in
from tests.fabkit.round_solids import SOLIDS
from tests.fabkit.solids import frame, node, star, tube

MAKERS = {"build123d": to_build123d, "cadquery": to_cadquery}


def needs(package: str) -> Any:
    return [
        pytest.mark.kernel,
        pytest.mark.skipif(find_spec(package) is None, reason=f"{package} is not installed"),
    ]


each_kernel = pytest.mark.parametrize("package", [pytest.param(name, marks=needs(name)) for name in MAKERS])


@pytest.fixture(scope="module")
def assembly() -> Assembly:
    return gridshell(3, 2)


def shape_of(made: Any) -> Any:
    """The OCCT shape of what was made of a part."""
    return made.val().wrapped if hasattr(made, "val") else made.wrapped


def check_shape(shape: Any, part: Part, placement: Frame) -> None:
    (solid,) = solids_in(shape)
    body = measure(solid)
    reach = np.abs(part.solid.vertices).max() + np.abs(placement.origin).max()
    assert body.valid
    assert body.closed
    assert body.n_faces == part.solid.topology.n_faces + len(part.solid.topology.rounds)
    assert body.volume == pytest.approx(part.solid.volume_mm3, rel=1e-9)
    # OCCT's own integrals lose some digits far from the origin
    assert np.abs(body.centroid - placement.to_world(part.solid.centroid)).max() < 1e-10 * reach


@each_kernel
@pytest.mark.parametrize("solid", [tube(), star(), star(30, 2000, 1500, 0.2), *SOLIDS.values()])
def test_part_comes_in_its_own_frame(package: str, solid: Any) -> None:
    part = node("N1", solid, frame(2))
    check_shape(shape_of(MAKERS[package](part)), part, Frame.world())


@each_kernel
def test_parts_of_an_assembly_are_placed(package: str, assembly: Assembly) -> None:
    leaves = [leaf for _, group in tree(MAKERS[package](assembly)) for leaf in group]
    for (name, shape, _), part in zip(leaves, assembly.parts(), strict=True):
        assert name == instance_name(part)
        check_shape(shape, part, part.placement)


@each_kernel
def test_tree_names_and_colours(package: str, assembly: Assembly) -> None:
    made = MAKERS[package](assembly)
    assert (made.label if package == "build123d" else made.name) == assembly.name
    groups = tree(made)
    assert [name for name, _ in groups] == ["beams", "nodes", "panels"]
    for (_, leaves), parts in zip(groups, by_name(assembly).values(), strict=True):
        assert [name for name, _, _ in leaves] == [instance_name(part) for part in parts]
        for (_, _, colour), part in zip(leaves, parts, strict=True):
            assert colour[:3] == pytest.approx(part.kind.colour, abs=1e-6)  # kept in single precision


@each_kernel
def test_equal_parts_share_their_shape(package: str, assembly: Assembly) -> None:
    shapes: dict[str, Any] = {}
    leaves = [leaf for _, group in tree(MAKERS[package](assembly)) for leaf in group]
    for (_, shape, _), part in zip(leaves, assembly.parts(), strict=True):
        assert shapes.setdefault(part.mark, shape).IsPartner(shape)
    assert len(shapes) < len(leaves)


@each_kernel
def test_empty_groups_are_left_out(package: str, assembly: Assembly) -> None:
    made = MAKERS[package](assembled("beams only", assembly["beams"]))
    assert [name for name, _ in tree(made)] == ["beams"]


@each_kernel
def test_zones_are_between_structure_and_groups(package: str) -> None:
    zones = [{"name": "West", "faces": [0, 1, 2]}, {"name": "Others"}]
    whole = design(Project(mesh=dome(6, 2), mean_edge_mm=1500, zones=zones)).assembly
    made = MAKERS[package](whole)
    named = {each.label if package == "build123d" else each.name: tree(each) for each in made.children}
    assert list(named) == ["West", "Others"]
    for zone, groups in named.items():
        assert [name for name, _ in groups] == [f"{zone} {parts.kind.group}" for parts in whole.groups if len(parts)]
        found = {name for _, leaves in groups for name, _, _ in leaves}
        assert found == {
            name
            for parts in whole.groups
            for name, own in zip(parts.piece_names, whole.zones.named(parts), strict=True)
            if own == zone
        }


def tree(made: Any) -> list[tuple[str, list[tuple[str, Any, tuple[float, ...]]]]]:
    """Groups by name, each with name, placed OCCT shape and sRGB of its leaves."""
    if hasattr(made, "label"):
        return [(g.label, [(s.label, s.wrapped, tuple(s.color)) for s in g.children]) for g in made.children]
    return [
        (g.name, [(s.name, s.obj.moved(s.loc).wrapped, s.color.toTuple()) for s in g.children]) for g in made.children
    ]


@pytest.mark.parametrize("package", MAKERS)
def test_missing_kernel_is_named_with_its_cure(package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(FabkitError, match=rf'pip install "fabkit\[{package}\]"'):
        MAKERS[package](node("N1", tube()))


def test_no_kernel_is_imported_before_it_is_asked_for() -> None:
    script = (
        "import sys, fabkit.formats.kernels; sys.exit(any(m in sys.modules for m in ('OCP', 'build123d', 'cadquery')))"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0

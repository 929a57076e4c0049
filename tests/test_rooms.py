"""The arrows of the house: which room may import which. docs/architecture.md explains the plan."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

GROUND = {"geometry.arrays", "geometry.errors"}
PARTS = {"fabkit.parts", "fabkit.errors", "geometry.mesh", *GROUND}

MAY_IMPORT: dict[str, set[str]] = {
    "geometry": {
        "geometry.mesh",
        "geometry.meshing",
        "geometry.optimise",
        "geometry.parallel",
        "geometry.curvature",
        "geometry.edge_offset",
        *GROUND,
    },
    "geometry.arrays": set(),
    "geometry.errors": set(),
    "geometry.optimise": GROUND,
    "geometry.mesh": GROUND,
    "geometry.functionals": {"geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.parallel": {"geometry.functionals", "geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.curvature": {
        "geometry.parallel",
        "geometry.functionals",
        "geometry.optimise",
        "geometry.mesh",
        *GROUND,
    },
    "geometry.edge_offset": {
        "geometry.curvature",
        "geometry.parallel",
        "geometry.functionals",
        "geometry.optimise",
        "geometry.mesh",
        *GROUND,
    },
    "geometry.meshing": {"geometry.functionals", "geometry.optimise", "geometry.mesh", *GROUND},
    "fabkit": {
        "fabkit.build",
        "fabkit.project",
        "fabkit.errors",
        "fabkit.parts",
        "fabkit.detailing",
        "fabkit.signals",
    },
    "fabkit.__main__": {"fabkit.commands.app", "fabkit.signals"},
    "fabkit.signals": set(),
    "fabkit.errors": {"geometry.errors"},
    "fabkit.units": set(),
    "fabkit.stages": set(),
    "fabkit.wording": set(),
    "fabkit.parts": {"geometry.mesh", "fabkit.errors", *GROUND},
    "fabkit.fitness": {"geometry.parallel", *PARTS},
    "fabkit.detailing": {"geometry.parallel", "fabkit.fitness", "fabkit.wording", *PARTS},
    "fabkit.production": {"fabkit.fitness", *PARTS},
    "fabkit.formats": {"fabkit.production", "fabkit.fitness", "fabkit.signals", "fabkit.stages", *PARTS},
    "fabkit.project": {
        "fabkit.detailing",
        "fabkit.production",
        "fabkit.gauss_image",
        "fabkit.fitness",
        "fabkit.units",
        "fabkit.wording",
        "fabkit.errors",
    },
    "fabkit.commands.inspection": {
        "geometry.mesh",
        "geometry.parallel",
        "fabkit.build",
        "fabkit.detailing",
        "fabkit.fitness",
        "fabkit.gauss_image",
        "fabkit.project",
        "fabkit.stages",
        "fabkit.errors",
        *GROUND,
    },
    "fabkit.gauss_image": {"geometry.mesh", "geometry.parallel", "fabkit.wording", *GROUND},
    "fabkit.build": {
        "geometry.mesh",
        "geometry.meshing",
        "geometry.parallel",
        "fabkit.detailing",
        "fabkit.gauss_image",
        "fabkit.production",
        "fabkit.formats",
        "fabkit.fitness",
        "fabkit.project",
        "fabkit.stages",
        "fabkit.units",
        "fabkit.wording",
        *PARTS,
    },
    "fabkit.designs": {
        "geometry.mesh",
        "geometry.parallel",
        "geometry.curvature",
        "geometry.edge_offset",
        "fabkit.gauss_image",
        "fabkit.formats",
        "fabkit.wording",
        "fabkit.errors",
        *GROUND,
    },
    "fabkit.commands.terminal": {"fabkit.errors", "fabkit.signals", "fabkit.wording", "geometry.errors"},
    "fabkit.commands.design": {"fabkit.designs", "fabkit.formats", "fabkit.commands.terminal", "fabkit.errors"},
    "fabkit.commands.options": {"fabkit.project", "fabkit.errors"},
    "fabkit.commands.app": {
        "fabkit.build",
        "fabkit.commands.design",
        "fabkit.fitness",
        "fabkit.commands.options",
        "fabkit.commands.inspection",
        "fabkit.project",
        "fabkit.commands.terminal",
        "fabkit.errors",
    },
}


def room_of(module: str) -> str:
    """The room of a dotted module: its package and the folder or file in it."""
    return ".".join(module.split(".")[:2])


def imports(path: Path) -> Iterator[str]:
    """Modules of the project that a file imports, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
        names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom) and node.level:
            raise AssertionError(f"{path} imports relatively; write the whole name")
        yield from (name for name in names if name.split(".")[0] in ("geometry", "fabkit"))


def modules() -> list[Path]:
    return sorted(path for package in ("geometry", "fabkit") for path in (ROOT / package).rglob("*.py"))


def trespasses(path: Path) -> list[str]:
    module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
    room = room_of(module)
    return [name for name in imports(path) if room_of(name) != room and room_of(name) not in MAY_IMPORT[room]]


@pytest.mark.parametrize("path", modules(), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_room_imports_what_it_may_not(path: Path) -> None:
    assert trespasses(path) == []


def test_every_room_in_the_table_exists_and_no_arrow_runs_in_a_circle() -> None:
    rooms = {room_of(".".join(p.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")) for p in modules()}
    assert rooms == set(MAY_IMPORT)
    done: set[str] = set()
    while ready := {room for room in MAY_IMPORT if room not in done and MAY_IMPORT[room] <= done}:
        done |= ready
    assert done == set(MAY_IMPORT)


def test_a_trespass_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    path = tmp_path / "geometry" / "mesh" / "bad.py"
    path.parent.mkdir(parents=True)
    path.write_text("def f():\n    from geometry.optimise import solver\n    import fabkit.parts.part\n")
    assert trespasses(path) == ["geometry.optimise", "fabkit.parts.part"]


def test_imports_of_kernels_are_lazy() -> None:
    kernels = {"OCP", "build123d", "cadquery", "packingsolver", "spyrrow"}
    for path in modules():
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not kernels & {name.split(".")[0] for name in names}, path

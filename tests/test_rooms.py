"""The arrows of the house: which room may import which, and in the large rooms which file may import which.

A room is a folder with Python files, sub-rooms counted apart; files beside the rooms are rooms of their own.
docs/architecture.md explains the plan.
"""

from __future__ import annotations

import ast
import importlib
import pkgutil
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("geometry", "fabkit")

LARGEST_FILE, LARGEST_ROOM, LARGEST_SHARE = 350, 2500, 0.15
"""Lines of a file and of a room, and the part of all lines that a room may have."""

GROUND = {"geometry.arrays", "geometry.errors"}

MAY_IMPORT: dict[str, set[str]] = {
    "geometry": {"geometry.public"},
    "geometry.public": {
        "geometry.optimised_pairs",
        "geometry.curvature",
        "geometry.edge_offset",
        "geometry.errors",
        "geometry.exact_offsets",
        "geometry.files",
        "geometry.gauss",
        "geometry.layout",
        "geometry.mesh",
        "geometry.meshing",
        "geometry.optimise",
        "geometry.parallel",
        "geometry.pictures",
        "geometry.remeshing",
        "geometry.spheres",
        "geometry.surface",
        "geometry.traced_curves",
    },
    "geometry.arrays": set(),
    "geometry.errors": {"geometry.arrays"},
    "geometry.mesh": GROUND,
    "geometry.mesh.intersections": {"geometry.mesh", "geometry.arrays"},
    "geometry.optimise": GROUND,
    "geometry.surface": {"geometry.mesh", "geometry.mesh.intersections", *GROUND},
    "geometry.colours": {"geometry.mesh", *GROUND},
    "geometry.pictures": {"geometry.colours", "geometry.mesh", *GROUND},
    "geometry.files": {"geometry.colours", "geometry.mesh", *GROUND},
    "geometry.functionals": {"geometry.surface", "geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.meshing": {"geometry.functionals", "geometry.surface", "geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.networks": {"geometry.surface", "geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.layout": {"geometry.networks", "geometry.surface", "geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.traced_curves": {"geometry.networks", "geometry.layout", "geometry.surface", "geometry.mesh", *GROUND},
    "geometry.parallel": {"geometry.functionals", "geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.spheres": {"geometry.mesh", *GROUND},
    "geometry.gauss": {
        "geometry.parallel",
        "geometry.spheres",
        "geometry.functionals",
        "geometry.optimise",
        "geometry.mesh",
        *GROUND,
    },
    "geometry.exact_offsets": {
        "geometry.gauss",
        "geometry.parallel",
        "geometry.functionals",
        "geometry.optimise",
        "geometry.mesh",
        *GROUND,
    },
    "geometry.circle_patterns": {"geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.curvature": {"geometry.gauss", "geometry.parallel", "geometry.optimise", "geometry.mesh", *GROUND},
    "geometry.optimised_pairs": {
        "geometry.gauss",
        "geometry.parallel",
        "geometry.meshing",
        "geometry.functionals",
        "geometry.surface",
        "geometry.optimise",
        "geometry.mesh",
        *GROUND,
    },
    "geometry.edge_offset": {
        "geometry.circle_patterns",
        "geometry.spheres",
        "geometry.gauss",
        "geometry.parallel",
        "geometry.functionals",
        "geometry.surface",
        "geometry.optimise",
        "geometry.mesh",
        "geometry.mesh.intersections",
        *GROUND,
    },
    "geometry.remeshing": {
        "geometry.layout",
        "geometry.meshing",
        "geometry.gauss",
        "geometry.surface",
        "geometry.mesh",
        *GROUND,
    },
    "geometry.shading": {"geometry.gauss", "geometry.mesh", *GROUND},
    "fabkit": {"fabkit.public"},
    "fabkit.public": {"fabkit.pipeline", "fabkit.project", "fabkit.errors"},
    "fabkit.families": set(),
    "fabkit.__main__": {"fabkit.commands", "fabkit.signals"},
    "fabkit.signals": set(),
    "fabkit.errors": {"geometry.errors"},
    "fabkit.units": set(),
    "fabkit.stages": set(),
    "fabkit.toml_tables": {"fabkit.errors"},
    "fabkit.wording": set(),
    "fabkit.parts.shapes": {"geometry.mesh", "geometry.arrays"},
    "fabkit.parts": {"fabkit.parts.shapes", "fabkit.errors", "geometry.mesh", *GROUND},
    "fabkit.kinds": {"fabkit.parts", "geometry.arrays"},
    "fabkit.connections": {"fabkit.errors", "geometry.arrays"},
    "fabkit.layer_meshes": {
        "fabkit.wording",
        "fabkit.errors",
        "geometry.files",
        "geometry.parallel",
        "geometry.mesh",
        "geometry.errors",
    },
    "fabkit.overrides": set(),
    "fabkit.rules": {"fabkit.connections", "fabkit.parts", "fabkit.wording"},
    "fabkit.fitness": {
        "fabkit.kinds",
        "fabkit.parts",
        "fabkit.errors",
        "geometry.gauss",
        "geometry.mesh",
        "geometry.mesh.intersections",
        *GROUND,
    },
    "fabkit.checking": {
        "fabkit.connections",
        "fabkit.kinds",
        "fabkit.parts",
        "fabkit.errors",
        "geometry.gauss",
        "geometry.arrays",
    },
    "fabkit.detailing.panel_layers": {
        "fabkit.detailing.shapes",
        "fabkit.kinds",
        "fabkit.rules",
        "fabkit.parts",
        "geometry.gauss",
        "geometry.mesh",
        "geometry.arrays",
    },
    "fabkit.detailing.shapes": {
        "fabkit.checking",
        "fabkit.connections",
        "fabkit.kinds",
        "fabkit.parts",
        "fabkit.rules",
        "geometry.mesh",
        "geometry.arrays",
    },
    "fabkit.detailing": {
        "fabkit.detailing.panel_layers",
        "fabkit.detailing.shapes",
        "fabkit.checking",
        "fabkit.connections",
        "fabkit.fitness",
        "fabkit.kinds",
        "fabkit.rules",
        "fabkit.parts",
        "fabkit.errors",
        "geometry.gauss",
        "geometry.mesh",
        "geometry.shading",
        *GROUND,
    },
    "fabkit.production.marks": {
        "fabkit.errors",
        "fabkit.rules",
        "fabkit.kinds",
        "fabkit.parts",
        "geometry.mesh",
        "geometry.arrays",
    },
    "fabkit.production.nesting": {"fabkit.kinds", "fabkit.parts", "fabkit.errors", *GROUND},
    "fabkit.production": {
        "fabkit.production.marks",
        "fabkit.production.nesting",
        "fabkit.fitness",
        "fabkit.kinds",
        "fabkit.parts",
        "fabkit.errors",
        "geometry.mesh",
        *GROUND,
    },
    "fabkit.formats.finished": {
        "fabkit.units",
        "fabkit.wording",
        "fabkit.rules",
        "fabkit.formats",
        "fabkit.formats.drawings",
        "fabkit.formats.report",
        "fabkit.formats.step",
        "fabkit.production",
        "fabkit.parts",
        "fabkit.errors",
        "geometry.arrays",
    },
    "fabkit.formats.step": {"fabkit.parts", "fabkit.errors", "geometry.arrays"},
    "fabkit.formats.surfaces": {
        "fabkit.wording",
        "fabkit.errors",
        "geometry.surface",
        "geometry.mesh",
        "geometry.arrays",
    },
    "fabkit.formats.drawings": {
        "fabkit.errors",
        "fabkit.parts",
        "geometry.remeshing",
        "fabkit.production",
        "geometry.mesh",
        "geometry.arrays",
    },
    "fabkit.formats.shown": {"fabkit.kinds", "fabkit.parts", "fabkit.errors", "geometry.arrays"},
    "fabkit.formats.report": {
        "fabkit.formats.shown",
        "fabkit.production",
        "fabkit.fitness",
        "fabkit.kinds",
        "fabkit.parts",
        "geometry.arrays",
    },
    "fabkit.formats": {
        "fabkit.rules",
        "fabkit.formats.step",
        "fabkit.formats.surfaces",
        "fabkit.formats.drawings",
        "fabkit.formats.report",
        "fabkit.formats.shown",
        "fabkit.production",
        "fabkit.kinds",
        "fabkit.parts",
        "fabkit.signals",
        "fabkit.stages",
        "fabkit.wording",
        "fabkit.errors",
        "geometry.errors",
        "geometry.files",
        "geometry.gauss",
        "geometry.mesh",
        "geometry.arrays",
    },
    "fabkit.gauss_image": {
        "fabkit.rules",
        "fabkit.wording",
        "geometry.files",
        "geometry.gauss",
        "geometry.parallel",
        "geometry.mesh",
        "geometry.errors",
    },
    "fabkit.refused_settings": {"fabkit.wording"},
    "fabkit.project": {
        "fabkit.rules",
        "fabkit.refused_settings",
        "fabkit.surface",
        "fabkit.gauss_image",
        "fabkit.optimisation",
        "fabkit.production",
        "fabkit.fitness",
        "fabkit.overrides",
        "fabkit.toml_tables",
        "fabkit.units",
        "fabkit.wording",
        "fabkit.errors",
        "geometry.mesh",
    },
    "fabkit.optimisation": {
        "fabkit.production",
        "fabkit.rules",
        "fabkit.errors",
        "geometry.optimised_pairs",
        "geometry.gauss",
        "geometry.surface",
        "geometry.errors",
    },
    "fabkit.built": {
        "fabkit.checking",
        "fabkit.detailing",
        "fabkit.production",
        "fabkit.parts",
        "fabkit.project",
        "fabkit.surface",
        "geometry.files",
        "geometry.gauss",
        "geometry.mesh",
    },
    "fabkit.surface": {
        "fabkit.wording",
        "fabkit.formats",
        "fabkit.formats.surfaces",
        "fabkit.rules",
        "fabkit.errors",
        "geometry.remeshing",
        "geometry.traced_curves",
        "geometry.layout",
        "geometry.surface",
        "geometry.files",
        "geometry.mesh",
        *GROUND,
    },
    "fabkit.structure": {
        "fabkit.optimisation",
        "fabkit.production",
        "fabkit.fitness",
        "fabkit.project",
        "fabkit.gauss_image",
        "fabkit.stages",
        "geometry.meshing",
        "geometry.exact_offsets",
        "geometry.gauss",
        "geometry.surface",
        "geometry.mesh",
        "geometry.errors",
    },
    "fabkit.pipeline": {
        "fabkit.layer_meshes",
        "fabkit.formats.finished",
        "fabkit.built",
        "fabkit.structure",
        "fabkit.surface",
        "fabkit.formats",
        "fabkit.production",
        "fabkit.detailing",
        "fabkit.detailing.shapes",
        "fabkit.fitness",
        "fabkit.kinds",
        "fabkit.parts",
        "fabkit.project",
        "fabkit.rules",
        "fabkit.gauss_image",
        "fabkit.stages",
        "fabkit.units",
        "fabkit.errors",
        "geometry.arrays",
        "geometry.errors",
        "geometry.files",
        "geometry.surface",
        "geometry.mesh",
    },
    "fabkit.designs": {
        "fabkit.rules",
        "fabkit.families",
        "fabkit.formats",
        "fabkit.formats.drawings",
        "fabkit.wording",
        "fabkit.errors",
        "geometry.edge_offset",
        "geometry.curvature",
        "geometry.spheres",
        "geometry.gauss",
        "geometry.parallel",
        "geometry.files",
        "geometry.surface",
        "geometry.mesh",
        "geometry.mesh.intersections",
        *GROUND,
    },
    "fabkit.commands": {
        "fabkit.surface",
        "fabkit.formats.drawings",
        "fabkit.formats.finished",
        "fabkit.units",
        "geometry.remeshing",
        "geometry.traced_curves",
        "fabkit.structure",
        "fabkit.designs",
        "fabkit.families",
        "fabkit.pipeline",
        "fabkit.project",
        "fabkit.formats",
        "fabkit.production",
        "fabkit.detailing",
        "fabkit.fitness",
        "fabkit.rules",
        "fabkit.gauss_image",
        "fabkit.stages",
        "fabkit.signals",
        "fabkit.wording",
        "fabkit.errors",
        "geometry.files",
        "geometry.pictures",
        "geometry.colours",
        "geometry.curvature",
        "geometry.exact_offsets",
        "geometry.gauss",
        "geometry.parallel",
        "geometry.mesh",
        *GROUND,
    },
}

LARGE_ROOM = 1000
"""Lines from which on a room says which of its files may import which."""

LAYERS: dict[str, tuple[str, ...]] = {
    "geometry.mesh": (
        "ragged_arrays origin spanning_forests",
        "orientability",
        "combinatorics",
        "polygons",
        "mesh independent_faces mesh_polylines",
        "coordinate_rounding solids triangulation mesh_arguments",
        "shapes other_libraries",
        "tilings",
    ),
    "geometry.optimise": (
        "functional solution",
        "affine blocks hinge remembered saddle_point",
        "constrained_quadratic semidefinite_quadratic grounded_laplacian penalty",
        "bounded_quadratic",
        "newton",
    ),
    "geometry.files": (
        "encoding number_rows clusters face_rings materials meeting_outlines raw_polygons",
        "obj off ply triangle_formats orientation overlaid_faces",
        "face_checks",
        "mending",
        "mesh_files",
        "mesh_pairs",
    ),
    "geometry.functionals": (
        "unknowns boundary_normals",
        "closeness convex_faces fairness face_frames parallel_edges reference_planes",
        "circular_faces conical_vertices gauss_image_terms planar_faces pair_distances",
        "constant_curvature upright_axes",
    ),
    "geometry.surface": (
        "surface rim_corners",
        "curvature curve curved_triangles smoothing subdivision",
    ),
    "geometry.networks": (
        "tangent_frames",
        "combed_fields cross_fields networks graded_sizes",
        "conjugate_networks",
    ),
    "geometry.layout": (
        "quarter_turns integer_lattices windings",
        "seams twists quality",
        "exact_maps integration open_rims singular_points",
        "grid_points rim_gaps",
        "rays",
        "cells",
        "drafts",
        "quads",
    ),
    "geometry.parallel": (
        "blending edge_parallelity constraints homology face_unknowns",
        "edge_closure optimality",
        "spectrum sampling minimising",
        "space",
    ),
    "geometry.gauss": (
        "axes distances lean",
        "pair unit_distances",
        "support_structure approximate_gauss_image nearest_pair boundary_matches",
        "rounded_mesh joined_pairs",
    ),
    "geometry.exact_offsets": (
        "edge_cones inscribed",
        "offset_conditions midscribed",
        "circumscribed",
        "exact_gauss_image",
        "offset_kinds",
        "exact_or_approximate",
        "constant_offset",
    ),
    "geometry.curvature": (
        "face_curvature fairness hexagon_levels rings",
        "christoffel_duals",
        "constant_mean_curvature",
        "revolution",
    ),
    "geometry.edge_offset": (
        "centring enneper rotational points_of_contact contradictory_signs buildability",
        "koebe_polyhedra tangent_hexagons",
        "signed_meshes covering",
    ),
    "fabkit.parts.shapes": ("topology", "fillets", "solid profiles"),
    "fabkit.parts": (
        "columns finish frame material section ragged symmetry",
        "build_up plates kind curves",
        "solids",
        "parts",
        "zones",
        "assembly",
    ),
    "fabkit.checking": (
        "access bore_distances convex_pieces fit links positions round_edges separation",
        "bores convex",
        "clash solid_rules",
        "placed_parts",
        "panel_bounds",
    ),
    "fabkit.detailing": (
        "ends zones",
        "beams joining",
        "hubs fins",
        "nodes",
        "bolted going_in panel_underside struts supports",
        "beam_layers panel_levels",
        "second_layer",
        "secondary",
        "assembling",
    ),
    "fabkit.rules": ("lengths", "connections documents fins layers marks sheets site supports zones", "detailing"),
    "fabkit.kinds": ("columns faces look_alikes", "beams caps fasteners fins nodes panels plain supports", "struts"),
    "fabkit.production.nesting": (
        "nests remaining_rectangles",
        "guillotine",
        "irregular loose_panels",
        "filling",
        "sheet_nesting",
    ),
    "fabkit.production": (
        "erection node_tables part_views strokes",
        "cut_lists drawing",
        "part_drawing plate_drawing",
        "pieces summary",
        "facts",
    ),
    "fabkit.formats.finished": (
        "contents part_geometry",
        "dxf_files earlier_marks picture_checks step_checks zone_checks",
        "dxf_checks",
        "view_checks",
        "drawing_checks",
        "differences folder_checks",
    ),
    "fabkit.formats.step": ("text p_curves", "solid", "entities", "writer", "files"),
    "fabkit.formats": (
        "legend_table occt_solids",
        "manifest polylines renaming tables single_files workbook",
        "folder gltf kernels",
        "documents",
    ),
    "fabkit.commands": (
        "terminal options facts",
        "inspection",
        "inspection_picture folders",
        "printing",
        "mesh_output surface_output",
        "meshes surface_mesh design",
        "command_line",
    ),
}
"""The files of large rooms from the ground up: each imports only those of lines before its own; `a b` are peers."""


def dotted(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def modules() -> list[Path]:
    return sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def room_of(module: str) -> str:
    """The innermost folder of a module that is a room; the module itself beside the rooms."""
    names = module.split(".")
    for n in range(len(names), 1, -1):
        if (ROOT.joinpath(*names[:n]) / "__init__.py").exists():
            return ".".join(names[:n])
    return ".".join(names[:2])


def imports(path: Path) -> Iterator[str]:
    """Modules of the project that a file imports, anywhere in it; those that come from a room's own name too."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            if node.level:
                raise AssertionError(f"{path} imports relatively; write the whole name")
            module = ROOT.joinpath(*(node.module or "").split("."))
            for alias in node.names:
                inside = (module / f"{alias.name}.py").exists() or (module / alias.name / "__init__.py").exists()
                names.append(f"{node.module}.{alias.name}" if inside else node.module or "")
        yield from (name for name in names if name.split(".")[0] in PACKAGES)


def trespasses(path: Path) -> list[str]:
    room = room_of(dotted(path))
    return [name for name in imports(path) if room_of(name) != room and room_of(name) not in MAY_IMPORT[room]]


def lines_of_rooms() -> dict[str, int]:
    lines: dict[str, int] = {}
    for path in modules():
        room = room_of(dotted(path))
        lines[room] = lines.get(room, 0) + len(path.read_text(encoding="utf-8").splitlines())
    return lines


@pytest.mark.parametrize("path", modules(), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_room_imports_what_it_may_not(path: Path) -> None:
    assert trespasses(path) == []


def test_every_room_in_the_table_exists_and_no_arrow_runs_in_a_circle() -> None:
    assert set(lines_of_rooms()) == set(MAY_IMPORT)
    done: set[str] = set()
    while ready := {room for room in MAY_IMPORT if room not in done and MAY_IMPORT[room] <= done}:
        done |= ready
    assert done == set(MAY_IMPORT)


def test_every_permission_is_used() -> None:
    used: dict[str, set[str]] = {room: set() for room in MAY_IMPORT}
    for path in modules():
        room = room_of(dotted(path))
        used[room] |= {room_of(name) for name in imports(path)} - {room}
    assert {room: MAY_IMPORT[room] - used[room] for room in MAY_IMPORT if MAY_IMPORT[room] - used[room]} == {}


def test_a_trespass_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for room in ("geometry/mesh", "geometry/optimise", "fabkit/parts"):
        (tmp_path / room).mkdir(parents=True)
        (tmp_path / room / "__init__.py").touch()
    (tmp_path / "geometry" / "optimise" / "solver.py").touch()
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    path = tmp_path / "geometry" / "mesh" / "bad.py"
    path.write_text("def f():\n    from geometry.optimise import solver\n    import fabkit.parts.part\n")
    assert trespasses(path) == ["geometry.optimise.solver", "fabkit.parts.part"]


def layers_broken(room: str, layers: tuple[str, ...]) -> list[str]:
    level = {f"{room}.{name}": k for k, names in enumerate(layers) for name in names.split()}
    own = [path for path in modules() if room_of(dotted(path)) == room and path.name != "__init__.py"]
    assert {dotted(path) for path in own} == set(level), f"the files of {room} and those in its layers"
    return [
        f"{dotted(path)} imports {name}"
        for path in own
        for name in imports(path)
        if room_of(name) == room and not level.get(name, len(layers)) < level[dotted(path)]
    ]


@pytest.mark.parametrize("room", LAYERS)
def test_files_of_large_rooms_import_only_from_layers_below(room: str) -> None:
    assert layers_broken(room, LAYERS[room]) == []


def test_every_large_room_has_layers() -> None:
    assert {room for room, lines in lines_of_rooms().items() if lines > LARGE_ROOM} <= set(LAYERS)


def test_no_file_and_no_room_is_too_large() -> None:
    sizes = {dotted(path): len(path.read_text(encoding="utf-8").splitlines()) for path in modules()}
    assert {name: n for name, n in sizes.items() if n > LARGEST_FILE} == {}
    rooms, whole = lines_of_rooms(), sum(sizes.values())
    assert {room: n for room, n in rooms.items() if n > min(LARGEST_ROOM, LARGEST_SHARE * whole)} == {}


def faces() -> list[str]:
    return [dotted(path) for path in modules() if path.name == "__init__.py"]


@pytest.mark.parametrize("room", faces())
def test_every_room_says_what_is_public_and_no_name_hides_a_file(room: str) -> None:
    face = importlib.import_module(room)
    for name in face.__all__:
        assert hasattr(face, name), name
    for module in pkgutil.iter_modules(face.__path__):
        if module.name != "__main__":
            importlib.import_module(f"{room}.{module.name}")
            assert isinstance(getattr(face, module.name), ModuleType), f"{room}.{module.name} is no module"


def test_imports_of_kernels_are_lazy() -> None:
    kernels = {"OCP", "build123d", "cadquery", "matplotlib", "packingsolver", "spyrrow", "sunposition"}
    for path in modules():
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not kernels & {name.split(".")[0] for name in names}, path

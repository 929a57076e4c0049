"""Every example runs, and what it ships is what it makes."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np

from fabkit import design, load_project
from geometry.mesh import read_mesh

EXAMPLES = Path(__file__).parents[1] / "examples"


def test_the_roof_that_ships_is_the_roof_that_the_script_makes(tmp_path: Path) -> None:
    script = runpy.run_path(str(EXAMPLES / "roof.py"))
    script["write"](tmp_path / "roof.obj")
    assert (tmp_path / "roof.obj").read_bytes() == (EXAMPLES / "roof.obj").read_bytes()
    numbers = script["main"]()
    assert numbers["faces"] == 288
    assert numbers["planarity"] < 1e-13  # planes stay planes under a projective map
    shipped = read_mesh(EXAMPLES / "roof.obj")
    assert shipped.mended == ()
    assert shipped.mesh.face_normals[:, 2].min() > 0.5  # the outside is up
    assert np.abs(shipped.mesh.vertices - script["roof"]().vertices).max() <= 0.5e-4 + 1e-12  # four decimals


def test_the_project_file_that_ships_is_one() -> None:
    project = load_project(EXAMPLES / "roof.toml", {"nesting": {"mode": "off"}})
    built = design(project)
    assert built.assembly.name == "Freeform roof"
    assert {beam.section.name for beam in built.assembly.beams} == {"flat 40x140"}

"""Where the real meshes are, what they are called here, and each read only once."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from geometry.files import read_mesh
from geometry.mesh import Mesh

DATA = Path(__file__).parents[2].parent / "shared" / "data"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="the folder of real meshes is not beside the project")

CONICAL = "dos/conical1.obj"
SIX_ARMED = "dos/planarizednormalized_six_quad.obj"
BOTANIC = "dos/botanic-garden-bubble-0.obj"
YAS = "libhedra/YasIsland.off"
GITTER = "libhedra/gitter.off"
HEXAGONAL = "libhedra/hexagonalminimal_plusgauss.off"
CATENOID = "libhedra/catenoid3.off"
CIRCULAR = "libhedra/circular_wo_boundary.off"
CONJUGATE = "directional/inspired_mesh_quads_Conjugate.off"


@cache
def read(name: str) -> Mesh:
    """The mesh in a file, mended."""
    return read_mesh(DATA / name).mesh

"""Structures of each connection, read back by OCCT: volumes to 1e-9 as the file says, nothing shared by neighbours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fabkit.detailing import detail
from fabkit.formats.step.files import write_step
from fabkit.production import share_equal_parts
from fabkit.rules import BeamRules, ConnectionRules, DetailingRules
from tests.fabkit.occt import HAS_KERNEL, solids_in
from tests.fabkit.test_trimmed_nodes import leaning_grid

pytestmark = [pytest.mark.kernel, pytest.mark.skipif(not HAS_KERNEL, reason="neither build123d nor CadQuery is here")]

SECTIONS = {"welded": "rhs 120x60x5", "hub": "tee 120x80x10x8", "bolted": "rhs 120x60x5"}
MOST_PAIRS = 150
"""Booleans take some 10 ms each."""


def volume(shape: Any) -> float:
    """By OCCT, of the shape as it was read."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    found = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, found)
    return float(found.Mass())


def common(first: Any, second: Any) -> float:
    """Volume that two solids share."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

    made = BRepAlgoAPI_Common(first, second)
    assert made.IsDone()
    return sum(volume(solid) for solid in solids_in(made.Shape()))


def shifted(solid: Any, z: float) -> Any:
    from OCP.gp import gp_Trsf, gp_Vec
    from OCP.TopLoc import TopLoc_Location

    move = gp_Trsf()
    move.SetTranslation(gp_Vec(0.0, 0.0, z))
    return solid.Moved(TopLoc_Location(move))


@pytest.mark.parametrize("kind", SECTIONS)
def test_solids_are_valid_and_neighbours_share_nothing(kind: str, tmp_path: Path) -> None:
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_Reader

    rules = DetailingRules(BeamRules(section=SECTIONS[kind]), ConnectionRules(kind=kind))  # type: ignore[arg-type]
    made = share_equal_parts(detail(leaning_grid(0.1, 2, 2), rules, name="grid").assembly, within_mm=1e-7)
    with open(tmp_path / "grid.step", "w") as stream:
        write_step(stream, made)
    reader = STEPControl_Reader()
    assert reader.ReadFile(str(tmp_path / "grid.step")) == IFSelect_ReturnStatus.IFSelect_RetDone
    reader.TransferRoots()
    solids = solids_in(reader.OneShape())
    parts = list(made.parts())
    assert len(solids) == len(parts)
    corners = [part.placement.to_world(part.solid.vertices) for part in parts]
    volumes = [volume(solid) for solid in solids]
    assert volumes == pytest.approx([part.solid.volume_mm3 for part in parts], rel=1e-9)
    assert all(BRepCheck_Analyzer(solid).IsValid() for solid in solids)

    low, high = (np.array([side(each, axis=0) for each in corners]) for side in (np.min, np.max))
    meet = (np.maximum(low[:, None], low) <= np.minimum(high[:, None], high)).all(axis=2)
    near = np.argwhere(np.triu(meet, 1)).tolist()
    chosen = np.random.default_rng(0).permutation(len(near))[:MOST_PAIRS]
    assert max(common(solids[near[k][0]], solids[near[k][1]]) for k in chosen) < 1e-3
    kinds = [part.kind.name for part in parts]
    beam, panel = next(pair for pair in near if [kinds[k] for k in pair] == ["beam", "panel"])
    assert common(solids[beam], shifted(solids[panel], -30.0)) > 1.0  # the judge finds what does overlap

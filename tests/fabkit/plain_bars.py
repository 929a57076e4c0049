"""Solid bars in contact with the blocks that enclose their ends, under thin panes with narrow joints and sheets used to
their edges: the shop of tests whose subject is not the default one."""

from __future__ import annotations

from typing import Any

from fabkit.project import Project
from fabkit.rules import DetailingRules
from geometry.mesh.shapes import dome

__all__ = ["PLAIN_RULES", "PLAIN_TABLES"]

PLAIN_TABLES: dict[str, Any] = {
    "beams": {"width_mm": 50, "height_mm": 120, "material": "steel"},
    "connection": {"kind": "contact"},
    "nodes": {"top": "enclosing", "material": "steel"},
    "layers": [{"thickness_mm": 10, "joint_mm": 10, "seat_mm": 5}],
    "sheets": {"gap_mm": 10, "border_mm": 10},
}
"""The tables of a project file that say so."""

PLAIN_RULES: DetailingRules = Project(mesh=dome(4, 1), mean_edge_mm=1500, **PLAIN_TABLES).rules

"""Which section the bar of each edge has, and at which level it lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fabkit.parts import Section
from fabkit.rules import BeamRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.mesh import Mesh

__all__ = ["BarSections"]


@dataclass(frozen=True, eq=False)
class BarSections:
    """The sections of the bars on E edges. sections: the different ones; of_edge (E,): index into them. levels (E, 2):
    in mm, of the inner and the outer side of each bar above the mesh edge on which it stands."""

    sections: tuple[Section, ...]
    of_edge: IntArray
    levels: FloatArray

    @classmethod
    def of(cls, mesh: Mesh, rules: BeamRules) -> BarSections:
        """Edges of the boundary have a section of their own where the rules have one for them."""
        sections = rules.sections
        of_edge = np.where(mesh.combinatorics.is_boundary_edge, len(sections) - 1, 0)
        heights = np.array([section.height_mm for section in sections])[of_edge]
        outer = {"outer": 0.0, "glass": 0.0, "centre": 0.5, "inner": 1.0}[rules.reference] * heights
        return cls(sections, of_edge, np.stack([outer - heights, outer], axis=1))

    @property
    def widths(self) -> FloatArray:
        """(E,) in mm."""
        return np.array([section.width_mm for section in self.sections])[self.of_edge]

    @property
    def webs(self) -> FloatArray:
        """(E,) thicknesses of webs in mm; of sections without a web the widths."""
        return np.array([section.web_mm for section in self.sections])[self.of_edge]

    @property
    def flanges(self) -> FloatArray:
        """(E,) thicknesses of flanges in mm, 0 without."""
        return np.array([section.flange_mm for section in self.sections])[self.of_edge]

    @property
    def are_round(self) -> BoolArray:
        """(E,)"""
        return np.array([section.is_round for section in self.sections])[self.of_edge]

    @property
    def are_tees(self) -> BoolArray:
        """(E,)"""
        return np.array([section.shape == "tee" for section in self.sections])[self.of_edge]

    @property
    def at_ends(self) -> tuple[FloatArray, FloatArray]:
        """(2E,) levels of the inner, and of the outer side of the bar of each end."""
        inner, outer = np.repeat(self.levels, 2, axis=0).T
        return inner, outer

    @property
    def half_widths(self) -> FloatArray:
        """(2E,) half of the width of the bar of each end in mm."""
        return np.repeat(self.widths / 2, 2)

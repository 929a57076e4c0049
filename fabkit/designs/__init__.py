"""Edge offset meshes to start from: M and S from a few numbers, so that beams of one height align at all nodes."""

from fabkit.designs.constant_curvature import cmc_design, cmc_near_design, minimal_design
from fabkit.designs.edge_offset_design import EdgeOffsetDesign, write_design
from fabkit.designs.hexagons import hexagons_design
from fabkit.designs.koebe import koebe_design
from fabkit.designs.span_and_rise import COVERAGE_RANGE, TURN_RANGE_DEG, with_rise, with_span

__all__ = [
    "COVERAGE_RANGE",
    "TURN_RANGE_DEG",
    "EdgeOffsetDesign",
    "cmc_design",
    "cmc_near_design",
    "hexagons_design",
    "koebe_design",
    "minimal_design",
    "with_rise",
    "with_span",
    "write_design",
]

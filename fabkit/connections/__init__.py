"""What joins beams to nodes: bolts and their bores, reach inside hollow sections, tubes of hubs. Numbers and arrays
over beam ends only; the parts are made in detailing."""

from fabkit.connections.bolts import BOLT_SIZES, BoltGroup, BoltSize
from fabkit.connections.bores import (
    LEAST_EDGE_RATIO,
    LEAST_PITCH_RATIO,
    LEAST_WALL_MM,
    bored_setbacks,
    largest_inclination,
    slot_setbacks,
)
from fabkit.connections.tubes import TUBE_DIAMETERS_MM, least_radius_for_end, next_tube

__all__ = [
    "BOLT_SIZES",
    "LEAST_EDGE_RATIO",
    "LEAST_PITCH_RATIO",
    "LEAST_WALL_MM",
    "TUBE_DIAMETERS_MM",
    "BoltGroup",
    "BoltSize",
    "bored_setbacks",
    "largest_inclination",
    "least_radius_for_end",
    "next_tube",
    "slot_setbacks",
]

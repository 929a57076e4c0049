"""Solids of a workshop: hollow sections, tees, round bars and tubes, plates and blocks with bores, bolts."""

from __future__ import annotations

import numpy as np

from fabkit.parts import (
    SHAFT,
    Section,
    Solid,
    bore_vertices,
    prism_topology,
    prism_vertices,
    profile_topology,
    profile_vertices,
    round_vertices,
    shaft_topology,
)
from geometry.arrays import FloatArray

__all__ = ["SOLIDS", "block", "bolt", "profile", "regular", "round_bar", "tube"]

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def regular(n: int, radius: float) -> FloatArray:
    """(n, 2) corners of a regular polygon."""
    angles = 2 * np.pi * np.arange(n) / n
    return radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def profile(name: str, first: float = 0.0, second: float = 0.0, length: float = 800.0) -> Solid:
    """A bar with its ends mitred by these slopes in the plane of its height."""
    section = Section.of(name)
    planes, radii = (np.array([0.0, 0.0, first]), np.array([length, 0.0, second])), section.corner_radii
    return Solid(profile_vertices(section.loops, *planes, radii=radii), profile_topology(section.loops, radii))


def round_bar(radius: float, first: FloatArray, second: FloatArray) -> Solid:
    return Solid(round_vertices([radius], first, second), shaft_topology())


def tube(radius: float, inner: float, first: FloatArray, second: FloatArray) -> Solid:
    return Solid(round_vertices([radius, inner], first, second), shaft_topology(hollow=True))


def block(lean: float = 0.0, radius: float = 8.0, depth: float = 30.0, n: int = 5) -> Solid:
    """A prism with a bore along its axis and a blind bore in the middle of each facet; its upper side leans along y."""
    outline = regular(n, 80.0)
    corners = prism_vertices(outline, 0.0, 90.0)
    corners[n:, 2] += lean * corners[n:, 1]
    topology = prism_topology(n).bored([(0, 1), *((2 + k, None) for k in range(n))])
    middles = (outline + np.roll(outline, -1, axis=0)) / 2
    inwards = -middles / np.linalg.norm(middles, axis=1, keepdims=True)
    starts = np.append(middles, np.full((n, 1), 45.0), axis=1)
    through = round_vertices([radius], np.zeros(3), np.array([90.0, 0.0, lean]))[:, [1, 2, 0]]
    bores = bore_vertices(starts, starts + depth * np.append(inwards, np.zeros((n, 1)), axis=1), radius, Z)
    return Solid(np.concatenate([corners, through, bores.reshape(-1, 3)]), topology)


def plate_with_bores() -> Solid:
    corners = prism_vertices(np.array([[0, 0], [200, 0], [180, 150], [0, 150.0]]), 0.0, 15.0)
    centres = np.array([[30.0, 30, 0], [150, 40, 0], [90, 100, 0]])
    bores = bore_vertices(centres, centres + 15 * Z, np.array([9.0, 11, 20]), X)
    return Solid(np.concatenate([corners, bores.reshape(-1, 3)]), prism_topology(4).bored([(0, 1)] * 3))


def bolt(head: int = 6) -> Solid:
    """An M20 x 80 with a head of so many corners, or a round one."""
    shank = bore_vertices(np.zeros(3), 80 * Z, 10.0, X)
    if head:
        topology = prism_topology(head).bored([(1, None)], sense=SHAFT)
        return Solid(np.concatenate([prism_vertices(regular(head, 17.0), -13.0, 0.0), shank]), topology)
    disc = bore_vertices(-13 * Z, np.zeros(3), 17.0, X)
    return Solid(np.concatenate([disc, shank]), shaft_topology().bored([(1, None)], sense=SHAFT))


def counterbored() -> Solid:
    """A plate with a bore whose upper half is wider: one bore begins in the bottom of the other."""
    topology = prism_topology(4).bored([(1, None)]).bored([(6, 0)])
    bores = bore_vertices(np.stack([40 * Z, 15 * Z]), np.stack([15 * Z, 0 * Z]), np.array([18.0, 11.0]), X)
    return Solid(np.concatenate([prism_vertices(regular(4, 90.0), 0.0, 40.0), bores.reshape(-1, 3)]), topology)


def beam_with_hand_hole(name: str = "rhs 120x60x5") -> Solid:
    """A hollow section with mitred ends, a hand hole in one wall, and bores through that wall and the opposite one."""
    bar = profile(name, 0.2, -0.1)
    outside = np.array([[300.0, 30, 20], [370.0, 30, 20], [370.0, 30, -20], [300.0, 30, -20]])
    topology = bar.topology.pierced(3, 7, 4).bored([(3, 7), (9, 5)])
    starts, ends = np.array([[500.0, 30, 10], [600.0, -25, 0]]), np.array([[500.0, 25, 10], [600.0, -30, 0]])
    bores = bore_vertices(starts, ends, 9.0, X).reshape(-1, 3)
    return Solid(np.concatenate([bar.vertices, outside, outside - [0, 5.0, 0], bores]), topology)


FLAT, END = np.zeros(3), np.array([300.0, 0.0, 0.0])

SOLIDS = {
    "hollow section, mitred": profile("rhs 120x60x5", 0.3, -0.5),
    "rounded section": profile("rhs 120x60x5 r10"),
    "rounded section, mitred": profile("rhs 120x60x8 rounded", 0.3, -0.5),
    "rounded section, sharp inside": profile("rhs 120x60x5 r4", 0.0, 0.4),
    "tee": profile("tee 120x80x10x8", 0.1, 0.1),
    "i": profile("i 120x80x10x8"),
    "round bar": round_bar(30.0, FLAT, END),
    "round bar, oblique": round_bar(30.0, np.array([0.0, 0.1, 0.2]), np.array([300.0, -0.2, -0.4])),
    "round bar, one end oblique": round_bar(30.0, FLAT, np.array([300.0, 0.0, 0.7])),
    "tube": tube(30.0, 26.0, FLAT, END),
    "tube, oblique": tube(30.0, 26.0, np.array([0.0, 0.0, 0.2]), np.array([300.0, 0.0, -0.4])),
    "hub": tube(38.05, 31.75, FLAT, np.array([120.0, 0, 0])),
    "plate with bores": plate_with_bores(),
    "counterbored plate": counterbored(),
    "block": block(),
    "block, leaning": block(0.3),
    "hand hole": beam_with_hand_hole(),
    "hand hole, rounded section": beam_with_hand_hole("rhs 120x60x5 r10"),
    "bolt": bolt(),
    "bolt, round head": bolt(0),
}

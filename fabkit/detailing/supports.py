"""Supports: a stub along the node axis from the bottom of a node to a base plate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fabkit.detailing.ends import Ends
from fabkit.detailing.nodes import NodeShapes
from fabkit.detailing.shapes.bars import bar_solids
from fabkit.errors import DetailingError
from fabkit.kinds import BASE_PLATE, STUB, BasePlateDetails, StubDetails
from fabkit.parts import Material, Parts, Section, Solids, bore_vertices, prism_topology, prism_vertices
from fabkit.rules import SupportRules
from geometry.arrays import BoolArray, FloatArray, IntArray
from geometry.gauss import SupportStructure
from geometry.mesh import Mesh

__all__ = ["make_supports", "supported_vertices"]

LEVEL_PLATE_COSINE = 0.5
"""Cosine of the angle between node axis and vertical up to which a base plate is level: at 60 degrees the cut of the
stub is twice as long as the stub is wide."""

LEAST_STUB_MM = 10.0
"""Least length in mm of the short side of a stub between its two cuts, for the two seams."""

SQUARE_STUB_SINE = 1e-9
"""Sine of the angle between node axis and normal of the plate up to which the cut of a stub is square: rounding."""

UP = np.array([0.0, 0.0, 1.0])


def supported_vertices(mesh: Mesh, rules: SupportRules) -> BoolArray:
    """(N,) the vertices that the rules choose, below_mm at the coordinates of this mesh. Raises DetailingError where a
    choice has none."""
    c = mesh.combinatorics
    chosen = np.zeros(mesh.n_vertices, dtype=bool)
    for vertex in rules.vertices:
        if vertex >= mesh.n_vertices or not c.is_used[vertex]:
            raise DetailingError(
                f"supports.vertices has vertex {vertex}, at which there is no node: vertices are counted from 0 to "
                f"{np.flatnonzero(c.is_used)[-1]}"
            )
        chosen[vertex] = True
    loops = c.boundary_loops
    if rules.loop is not None and (not loops or (rules.loop != "rim" and rules.loop >= len(loops))):
        has = f"{len(loops)} boundary loop{'s' if len(loops) > 1 else ''}, counted from 0" if loops else "no boundary"
        raise DetailingError(f"supports.loop is {rules.loop}, at which there is no support, as the mesh has {has}")
    if rules.loop is not None:
        own = loops if rules.loop == "rim" else [loops[rules.loop]]
        chosen[np.concatenate([np.asarray(loop) for loop in own])] = True
    if rules.below_mm is not None:
        low = c.is_used & (mesh.vertices[:, 2] < rules.below_mm)
        if not low.any():
            over = mesh.vertices[c.is_used, 2].min() - rules.below_mm
            raise DetailingError(
                f"supports.below_mm chooses no vertex: the lowest one is {over:.1f} mm above it; raise it by more"
            )
        chosen |= low
    return chosen


@dataclass(frozen=True, eq=False)
class _Places:
    """n supports. vertices (n,); starts (n, 3): middles of the lower sides of the nodes in mm; along (n, 3): unit
    directions of the stubs, downwards; normals (n, 3): of the plates, upwards; aside (n, 3): unit directions square to
    the stubs, towards which the plates rise; tangents (n,): of the angles between plates and square cuts."""

    vertices: IntArray
    starts: FloatArray
    along: FloatArray
    normals: FloatArray
    aside: FloatArray
    tangents: FloatArray


def _places(structure: SupportStructure, ends: Ends, nodes: NodeShapes, made: BoolArray) -> _Places:
    vertices = np.flatnonzero(made & np.isfinite(nodes.bottom))
    axes = structure.axes[vertices]
    normals = np.where((axes[:, 2] >= LEVEL_PLATE_COSINE)[:, None], UP, axes)
    cosines = np.einsum("nk,nk->n", axes, normals)
    rises = normals - cosines[:, None] * axes
    sines = np.linalg.norm(rises, axis=1)
    leans = sines > SQUARE_STUB_SINE
    first = ends.radial[ends.ring[ends.ring_starts[vertices]]]
    aside = np.where(leans[:, None], rises / np.where(leans, sines, 1.0)[:, None], first)
    starts = structure.mesh.vertices[vertices] + nodes.bottom[vertices, None] * axes
    return _Places(vertices, starts, -axes, normals, aside, np.where(leans, sines / cosines, 0.0))


def make_supports(
    structure: SupportStructure,
    ends: Ends,
    nodes: NodeShapes,
    made: BoolArray,
    rules: SupportRules,
    material: Material,
) -> tuple[Parts[Any], ...]:
    """Base plates and stubs at the vertices `made` (N,) that have a node. Raises DetailingError where a stub is too
    short for its oblique cut, or the cut too long for the plate."""
    places, section = _places(structure, ends, nodes, made), Section.of(rules.stub)
    _check(places, section, rules)
    return _plates(places, rules, material), _stubs(places, section, rules, material)


def _check(places: _Places, section: Section, rules: SupportRules) -> None:
    half = section.height_mm / 2
    shortest, reach = rules.length_mm - half * places.tangents, half * np.hypot(1.0, places.tangents)
    if len(short := np.flatnonzero(shortest < LEAST_STUB_MM)):
        worst = int(short[shortest[short].argmin()])
        raise DetailingError(
            f"the stub at vertex {places.vertices[worst]} (counted from 0) would be {shortest[worst]:.1f} mm long on "
            f"its short side, and at least {LEAST_STUB_MM:g} mm are needed: set supports.length_mm to "
            f"{np.ceil(rules.length_mm + LEAST_STUB_MM - shortest[worst]):g} or more"
        )
    if len(wide := np.flatnonzero(reach > rules.plate_mm / 2)):
        worst = int(wide[reach[wide].argmax()])
        raise DetailingError(
            f"the base plate at vertex {places.vertices[worst]} (counted from 0) is smaller than the cut of its stub, "
            f"which is {2 * reach[worst]:.1f} mm long: set supports.plate_mm to {np.ceil(2 * reach[worst]):g} or more"
        )


def _stubs(places: _Places, section: Section, rules: SupportRules, material: Material) -> Parts[StubDetails]:
    n, half = len(places.vertices), section.height_mm / 2
    first, second, names = np.zeros((n, 3)), np.zeros((n, 3)), np.empty(n, dtype=object)
    second[:, 0], second[:, 2] = rules.length_mm, places.tangents
    names[:] = section
    return Parts.each_its_own(
        STUB,
        places.vertices,
        bar_solids(section, first, second),
        origins=places.starts + half * places.aside,
        axes=np.stack([places.along, np.cross(places.aside, places.along), places.aside], axis=1),
        material=material,
        details=StubDetails(
            section=names,
            length_mm=rules.length_mm + half * places.tangents,
            cut_angle_deg=np.degrees(np.arctan(places.tangents)),
        ),
    )


def _plates(places: _Places, rules: SupportRules, material: Material) -> Parts[BasePlateDetails]:
    n, half, thickness = len(places.vertices), rules.plate_mm / 2, rules.plate_thickness_mm
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    box = prism_vertices(half * square, 0.0, thickness)
    centres = np.concatenate([(half - rules.hole_edge_mm) * square, np.zeros((4, 1))], axis=1)
    holes = bore_vertices(centres, centres + thickness * UP, rules.hole_mm / 2, np.array([1.0, 0.0, 0.0]))
    one = np.concatenate([box.reshape(-1, 3), holes.reshape(-1, 3)])
    tops = places.starts + rules.length_mm * places.along
    x = places.aside - np.einsum("nk,nk->n", places.aside, places.normals)[:, None] * places.normals
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    return Parts.each_its_own(
        BASE_PLATE,
        places.vertices,
        Solids.alike(np.tile(one, (n, 1, 1)), prism_topology(4).bored([(0, 1)] * 4)),
        origins=tops - thickness * places.normals,
        axes=np.stack([x, np.cross(places.normals, x), places.normals], axis=1),
        material=material,
        details=BasePlateDetails(
            side_mm=np.full(n, rules.plate_mm),
            thickness_mm=np.full(n, thickness),
            bores=np.full(n, f"4 x {rules.hole_mm:g}", dtype=object),
            lean_deg=np.degrees(np.arctan(places.tangents)),
        ),
    )

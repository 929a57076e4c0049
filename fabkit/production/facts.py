"""The facts of a build, defined once, so that report, workbook, terminal and manifest show the same ones."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fabkit.fitness.finding import named
from fabkit.kinds import PANEL, PanelDetails
from fabkit.parts import Assembly, Parts
from fabkit.production.nesting.nests import Nest
from fabkit.production.summary import GivenGaussImage, OptimisedGaussImage, Summary, SurfaceSummary
from geometry.errors import listed

__all__ = [
    "ANY_LINES",
    "LEAST_UNDIRECTED_SHARE",
    "REPORT",
    "SURFACE_DISTANCE",
    "TERMINAL",
    "WORKBOOK",
    "BuildFacts",
    "Fact",
    "build_facts",
]

REPORT, WORKBOOK, TERMINAL = "report", "workbook", "terminal"
EVERYWHERE = frozenset({REPORT, WORKBOOK, TERMINAL})
NOWHERE: frozenset[str] = frozenset()

LEAST_UNDIRECTED_SHARE = 0.01
"""Share of the area of a surface that is flat or spherical, above which it is reported."""

LEAST_STEP_MM = 0.05
"""Least step in mm between the outer sides of two panels that is reported: less is not seen."""

SURFACE_DISTANCE = "Distance of the vertices from the surface"

ANY_LINES = "any lines do there; they continue those around, or follow the longest direction"


@dataclass(frozen=True)
class Fact:
    """One fact. name: its label. values: numbers, or one text. form: format of the numbers, as `format` takes it; unit:
    of the numbers. note: a short explanation.

    keys: key of each value in the manifest, with dots where it is nested. shown: the documents that show it.

    >>> from fabkit.production import Fact
    >>> Fact("Edge lengths", (1455.31, 1602.88), ".1f", "mm").text
    '1455.3 to 1602.9 mm'
    """

    name: str
    values: tuple[float | str, ...]
    form: str = ""
    unit: str = ""
    note: str = ""
    keys: tuple[str, ...] = ()
    shown: frozenset[str] = EVERYWHERE

    @property
    def figures(self) -> str:
        """The values in words, without the unit: `1455.3 to 1602.9`."""
        texts = [value if isinstance(value, str) else format(value, self.form) for value in self.values]
        return (" to " if len(texts) == 2 else ", ").join(texts)

    @property
    def text(self) -> str:
        """The values in words: `1455.3 to 1602.9 mm`."""
        return f"{self.figures} {self.unit}".strip()


@dataclass(frozen=True)
class BuildFacts:
    """Facts about the mesh and its Gauss image, about the parts, and about the sheets.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> [fact.name for fact in built.facts.sheets if fact.keys]
    ['Sheets used']
    """

    mesh: tuple[Fact, ...]
    parts: tuple[Fact, ...]
    sheets: tuple[Fact, ...]

    @property
    def all(self) -> tuple[Fact, ...]:
        return *self.parts, *self.sheets, *self.mesh


def build_facts(summary: Summary, assembly: Assembly, nest: Nest | None) -> BuildFacts:
    """The facts about the mesh, the parts and the sheets of a build.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.production import build_facts
    >>> facts = build_facts(built.summary, built.assembly, built.nest)
    >>> [(fact.name, fact.text) for fact in facts.parts if fact.keys][:1]
    [('Beams', '30')]
    """
    return BuildFacts(tuple(_mesh(summary)), tuple(_parts(assembly)), tuple(_sheets(nest)))


def _mesh(summary: Summary) -> Iterator[Fact]:
    on_paper, lengths = frozenset({REPORT, WORKBOOK}), summary.edge_lengths_mm
    yield Fact("Mesh file", (summary.source,), shown=frozenset({WORKBOOK}))
    yield Fact("Unit of the mesh file", (summary.scale_mm,), "g", "mm", shown=frozenset({WORKBOOK}))
    yield Fact("Origin of the model", (summary.placed_at,), shown=on_paper)
    yield Fact("Vertices", (summary.n_vertices,), keys=("counts.vertices",), shown=on_paper)
    yield Fact("Edges", (summary.n_edges,), keys=("counts.edges",), shown=on_paper)
    yield Fact("Faces", (summary.n_faces,), keys=("counts.faces",), shown=on_paper)
    yield Fact("Boundaries", (summary.n_boundaries,), shown=on_paper)
    yield Fact("Edge lengths", (float(lengths.min()), float(lengths.max())), ".1f", "mm", shown=on_paper)
    if summary.surface is not None:
        yield from _surface(summary.surface)
        laid = summary.edge_length_shares_mm
        yield _shares("Most edges", laid, ".1f", "mm", "5 %, median, 95 % of their lengths", "surface.edge_length_mm")
    of_edge = ".1e", "of the face's mean edge"
    before = "Largest planarity, as read" if summary.surface is None else "Largest planarity, as laid"
    yield Fact(before, (summary.planarity_before,), *of_edge, keys=("planarity.before",))
    yield Fact("Largest planarity, as built", (summary.planarity_after,), *of_edge, keys=("planarity.after",))
    moved = EVERYWHERE if summary.largest_move_mm > 0 else NOWHERE
    yield Fact("Mean displacement of vertices", (summary.mean_move_mm,), ".3f", "mm", keys=("moved_mm.mean",))
    yield Fact("Largest displacement of a vertex", (summary.largest_move_mm,), ".3f", "mm", keys=("moved_mm.largest",))
    farthest, counted = (summary.farthest_vertex,), "counted from 0"
    yield Fact("Vertex displaced most", farthest, note=counted, keys=("moved_mm.vertex",), shown=moved)
    given = summary.gauss_image
    checksum = f"sha256 {given.sha256}" if isinstance(given, GivenGaussImage) else ""
    yield Fact("Gauss image", (summary.gauss_image_origin,), note=checksum)
    yield from _optimised(given) if isinstance(given, OptimisedGaussImage) else ()
    heights, leans = summary.height_shares, summary.lean_shares_deg
    yield _shares("Beam heights", heights, ".4f", "of nominal", "minimum, 2.5 %, median, 97.5 %, maximum", "heights")
    yield _shares("Lean of node axes from the normals", leans, ".2f", "degrees", "median, 95 %, maximum", "lean_deg")
    twist = float(np.abs(summary.twists_deg).max())
    yield Fact("Largest twist of a beam", (twist,), ".1e", "degrees", keys=("largest_twist_deg",))
    if summary.fin_direction:
        keys = tuple(f"fins.direction.{axis}" for axis in "xyz")
        yield Fact("Direction of the fins", summary.fin_direction, "+.3f", note="moves the Gauss image", keys=keys)
        shares, keys = tuple(100 * share for share in summary.fin_shade), ("fins.shade.upright", "fins.shade.leaning")
        yield Fact("Panels in the shade", shares, ".1f", "%", "with fins along the node axes, and as they are", keys)
    yield Fact("Panel underside above the mesh", (summary.underside_mm,), ".1f", "mm", keys=("panel_underside.mm",))
    yield Fact("Panel underside set by", (summary.underside_reason,), keys=("panel_underside.reason",))
    within, key = (summary.equal_within_mm,), ("equal_within_mm",)
    yield Fact("Tolerance of parts with one mark", within, ".2g", "mm", keys=key, shown=on_paper)


def _surface(laid: SurfaceSummary) -> Iterator[Fact]:
    on_paper = frozenset({REPORT, WORKBOOK})
    yield Fact("Design surface", (laid.n_triangles,), "d", "triangles", keys=("surface.triangles",))
    low, median = laid.crossing_deg
    crossing = f"median crossing angle of the lines {median:.0f} degrees, 95 % above {low:.0f} degrees"
    note = "lines of curvature" if laid.lines == "principal" else crossing
    yield Fact("Network of lines", (laid.lines,), note=note, keys=("surface.lines",))
    if laid.undirected_share > LEAST_UNDIRECTED_SHARE:
        share, what = (100 * laid.undirected_share,), f"% of the area: {ANY_LINES}"
        yield Fact("Flat or spherical", share, ".0f", what, keys=("surface.undirected_percent",))
    if len(laid.loop_lengths_mm) > 1:
        found = listed([f"{length:.0f}" for length in laid.loop_lengths_mm], len(laid.loop_lengths_mm))
        yield Fact("Boundary loops of the surface", (f"{found} mm long; all are kept",))
    yield Fact("Edges along the lines", (100 * laid.aligned_share,), ".1f", "%", "within 10 degrees", shown=on_paper)
    yield Fact("Quads", (100 * laid.quad_share,), ".1f", "% of the faces", keys=("surface.quad_percent",))
    yield Fact("Irregular inner vertices", (laid.irregular,), keys=("surface.irregular_vertices",))
    key = "surface.distance_mm"
    yield _shares(SURFACE_DISTANCE, laid.distance_shares_mm, ".1f", "mm", "median, 95 %, largest", key)
    if laid.smoothing_mm > 0:
        moved = (laid.smoothing_mm,)
        yield Fact("Largest smoothing of the surface", moved, ".1f", "mm", keys=("surface.smoothing_mm",))


def _optimised(image: OptimisedGaussImage) -> Iterator[Fact]:
    """What optimising changed; the manifest has these figures under gauss_image."""
    width = "before and after: from 2.5 to 97.5 %, over the median"
    yield Fact("Spread of beam heights, optimised", image.height_spread, ".4f", note=width)
    lean = "before and after, at 95 % of the nodes, from the normals of the surface"
    yield Fact("Lean of node axes, optimised", image.lean_p95_deg, ".1f", "degrees", lean)
    farthest = f"median and largest; vertex {image.farthest_vertex} moves most, counted from 0"
    yield Fact("Movement of vertices, optimised", image.moves_mm, ".1f", "mm", farthest)
    yield Fact("95 % of the vertices, optimised, from the surface within", (image.off_surface_p95_mm,), ".1f", "mm")
    if image.no_longer_convex:
        faces = f"faces {named([str(face) for face in image.no_longer_convex])}, counted from 0"
        yield Fact("Faces no longer convex", (len(image.no_longer_convex),), note=faces)


def _shares(name: str, shares: dict[str, float], form: str, unit: str, note: str, key: str) -> Fact:
    return Fact(name, tuple(shares.values()), form, unit, note, tuple(f"{key}.{share}" for share in shares))


def _parts(assembly: Assembly) -> Iterator[Fact]:
    total_mass, in_cells = 0.0, frozenset({WORKBOOK})
    for parts in assembly.groups:
        n_marks, mass = len(parts.mark_names), float(parts.masses_kg.sum())
        group, name = parts.kind.group, parts.kind.group.capitalize()
        note = f"{n_marks} mark{'' if n_marks == 1 else 's'}, {mass:,.0f} kg"
        yield Fact(name, (len(parts),), note=note, keys=(f"counts.{group}",))
        yield Fact(f"{name}, marks", (n_marks,), keys=(f"counts.marks.{group}",), shown=in_cells)
        yield Fact(f"{name}, mass", (mass,), ",.1f", "kg", shown=in_cells)
        total_mass += mass
    yield Fact("Mass", (total_mass,), ",.0f", "kg")
    yield from _zones(assembly)
    corners, far_ends = np.concatenate([np.zeros((1, 2)), *(parts.hidden_mm for parts in assembly.groups)]).max(axis=0)
    hidden = "Largest difference hidden in a mark"
    yield Fact(f"{hidden}, of corners", (float(corners),), ".2f", "mm", "in a coordinate", ("hidden_mm.corners",))
    note = "of beams, from the directions of the facets of a node"
    yield Fact(f"{hidden}, at far ends", (float(far_ends),), ".2f", "mm", note, ("hidden_mm.far_ends",))
    panels = assembly.of(PANEL)
    if len(panels):
        yield Fact("Area of the panels", (float(panels.details.area_mm2.sum()) * 1e-6,), ".2f", "m²")
        yield from _layers(panels)
    yield Fact("Left out", (len(assembly.left_out),), keys=("counts.left_out",), shown=NOWHERE)


def _zones(assembly: Assembly) -> Iterator[Fact]:
    """How many parts each zone has, and their mass."""
    zone = np.concatenate([np.zeros(0, dtype=np.int64), *(assembly.zones.of(parts) for parts in assembly.groups)])
    masses = np.concatenate([np.zeros(0), *(parts.masses_kg for parts in assembly.groups)])
    for number, name in enumerate(assembly.zones.names):
        own = zone == number
        note = f"{masses[own].sum():,.0f} kg"
        yield Fact(f"Parts in {name}", (int(own.sum()),), note=note, shown=frozenset({REPORT, WORKBOOK}))


def _layers(panels: Parts[PanelDetails]) -> Iterator[Fact]:
    """Where the layers of panels lie, how far apart they are, and their seats and steps."""
    own, on_paper = panels.details, frozenset({REPORT, WORKBOOK})
    n_layers = int(own.layer.max()) + 1
    lower, upper = np.full((2, n_layers, int(panels.elements.max()) + 1), np.nan)
    np.fmin.at(lower, (own.layer, panels.elements), own.underside_mm)
    np.fmax.at(upper, (own.layer, panels.elements), own.underside_mm + own.thickness_mm)
    stocks = panels.kind.stock(panels) if panels.kind.stock else [""] * len(panels)
    for number in range(n_layers if n_layers > 1 else 0):
        low, high = float(np.nanmin(lower[number])), float(np.nanmax(lower[number]))
        made_of = " / ".join(dict.fromkeys(stocks[k] for k in np.flatnonzero(own.layer == number).tolist()))
        keys = tuple(f"layers.{number}.{end}_mm" for end in ("lowest", "highest"))
        yield Fact(f"Layer {number}, lower side above the mesh", (low, high), ".1f", "mm", made_of, keys)
        if number:
            apart = lower[number - 1] - upper[number]
            ends = (float(np.nanmin(apart)), float(np.nanmax(apart)))
            name = f"Clear between layers {number - 1} and {number}"
            yield Fact(
                name, ends, ".1f", "mm", keys=(f"layers.{number}.least_clear_mm", f"layers.{number}.largest_clear_mm")
            )
    if not np.isnan(own.least_seats_mm.values).all():
        ends = (float(np.nanmin(own.least_seats_mm.values)), float(np.nanmax(own.largest_seats_mm.values)))
        note = "a wedge over the width of each beam, see panel_edges"
        yield Fact("Seats of the panels", ends, ".1f", "mm", note, ("seats_mm.least", "seats_mm.largest"), on_paper)
    steps = np.abs(own.steps_mm.values)
    if np.nan_to_num(steps).max(initial=0.0) >= LEAST_STEP_MM:
        found = (float(np.nanmedian(steps)), float(np.nanmax(steps)))
        keys = ("steps_mm.median", "steps_mm.largest")
        yield Fact("Steps between panels", found, ".1f", "mm", "median, largest; at the joints", keys)


def _sheets(nest: Nest | None) -> Iterator[Fact]:
    in_cells, key = frozenset({WORKBOOK}), ("counts.sheets",)
    if nest is None:
        yield Fact("Sheets used", (0,), keys=key, shown=NOWHERE)
        yield Fact("Panels were not nested", (), shown=in_cells)
        return
    used = 100 * nest.utilisation
    yield Fact("Sheets used", (nest.n_sheets,), note=f"{used:.0f} % of their area", keys=key)
    yield Fact("Utilisation", (used,), ".1f", "%", shown=in_cells)
    sizes = Counter(f"{sheet.length_mm:g} x {sheet.width_mm:g} mm" for sheet in nest.sheets)
    stock = next(iter(sizes)) if len(sizes) == 1 else ", ".join(f"{count} of {size}" for size, count in sizes.items())
    yield Fact("Stock", (stock or "no sheet",), shown=in_cells)
    yield Fact("Rotation of the panels", (nest.rotation,), shown=in_cells)
    yield Fact("Gap between panels", (nest.gap_mm,), "g", "mm", shown=in_cells)
    yield Fact("Border of a sheet", (nest.border_mm,), "g", "mm", shown=in_cells)
    yield Fact("Nested by", (nest.engine,), shown=in_cells)

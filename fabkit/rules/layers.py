"""What a shop decides about the layers of panels; all default dimensions of panels are here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, model_validator
from pydantic.dataclasses import dataclass

from fabkit.parts import BuildUp, CoatedSide, EdgeWork, Finish, Material, plate_of_glass
from fabkit.rules.lengths import Level, NotNegative, Positive
from fabkit.wording import echo

__all__ = ["LayerRules", "problem_of_layers", "problem_of_mirrored_panes"]

DEFAULT_BUILD_UP = "44.2"
"""Laminated glass: two plies of 4 mm and two foils of 0.38 mm (EN ISO 12543)."""


def _as_text(given: Any) -> Any:
    """44.2 without quotes is a number."""
    return f"{given:.10g}" if isinstance(given, int | float) and not isinstance(given, bool) else given


def _in_order(given: Any) -> Any:
    """A single surface, or several in order."""
    numbers = given if isinstance(given, list | tuple) else (given,)
    are_whole = all(isinstance(each, int) and not isinstance(each, bool) for each in numbers)
    return tuple(sorted(set(numbers))) if are_whole else numbers


Surfaces = Annotated[tuple[int, ...], BeforeValidator(_in_order)]
"""Numbers of coated surfaces: one of them, or a list."""

BuildUpName = Annotated[str, BeforeValidator(_as_text), AfterValidator(lambda text: BuildUp.of(text).name)]


@dataclass(frozen=True, config=ConfigDict(extra="forbid"))
class LayerRules:
    """One layer of panels: a plate over each face, or the panes of a build-up of glass with gaps between them.

    thickness_mm: of a single plate; build_up: instead, glass as the trade writes it from outside to inside, see
    `BuildUp`; by default 44.2. material: of the plate, or the glass of the panes.

    Where the layer lies, one of: z_mm, height of its lower side above the mesh, along the face normals; distance_mm,
    distance d of the parallel mesh M + d S in whose faces its lower side lies; parallel, the file of any mesh parallel
    to M, in the same unit and place, in whose faces its lower side lies. Negative heights are below the mesh. A layer
    without any lies at the lift, the minimum that clears beams and nodes, plus the seat: seat_mm, free height between
    the panels and the highest beam or node block under them, by default that of an inner gasket. lift: "one" for all
    panels, or "each" panel its own, with steps between them.

    joint_mm: gap between two panels, by default a clearance of 5 mm to a clamping strip on either side of its web of
    10 mm. edges: "square", or "mitred" parallel to the support planes, so that the joint is constant through the
    thickness. rim_step_mm: by how much the edges at the rim are cut back further. least_edge_mm: minimum length of an
    edge of a panel. edge_work: of all edges, "arrissed", "ground", "smooth ground" or "polished" (EN 12150-1). coating:
    number of the coated surface, counted from outside, two for each ply, or several of different panes.
    least_bearing_mm: minimum width over which a panel of the layer next above the beams lies above the
    beam at each of its edges; negative for panels that are held otherwise, and may end beside it.

    >>> from fabkit.rules import LayerRules
    >>> LayerRules(build_up="8 / 16 Ar / 44.2").total_mm, LayerRules(thickness_mm=10).panes_mm
    (32.76, ((0.0, 10.0),))
    """

    thickness_mm: Positive | None = None
    build_up: BuildUpName | None = None
    z_mm: Level | None = None
    distance_mm: Level | None = None
    parallel: Path | None = None
    joint_mm: NotNegative = 20.0
    seat_mm: NotNegative = 12.0
    lift: Literal["one", "each"] = "one"
    edges: Literal["square", "mitred"] = "square"
    rim_step_mm: NotNegative = 0.0
    least_edge_mm: Positive = 1.0
    least_bearing_mm: Level = 10.0
    material: str = "glass"
    edge_work: EdgeWork = "none"
    coating: Surfaces = ()

    @model_validator(mode="after")
    def _consistent(self) -> LayerRules:
        if self.thickness_mm is not None and self.build_up is not None:
            raise ValueError(
                f"build_up is {echo(self.build_up)} and thickness_mm given too, which is that of a single plate: take "
                "out one of the two"
            )
        if self.thickness_mm is None and self.build_up is None and self.material != "glass":
            raise ValueError(f"a layer of {echo(self.material)} needs its thickness_mm, or the build_up of glass")
        if self.thickness_mm is None and self.build_up is None:
            object.__setattr__(self, "build_up", DEFAULT_BUILD_UP)
        if len(self.heights) > 1:
            raise ValueError(
                f"{' and '.join(self.heights)} are given, and each says where the layer lies: take out all but one"
            )
        if self.heights and self.lift == "each":
            raise ValueError(
                f"lift is 'each', but {self.heights[0]} says where the layer lies: take out one of the two"
            )
        if problem := self._problem_of_coatings():
            raise ValueError(problem)
        return self

    @property
    def heights(self) -> tuple[str, ...]:
        """The keys given that say where the layer lies."""
        keys = ("z_mm", "distance_mm", "parallel")
        return tuple(key for key in keys if getattr(self, key) is not None)

    @property
    def is_at_lift(self) -> bool:
        """Whether the layer lies on beams and nodes, with a seat between."""
        return not self.heights

    @property
    def unit(self) -> BuildUp | None:
        """The build-up of the glass, None for a single plate."""
        return None if self.build_up is None else BuildUp.of(self.build_up)

    @property
    def total_mm(self) -> float:
        """Thickness of the layer, gaps included."""
        return self.unit.thickness_mm if self.unit is not None else self.thickness_mm or 0.0

    @property
    def panes_mm(self) -> tuple[tuple[float, float], ...]:
        """Height of the lower side of each pane above that of the layer, and its thickness; the outermost one first."""
        if self.unit is None:
            return ((0.0, self.total_mm),)
        return tuple(zip(self.unit.levels_mm, (pane.thickness_mm for pane in self.unit.panes), strict=True))

    def pane_materials(self, density_kg_m3: float) -> tuple[Material, ...]:
        """The material of each pane, the outermost one first; density_kg_m3: of the material."""
        material = Material(self.material, density_kg_m3)
        if self.unit is not None:
            found = tuple(pane.material(material) for pane in self.unit.panes)
        elif self.material == "glass":
            found = (plate_of_glass(self.total_mm, material),)
        else:
            found = (material,)
        return tuple(
            replace(each, name=f"{each.name} {finish.coated}".strip())
            for each, finish in zip(found, self.finishes, strict=True)
        )

    @property
    def finishes(self) -> tuple[Finish, ...]:
        """The finish of each pane, the outermost one first."""
        panes = (None,) if self.unit is None else self.unit.panes
        build_up = "" if self.unit is None else f"{self.material} {self.unit.name}"
        found, first = [], 1
        for pane in panes:
            last = first + 2 * (1 if pane is None else len(pane.plies_mm)) - 1
            coating = next((number for number in self.coating if first <= number <= last), 0)
            sides: dict[int, CoatedSide] = {0: "", first: "outside", last: "inside"}
            is_equal = not coating and (pane is None or pane.is_symmetric)
            found.append(Finish(build_up, self.edge_work, coating, sides.get(coating, "interlayer"), is_equal))
            first = last + 1
        return tuple(found)

    def _problem_of_coatings(self) -> str:
        """Why there are no such coatings, in a sentence; empty if there are."""
        plies = [1] if self.unit is None else [len(pane.plies_mm) for pane in self.unit.panes]
        panes = [number for number, count in enumerate(plies) for _ in range(2 * count)]
        name = self.unit.name if self.unit else f"a plate of {self.material}"
        if wrong := [number for number in self.coating if not 1 <= number <= len(panes)]:
            return (
                f"coating is {wrong[0]}, but {name} has surfaces 1 (outside) to {len(panes)}, two for each ply: take "
                "one of these"
            )
        on = [panes[number - 1] for number in self.coating]
        if twice := [pane for pane in on if on.count(pane) > 1]:
            return f"coating names two surfaces of pane {twice[0]} (counted from 0) of {name}: leave one of them out"
        return ""


def problem_of_mirrored_panes(layers: Sequence[LayerRules]) -> str:
    """Why no panes of these layers may be turned over, in a sentence; empty if some may.

    >>> from fabkit.rules import LayerRules, problem_of_mirrored_panes
    >>> problem_of_mirrored_panes([LayerRules(build_up="44.2")])
    ''
    >>> "surface 4 is coated" in problem_of_mirrored_panes([LayerRules(build_up="44.2", coating=(4,))])
    True
    """
    if any(finish.has_equal_faces for layer in layers for finish in layer.finishes):
        return ""
    coated = next((layer.coating for layer in layers if layer.coating), ())
    why = f"surface {coated[0]} is coated" if coated else "the plies of the laminate differ"
    return (
        f"marks.mirrored_panes is true, but the two faces of every pane differ ({why}), so that a mirror image is "
        "another piece: take out mirrored_panes"
    )


def problem_of_layers(layers: Sequence[LayerRules], *, is_below_glass: bool) -> str:
    """Why these layers cannot be made together, in a sentence; empty if they can. is_below_glass: whether the beams
    stand below the glass, whose outer faces lie on the mesh."""
    if not layers:
        return "layers is empty: leave it out for one pane of 44.2 on the beams, or name a layer"
    at_lift = [number for number, layer in enumerate(layers) if layer.is_at_lift]
    if len(at_lift) > 1:
        return (
            f"layers {' and '.join(map(str, at_lift))} (counted from 0) all lie at the lift: say where all but one of "
            "them lie, by z_mm or distance_mm"
        )
    if is_below_glass and at_lift != [0]:
        return (
            "beams.reference is 'glass', so the outer faces of layer 0 lie on the mesh: take out what says where "
            f"layer 0 lies{' and say where the others lie' if at_lift else ''}"
        )
    if is_below_glass and layers[0].lift == "each":
        return "beams.reference is 'glass', so the mesh says where layer 0 lies: take out its lift 'each'"
    return ""

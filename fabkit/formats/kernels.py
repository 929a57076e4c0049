"""Hand parts to people who script: exact solids for build123d and CadQuery, made by the OCCT kernel that both bring.

The two exclude each other in one environment, and nothing else here needs either; so they are imported only when one
of these functions is called.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import starmap
from typing import TYPE_CHECKING

import numpy as np

from fabkit.errors import FabkitError
from fabkit.formats.occt_solids import occt_solid
from fabkit.parts import Assembly, Frame, Part

if TYPE_CHECKING:
    import build123d
    import cadquery
    from OCP.gp import gp_Trsf

__all__ = ["to_build123d", "to_cadquery"]


def to_build123d(item: Part | Assembly) -> build123d.Solid | build123d.Compound:
    """A part in its own frame as a Solid, or an assembly as a Compound: structure / group / part, or
    structure / zone / group / part where it has zones.

    The structure's location is the origin of the assembly, so that parts stand where the mesh file has them.
    The label of a part is its mark, within an assembly its instance name, as in STEP files; the colour that of its
    kind; parts that share a mark share their shape. Raises FabkitError where build123d is not installed.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import to_build123d
    >>> block = to_build123d(built.assembly["nodes"][0])
    >>> block.label, len(block.faces())
    ('N001', 11)
    """
    try:
        import build123d
    except ModuleNotFoundError as error:
        raise _missing("build123d") from error

    def solid(part: Part) -> build123d.Solid:
        return build123d.Solid(occt_solid(part.solid), label=part.mark, color=build123d.Color(*part.kind.colour))

    def placed(part: Part, name: str) -> build123d.Solid:
        if part.mark not in shapes:
            shapes[part.mark] = solid(part)
        instance = shapes[part.mark].moved(build123d.Location(_occt_motion(part.placement)))
        instance.label = name
        return instance

    if isinstance(item, Part):
        return solid(item)
    shapes: dict[str, build123d.Solid] = {}
    children: list[build123d.Compound] = []
    for zone, groups in _tree(item):
        own = [build123d.Compound(label=name, children=list(starmap(placed, parts))) for name, parts in groups]
        children += [build123d.Compound(label=zone, children=own)] if zone else own
    structure = build123d.Compound(label=item.name, children=children)
    structure.location = build123d.Location(_occt_motion(Frame(item.origin_mm, np.eye(3))))
    return structure


def to_cadquery(item: Part | Assembly) -> cadquery.Workplane | cadquery.Assembly:
    """A part in its own frame as a Workplane, or an assembly as an Assembly: structure / group /
    part, or structure / zone / group / part where it has zones.

    The structure's location is the origin of the assembly, so that parts stand where the mesh file has them.
    The name of a part within an assembly is its instance name, as in STEP files; its colour that of its kind; parts
    that share a mark share their shape. Raises FabkitError where CadQuery is not installed.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import to_cadquery
    >>> to_cadquery(built.assembly["nodes"][0]).faces().size()
    11
    """
    try:
        import cadquery
    except ModuleNotFoundError as error:
        raise _missing("cadquery") from error

    if isinstance(item, Part):
        return cadquery.Workplane(cadquery.Solid(occt_solid(item.solid)))
    shapes: dict[str, cadquery.Solid] = {}
    place = cadquery.Location(_occt_motion(Frame(item.origin_mm, np.eye(3))))
    structure = cadquery.Assembly(name=item.name, loc=place)
    for zone, groups in _tree(item):
        outer = cadquery.Assembly(name=zone) if zone else structure
        for label, parts in groups:
            group = cadquery.Assembly(name=label)
            for part, name in parts:
                if part.mark not in shapes:
                    shapes[part.mark] = cadquery.Solid(occt_solid(part.solid))
                group.add(
                    shapes[part.mark],
                    name=name,
                    loc=cadquery.Location(_occt_motion(part.placement)),
                    color=cadquery.Color(*part.kind.colour),
                )
            outer.add(group)
        if zone:
            structure.add(outer)
    return structure


def _tree(assembly: Assembly) -> Iterator[tuple[str, list[tuple[str, list[tuple[Part, str]]]]]]:
    """Each zone that has parts, or an empty name where there are no zones, with the names of its groups and their parts
    with their own."""
    for number, zone in enumerate(assembly.zones.names or ("",)):
        groups = []
        for parts in assembly.groups:
            rows = np.flatnonzero(assembly.zones.of(parts) == number).tolist()
            if rows:
                names = parts.piece_names
                groups.append((f"{zone} {parts.kind.group}".strip(), [(parts[row], names[row]) for row in rows]))
        if groups:
            yield zone, groups


def _missing(package: str) -> FabkitError:
    return FabkitError(
        f'{package} is not installed; install it with: pip install "fabkit[{package}]" '
        "(build123d and CadQuery cannot share an environment)"
    )


def _occt_motion(placement: Frame) -> gp_Trsf:
    """The motion from the frame of a part to the world."""
    from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt, gp_Trsf

    x, _, z = placement.axes.tolist()
    motion = gp_Trsf()
    motion.SetTransformation(gp_Ax3(gp_Pnt(*placement.origin.tolist()), gp_Dir(*z), gp_Dir(*x)), gp_Ax3())
    return motion

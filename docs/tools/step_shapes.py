"""Shapes of a STEP file that this program wrote, for pictures; read without a CAD kernel.

Only what such a file has is understood: solids with planar faces and round ones, parts in groups. Of a planar face the
outline is drawn, of a round one the tube between its two circles.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from docs.tools.drawing import Shapes, polygons, tubes
from fabkit.formats.step import write_step
from fabkit.parts import Assembly
from geometry.arrays import FloatArray, IntArray

__all__ = ["StepShapes"]

ENTITY = re.compile(r"^#(\d+)=(\w*)\((.*?)\);$", re.MULTILINE | re.DOTALL)
REFERENCE = re.compile(r"#(\d+)")


@dataclass(frozen=True, eq=False)
class StepShapes:
    """entities: kind and arguments by number."""

    entities: Mapping[int, tuple[str, str]]

    @classmethod
    def read(cls, path: Path) -> StepShapes:
        text = path.read_text(encoding="ascii")
        return cls({int(number): (kind, arguments) for number, kind, arguments in ENTITY.findall(text)})

    @classmethod
    def written(cls, assembly: Assembly) -> StepShapes:
        """Of the file that is written for an assembly."""
        with TemporaryDirectory() as folder:
            write_step(Path(folder) / "model.step", assembly)
            return cls.read(Path(folder) / "model.step")

    def shapes(
        self,
        group: str,
        colour: str,
        *,
        elements: IntArray | None = None,
        width: float = 0.4,
        opacity: float = 1.0,
    ) -> Shapes:
        """The parts of a group in metres, or only those of some mesh elements; width: of the lines around their faces
        in pixels."""
        chosen = None if elements is None else set(elements.tolist())
        by_size: dict[int, list[FloatArray]] = {}
        by_radius: dict[float, list[FloatArray]] = {}
        for use, own, axes, origin in self._placed(group):
            if chosen is not None and self._element(use) not in chosen:
                continue
            for outline in self._outlines[own]:
                by_size.setdefault(len(outline), []).append(outline @ axes + origin)
            for radius, line in self._tubes[own]:
                by_radius.setdefault(radius, []).append(line @ axes + origin)
        flat = [polygons(np.stack(same) / 1000, colour, width=width, opacity=opacity) for same in by_size.values()]
        for radius, lines in by_radius.items():
            flat += tubes(np.stack(lines) / 1000, radius / 1000, colour)
        return flat

    def count(self, group: str) -> int:
        """Number of pieces of a group."""
        return len(self._placed(group))

    # --- entities

    def _texts(self, number: int) -> list[str]:
        return re.findall(r"'((?:[^']|'')*)'", self.entities[number][1])

    def _references(self, number: int) -> list[int]:
        return [int(each) for each in REFERENCE.findall(self.entities[number][1])]

    def _of(self, kind: str) -> list[int]:
        return [number for number, (name, _) in self.entities.items() if name == kind]

    def _numbers(self, number: int) -> FloatArray:
        text = self.entities[number][1]
        return np.array([float(each) for each in text[text.rindex("(") + 1 : text.index(")")].split(",")])

    def _frame(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Axes (3, 3) as rows, and the origin (3,), of a placement."""
        origin, z, x = (self._numbers(each) for each in self._references(number))
        return np.stack([x, np.cross(z, x), z]), origin

    # --- the tree of parts

    @cached_property
    def _products(self) -> dict[str, int]:
        """Definition of each product by its name."""
        names = {}
        for number in self._of("PRODUCT_DEFINITION"):
            formation = self._references(number)[0]
            names[self._texts(self._references(formation)[0])[0]] = number
        return names

    @cached_property
    def _uses(self) -> dict[int, tuple[int, int]]:
        """Definitions of the whole and of the part of each use of a part."""
        found = {number: self._references(number) for number in self._of("NEXT_ASSEMBLY_USAGE_OCCURRENCE")}
        return {number: (whole, part) for number, (whole, part) in found.items()}

    @cached_property
    def _places(self) -> dict[int, tuple[FloatArray, FloatArray]]:
        """Axes and origin of each use of a part."""
        places = {}
        for number in self._of("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION"):
            relation, shape = self._references(number)
            transformation = re.search(r"WITH_TRANSFORMATION\(#(\d+)\)", self.entities[relation][1])
            assert transformation is not None
            places[self._references(shape)[0]] = self._frame(self._references(int(transformation[1]))[1])
        return places

    def _element(self, use: int) -> int:
        """The mesh element in the name of a piece, as 7 in B001 e7."""
        found = re.search(r" [efv](\d+)", self._texts(use)[0])
        assert found is not None
        return int(found[1])

    def _placed(self, group: str) -> list[tuple[int, int, FloatArray, FloatArray]]:
        """Use, definition, axes and origin of all parts of a group."""
        if group not in self._products:
            return []
        whole = self._products[group]
        ((own, start),) = (self._places[use] for use, (_, part) in self._uses.items() if part == whole)
        placed = []
        for use, (used_in, part) in self._uses.items():
            if used_in == whole:
                axes, origin = self._places[use]
                placed.append((use, part, axes @ own, origin @ own + start))
        return placed

    # --- solids

    @cached_property
    def _solids(self) -> dict[int, int]:
        """The solid of each definition."""
        found = {}
        for number in self._of("SHAPE_DEFINITION_REPRESENTATION"):
            shape, representation = self._references(number)
            items = self._references(representation)
            solids = [item for item in items if self.entities[item][0] == "MANIFOLD_SOLID_BREP"]
            if solids:
                found[self._references(shape)[0]] = solids[0]
        return found

    def _faces(self, definition: int) -> list[list[int]]:
        """Bounds of each face of the solid of a definition, and its surface last."""
        (shell,) = self._references(self._solids[definition])
        return [self._references(face) for face in self._references(shell)]

    def _edges(self, bound: int) -> list[tuple[int, bool]]:
        """The edges of a loop in their order, and whether each runs as it is."""
        (loop,) = self._references(bound)
        return [(self._references(each)[0], ".T." in self.entities[each][1]) for each in self._references(loop)]

    @cached_property
    def _outlines(self) -> dict[int, list[FloatArray]]:
        """Corners (k, 3) of the outer loops of the planar faces of each definition; round ones have none."""
        found: dict[int, list[FloatArray]] = {}
        for definition in self._solids:
            found[definition] = []
            for face in self._faces(definition):
                corners = []
                for edge, runs in self._edges(face[0]):
                    ends = self._references(edge)
                    corners.append(self._numbers(self._references(ends[0 if runs else 1])[0]))
                if self.entities[face[-1]][0] == "PLANE" and len(corners) > 2:
                    found[definition].append(np.array(corners))
        return found

    @cached_property
    def _tubes(self) -> dict[int, list[tuple[float, FloatArray]]]:
        """Radius and ends (2, 3) of the axis of each round face of a shaft."""
        found: dict[int, list[tuple[float, FloatArray]]] = {}
        for definition in self._solids:
            found[definition] = []
            for face in self._faces(definition):
                kind, arguments = self.entities[face[-1]]
                curves = [self._references(edge)[2] for edge, _ in self._edges(face[0])]
                circles = [curve for curve in dict.fromkeys(curves) if self.entities[curve][0] in ("CIRCLE", "ELLIPSE")]
                if kind == "CYLINDRICAL_SURFACE" and len(circles) == 2:
                    centres = [self._frame(self._references(curve)[0])[1] for curve in circles]
                    found[definition].append((float(arguments.rsplit(",", 1)[1]), np.array(centres)))
        return found

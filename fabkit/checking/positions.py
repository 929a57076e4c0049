"""Positions: the parts of all kinds numbered consecutively."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from fabkit.parts import Assembly, Kind, Part, SolidArray
from geometry.arrays import BoolArray, IntArray, integers

__all__ = ["Positions"]


@dataclass(frozen=True, eq=False)
class Positions:
    """Positions of parts in the order of `assembly.parts()`."""

    assembly: Assembly

    @cached_property
    def starts(self) -> IntArray:
        """(G+1,): group g has the positions starts[g] .. starts[g+1] - 1."""
        return integers(np.cumsum([0, *(len(group) for group in self.assembly.groups)]))

    def of_layers(self, kind: Kind[Any]) -> IntArray:
        """(k,) the positions of the parts of a kind in all layers of beams, in the order of `Assembly.of_layers`."""
        kinds = [group.kind for group in self.assembly.groups]
        groups = [kinds.index(parts.kind) for parts in self.assembly.of_layers(kind) if len(parts)]
        return integers(
            np.concatenate(
                [np.zeros(0, dtype=np.int64), *(np.arange(self.starts[g], self.starts[g + 1]) for g in groups)]
            )
        )

    def __len__(self) -> int:
        return int(self.starts[-1])

    def __getitem__(self, position: int) -> Part:
        group = int(np.searchsorted(self.starts, position, side="right")) - 1
        return self.assembly.groups[group][position - int(self.starts[group])]

    def placed(self) -> list[SolidArray]:
        """All parts in world coordinates, by group and topology; SolidArray.parts: their positions."""
        return [
            replace(batch, parts=start + batch.parts)
            for group, start in zip(self.assembly.groups, self.starts[:-1].tolist(), strict=True)
            for batch in group.placed()
        ]

    def where(self, chosen: BoolArray) -> Assembly:
        """The assembly of the parts at these positions."""
        starts = self.starts.tolist()
        groups = (
            group.take(chosen[start:end])
            for group, start, end in zip(self.assembly.groups, starts[:-1], starts[1:], strict=True)
        )
        return replace(self.assembly, groups=tuple(groups))

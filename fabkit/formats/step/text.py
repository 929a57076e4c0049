"""The text of ISO 10303-21: strings, reals, and blocks of entities that can be numbered from any id."""

from __future__ import annotations

import re
from collections.abc import Sequence
from operator import itemgetter

import numpy as np
from pydantic_core import to_json

from fabkit.errors import OutputError
from geometry.arrays import FloatArray

__all__ = ["Block", "reals", "string"]

_SPECIAL = re.compile(r"['\\]|[^ -~\U00010000-\U0010ffff]+|[\U00010000-\U0010ffff]+")
_SINGLE_DIGIT_MANTISSA = re.compile(r"e(?<=[\[,-]\de)")


def string(text: str) -> str:
    """The text between the quotes of a STEP string: quotes and backslashes doubled, what is not printable ASCII as
    \\X2\\...\\X0\\, beyond 16 bits as \\X4\\...\\X0\\ (ISO 10303-21, 6.4.3)."""
    plain = text.isascii() and text.isprintable() and "'" not in text and "\\" not in text
    return text if plain else _SPECIAL.sub(_encoded, text)


def _encoded(run: re.Match[str]) -> str:
    special = run.group()
    if special in "'\\":
        return special * 2
    width, encoding = (4, "utf-32-be") if special > "\uffff" else (2, "utf-16-be")
    return f"\\X{width}\\{special.encode(encoding).hex().upper()}\\X0\\"


def reals(values: FloatArray) -> list[str]:
    """Finite numbers of any shape, flattened, each as the shortest STEP real that reads back as the same double.

    pydantic's JSON writer does this ten times faster than repr; JSON's `1e-7` is `1.E-7` in STEP. Raises OutputError
    where a number is not finite.
    """
    if not np.isfinite(values).all():
        raise OutputError("a number that is not finite cannot be written to a STEP file")
    text = to_json((values + 0.0).ravel().tolist()).decode("ascii")  # + 0.0 turns -0.0 into 0.0
    if "e" in text:
        text = _SINGLE_DIGIT_MANTISSA.sub(".E", text).replace("e", "E")
    return text[1:-1].split(",")


class Block:
    """The text of some entities, ready to be numbered and filled in many times.

    entities: without id and semicolon. `#<n>` refers to the n-th entity of the block, `#7` to an entity outside it,
    `%s` is filled in; an empty text leaves its id to be written later. n_ids: how many ids a block takes.

    Ids of a block are those of ten or a hundred that share their leading digits (or of several such groups), so only
    these few are put into text, not each id. The price is some unused ids at the end of a block, as the standard
    allows.
    """

    def __init__(self, entities: Sequence[str]) -> None:
        digits = 1 if len(entities) <= 10 else 2
        self._step = 100 if digits == 2 else 10
        self._n_groups = -(-len(entities) // self._step)
        self.n_ids = self._n_groups * self._step
        text = "".join(f"#<{n}>={entity};\n" for n, entity in enumerate(entities) if entity)
        tokens = re.split(r"<(\d+)>|%s", text)
        fields: list[int] = []
        self.n_values = 0
        for n, number in enumerate(tokens[1::2]):
            if number is None:
                fields.append(self._n_groups + self.n_values)
                self.n_values += 1
            else:
                group, rest = divmod(int(number), self._step)
                fields.append(group)
                tokens[2 * n + 2] = f"{rest:0{digits}d}{tokens[2 * n + 2]}"
        self._pick = itemgetter(*fields)
        self._tokens = tokens

    def first_id(self, free_id: int) -> int:
        """The smallest id at which this block may begin; free_id: the smallest free id, which must be positive."""
        return -(-free_id // self._step) * self._step

    def text(self, first_id: int, values: Sequence[str]) -> str:
        """The entities, numbered from first_id, with these values filled in one after the other."""
        group = first_id // self._step
        tokens = self._tokens.copy()
        tokens[1::2] = self._pick((*map(str, range(group, group + self._n_groups)), *values))
        return "".join(tokens)

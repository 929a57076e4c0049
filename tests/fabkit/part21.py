"""Just enough of ISO 10303-21 to read back what is written: instances by id, their values, what they refer to."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from fabkit.formats.step.files import write_part_step, write_step
from fabkit.parts import Assembly, Part
from geometry.arrays import FloatArray

__all__ = ["Instance", "Reference", "StepText", "coordinates", "written"]

_TOKEN = re.compile(
    r"""'(?P<string>(?:[^']|'')*)'|\#(?P<reference>[1-9][0-9]*)|\.(?P<enum>[A-Z][A-Z0-9_]*)\.|(?P<mark>[(),*$])
    |(?P<real>[+-]?[0-9]+\.[0-9]*(?:E[+-]?[0-9]+)?)|(?P<integer>[+-]?[0-9]+)|(?P<keyword>[A-Z][A-Z0-9_]*)|\s+""",
    re.VERBOSE,
)  # fmt: skip


@dataclass(frozen=True)
class Instance:
    """kind: the entity, "" for a complex one, whose values are its leaves as pairs (entity, values).

    Values: text; float; int; bool for .T. and .F.; other enumerations as ".X."; references as `Reference`; lists; None.
    """

    kind: str
    values: list[Any]


class Reference(int):
    """The id of another instance."""


class StepText:
    """A file as a dictionary of instances. Raises ValueError where it is not well-formed."""

    def __init__(self, text: str) -> None:
        head, data, tail = re.split(r"^(?:DATA;|ENDSEC;\nEND-ISO-10303-21;)\n", text, flags=re.MULTILINE)
        if not head.startswith("ISO-10303-21;\nHEADER;\n") or not head.endswith("ENDSEC;\n") or tail:
            raise ValueError("sections are not as they should be")
        self.header = head
        self.instances: dict[int, Instance] = {}
        for line in re.findall(r"(.*?);\n", data, flags=re.DOTALL):
            identifier, _, entity = line.partition("=")
            if not re.fullmatch(r"#[1-9][0-9]*", identifier):
                raise ValueError(f"no id: {line[:60]!r}")
            if int(identifier[1:]) in self.instances:
                raise ValueError(f"{identifier} twice")
            self.instances[int(identifier[1:])] = _instance(entity)

    def __getitem__(self, identifier: int) -> Instance:
        return self.instances[identifier]

    def all(self, kind: str) -> list[Instance]:
        return [instance for instance in self.instances.values() if instance.kind == kind]

    def references(self, value: Any = None) -> Iterator[int]:
        """All ids that a value refers to, or that anything in the file refers to."""
        if value is None:
            for instance in self.instances.values():
                yield from self.references(instance.values)
        elif isinstance(value, Reference):
            yield value
        elif isinstance(value, list | tuple):
            for each in value:
                if each is not None:
                    yield from self.references(each)


def _instance(text: str) -> Instance:
    tokens = list(_tokens(text))
    if tokens[0] == "(":
        leaves, at = [], 1
        while tokens[at] != ")":
            values, after = _list(tokens, at + 1)
            leaves.append((tokens[at][1], values))
            at = after
        return Instance("", leaves)
    values, after = _list(tokens, 1)
    if after != len(tokens):
        raise ValueError(f"more than one entity: {text[:60]!r}")
    return Instance(tokens[0][1], values)


def _tokens(text: str) -> Iterator[Any]:
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise ValueError(f"not ISO 10303-21: {text[at : at + 40]!r}")
        at = match.end()
        if match.lastgroup == "mark":
            yield match.group()
        elif match.lastgroup:
            yield match.lastgroup, match[match.lastgroup]


def _list(tokens: list[Any], at: int) -> tuple[list[Any], int]:
    """The values in parentheses that open at tokens[at], and where they end."""
    if tokens[at] != "(":
        raise ValueError("no list of values")
    values: list[Any] = []
    at += 1
    while tokens[at] != ")":
        if tokens[at] == ",":
            at += 1
        if tokens[at] == "(":
            value, at = _list(tokens, at)
        elif tokens[at][0] == "keyword":  # a typed value, as LENGTH_MEASURE(1.)
            inner, at = _list(tokens, at + 1)
            value = inner[0]
        else:
            value, at = _value(tokens[at]), at + 1
        values.append(value)
    return values, at + 1


def _value(token: Any) -> Any:
    if token == "$":
        return None
    if token == "*":
        return "*"
    kind, text = token
    if kind == "enum":
        return {"T": True, "F": False}.get(text, f".{text}.")
    convert = {"string": lambda s: s.replace("''", "'"), "reference": Reference, "real": float, "integer": int}
    return convert[kind](text)


def written(item: Assembly | Part, **options: Any) -> StepText:
    stream = io.StringIO()
    if isinstance(item, Part):
        write_part_step(stream, item, **options)
    else:
        write_step(stream, item, **options)
    return StepText(stream.getvalue())


def coordinates(file: StepText, identifier: int) -> FloatArray:
    return np.array(file[identifier].values[1])

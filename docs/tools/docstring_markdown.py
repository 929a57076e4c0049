"""Docstrings as Markdown for the site: examples in fences, parameters as code, operators escaped."""

from __future__ import annotations

import inspect
import re
from typing import Any

import griffe

EXAMPLE = re.compile(r"^>>> .*?(?=\n\n|\Z)", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"(```.*?```|`[^`]*`)", re.DOTALL)

DESCRIBED = re.compile(r"(?:^|(?<=[.;:] ))([a-zA-Z]\w*(?:, [a-zA-Z]\w*)*)(?= \([^()]*\):|:| \()", re.MULTILINE)
"""Names before a colon or a shape, at the beginning of a line or sentence."""


def as_markdown(text: str, names: set[str]) -> str:
    """names: parameters and fields, whose descriptions begin with "name:" or "name (shape):"."""
    text = EXAMPLE.sub(lambda found: f"```pycon\n{found[0]}\n```", inspect.cleandoc(text))
    parts = CODE.split(text)
    parts[::2] = [_prose(part, names) for part in parts[::2]]
    return "".join(parts)


def _prose(text: str, names: set[str]) -> str:
    def escaped(prose: str) -> str:
        return re.sub(r"([*_\\])", r"\\\1", prose).replace("<", "&lt;")

    parts = DESCRIBED.split(text)
    for place in range(1, len(parts), 2):
        described = parts[place].split(", ")
        is_named = names.issuperset(described)
        paragraph = "\n\n" if parts[place - 1].strip() else ""
        names_as_code = ", ".join(f"**`{name}`**" for name in described)
        parts[place] = paragraph + names_as_code if is_named else escaped(parts[place])
    parts[::2] = [escaped(part) for part in parts[::2]]
    return "".join(parts)


class DocstringMarkdown(griffe.Extension):
    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring:
            names = {parameter.name for parameter in getattr(obj, "parameters", ())}
            obj.docstring.value = as_markdown(obj.docstring.value, names | set(obj.members))

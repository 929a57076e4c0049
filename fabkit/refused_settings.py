"""What is wrong with the settings of a project, in sentences that name the key, what was found and what would do."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from itertools import accumulate
from typing import Any, get_args, get_type_hints

from pydantic import BaseModel, ValidationError

from fabkit.wording import echo

__all__ = ["problems", "truth_for_number"]

PLAIN = {
    "path_type": "A path in quotes is needed, as in 'roof.obj'",
    "tuple_type": "A list in brackets is needed",
    "too_long": "It has more than {max_length} entries",
    "dict_type": "A table is needed, as in {{ steel = 7850 }}",
    "model_type": "A table is needed",
    "dataclass_type": "A table is needed",
}
"""Sentences in place of those in which pydantic speaks of Python, by its types of errors; its numbers in braces."""

MAX_NAMED_KEYS = 24
"""Largest number of known keys that a sentence names: two lines of a terminal."""

MAX_PROBLEM_LETTERS = 400
"""Largest number of letters that describe the problems of one project."""


def problems(error: ValidationError, project: type[BaseModel]) -> str:
    """What is wrong with the settings of a project, an object of this class: the first, and as many more as three lines
    of a terminal have room for; of the rest, how many there are."""
    sentences = [_sentence(dict(problem), project) for problem in error.errors()]
    lengths = accumulate(len(sentence) + 2 for sentence in sentences)
    count = max(1, sum(length <= MAX_PROBLEM_LETTERS for length in lengths))
    more = len(sentences) - count
    return "; ".join(sentences[:count]) + (f"; and {more} more things" if more else "")


def truth_for_number(given: Any, made: Any, where: str = "") -> str:
    """A sentence about the first true or false of the settings from which something else was made, which pydantic takes
    for 1 and 0; empty where there is none."""
    if isinstance(given, bool):
        return "" if isinstance(made, bool) else f"{where} is {given}: a number is needed, not true or false"
    if isinstance(given, Mapping):
        parts = [
            (key, each, made.get(key, each) if isinstance(made, Mapping) else getattr(made, key, each))
            for key, each in given.items()
        ]
    elif isinstance(given, list | tuple) and isinstance(made, list | tuple):
        parts = [(number, *both) for number, both in enumerate(zip(given, made, strict=False))]
    else:
        return ""
    found = (truth_for_number(one, other, f"{where}.{key}".lstrip(".")) for key, one, other in parts)
    return next(filter(None, found), "")


def _table(parent: str, project: type[BaseModel]) -> Any:
    """The class of a table, by its name with dots: a field of a project, or of one of its tables."""
    table: Any = project
    for name in parent.split(".") if parent else ():
        if not name.isdecimal():
            found = get_type_hints(table)[name]
            table = next(each for each in (found, *get_args(found)) if hasattr(each, "__annotations__"))
    return table


def _sentence(problem: dict[str, Any], project: type[BaseModel]) -> str:
    where = ".".join(str(part) for part in problem["loc"])
    if problem["type"] in ("extra_forbidden", "unexpected_keyword_argument"):
        parent, _, key = where.rpartition(".")
        known = list(get_type_hints(_table(parent, project)))
        close = get_close_matches(key, known, n=1, cutoff=0.5)
        place = f"[{parent}]" if parent else "the project"
        more = f" and {len(known) - MAX_NAMED_KEYS} more" if len(known) > MAX_NAMED_KEYS else ""
        hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(known[:MAX_NAMED_KEYS])}{more}"
        return f"unknown key {echo(key)} in {place}; {hint}"
    if problem["type"] == "missing":
        return f"{where} is missing, and has to be given"
    plain, given = PLAIN.get(problem["type"]), problem["input"]
    message = plain.format(**problem.get("ctx", {})) if plain else problem["msg"].removeprefix("Value error, ")
    if problem["type"] == "tuple_type" and isinstance(given, Mapping):
        return f"{where} is one table: write [[{where}]] above it, as for the first of a list"
    if problem["type"] == "tuple_type" and given and isinstance(given, str):
        message += f", as in [{echo(given)}]"
    if not where or (problem["type"] == "value_error" and isinstance(given, Mapping)):
        return f"[{where}] {message}" if where else str(message)
    return f"{where} is {echo(given)}: {message[0].lower()}{message[1:]}"

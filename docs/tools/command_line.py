"""Writes docs/command-line.md, the reference of the command line, from the program itself."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterator
from enum import Enum
from pathlib import Path
from types import NoneType
from typing import Any, get_args, get_type_hints

import typer
from typer.models import ArgumentInfo, ParameterInfo

from fabkit.commands import app

PAGE = Path(__file__).parents[1] / "command-line.md"

VALUES = {Path: "PATH", str: "TEXT", int: "INTEGER", float: "NUMBER", bool: ""}


def page() -> str:
    """The whole page; `python docs/tools/command_line.py` writes it."""
    head = ["# Command line reference", "", "Made from the program by `docs/tools/command_line.py`.", ""]
    return "\n".join([*head, *_section("fabkit", app, "##")])


def _section(name: str, group: typer.Typer, heading: str) -> Iterator[str]:
    yield str(group.info.help)
    yield ""
    for command in group.registered_commands:
        assert command.callback is not None
        yield f"{heading} {name} {command.name}{_arguments(command.callback)}"
        yield ""
        yield from _command(command.callback)
    for each in group.registered_groups:
        assert each.typer_instance is not None
        yield f"{heading} {name} {each.name}"
        yield ""
        yield from _section(f"{name} {each.name}", each.typer_instance, f"{heading}#")


def _arguments(callback: Callable[..., Any]) -> str:
    return "".join(f" {info.metavar}" for _, _, info, _ in _parameters(callback) if isinstance(info, ArgumentInfo))


def _command(callback: Callable[..., Any]) -> Iterator[str]:
    yield inspect.getdoc(callback) or ""
    yield ""
    yield "| option | what it is |"
    yield "|---|---|"
    panel = None
    for key, kind, info, default in sorted(_parameters(callback), key=lambda row: row[2].rich_help_panel is not None):
        if info.rich_help_panel != panel:
            panel = info.rich_help_panel
            yield f"| **{panel}** | |"
        yield f"| {_name(key, kind, info)} | {_meaning(kind, info, default)} |"
    yield ""


def _parameters(callback: Callable[..., Any]) -> Iterator[tuple[str, Any, ParameterInfo, Any]]:
    """Name, type, declaration and default of each."""
    hints = get_type_hints(callback, include_extras=True)
    for key, parameter in inspect.signature(callback).parameters.items():
        annotation = hints[key]
        if infos := [each for each in getattr(annotation, "__metadata__", ()) if isinstance(each, ParameterInfo)]:
            yield key, annotation.__origin__, infos[0], parameter.default


def _value_type(kind: Any) -> Any:
    """What a value is, where it may be missing or repeated."""
    inner = [each for each in get_args(kind) if each is not NoneType]
    return _value_type(inner[0]) if inner else kind


def _name(key: str, kind: Any, info: ParameterInfo) -> str:
    if isinstance(info, ArgumentInfo):
        return f"`{info.metavar}`"
    value = _value_type(kind)
    choices = "\\|".join(str(each.value) for each in value) if issubclass(value, Enum) else ""
    shown = info.metavar or choices or VALUES[value]
    names = [each for each in (info.default, *(info.param_decls or ())) if isinstance(each, str)]  # as typer reads them
    names = names or [f"--{key.replace('_', '-')}"]
    return f"`{', '.join(names)}{' ' if shown else ''}{shown}`"


def _meaning(kind: Any, info: ParameterInfo, default: Any) -> str:
    if default is inspect.Parameter.empty and not isinstance(info, ArgumentInfo):
        return f"{info.help} Required."
    if default in (None, False, inspect.Parameter.empty):
        return str(info.help)
    return f"{info.help} Default: {default:g}." if isinstance(default, float) else f"{info.help} Default: {default}."


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")

"""Pages of one file that open offline in a browser: a head, a body, data and scripts; and the model that they show."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from html import escape
from importlib.resources import files
from string import Template

from fabkit.formats.report.text import json_text

__all__ = ["css_name", "html_page", "key_facts", "model_html", "part_of_page", "report_values"]

SHARED_SCRIPTS = ("model.js", "camera.js", "program.js", "viewer.js", "table.js", "controls.js")
"""Scripts of every page, before its own."""

FIND_IN_REPORT = "Find a mark or piece"
"""What the field beside the model of a build is for."""

REPORT_SCRIPTS = ("card.js", "page.js")
"""Scripts of the page of a build, after those."""


@cache
def _text(name: str) -> str:
    return files("fabkit.formats.report").joinpath(name).read_text(encoding="utf-8")


def part_of_page(name: str, /, **values: str) -> str:
    """A part of a page from its file; the values are HTML."""
    return Template(_text(name)).substitute(values)


def html_page(
    title: str,
    body: str,
    *,
    colours: Mapping[str, str],
    scripts: Sequence[str],
    data: object,
    more: str = "",
    style: str = "",
    issue: str = "",
) -> str:
    """The text of a page, which asks the network for nothing. title and issue, plain texts, stand on each printed page.

    colours: of the kinds of part by name, as CSS has them. data: for the scripts, as JSON; more: HTML with other data.
    """
    variables = " ".join(f"--kind-{css_name(name)}: {colour};" for name, colour in colours.items())
    foot = f"{title}, {issue}" if issue else title
    return part_of_page(
        "page.html",
        title=escape(title),
        style=f':root {{ {variables} --foot: "{_css_text(foot)}"; }}\n{style}{_text("page.css")}',
        body=body,
        data=json_text(data),
        more=more,
        script="".join(map(_text, (*SHARED_SCRIPTS, *scripts))),
    )


def _css_text(text: str) -> str:
    """A plain text between quotes of a style sheet; letters that could end it, or the element, as their numbers."""
    return "".join(letter if letter.isalnum() or letter in " ,.-" else f"\\{ord(letter):06x} " for letter in text)


def css_name(group: str) -> str:
    return group.replace(" ", "-")


def model_html(names: Iterable[str], *, find: str, colours: str = "") -> str:
    """The model and what is beside it. names: of its layers; find: what can be found in it; colours: HTML with what
    else can be chosen."""
    layers = "\n".join(
        f'<label><input type="checkbox" value="{escape(name)}" checked>'
        f'<i style="background: var(--kind-{css_name(name)})"></i>{escape(name.capitalize())}</label>'
        for name in names
    )
    return part_of_page("model.html", layers=layers, find=find, colours=colours)


def key_facts(facts: Iterable[tuple[str, str, str]]) -> str:
    """Names, values and notes, plain texts, as the boxes at the head of a page."""
    return "\n".join(
        f"<div><dt>{escape(name)}</dt><dd>{escape(value)}{f' <small>{escape(note)}</small>' if note else ''}</dd></div>"
        for name, value, note in facts
    )


def report_values(page: str) -> dict[str, str]:
    """What stands in a page of a build in the places of the values of its templates. Raises ValueError where the rest,
    its program or its style are not those of this version.

    >>> from fabkit import Project, build
    >>> from geometry.mesh.shapes import dome
    >>> from pathlib import Path
    >>> from fabkit.formats.report import report_values
    >>> _ = build(Project(mesh=dome(4, 1), mean_edge_mm=1500, out="roof"))
    >>> report_values(Path("roof/report.html").read_text())["name"]
    'structure'
    """
    model = _text("model.html").replace("$colours", _text("colours.html")).replace("$find", FIND_IN_REPORT)
    template = _text("page.html").replace("$body", _text("report.html").replace("$model", model))
    first, *rest = re.split(r"\$(\w+)", template)
    at, found = len(first), {}
    for name, fixed in zip(rest[::2], rest[1::2], strict=True):
        end = page.index(fixed, at) if fixed else at
        found[name], at = page[at:end], end + len(fixed)
    scripts = "".join(map(_text, (*SHARED_SCRIPTS, *REPORT_SCRIPTS)))
    if not page.startswith(first) or at != len(page) or found["script"] != scripts:
        raise ValueError
    if not found["style"].endswith(_text("page.css")):
        raise ValueError
    return found

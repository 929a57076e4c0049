"""report.html: what was built, as one file that opens offline in a browser.

The file asks the network for nothing: model, style and scripts are in it. It says nothing of when or where it was
written, so the same input gives the same bytes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

import numpy as np

from fabkit.formats.report.figures import histogram, sheet_picture
from fabkit.formats.report.fitness import fitness_html
from fabkit.formats.report.model import model_data
from fabkit.formats.report.tables import cells_data, table_html
from fabkit.formats.report.text import json_text
from fabkit.formats.shown import left_out_bars, placed_parts
from fabkit.kinds import BEAM, NODE
from fabkit.parts import LEFT_OUT_COLOUR, Assembly, Measure, Parts, Surroundings
from fabkit.production import REPORT, SURFACE_DISTANCE, BuildFacts, Drawing, Fact, Summary, Table
from geometry.arrays import FloatArray

__all__ = ["report_html"]

_SCRIPTS = (
    "model.js",
    "camera.js",
    "program.js",
    "viewer.js",
    "table.js",
    "card.js",
    "page.js",
)

PRINTED_SHEETS = 96
"""Largest number of sheets whose pictures are printed with the report: more than fit two pages help nobody."""
_AROUND = (("Ends and facets", "node_facets", "Node", "Beam"), ("Edges", "panel_edges", "Panel", "Beam"))
"""What is shown around a part that is picked: heading, table, and the columns that may name the part."""


def report_html(
    *,
    summary: Summary,
    facts: BuildFacts,
    assembly: Assembly,
    tables: Sequence[Table],
    pieces: Sequence[Table],
    sheets: Sequence[Drawing],
    left_out_lines: FloatArray | None = None,
) -> str:
    """The text of the file. tables: of the cut list. pieces: of `piece_tables`, which the page shows of a part that is
    picked. left_out_lines (n, 2, 3), in mm: the ends of the edges of the beams that are left out.

    Names and notes from files are escaped wherever they stand.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats.report import report_html
    >>> from fabkit.production import cut_list, piece_tables
    >>> lists = {"tables": cut_list(built.assembly, built.nest).tables, "pieces": piece_tables(built.assembly, None)}
    >>> page = report_html(summary=built.summary, facts=built.facts, assembly=built.assembly, sheets=(), **lists)
    >>> "<h1>structure</h1>" in page
    True
    """
    listed = {table.title: table for table in pieces}
    measured = [each for group in assembly.groups if len(group) for each in group.kind.measures(group)]
    room = files("fabkit.formats.report")
    page = Template(room.joinpath("page.html").read_text(encoding="utf-8"))
    layers = [(parts.kind.group, placed_parts(parts)) for parts in assembly.groups]
    model, arrays = model_data([*layers, ("left out", left_out_bars(assembly, left_out_lines))])
    return page.substitute(
        name=escape(summary.name),
        source=f"from {escape(summary.source)}, in units of {summary.scale_mm:g} mm",
        style=_colours(assembly) + room.joinpath("page.css").read_text(encoding="utf-8"),
        script="".join(room.joinpath(name).read_text(encoding="utf-8") for name in _SCRIPTS),
        key_facts=_key_facts([*facts.parts, *facts.sheets]),
        left_out=_left_out(assembly),
        fitness=fitness_html(summary.fitness, assembly),
        layers=_layers(assembly),
        mesh_facts=_mesh_facts(facts.mesh),
        mended=_mended(summary),
        deviations=_deviations(summary, assembly),
        histograms=_histograms([*measured, *_of_surface(summary)]),
        sheets_link='<a href="#sheets">Sheets</a>' if sheets else "",
        sheets=_sheets(sheets),
        tables="\n".join(table_html(table) for table in tables),
        data=json_text(
            {
                "forms": {group.kind.group: group.kind.form for group in assembly.groups},
                "labels": _labels(assembly),
                "measures": [_measure_data(measure) for measure in measured],
                "tables": {table.title: cells_data(table) for table in tables},
                "pieces": cells_data(listed["pieces"]),
                "around": [[head, cells_data(listed[title]), *names] for head, title, *names in _AROUND],
                "model": model,
            }
        ),
        arrays=arrays,
    )


def _colours(assembly: Assembly) -> str:
    """The colours of the kinds of part, as variables of the style sheet and in their histograms."""
    groups = {group.kind.group: group.kind.colour for group in assembly.groups}
    shades = groups | {"left out": LEFT_OUT_COLOUR}
    hexes = {_css_name(name): "".join(f"{round(255 * c):02x}" for c in colour) for name, colour in shades.items()}
    variables = " ".join(f"--kind-{name}: #{value};" for name, value in hexes.items())
    fills = "".join(f".{name} rect {{ fill: var(--kind-{name}); }}\n" for name in map(_css_name, groups))
    return f":root {{{variables}}}\n{fills}"


def _css_name(group: str) -> str:
    return group.replace(" ", "-")


def _key_facts(facts: Sequence[Fact]) -> str:
    return "\n".join(
        f"<div><dt>{escape(fact.name)}</dt><dd>{escape(fact.text)} <small>{escape(fact.note)}</small></dd></div>"
        for fact in facts
        if REPORT in fact.shown
    )


def _left_out(assembly: Assembly) -> str:
    """A red box that lists every part that was not made; empty if all were made."""
    if not assembly.left_out:
        return ""
    kinds = Counter(left.kind for left in assembly.left_out)
    counted = ", ".join(f"{count} {kind}{'s' if count > 1 else ''}" for kind, count in kinds.items())
    items = "\n".join(f"<li>{escape(left.reason)}</li>" for left in assembly.left_out)
    return (
        f'<div class="left-out" role="alert"><h2>Left out: {escape(counted)}</h2>'
        "<p>This structure is not complete. Beams that are left out are shown in red in the "
        f"model.</p><ul>\n{items}\n</ul></div>"
    )


def _layers(assembly: Assembly) -> str:
    names = [group.kind.group for group in assembly.groups if len(group)]
    if any(left.kind == BEAM.name for left in assembly.left_out):
        names.append("left out")
    return "\n".join(
        f'<label><input type="checkbox" value="{name}" checked>'
        f'<i style="background: var(--kind-{_css_name(name)})"></i>{name.capitalize()}</label>'
        for name in names
    )


def _mesh_facts(facts: Sequence[Fact]) -> str:
    return "\n".join(
        f'<tr><th scope="row">{escape(fact.name)}</th><td{_is_text(fact)}>{escape(fact.text)}{_note(fact)}</td></tr>'
        for fact in facts
        if REPORT in fact.shown
    )


def _is_text(fact: Fact) -> str:
    return ' class="text"' if any(isinstance(value, str) for value in fact.values) else ""


def _note(fact: Fact) -> str:
    return f"<br><small class='soft'>{escape(fact.note)}</small>" if fact.note else ""


def _mended(summary: Summary) -> str:
    if not summary.mended:
        return '<p class="soft">Nothing: the file was used as it is.</p>'
    items = "\n".join(f"<li>{escape(sentence)}</li>" for sentence in summary.mended)
    return f'<ul class="mended">\n{items}\n</ul>'


def _deviations(summary: Summary, assembly: Assembly) -> str:
    """Median, 95th percentile and maximum of values that are zero for an ideal mesh, and the part with the maximum."""
    rows = []
    for nodes in (nodes for nodes in assembly.of_layers(NODE) if len(nodes)):
        own, which = nodes.details, nodes.kind.name
        rows.append(_deviation(f"Step between beam tops at a {which}, mm", own.top_step_mm, ".2f", nodes))
        title = f"Misalignment of the beams at the axis of a {which}, mm"
        rows.append(_deviation(title, own.axis_misalignment_mm, ".2f", nodes))
    for beams in (beams for beams in assembly.of_layers(BEAM) if len(beams)):
        which, deviation = beams.kind.name, np.abs(beams.details.height_deviation_mm)
        title = f"Deviation of the parallel meshes from the height of a {which}, mm"
        rows.append(_deviation(title, deviation, ".2f", beams))
        rows.append(_deviation(f"Twist of a {which}, °", np.abs(beams.details.twist_deg), ".1e", beams))
    return "\n".join(rows)


def _deviation(title: str, values: FloatArray, form: str, parts: Parts[Any]) -> str:
    figures = (np.median(values), np.percentile(values, 95), values.max())
    cells = "".join(f"<td>{figure:{form}}</td>" for figure in figures)
    worst = escape(parts.mark_names[parts.mark[values.argmax()]])
    return f'<tr><th scope="row">{title}</th>{cells}<td><button type="button" class="mark">{worst}</button></td></tr>'


def _of_surface(summary: Summary) -> Sequence[Measure]:
    """What is measured of the vertices of a mesh that was laid on a surface."""
    laid = summary.surface
    return () if laid is None else (Measure("surface", SURFACE_DISTANCE, "mm", 1, laid.distances_mm),)


def _histograms(measured: Sequence[Measure]) -> str:
    groups: dict[str, list[str]] = {}
    for measure in measured:
        groups.setdefault(measure.group, []).append(histogram(measure))
    return "\n".join(
        f'<h3>{name.capitalize()}</h3><div class="histograms {_css_name(name)}">{"".join(figures)}</div>'
        for name, figures in groups.items()
    )


def _sheets(sheets: Sequence[Drawing]) -> str:
    if not sheets:
        return ""
    pictures = "\n".join(sheet_picture(sheet) for sheet in sheets[:PRINTED_SHEETS])
    later = "\n".join(sheet_picture(sheet) for sheet in sheets[PRINTED_SHEETS:])
    note = f'<p class="printed-rows">The first {PRINTED_SHEETS} of {len(sheets)} sheets.</p>' if later else ""
    return (
        f'<section id="sheets">\n<h2>Sheets</h2>\n<div class="sheets">\n{pictures}\n'
        f'<div class="later">{later}</div>\n</div>{note}\n</section>'
    )


def _measure_data(measure: Measure) -> dict[str, object]:
    rounded = np.round(measure.values, measure.decimals)
    values = [None if value != value else value for value in rounded.tolist()]
    return {
        "group": measure.group,
        "title": measure.title,
        "unit": measure.unit,
        "decimals": measure.decimals,
        "signed": measure.signed,
        "values": values,
    }


def _labels(assembly: Assembly) -> dict[str, Sequence[str]]:
    """A line about each thing in the model, by group."""
    around = Surroundings(assembly)
    lines: dict[str, Sequence[str]] = {group.kind.group: group.kind.labels(group, around) for group in assembly.groups}
    return lines | {"left out": [left.reason for left in assembly.left_out if left.kind == BEAM.name]}

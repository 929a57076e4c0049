"""report.html: what was built, as one file that opens offline in a browser.

The file asks the network for nothing: model, style and scripts are in it. It says nothing of when or where it was
written, so the same input gives the same bytes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from fabkit.formats.report.figures import histogram, sheet_pictures
from fabkit.formats.report.fitness import fitness_html
from fabkit.formats.report.html_page import (
    FIND_IN_REPORT,
    REPORT_SCRIPTS,
    css_name,
    html_page,
    key_facts,
    model_html,
    part_of_page,
)
from fabkit.formats.report.model import model_data
from fabkit.formats.report.tables import cells_data, table_html
from fabkit.formats.shown import left_out_bars, placed_parts
from fabkit.kinds import BEAM, NODE
from fabkit.parts import LEFT_OUT_COLOUR, Assembly, Measure, Parts, Surroundings
from fabkit.production import REPORT, SURFACE_DISTANCE, BuildFacts, Drawing, Fact, Summary, Table
from geometry.arrays import FloatArray

__all__ = ["report_html"]

PRINTED_SHEETS = 96
"""Largest number of sheets whose pictures are printed with the report: more than fit two pages help nobody."""
_AROUND = (("Ends and facets", "node_facets", "Node", "Beam"), ("Edges of panels", "panel_edges", "Panel", "Beam"))
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
    issue: str = "",
) -> str:
    """The text of the file. tables: of the cut list. pieces: of `piece_tables`, which the page shows of a part that is
    picked. left_out_lines (n, 2, 3), in mm: the ends of the edges of the beams that are left out. issue: revision and
    date, which stand at the head and on each printed page.

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
    layers = [(parts.kind.group, placed_parts(parts)) for parts in assembly.groups]
    model, arrays = model_data([*layers, ("left out", left_out_bars(assembly, left_out_lines))])
    body = part_of_page(
        "report.html",
        name=escape(summary.name),
        source=", ".join(
            filter(None, (f"from {escape(summary.source)}, in units of {summary.scale_mm:g} mm", escape(issue)))
        ),
        key_facts=key_facts((f.name, f.text, f.note) for f in (*facts.parts, *facts.sheets) if REPORT in f.shown),
        left_out=_left_out(assembly),
        fitness=fitness_html(summary.fitness, assembly),
        model=model_html(_layers(assembly), find=FIND_IN_REPORT, colours=part_of_page("colours.html")),
        mesh_facts=_mesh_facts(facts.mesh),
        mended=_mended(summary),
        deviations=_deviations(summary, assembly),
        histograms=_histograms([*measured, *_of_surface(summary)]),
        sheets_link='<a href="#sheets">Sheets</a>' if sheets else "",
        sheets=_sheets(sheets),
        tables="\n".join(table_html(table) for table in tables),
    )
    data = {
        "forms": {group.kind.group: group.kind.form for group in assembly.groups},
        "labels": _labels(assembly),
        "measures": [_measure_data(measure) for measure in measured],
        "tables": {table.title: cells_data(table) for table in tables},
        "pieces": cells_data(listed["pieces"]),
        "around": [[head, cells_data(listed[title]), *names] for head, title, *names in _AROUND],
        "model": model,
    }
    groups = [css_name(group.kind.group) for group in assembly.groups]
    return html_page(
        summary.name,
        body,
        colours=_colours(assembly),
        scripts=REPORT_SCRIPTS,
        data=data,
        more=f'<script type="text/plain" id="model-data">{arrays}</script>\n',
        style="".join(f".{name} rect {{ fill: var(--kind-{name}); }}\n" for name in groups),
        issue=issue,
    )


def _colours(assembly: Assembly) -> dict[str, str]:
    """The colours of the kinds of part in the model and in their histograms."""
    shades = {group.kind.group: group.kind.colour for group in assembly.groups} | {"left out": LEFT_OUT_COLOUR}
    return {name: "#" + "".join(f"{round(255 * c):02x}" for c in colour) for name, colour in shades.items()}


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


def _layers(assembly: Assembly) -> list[str]:
    names = [group.kind.group for group in assembly.groups if len(group)]
    return [*names, "left out"] if any(left.kind == BEAM.name for left in assembly.left_out) else names


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
        f'<h3>{name.capitalize()}</h3><div class="histograms {css_name(name)}">{"".join(figures)}</div>'
        for name, figures in groups.items()
    )


def _sheets(sheets: Sequence[Drawing]) -> str:
    if not sheets:
        return ""
    drawn = sheet_pictures(sheets)
    pictures, later = "\n".join(drawn[:PRINTED_SHEETS]), "\n".join(drawn[PRINTED_SHEETS:])
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

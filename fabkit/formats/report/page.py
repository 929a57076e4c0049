"""report.html: what was built, as one file that opens offline in a browser.

The file asks the network for nothing: model, style and scripts are in it. It says nothing of when or where it was
written, so the same input gives the same bytes.
"""

from __future__ import annotations

import base64
import json
from collections import Counter
from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template

import numpy as np

from fabkit.formats.report.figures import histogram, sheet_picture
from fabkit.formats.report.fitness import fitness_html
from fabkit.formats.report.tables import table_html
from fabkit.parts import Assembly, Beam, Node, Panel, Part
from fabkit.parts.palette import LEFT_OUT_COLOUR, PALETTE
from fabkit.production import REPORT, BuildFacts, Drawing, Fact, Measure, Summary, Table, measures
from geometry.arrays import FloatArray

__all__ = ["report_html"]

_SCRIPTS = (
    "model.js",
    "camera.js",
    "program.js",
    "viewer.js",
    "table.js",
    "page.js",
)


def report_html(
    *,
    summary: Summary,
    facts: BuildFacts,
    assembly: Assembly,
    tables: Sequence[Table],
    sheets: Sequence[Drawing],
    glb: bytes,
) -> str:
    """The text of the file. glb: what `glb_bytes` wrote for this assembly; the viewer shows it.

    Names and notes from files are escaped wherever they stand.
    """
    measured = measures(assembly)
    room = files("fabkit.formats.report")
    page = Template(room.joinpath("page.html").read_text(encoding="utf-8"))
    return page.substitute(
        name=escape(summary.name),
        source=f"from {escape(summary.source)}, one unit of which is {summary.scale_mm:g} mm",
        style=_colours() + room.joinpath("page.css").read_text(encoding="utf-8"),
        script="".join(room.joinpath(name).read_text(encoding="utf-8") for name in _SCRIPTS),
        key_facts=_key_facts([*facts.parts, *facts.sheets]),
        left_out=_left_out(assembly),
        fitness=fitness_html(summary.fitness, assembly),
        layers=_layers(assembly),
        measures=_measure_options(measured),
        mesh_facts=_mesh_facts(facts.mesh),
        mended=_mended(summary),
        misfits=_misfits(summary, assembly),
        histograms=_histograms(measured),
        sheets_link='<a href="#sheets">Sheets</a>' if sheets else "",
        sheets=_sheets(sheets),
        tables="\n".join(table_html(table) for table in tables),
        data=_json({"labels": _labels(assembly), "measures": [_measure_data(measure) for measure in measured]}),
        glb=base64.b64encode(glb).decode(),
    )


def _colours() -> str:
    """The colours of the model as variables of the style sheet."""
    shades = {f"{kind}s": colour for kind, colour in PALETTE.items()} | {"left-out": LEFT_OUT_COLOUR}
    hexes = {name: "".join(f"{round(255 * c):02x}" for c in colour) for name, colour in shades.items()}
    return ":root {" + " ".join(f"--kind-{name}: #{value};" for name, value in hexes.items()) + "}\n"


def _json(value: object) -> str:
    """JSON that may stand in a script element: nothing in it can end the element or open a comment."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def _key_facts(facts: Sequence[Fact]) -> str:
    return "\n".join(
        f"<div><dt>{escape(fact.name)}</dt><dd>{escape(fact.text)} <small>{escape(fact.note)}</small></dd></div>"
        for fact in facts
        if REPORT in fact.shown
    )


def _left_out(assembly: Assembly) -> str:
    """A red box with every part that was not made; nothing where all were."""
    if not assembly.left_out:
        return ""
    kinds = Counter(left.kind for left in assembly.left_out)
    counted = ", ".join(f"{count} {kind}{'s' if count > 1 else ''}" for kind, count in kinds.items())
    items = "\n".join(f"<li>{escape(left.reason)}</li>" for left in assembly.left_out)
    return (
        f'<div class="left-out" role="alert"><h2>Left out: {escape(counted)}</h2>'
        f"<p>This structure is not complete. Left-out beams stand in red in the model.</p><ul>\n{items}\n</ul></div>"
    )


def _layers(assembly: Assembly) -> str:
    names = [name for name, parts in assembly.groups().items() if parts]
    if any(left.kind == "beam" for left in assembly.left_out):
        names.append("left out")
    return "\n".join(
        f'<label><input type="checkbox" value="{name}" checked>'
        f'<i style="background: var(--kind-{name.replace(" ", "-")})"></i>{name.capitalize()}</label>'
        for name in names
    )


def _measure_options(measured: Sequence[Measure]) -> str:
    groups: dict[str, str] = {}
    for index, measure in enumerate(measured):
        option = f'<option value="{index}">{escape(measure.title)}</option>'
        groups[measure.group] = groups.get(measure.group, "") + option
    return "\n".join(f'<optgroup label="{name.capitalize()}">{each}</optgroup>' for name, each in groups.items())


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


def _misfits(summary: Summary, assembly: Assembly) -> str:
    """Median, 95th percentile and maximum of what would be zero for an ideal mesh, and the part it is largest at."""
    beams, nodes = assembly.beams, assembly.nodes
    rows = []
    if nodes:
        spread = np.array([node.top_spread_mm for node in nodes])
        rows.append(_misfit("Beam tops out of level at a node, mm", spread, ".2f", nodes))
        on_axis = np.array([node.axis_spread_mm for node in nodes])
        rows.append(_misfit("Beam sides that miss each other on the node axis, mm", on_axis, ".2f", nodes))
    if beams:
        deviation = np.abs([beam.height_deviation_mm for beam in beams])
        rows.append(_misfit("Section height off the meshes' distance, mm", deviation, ".2f", beams))
        rows.append(_misfit("Twist of a beam, °", np.abs([beam.twist_deg for beam in beams]), ".1e", beams))
    return "\n".join(rows)


def _misfit(title: str, values: FloatArray, form: str, parts: Sequence[Part]) -> str:
    figures = (np.median(values), np.percentile(values, 95), values.max())
    cells = "".join(f"<td>{figure:{form}}</td>" for figure in figures)
    worst = escape(parts[int(values.argmax())].mark)
    return f'<tr><th scope="row">{title}</th>{cells}<td><button type="button" class="mark">{worst}</button></td></tr>'


def _histograms(measured: Sequence[Measure]) -> str:
    groups: dict[str, list[str]] = {}
    for measure in measured:
        groups.setdefault(measure.group, []).append(histogram(measure))
    return "\n".join(
        f'<h3>{name.capitalize()}</h3><div class="histograms {name}">{"".join(figures)}</div>'
        for name, figures in groups.items()
    )


def _sheets(sheets: Sequence[Drawing]) -> str:
    if not sheets:
        return ""
    pictures = "\n".join(sheet_picture(sheet) for sheet in sheets)
    return f'<section id="sheets">\n<h2>Sheets</h2>\n<div class="sheets">\n{pictures}\n</div>\n</section>'


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


def _labels(assembly: Assembly) -> dict[str, list[str]]:
    """A line about each thing in the model, by group."""
    node_marks = {node.element: node.mark for node in assembly.nodes}

    def ends(beam: Beam) -> str:
        return " to ".join(node_marks.get(vertex, f"vertex {vertex}") for vertex in beam.nodes)

    def of_beam(beam: Beam) -> str:
        return f"{beam.section.name}, {beam.material.name}; edge {beam.element}, {ends(beam)}"

    def of_node(node: Node) -> str:
        return f"{node.material.name}; vertex {node.element}, {len(node.beams)} beams"

    def of_panel(panel: Panel) -> str:
        return f"{panel.thickness_mm:g} mm {panel.material.name}; face {panel.element}"

    return {
        "beams": [of_beam(beam) for beam in assembly.beams],
        "nodes": [of_node(node) for node in assembly.nodes],
        "panels": [of_panel(panel) for panel in assembly.panels],
        "left out": [left.reason for left in assembly.left_out if left.kind == "beam"],
    }

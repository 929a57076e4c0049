"""The findings as a section of the report: for each its value against its bound, a sentence and the cure."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from fabkit.fitness import CRITERIA, Finding
from fabkit.parts import Assembly

__all__ = ["fitness_html"]

MAX_MARK_BUTTONS = 12
"""Largest number of parts concerned that get a button; the sentence or the tables name the others."""

TITLES = {
    "moves": "Displacement while planarising",
    "folding": "Folding",
    "self-crossing": "Outlines that cross themselves",
    "self-intersection": "Faces that intersect",
    "lean": "Lean of the node axes",
    "heights": "Heights of the beams",
    "tilt": "Tilt of the beams",
    "mitres": "Mitre cuts",
    "block-heights": "Height of the node blocks",
    "slots": "Room to weld between beams",
    "uncovered": "Beams' ends above their blocks",
    "underside": "Panels raised by one node",
    "corners": "Sharp corners of panels",
    "short-edges": "Short edges of panels",
    "panel-masses": "Heavy panels",
    "going-in": "Beams that do not go in from outside",
    "props": "Nodes that have to be propped",
    "sheets": "Panels larger than the sheets",
}


def fitness_html(findings: Sequence[Finding], assembly: Assembly) -> str:
    """The findings as cards, and the criteria whose values are within their bounds."""
    within = [TITLES[name].lower() for name in CRITERIA if name not in {finding.name for finding in findings}]
    within_bounds = f"Within their bounds: {', '.join(within)}."
    if not findings:
        return f'<p class="soft">Nothing is unusual. {within_bounds}</p>'
    cards = "\n".join(_card(finding, assembly) for finding in findings)
    return f'<div class="findings">\n{cards}\n</div>\n<p class="soft">{within_bounds}</p>'


def _card(finding: Finding, assembly: Assembly) -> str:
    number = f"{finding.value:.0f}" if finding.value >= 100 or finding.unit == "panels" else f"{finding.value:.3g}"
    return (
        f'<article class="{finding.level}"><header><h3>{TITLES[finding.name]}</h3>'
        f"<span>{finding.level}</span></header>"
        f"<p class='number'>{number} <small>{escape(finding.unit)}</small></p>{_bar(finding)}"
        f"<p class='sentence'>{escape(finding.sentence)}.</p>{_buttons(finding, assembly)}"
        f"<p class='soft'>Remedy: {escape(finding.cure)}.</p></article>"
    )


def _bar(finding: Finding) -> str:
    """A bar that shows the value on a scale from zero to twice its bound, which is marked in the middle."""
    if finding.bound <= 0:
        return ""
    share = 100 * min(1.0, finding.value / (2 * finding.bound))
    return (
        f"<div class='bar' role='img' aria-label='{finding.value:.3g}, bound {finding.bound:g}'>"
        f"<i style='width: {share:.1f}%'></i><b>{finding.bound:g}</b></div>"
    )


def _buttons(finding: Finding, assembly: Assembly) -> str:
    """Buttons that show the parts on the elements concerned in the model."""
    of_layer = (group for group in assembly.groups if group.kind.layer == finding.layer)
    groups = [group for group in of_layer if group.kind.element == finding.noun][:1]
    marks: dict[int, list[str]] = {}
    for element, mark in (
        (e, m) for group in groups for e, m in zip(group.elements.tolist(), group.marks, strict=True)
    ):
        marks.setdefault(element, []).append(mark)
    found = list(dict.fromkeys(mark for element in finding.elements for mark in marks.get(element, ())))
    if not found:
        return ""
    buttons = " ".join(
        f'<button type="button" class="mark">{escape(mark)}</button>' for mark in found[:MAX_MARK_BUTTONS]
    )
    more = len(found) - MAX_MARK_BUTTONS
    return f"<p class='parts'>{buttons}{f' and {more} more' if more > 0 else ''}</p>"

"""The facts of a build: the same in the report, the workbook, at the terminal and in the manifest."""

from __future__ import annotations

import json
import re
from html import unescape
from pathlib import Path
from typing import Any

import openpyxl
import pytest
from typer.testing import CliRunner

from fabkit.commands.command_line import app
from fabkit.pipeline import Built, build
from fabkit.production.facts import REPORT, TERMINAL, WORKBOOK, BuildFacts, Fact, build_facts
from fabkit.project import Project
from tests.fabkit.gridshell import gridshell, gridshell_summary

ROOF = Path(__file__).parents[2] / "examples" / "roof.obj"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Built, Path, str]:
    """A build, its folder, and what the command says of the same."""
    folder = tmp_path_factory.mktemp("facts")
    built = build(Project(mesh=ROOF, unit="m", out=folder / "out"))
    said = CliRunner(env={"COLUMNS": "200"}).invoke(app, ["build", str(ROOF), "--unit", "m", "-o", str(folder / "too")])
    assert said.exit_code == 0
    return built, folder / "out", said.output


def shown(facts: BuildFacts, place: str) -> list[Fact]:
    return [fact for fact in facts.all if place in fact.shown]


def test_every_fact_is_where_it_is_to_be_shown(made: tuple[Built, Path, str]) -> None:
    built, folder, terminal = made
    page = unescape(re.sub(r"<[^>]*>", "|", (folder / "report.html").read_text(encoding="utf-8")))
    rows = list(openpyxl.load_workbook(folder / "cutlist.xlsx")["Summary"].iter_rows(values_only=True))
    cells = {row[0]: row[1:] for row in rows}
    for fact in shown(built.facts, REPORT):
        assert re.search(f"[|]{re.escape(fact.name)}[|]+{re.escape(fact.text)} ?[|]", page), fact
        assert fact.note in page
    for fact in shown(built.facts, TERMINAL):
        assert re.search(f"(?m)^{re.escape(fact.name)} +{re.escape(fact.text)}", terminal), fact
        assert fact.note in terminal
    for fact in shown(built.facts, WORKBOOK):
        value, note = cells[f"{fact.name} ({fact.unit})" if fact.unit else fact.name]
        assert (note or "") == fact.note
        if len(fact.values) == 1 and isinstance(fact.values[0], float):
            assert isinstance(value, int | float)
            assert format(value, fact.form) == fact.figures
        else:
            assert str(value) == fact.figures


def test_the_manifest_has_the_values_unrounded(made: tuple[Built, Path, str]) -> None:
    built, folder, _ = made
    manifest = json.loads((folder / "manifest.json").read_text())

    def value(key: str) -> Any:
        found = manifest
        for name in key.split("."):
            found = found[name]
        return found

    keys = {key: value for fact in built.facts.all for key, value in zip(fact.keys, fact.values, strict=False)}
    assert {key: value(key) for key in keys} == keys
    assert {
        "counts.beams",
        "counts.marks.nodes",
        "counts.left_out",
        "panel_underside.mm",
        "panel_underside.reason",
        "heights.p2_5",
    } <= set(keys)
    assert len(keys) == sum(len(fact.keys) for fact in built.facts.all)


def test_without_a_nest_the_manifest_counts_no_sheets() -> None:
    facts = build_facts(gridshell_summary(), gridshell(), None)
    assert [(fact.name, fact.values, fact.shown) for fact in facts.sheets if fact.keys] == [
        ("Sheets used", (0,), frozenset())
    ]


def test_figures_are_words() -> None:
    assert Fact("Edges", (1.25, 3.0), ".1f", "mm").text == "1.2 to 3.0 mm"
    assert Fact("Shares", (0.5, 1.0, 2.0), ".2f").text == "0.50, 1.00, 2.00"
    assert Fact("Vertices", (12,)).text == "12"

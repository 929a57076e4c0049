"""report.html: its text, and what a browser makes of it."""

from __future__ import annotations

import base64
import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fabkit import Project, design
from fabkit.fitness import CRITERIA, Finding
from fabkit.formats.report.figures import histogram
from fabkit.formats.report.fitness import fitness_html
from fabkit.formats.report.page import report_html
from fabkit.parts import LEFT_OUT_COLOUR, Assembly, Material, Measure
from fabkit.production.cut_lists import cut_list
from fabkit.production.drawing import sheet_drawings
from fabkit.production.facts import build_facts
from fabkit.production.nesting.nests import Sheet
from fabkit.production.nesting.sheet_nesting import nest_panels
from fabkit.production.pieces import piece_tables
from geometry.mesh.shapes import dome
from tests.fabkit.assemblies import assembled, by_name, with_parts
from tests.fabkit.browser import Browser, pixels
from tests.fabkit.gridshell import gridshell, gridshell_summary, left_out_lines

NAME = "Roof </script><script>alert(1)</script> & <b>co</b>"
ISSUE = 'revision "B" \\ }</style>'
LEFT_OUT = 3
FINDINGS = tuple(
    Finding(
        name, level, 12.5 * k, 10.0 * k, "degrees", f"{name} is unusual, and " * 6, "mend it " * 12, noun, (1, 2, 3)
    )
    for k, (name, level, noun) in enumerate(
        zip(CRITERIA, ("note", "accepted") * 6, ("vertex", "edge", "face", "") * 3, strict=False)
    )
)
VOID = {"meta", "link", "input", "col", "br"}


def report(name: str = NAME, *, left_out: int = LEFT_OUT, assembly: Assembly | None = None) -> str:
    assembly = assembly or gridshell(6, 5, name=name, left_out=left_out)
    nest = nest_panels(assembly["panels"], Sheet(6000.0, 3210.0), gap_mm=10.0, border_mm=15.0)
    summary = replace(
        gridshell_summary(6, 5, name=name, mended=("2 pairs of <equal> vertices were joined",)), fitness=FINDINGS
    )
    return report_html(
        summary=summary,
        facts=build_facts(summary, assembly, nest),
        assembly=assembly,
        tables=cut_list(assembly, nest).tables,
        pieces=piece_tables(assembly, nest),
        sheets=sheet_drawings(nest, assembly["panels"]),
        left_out_lines=left_out_lines(left_out=left_out),
        issue=ISSUE,
    )


@pytest.fixture(scope="module")
def text() -> str:
    return report()


def test_each_colour_that_the_page_uses_is_defined() -> None:
    """Also of kinds whose groups have names of two words."""
    sizes = {"beams": {"section": "rhs 120x60x5"}, "connection": {"kind": "bolted"}}
    bolted = design(Project(mesh=dome(12, 4), mean_edge_mm=3000, **sizes)).assembly
    page = report(left_out=0, assembly=bolted)
    used = set(re.findall(r"var\((--kind-[^)]*)\)", page))
    assert len(used) == len(bolted.groups) == 6
    assert used <= set(re.findall(r"(--kind-[a-z-]+): #", page))


class Outline(HTMLParser):
    """Checks that every element is closed in its turn; keeps attributes, and texts by element."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.attributes: list[tuple[str, str, str | None]] = []
        self.counts: dict[str, int] = {}
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.counts[tag] = self.counts.get(tag, 0) + 1
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.attributes += [(tag, name, value) for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def embedded(text: str) -> dict[str, Any]:
    (found,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    return json.loads(found)


def test_html_is_well_formed(text: str) -> None:
    assert text.startswith("<!DOCTYPE html>")
    assert Outline(text).counts["h1"] == 1
    assert "$" not in re.sub(r"<script.*?</script>", "", text, flags=re.DOTALL)


def test_nothing_is_asked_of_the_network(text: str) -> None:
    for tag, name, value in Outline(text).attributes:
        if name in ("src", "href", "xlink:href", "action", "data", "poster", "srcset"):
            local = (value or "").startswith(("#", "data:,", "parts/", "panels/"))
            assert local, f"{tag} {name}={value}"
    assert not re.search(r"https?://|@import|url\(|\bfetch\(|XMLHttpRequest|import\(", text)


def test_names_and_notes_are_text_not_markup(text: str) -> None:
    assert "<script>alert" not in text
    assert "<b>co</b>" not in text
    assert "&lt;equal&gt;" in text
    strange = gridshell(2, 2, name="x")
    beams = [replace(beam, mark="<i>", material=Material("</script>", 1.0)) for beam in strange["beams"]]
    odd = report("x", left_out=0, assembly=with_parts(strange, beams=tuple(beams)))
    assert "<i>" not in re.sub(r'<i style="[^"]*">|<i>(?=</i>)', "", odd)
    assert embedded(odd)["labels"]["beams"][0].count("</script>") == 1


def test_same_input_same_bytes(text: str) -> None:
    assert report() == text


def test_left_out_stands_in_red_at_the_top(text: str) -> None:
    head = text[: text.index("</header>")]
    assert "Left out: 3 beams" in head
    assert [f"edge {edge}: no room" in head for edge in (68, 69, 70)] == [True] * 3
    assert "Left out" not in report(left_out=0).split("<script", 1)[0].split("</header>")[0]


def test_what_is_unusual_stands_before_the_model_with_parts_to_click() -> None:
    assembly = gridshell(6, 5)
    found = Finding(
        "lean", "note", 17.0, 15.0, "degrees", "axes lean by <17> degrees", "turn & mend", "vertex", (3, 999)
    )
    html = fitness_html((found,), assembly)
    Outline(html)
    assert "axes lean by &lt;17&gt; degrees." in html
    assert "turn &amp; mend" in html
    marks = {node.element: node.mark for node in assembly["nodes"]}
    assert re.findall(r'class="mark">(.*?)<', html) == [marks[3]]  # there is no vertex 999
    assert "width: 56.7%" in html  # of twice the bound
    assert "panels larger than the sheets" in html
    assert "Nothing is unusual" in fitness_html((), assembly)


def test_data_has_a_value_for_each_part(text: str) -> None:
    data = embedded(text)
    assembly = gridshell(6, 5, left_out=LEFT_OUT)
    counts = {name: len(parts) for name, parts in by_name(assembly).items()} | {"left out": LEFT_OUT}
    assert {name: len(labels) for name, labels in data["labels"].items()} == counts
    for measure in data["measures"]:
        assert len(measure["values"]) == counts[measure["group"]]
    lengths = next(each["values"] for each in data["measures"] if each["title"] == "Long-point length")
    assert lengths == [round(beam.details.long_point_mm, 1) for beam in assembly["beams"]]


def test_misalignments_are_reported_in_millimetres(text: str) -> None:
    spread = np.array([node.details.top_step_mm for node in gridshell(6, 5)["nodes"]])
    figures = [f"{np.percentile(spread, share):.2f}" for share in (50, 95, 100)]
    row = next(line for line in text.splitlines() if "Step between beam tops at a node, mm" in line)
    assert re.findall(r"<td>([\d.]+)</td>", row) == figures


def test_measures_without_parts_are_left_away() -> None:
    assert embedded(report(left_out=0, assembly=assembled("Nothing")))["measures"] == []
    empty = report(left_out=0, assembly=with_parts(gridshell(2, 2), nodes=()))
    assert {measure["group"] for measure in embedded(empty)["measures"]} == {"beams", "panels"}


@given(st.lists(st.floats(-1e6, 1e6) | st.just(float("nan")), max_size=60))
def test_histogram_counts_every_value_once(values: list[float]) -> None:
    picture = histogram(Measure("beams", "Length", "mm", 1, np.array(values)))
    Outline(picture)
    known = [value for value in values if value == value]
    bars = [int(count) for count in re.findall(r": (\d+)</title>", picture)]
    if "<svg" in picture:
        assert sum(bars) == len(known)
    elif known:
        value, count = re.findall(r"<figcaption>(.*) for all (\d+)<", picture)[0]
        np.testing.assert_allclose(known, float(value), atol=0.05001)  # one decimal is shown
        assert int(count) == len(known)


def column_of(table: dict[str, Any], name: str) -> list[str]:
    return table["cells"][table["columns"].index(name)]


# In the browser


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory, text: str) -> Iterator[Browser]:
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not installed")
    folder = tmp_path_factory.mktemp("report")
    path = Path(folder) / "report.html"
    path.write_text(text, encoding="utf-8")
    with Browser(chromium, folder / "profile") as browser:
        browser.size(760, 620)  # small: reading pictures takes time
        browser.open(path.as_uri())
        browser.frame()
        yield browser


def canvas_pixels(browser: Browser) -> np.ndarray:
    browser.frame()
    return pixels(browser.screenshot("#model canvas")).reshape(-1, 3).astype(int)


def near(image: np.ndarray, colour: tuple[int, ...], tolerance: int) -> int:
    return int((np.abs(image - colour).max(axis=1) <= tolerance).sum())


def test_page_opens_without_complaint_and_without_requests(browser: Browser) -> None:
    assert browser.evaluate("document.documentElement.dataset.ready") == "yes"
    assert browser.problems == []
    assert [url for url in browser.requests if not url.startswith(("file:", "data:", "about:"))] == []


def test_model_is_drawn_and_layers_can_be_hidden(browser: Browser) -> None:
    browser.evaluate("viewer.showAll('home')")
    n_parts = sum(1 for _ in gridshell(6, 5).parts())
    assert browser.evaluate("Number(document.querySelector('#model canvas').dataset.parts)") == n_parts
    everything = canvas_pixels(browser)
    drawn = 1 - near(everything, (255, 255, 255), 2) / len(everything)
    assert 0.2 < drawn < 0.9  # the structure fills much of the picture, and not all
    red = tuple(round(255 * c) for c in LEFT_OUT_COLOUR)
    assert near(everything, red, 12) > 20

    def toggle(name: str) -> None:
        browser.evaluate(f"document.querySelector('#layers input[value=\"{name}\"]').click()")

    toggle("left out")
    assert near(canvas_pixels(browser), red, 12) == 0
    toggle("panels")
    bare = canvas_pixels(browser)
    assert 0.005 < 1 - near(bare, (255, 255, 255), 2) / len(bare) < drawn / 2
    toggle("beams")
    toggle("nodes")
    assert near(canvas_pixels(browser), (255, 255, 255), 2) == len(bare)
    for name in ("left out", "panels", "beams", "nodes"):
        toggle(name)
    np.testing.assert_array_equal(canvas_pixels(browser), everything)


def test_a_click_tells_the_part_and_its_facts(browser: Browser) -> None:
    browser.evaluate("document.querySelector('#model').scrollIntoView()")
    browser.evaluate("viewer.showAll('top')")
    browser.frame()
    middle = browser.evaluate(
        "(r => [r.x + r.width / 2, r.y + r.height / 2])(document.querySelector('canvas').getBoundingClientRect())"
    )
    browser.click(middle[0] + 1, middle[1] + 1)
    browser.frame()
    # seen from the top, the middle of a shell of 6 by 5 cells lies on the edge between its two middle panels
    name = browser.evaluate("document.querySelector('#part strong').textContent")
    mark = name.split(" ")[0]
    parts = {part.mark: part for part in gridshell(6, 5, left_out=LEFT_OUT).parts()}
    origin = parts[mark].placement.to_world(parts[mark].solid.centroid)
    assert np.abs(origin[:2]).max() < 1500 / 2 + 50
    facts = browser.evaluate("[...document.querySelectorAll('#part dd')].map(e => e.textContent)")
    assert f"{parts[mark].mass_kg:.1f} kg" in [re.sub(r"(\.\d)\d kg", r"\1 kg", fact) for fact in facts]
    assert browser.evaluate("decodeURIComponent(location.hash)").startswith(f"#{mark}")
    assert browser.evaluate("pick(null)") == 0
    assert browser.evaluate("location.hash") == ""


def test_an_address_shows_a_piece_with_its_ends_its_row_and_its_file(browser: Browser) -> None:
    assembly = gridshell(6, 5, left_out=LEFT_OUT)
    beams = assembly["beams"]
    name, mark = beams.piece_names[7], beams.marks[7]
    a, b = (f"{node.mark} v{node.element}" for node in assembly["nodes"] if node.element in beams[7].details.nodes)
    browser.evaluate(f"location.hash = encodeURIComponent({name!r})")
    browser.frame()
    card = browser.evaluate("document.querySelector('#part').innerText")
    assert card.startswith(name)
    assert {a, b} <= {line.split("\t")[-1] for line in card.splitlines()}
    assert f"parts/{mark}.step" in card
    row = next(row for row in cut_list(assembly, None)["beams"].texts if row[0] == mark)
    assert all(cell in card for cell in row)
    around = browser.evaluate("[...document.querySelectorAll('#part .around tbody tr')].map(r => r.innerText)")
    assert sorted(line.split("\t")[0] for line in around if "v" in line) == sorted([a, b])
    assert browser.evaluate("document.querySelector('#found').textContent").startswith("1")
    browser.evaluate("location.hash = 'nothing here'")
    browser.frame()
    assert browser.evaluate("[document.querySelector('#found').textContent, state.pinned]") == ["0 found", None]
    assert browser.evaluate("pick(null)") == 0


def test_marks_can_be_hidden_and_shown_alone(browser: Browser) -> None:
    def colours(group: str) -> np.ndarray:
        shape = f"viewer.shapes.find(s => s.layer.name === '{group}')"
        return np.array(browser.evaluate(f"[...{shape}.colours]")).reshape(-1, 4)

    beams = gridshell(6, 5, left_out=LEFT_OUT)["beams"]
    own = np.array([mark == beams.marks[0] for mark in beams.marks])
    assert 0 < own.sum() < len(beams)
    browser.evaluate(f"pick({beams.marks[0]!r})")
    click = "[...document.querySelectorAll('#part header button')].find(e => e.textContent.startsWith('{}')).click()"
    browser.evaluate(click.format("Hide"))
    np.testing.assert_array_equal(colours("beams")[:, 3] == 0, own)
    assert browser.evaluate("document.querySelector('#hidden').innerText").startswith(f"Hidden: {beams.marks[0]}.")
    browser.evaluate("document.querySelector('#hidden button').click()")
    assert colours("beams")[:, 3].all()
    browser.evaluate(f"pick({beams.marks[0]!r})")
    browser.evaluate(click.format("Only"))
    np.testing.assert_array_equal(colours("beams")[:, 3] > 0, own)
    assert not colours("panels")[:, 3].any()
    browser.evaluate("showAllMarks(); pick(null)")


def test_section_and_exploded_view(browser: Browser) -> None:
    """What is cut away is white and cannot be picked; an exploded model still fits."""
    browser.evaluate("viewer.showAll('top')")
    whole = canvas_pixels(browser)
    middle = "viewer.canvas.clientWidth / 2, viewer.canvas.clientHeight / 2"
    assert browser.evaluate(f"viewer.partAt({middle}) !== null")
    browser.evaluate("viewer.cutAt(0, 0.3)")
    half = canvas_pixels(browser)
    drawn = [1 - near(each, (255, 255, 255), 2) / len(each) for each in (whole, half)]
    assert 0.15 < drawn[1] / drawn[0] < 0.45
    assert browser.evaluate(f"viewer.partAt({middle})") is None
    browser.evaluate("viewer.cutAt(null, 0); viewer.explode(1); viewer.showAll('top')")
    image = canvas_pixels(browser)
    assert near(image, (255, 255, 255), 2) > near(whole, (255, 255, 255), 2)  # gaps between the parts
    height = browser.evaluate("Math.round(viewer.canvas.clientHeight)")
    rows = (np.abs(image.reshape(height, -1, 3) - 255).max(axis=2) > 2).any(axis=1)
    columns = (np.abs(image.reshape(height, -1, 3) - 255).max(axis=2) > 2).any(axis=0)
    assert not rows[[0, -1]].any()
    assert not columns[[0, -1]].any()
    browser.evaluate("viewer.explode(0); viewer.showAll('home')")


def test_the_whole_model_fits_at_any_width(browser: Browser) -> None:
    for width in (340, 1100, 760):
        browser.size(width, 620)
        browser.frame()
        browser.frame()
        height = browser.evaluate("Math.round(viewer.canvas.clientHeight)")
        drawn = np.abs(canvas_pixels(browser).reshape(height, -1, 3) - 255).max(axis=2) > 2
        assert drawn.any()
        assert not drawn[[0, -1]].any()
        assert not drawn[:, [0, -1]].any()


def test_the_model_turns_moves_and_zooms_under_the_pointer(browser: Browser) -> None:
    browser.evaluate("document.querySelector('#model').scrollIntoView()")
    browser.evaluate("viewer.showAll('home')")

    def camera() -> np.ndarray:
        return np.array(browser.evaluate("(c => [c.azimuth, c.elevation, c.distance, ...c.target])(viewer.camera)"))

    def changed(before: np.ndarray) -> list[bool]:
        """Whether direction, distance and target are others than before."""
        other = np.abs(camera() - before) > 1e-9
        return [bool(other[:2].any()), bool(other[2]), bool(other[3:].any())]

    x, y = browser.evaluate(
        "(r => [r.x + r.width / 2, r.y + r.height / 2])(document.querySelector('canvas').getBoundingClientRect())"
    )
    browser.evaluate("document.activeElement.blur()")
    start = camera()
    browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-100)
    assert changed(start) == [False, False, False]  # the page scrolls until the model was clicked
    browser.evaluate("document.querySelector('#model').scrollIntoView()")
    browser.drag((x, y), (x + 60, y + 20))
    assert changed(start) == [True, False, False]
    turned = camera()
    browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-100)
    assert changed(turned) == [False, True, False]
    zoomed = camera()
    browser.drag((x, y), (x + 60, y + 20), shift=True)
    assert changed(zoomed) == [False, False, True]
    moved = camera()
    browser.pinch((x, y), 40, 80)
    assert camera()[2] == pytest.approx(moved[2] / 2, rel=0.02)
    assert browser.evaluate("pick(null)") == 0


def test_colouring_by_a_measure_paints_and_explains(browser: Browser) -> None:
    browser.evaluate("viewer.showAll('top')")
    by_kind = canvas_pixels(browser)
    choose = (
        "(s => {{ s.value = [...s.options].find(o => o.text === '{}').value; s.dispatchEvent(new Event('change')); }})"
        "(document.querySelector('#column'))"
    )
    browser.evaluate(choose.format("Area"))
    areas = [panel.details.area_mm2 / 1e6 for panel in gridshell(6, 5)["panels"]]
    shown = browser.evaluate("[...document.querySelectorAll('#scale b')].map(e => e.textContent)")
    assert shown == [f"{min(areas):.3f}", f"{max(areas):.3f} m²"]
    assert (np.abs(canvas_pixels(browser) - by_kind).max(axis=1) > 30).mean() > 0.2
    browser.evaluate(choose.format("Sheet"))  # of each piece
    assert browser.evaluate("[document.querySelector('#scale b').textContent, state.column.group]") == ["1", "panels"]
    browser.evaluate(choose.format("Node A"))  # words
    assert browser.evaluate("state.scale.words.size") == len(
        set(column_of(embedded(report())["pieces"], "Node A")[: len(gridshell(6, 5, left_out=LEFT_OUT)["beams"])])
    )
    browser.evaluate(choose.format("Order"))  # of parts of all kinds
    orders = [int(cell) for cell in column_of(embedded(report())["pieces"], "Order")]
    least, most = browser.evaluate("[state.scale.least, state.scale.most]")
    assert (least, most) == (min(orders), max(orders))
    firsts = browser.evaluate("layers.filter((l) => l.first !== null).map((l) => l.first)")
    shown = browser.evaluate("layers.filter((l) => l.first !== null).map((l) => columnColour(l, 0).slice(0, 3))")
    shares = [(orders[first] - least) / (most - least) for first in firsts]
    assert shown == browser.evaluate(f"{shares}.map((share) => colourAt(state.scale.ramp, share))")
    browser.evaluate("chooseColumn(null)")
    np.testing.assert_array_equal(canvas_pixels(browser), by_kind)


def test_tables_have_a_row_for_each_mark(text: str) -> None:
    tables = embedded(text)["tables"]
    for name, parts in by_name(gridshell(6, 5, left_out=LEFT_OUT)).items():
        assert tables[name]["cells"][0] == list(dict.fromkeys(part.mark for part in parts))


def test_tables_show_all_their_rows_can_be_sorted_and_filtered(browser: Browser) -> None:
    seen = set()
    for share in (0, 0.5, 1):
        browser.evaluate(
            f"(b => {{ b.scrollTop = {share} * b.scrollHeight; }})(document.querySelector('#table-beams'))"
        )
        browser.frame()
        seen |= set(
            browser.evaluate("[...document.querySelectorAll('#table-beams tbody .mark')].map(e => e.textContent)")
        )
    assert seen == {beam.mark for beam in gridshell(6, 5, left_out=LEFT_OUT)["beams"]}
    column = "document.querySelectorAll('#table-beams tbody td:nth-child(5)')"
    head = "document.querySelectorAll('#table-beams th button')[4].click()"
    for direction in (1, -1):
        browser.evaluate(head)
        values = browser.evaluate(f"[...{column}].map(e => Number(e.textContent))")
        assert len(set(values)) > 3
        assert values == sorted(values, reverse=direction < 0)
    search = "document.querySelector('input[data-table=table-beams]')"
    browser.evaluate(f"{search}.value = 'b12'; {search}.dispatchEvent(new Event('input'))")
    assert browser.evaluate(f"[...{column}].map(e => e.parentNode.cells[0].textContent)") == ["B12"]


def test_long_facts_break_and_stay_in_their_column(browser: Browser) -> None:
    boxes = browser.evaluate(
        "[...document.querySelectorAll('.facts td, .facts th')].map(e => [e.scrollWidth - e.clientWidth,"
        " e.getBoundingClientRect().right - e.closest('.facts').parentNode.getBoundingClientRect().right])"
    )
    assert len(boxes) > 20
    assert np.array(boxes).max() < 2
    heights = browser.evaluate(
        "[...document.querySelectorAll('.facts tr:not(:has(small)) th')].map(e => e.clientHeight)"
    )
    assert max(heights) < 100  # titles are not squeezed to a word a line: 3 lines


def test_findings_stand_side_by_side_and_lead_into_the_model(browser: Browser) -> None:
    boxes = np.array(
        browser.evaluate(
            "[...document.querySelectorAll('.findings article')].map(e => [e.scrollWidth - e.clientWidth,"
            " e.getBoundingClientRect().top, document.querySelector('#model').getBoundingClientRect().top,"
            " e.getBoundingClientRect().right - e.parentNode.getBoundingClientRect().right])"
        )
    )
    assert len(boxes) == len(FINDINGS)
    assert boxes[:, 0].max() < 2  # nothing runs out of its card
    assert (boxes[:, 1] < boxes[:, 2]).all()
    assert boxes[:, 3].max() < 1
    browser.evaluate("document.querySelector('.findings button.mark').click()")
    clicked = browser.evaluate("document.querySelector('.findings button.mark').textContent")
    assert browser.evaluate("document.querySelector('#part strong').textContent").startswith(clicked)


def test_sheets_are_there_and_open_large(browser: Browser) -> None:
    assembly = gridshell(6, 5)
    nest = nest_panels(assembly["panels"], Sheet(6000.0, 3210.0), gap_mm=10.0, border_mm=15.0)
    assert browser.evaluate("document.querySelectorAll('.sheets svg').length") == nest.n_sheets
    captions = browser.evaluate("[...document.querySelectorAll('.sheets figcaption')].map(e => e.textContent)")
    assert sum(int(re.findall(r"(\d+) panel", caption)[0]) for caption in captions) == len(assembly["panels"])
    browser.evaluate("document.querySelector('.sheets button').click()")
    assert browser.evaluate("document.querySelector('dialog').open") is True
    assert browser.evaluate("document.querySelector('dialog svg').getBoundingClientRect().width") > 600
    browser.evaluate("document.querySelector('dialog').close()")
    assert browser.problems == []


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="no pdftotext")
def test_the_page_prints_on_few_pages_that_say_what_they_are(browser: Browser, tmp_path: Path) -> None:
    printed = browser.call("Page.printToPDF", preferCSSPageSize=True)["data"]
    (tmp_path / "a.pdf").write_bytes(base64.b64decode(printed))
    text, boxes = (
        subprocess.run(["pdftotext", how, tmp_path / "a.pdf", "-"], check=True, capture_output=True).stdout.decode()
        for how in ("-layout", "-bbox")
    )
    pages = text.split("\f")[:-1]
    assert 3 < len(pages) <= 10
    for number, page in enumerate(pages, start=1):
        foot = " ".join(page.split())
        assert f"Page {number} of {len(pages)}" in foot
        assert ISSUE in foot
    assert "Beams" in text
    sizes = {tuple(map(float, size)) for size in re.findall(r'<page width="([\d.]+)" height="([\d.]+)"', boxes)}
    assert len(sizes) == 2
    assert max(map(max, sizes)) == pytest.approx(842, abs=1)  # A4, tables across
    heights = [float(low) - float(high) for high, low in re.findall(r'yMin="([\d.]+)" .*?yMax="([\d.]+)"', boxes)]
    assert np.percentile(heights, 5) > 8 * 1.0  # a box is higher than the size of its letters; notes below are smaller

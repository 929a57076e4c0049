"""The page on free parameters: its meshes are exact, it is what the script makes, and it works in a browser."""

from __future__ import annotations

import base64
import json
import re
import shutil
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from docs.tools import parameters
from geometry.arrays import FloatArray, IntArray
from tests.fabkit.browser import Browser

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "gallery" / "parameters.html"
DATA = re.compile(r'<script type="application/json" id="data">(.*?)</script>', re.DOTALL)

FAMILIES = {
    "Koebe polyhedra",
    "Minimal meshes",
    "Constant mean curvature",
    "Laguerre geometry",
    "Signs and lengths",
}

LARGEST = 1_500_000
"""Bytes: the page is part of the repository."""

PACKED = 1e-6
"""Of the size of a mesh: coordinates have 24 bits, 6e-8; from there to a direction is a factor of size over edge."""


@cache
def shipped() -> str:
    return PAGE.read_text(encoding="utf-8")


@cache
def data(text: str) -> dict[str, Any]:
    (found,) = DATA.findall(text)
    return json.loads(found)


def decoded(text: str, kind: str) -> IntArray:
    return np.frombuffer(base64.b64decode(text), kind).astype(np.int64)


def points(page: dict[str, Any], number: int) -> FloatArray:
    low, step, text = page["arrays"][number]
    return low + step * (decoded(text, "u1").reshape(-1, 3, 3) @ [1, 256, 65536])


def states(page: dict[str, Any]) -> list[dict[str, Any]]:
    return [state for study in page["studies"] for state in study["states"]]


# --- what it says


def test_all_meshes_are_edge_offset_meshes_of_the_curvature_they_should_have() -> None:
    found = parameters.main()
    assert {name.removeprefix("meshes, ") for name in found if name.startswith("meshes")} == FAMILIES
    assert all(count >= 9 for name, count in found.items() if name.startswith("meshes"))
    assert found["largest deviation of an edge of S from distance 1"] < 1e-13  # rounding of coordinates about 1
    assert found["largest sine between corresponding edges"] < 1e-12  # the same over the shortest edges, 1e-2
    assert found["largest deviation of H from what it should be"] < 1e-11  # and the same over areas, their squares


def test_the_page_that_ships_is_the_page_that_the_script_makes() -> None:
    made = parameters.page()
    assert DATA.sub("", shipped()) == DATA.sub("", made)
    ours, other = data(shipped()), data(made)
    assert ours["rows"] == other["rows"]
    assert ours["topologies"] == other["topologies"]
    assert len(states(ours)) == len(states(other))
    for study, twin in zip(ours["studies"], other["studies"], strict=True):
        assert {**study, "states": []} == {**twin, "states": []}
    for state, twin in zip(states(ours), states(other), strict=True):
        for name in ("topology", "reversed", "turned"):
            assert state[name] == twin[name]
        # five digits are kept; H of a small face is the difference of two areas
        np.testing.assert_allclose(state["numbers"], twin["numbers"], rtol=1e-3, atol=1e-6)
        for name in ("mesh", "image"):
            here, there = points(ours, state[name]), points(other, twin[name])
            np.testing.assert_allclose(here, there, rtol=0, atol=1e-5 * np.abs(there).max())


def test_every_slider_has_all_its_meshes() -> None:
    for study in data(shipped())["studies"]:
        values = [len(parameter["values"]) for parameter in study["parameters"]]
        assert len(study["states"]) == np.prod(values)
        assert all(0 <= p["start"] < n for p, n in zip(study["parameters"], values, strict=True))
        assert all(p["sentence"].endswith(".") for p in study["parameters"])
        assert np.prod([n for p, n in zip(study["parameters"], values, strict=True) if not p["isChoice"]]) >= 8


def test_what_is_embedded_touches_the_sphere_and_is_parallel() -> None:
    """Seen from the page alone."""
    page = data(shipped())
    for state in states(page):
        edges = decoded(page["topologies"][state["topology"]]["edges"], "<u2").reshape(-1, 2)
        m, s = points(page, state["mesh"]), points(page, state["image"])
        assert edges.max() < len(m) == len(s)
        along, image = m[edges[:, 1]] - m[edges[:, 0]], s[edges[:, 1]] - s[edges[:, 0]]
        lengths, images = np.linalg.norm(along, axis=1), np.linalg.norm(image, axis=1)
        off = np.linalg.norm(np.cross(s[edges[:, 0]], image), axis=1) / images - 1
        assert np.abs(off).max() < PACKED
        across = np.linalg.norm(np.cross(along, image), axis=1)
        assert (across / images).max() < PACKED * np.abs(m).max() + PACKED * (lengths / images).max()
        reverses = np.einsum("ei,ei->e", along, image) < 0
        np.testing.assert_array_equal(
            reverses, np.unpackbits(decoded(state["reversed"], "u1").astype("u1"))[: len(edges)]
        )
        assert state["numbers"][2:4] == [reverses.sum(), len(edges)]
        assert state["numbers"][4:6] == pytest.approx([lengths.min(), lengths.max()], rel=1e-4, abs=PACKED)
        assert state["numbers"][6:8] == [1, 1]  # heights of beams over d


def test_the_page_is_small_and_asks_nothing_of_the_network() -> None:
    assert len(shipped().encode()) < LARGEST
    assert not re.search(r"https?://|@import|url\(|\bfetch\(|XMLHttpRequest|import\(|\bsrc=", shipped())
    assert "$" not in re.sub(r"<script.*?</script>", "", shipped(), flags=re.DOTALL)


# --- in the browser


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not installed")
    with Browser(chromium, tmp_path_factory.mktemp("parameters") / "profile") as browser:
        browser.size(1000, 700)
        browser.open(PAGE.as_uri())
        browser.frame()
        yield browser


def pictures(browser: Browser) -> list[str]:
    browser.frame()
    return browser.evaluate("['mesh', 'image'].map(id => document.getElementById(id).toDataURL())")


def numbers(browser: Browser) -> list[str]:
    return browser.evaluate("[...document.querySelectorAll('#numbers td:nth-child(2)')].map(e => e.textContent)")


def open_study(browser: Browser, title: str) -> None:
    browser.evaluate(f"[...document.querySelectorAll('nav button')].find(b => b.textContent === '{title}').click()")


def slide(browser: Browser, slider: int, place: int) -> None:
    browser.evaluate(
        f"(s => {{ s.value = {place}; s.dispatchEvent(new Event('input')); }})"
        f"(document.querySelectorAll('#controls input')[{slider}])"
    )


def drawn_shares(browser: Browser) -> list[float]:
    """Of each picture, what differs from its background, which is in its corner."""
    browser.frame()
    return browser.evaluate(
        """Object.values(views).map(({ gl, canvas }) => {
          const p = new Uint8Array(4 * canvas.width * canvas.height);
          gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
          let n = 0;
          for (let k = 0; k < p.length; k += 4) n += p[k] !== p[0] || p[k + 1] !== p[1] || p[k + 2] !== p[2];
          return (4 * n) / p.length;
        })"""
    )


def test_the_page_opens_without_complaint_and_without_requests(browser: Browser) -> None:
    assert browser.evaluate("document.documentElement.dataset.ready") == "yes"
    assert browser.problems == []
    assert [url for url in browser.requests if not url.startswith(("file:", "data:", "about:"))] == []


def test_every_study_is_drawn_at_all_ends_of_its_sliders(browser: Browser) -> None:
    for study in data(shipped())["studies"]:
        open_study(browser, study["title"])
        for end in (0, 100):  # beyond the last value a slider stays there
            for slider in range(sum(not p["isChoice"] for p in study["parameters"])):
                slide(browser, slider, end)
            for share in drawn_shares(browser):
                assert 0.02 < share < 0.9, study["title"]
    assert browser.evaluate("Object.values(views).map(({ gl }) => gl.getError())") == [0, 0]
    assert browser.problems == []


def test_a_slider_changes_both_pictures_and_the_numbers_to_those_of_its_mesh(browser: Browser) -> None:
    open_study(browser, "Coverage")
    study = data(shipped())["studies"][0]
    seen = []
    for place in (0, 8):
        slide(browser, 0, place)
        seen.append((pictures(browser), numbers(browser)))
        low, high = study["states"][place]["numbers"][4:6]  # of edge lengths; the first choice of faces is quads
        assert [float(text) for text in seen[-1][1][2].split(" to ")] == pytest.approx([low, high], rel=1e-3)
        assert seen[-1][1][3] == "1"
    (before, old), (after, new) = seen
    assert before[0] != after[0]
    assert before[1] != after[1]
    assert old != new
    slide(browser, 0, 0)
    assert (pictures(browser), numbers(browser)) == (before, old)


def test_a_choice_changes_the_faces(browser: Browser) -> None:
    open_study(browser, "Catenoid")
    before = pictures(browser), numbers(browser)
    browser.evaluate("document.querySelectorAll('#controls button')[1].click()")
    after = pictures(browser), numbers(browser)
    assert before[0][0] != after[0][0]
    assert before[1][1] != after[1][1]  # edges
    assert after[1][4] == "0"  # H


def test_turning_one_picture_turns_the_other(browser: Browser) -> None:
    open_study(browser, "Enneper")
    before = pictures(browser)
    x, y, width, height = browser.evaluate(
        "(r => [r.x, r.y, r.width, r.height])(document.querySelector('#mesh').getBoundingClientRect())"
    )
    browser.drag((x + width / 2, y + height / 2), (x + width / 2 + 60, y + height / 2 + 20))
    after = pictures(browser)
    assert before[0] != after[0]
    assert before[1] != after[1]
    sides = browser.evaluate("Object.values(views).map(({ camera }) => [camera.azimuth, camera.elevation])")
    assert sides[0] == sides[1]


def test_pointing_at_a_face_shows_its_partner(browser: Browser) -> None:
    open_study(browser, "Coverage")
    slide(browser, 0, 8)
    x, y, width, height = browser.evaluate(
        "(r => [r.x, r.y, r.width, r.height])(document.querySelector('#image').getBoundingClientRect())"
    )
    before = pictures(browser)
    browser.mouse("mouseMoved", x + width / 2, y + height / 3)
    pointed = pictures(browser)
    hovered = browser.evaluate("Object.values(views).map(view => view.hovered)")
    assert hovered[0] == hovered[1] >= 0
    assert before[0] != pointed[0]
    browser.mouse("mouseMoved", x + 5, y + height - 5)  # a corner of the picture, where nothing is
    assert pictures(browser) == before


def test_beams_and_sphere_can_be_left_away(browser: Browser) -> None:
    open_study(browser, "Coverage")
    before = drawn_shares(browser)
    for name in ("beams", "sphere"):
        browser.evaluate(f"document.getElementById('{name}').click()")
    bare = drawn_shares(browser)
    assert bare[0] < before[0]
    assert bare[1] < 0.9 * before[1]
    for name in ("beams", "sphere"):
        browser.evaluate(f"document.getElementById('{name}').click()")
    assert drawn_shares(browser) == before
    assert browser.problems == []

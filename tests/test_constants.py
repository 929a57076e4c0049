"""Module-level numbers: each is documented by the string right below it, and no name stands for two of them."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[1]


def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("constants_script", ROOT / "docs" / "tools" / "constants.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look for annotations
    spec.loader.exec_module(module)
    return module


constants = script()


def test_constants_are_documented_and_their_names_stand_for_one_value() -> None:
    assert constants.offenders() == set()


def test_the_tables_of_the_conventions_are_those_of_the_code() -> None:
    page = constants.PAGE.read_text(encoding="utf-8")
    assert constants.with_tables(page) == page, "run python docs/tools/constants.py"


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('A = 1\n"""One. Two."""\n', [("A", "1", "One", False)]),
        ('A: float = -1e-3 * 2\n"""Relative to\nan edge."""\n', [("A", "-1e-3 * 2", "Relative to an edge", False)]),
        ("A, B = np.radians(5.0), (1, 2)\n", [("A B", "np.radians(5.0), (1, 2)", "", False)]),
        ("A = 1  # beside\nB = 2\n", [("A", "1", "", True), ("B", "2", "", False)]),
        ("# above\nA = 2.0 / 3\n", [("A", "2.0 / 3", "", True)]),
        ("A = 'text'\nb = 1\nC = f(1)\nD = {1: 2}\nE = True\nif F:\n    G = 1\n", []),
    ],
)
def test_constants_are_found(text: str, found: list[tuple[str, str, str, bool]]) -> None:
    assert [
        (" ".join(constant.names), constant.value, constant.first_sentence, constant.has_comment)
        for constant in constants.constants_of("a.py", text)
    ] == found


def test_what_offends_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(constants, "ROOT", tmp_path)
    for path, text in {
        "geometry/a.py": 'NEAR = 1\n"""Of a."""\n_FAR = 2\n"""Of a."""\n',
        "fabkit/b/c.py": 'from geometry.a import NEAR\nFAR = 2\n"""Of c."""\nBARE = 3\n',
    }.items():
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text(text, encoding="utf-8")
    assert constants.offenders() == {"fabkit/b/c.py BARE", "fabkit/b/c.py FAR", "geometry/a.py _FAR"}

"""Examples in docstrings run, and each public name of a room has one.

`docs/tools/public_names.py` says what is public.
"""

from __future__ import annotations

import doctest
import inspect
import runpy
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
PUBLIC = runpy.run_path(str(ROOT / "docs" / "tools" / "public_names.py"))
KERNELS = {
    "exact_surface": "build123d",
    "to_build123d": "build123d",
    "to_cadquery": "cadquery",
}
"""Examples that call these functions need the package, and run with `-m kernel` where it is installed."""

LIBRARIES = {"to_compas": "compas", "to_meshio": "meshio", "suns_at": "sunposition"}
"""Examples that call these functions need the library, which the extra `[test]` installs."""


def examples() -> Iterator[Any]:
    """Each docstring with examples, as a parameter named after what it documents."""
    for module in PUBLIC["modules"]():
        for found in doctest.DocTestFinder(exclude_empty=True).find(module):
            needed = {
                library
                for call, library in (KERNELS | LIBRARIES).items()
                if any(f"{call}(" in example.source for example in found.examples)
            }
            marks: list[Any] = [pytest.mark.kernel] if needed & set(KERNELS.values()) else []
            for library in needed:
                reason = f"{library} is not installed"
                marks.append(pytest.mark.skipif(find_spec(library) is None, reason=reason))
            if found.examples:
                yield pytest.param(found, id=found.name, marks=marks)


@pytest.mark.parametrize("example", list(examples()))
def test_examples_print_what_they_say(
    example: doctest.DocTest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # for what they write
    said: list[str] = []
    done = doctest.DocTestRunner(optionflags=doctest.FAIL_FAST).run(example, out=said.append, clear_globs=False)
    assert done.attempted > 0
    assert done.failed == 0, "".join(said)


@pytest.mark.parametrize("package", PUBLIC["PACKAGES"])
def test_no_example_is_overlooked(package: str) -> None:
    """All lines that begin with >>> are found, as they are not in strings that are no docstrings."""
    for module in PUBLIC["modules"]():
        if module.__name__.split(".")[0] != package:
            continue
        text = Path(str(module.__file__)).read_text(encoding="utf-8")
        found = sum(len(each.examples) for each in doctest.DocTestFinder().find(module))
        assert found == sum(line.lstrip().startswith(">>> ") for line in text.splitlines()), module.__name__


def test_each_public_name_has_an_example() -> None:
    without = {
        name for name, value in PUBLIC["public_objects"]().items() if ">>> " not in (inspect.getdoc(value) or "")
    }
    assert without == set(), "these need an example in their docstring"

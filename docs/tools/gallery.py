"""Draw all figures anew, and write docs/gallery/README.md from their docstrings and numbers."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from types import ModuleType

__all__ = ["page", "rows"]

ROOT = Path(__file__).parents[2]
EXAMPLES, GALLERY = ROOT / "examples", ROOT / "docs" / "gallery"

HEAD = """\
# Gallery

Figures of the paper this project implements, [Pottmann2007] in [references.bib](../references.bib), made anew with
shapes of our own. Each is drawn by a short script in [examples](../../examples), which runs in the folder of
the project as `python -m examples.figure_03_parallel_meshes`; `python -m docs.tools.gallery` runs all of them and
writes this page. Lengths without unit are in units of the example; d is the nominal distance of M and M'.

What the free parameters of edge offset meshes do is on a page of its own, [parameters.html](parameters.html): open it
in a browser, turn a slider, and see M and S change.
"""

ROUNDING = 1e-9
"""Below this a number is zero but for rounding, and its digits differ from machine to machine."""

CITATION = re.compile(r" \[.*?\]\.?")


def figures() -> dict[str, ModuleType]:
    """The scripts by the names of their pictures."""
    names = sorted(path.stem for path in EXAMPLES.glob("figure_*.py"))
    return {name[:9]: importlib.import_module(f"examples.{name}") for name in names}


def rows(numbers: dict[str, float]) -> list[str]:
    shown = {name: "below 1e-9" if abs(value) < ROUNDING else f"{value:.3g}" for name, value in numbers.items()}
    return [f"| {name} | {value} |" for name, value in shown.items()]


def page(numbers: dict[str, dict[str, float]]) -> str:
    """The whole page; numbers: what each figure's main returned."""
    parts = [HEAD]
    for name, module in figures().items():
        title, _, text = (module.__doc__ or "").strip().partition("\n\n")
        script = Path(module.__file__ or "").name
        parts.append(f"\n## Figure {int(name[-2:])}\n\n**{title}**\n\n{text}\n\n")
        parts.append(f"![{CITATION.sub('', title)}]({name}.png)\n")
        parts.append(f"\n[{script}](../../examples/{script}) finds:\n")
        parts.append("\n".join(["", "| number | value |", "|---|---|", *rows(numbers[name]), ""]))
    return "".join(parts)


if __name__ == "__main__":
    for name, module in figures().items():
        module.draw(GALLERY / f"{name}.png")
    (GALLERY / "README.md").write_text(page({name: module.main() for name, module in figures().items()}), "utf-8")

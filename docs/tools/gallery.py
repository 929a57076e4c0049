"""Draw all figures, and write docs/gallery/README.md from their docstrings and numbers."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from types import ModuleType

from docs.tools.connection_nodes import draw_connections

__all__ = ["page", "rows"]

ROOT = Path(__file__).parents[2]
EXAMPLES, GALLERY = ROOT / "examples", ROOT / "docs" / "gallery"

HEAD = """\
# Gallery

Figures of the paper that this project implements, [Pottmann2007] in [references.bib](../references.bib), redrawn with
our own shapes. Each figure has a short script in [examples](../../examples); run it in the folder of the project, such
as `python -m examples.figure_03_parallel_meshes`. `python -m docs.tools.gallery` runs all scripts and writes this page.
Lengths without unit are in units of the example; d is the nominal distance between M and M'.

An interactive page, [parameters.html](parameters.html), shows the free parameters of edge offset meshes: open it in a
browser, move a slider, and see M and S change. How far vertices of real meshes move for beams of nearly constant
height is drawn in [constant-heights.md](../howto/constant-heights.md).
"""

CONNECTIONS = """
## Connections

**One node of each connection, assembled and taken apart.**

Parts as fabkit makes them, of a dome of 12 by 4 quads: beams with corner radii welded to a block or bolted to it
through end plates and hand holes, tees on a round tube with caps, and solid bars that only touch a block. The dots on
blocks and caps say which side is up and which facet is the first. [How to ask for them](../howto/connections.md),
`python -m docs.tools.connection_nodes` draws them.

![One node of each connection, assembled and taken apart](connections.png)
"""

ROUNDING = 1e-9
"""Size of a number below which it is zero except for rounding, so that its digits depend on the machine."""

CITATION = re.compile(r" \[.*?\]\.?")


def figures() -> dict[str, ModuleType]:
    """The scripts by the names of their pictures."""
    names = sorted(path.stem for path in EXAMPLES.glob("figure_*.py"))
    return {name[:9]: importlib.import_module(f"examples.{name}") for name in names}


def rows(numbers: dict[str, float]) -> list[str]:
    def shown(value: float) -> str:
        return "below 1e-9" if abs(value) < ROUNDING and isinstance(value, float) else f"{value:.3g}"

    return [f"| {name} | {shown(value)} |" for name, value in numbers.items()]


def page(numbers: dict[str, dict[str, float]]) -> str:
    """The whole page; numbers: what each figure's main returned."""
    parts = [HEAD]
    for name, module in figures().items():
        title, _, text = (module.__doc__ or "").strip().partition("\n\n")
        script = Path(module.__file__ or "").name
        parts.append(f"\n## Figure {int(name[-2:])}\n\n**{title}**\n\n{text}\n\n")
        parts.append(f"![{CITATION.sub('', ' '.join(title.split()))}]({name}.png)\n")
        parts.append(f"\n[{script}](../../examples/{script}) finds:\n")
        parts.append("\n".join(["", "| number | value |", "|---|---|", *rows(numbers[name]), ""]))
    return "".join([*parts, CONNECTIONS])


if __name__ == "__main__":
    for name, module in figures().items():
        module.draw(GALLERY / f"{name}.png")
    draw_connections(GALLERY / "connections.png")
    (GALLERY / "README.md").write_text(page({name: module.main() for name, module in figures().items()}), "utf-8")

"""What mkdocs is given beside docs/: pages that lie elsewhere in the repository, the examples, the Python reference.

Links in Markdown are those of the repository, so that they work there too; here they are turned to the site's pages.
"""

from __future__ import annotations

import ast
import html
import inspect
import posixpath
import re
import runpy
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from pygments.formatters import HtmlFormatter

ROOT = Path(__file__).parents[2]
PUBLIC = runpy.run_path(str(Path(__file__).with_name("public_names.py")))
PAGES = {"README.md": "index.md", "CONTRIBUTING.md": "CONTRIBUTING.md", "CHANGELOG.md": "CHANGELOG.md"}
"""Pages outside docs/, by their paths in the repository."""

LINK = re.compile(r"(?<=\]\()(?!\w+:|#)([^)#\s]+)")


def on_config(config: MkDocsConfig) -> None:
    assert config.nav is not None
    named = set(_paths(config.nav))
    config.nav = _expanded(config.nav, named)
    for package in PUBLIC["PACKAGES"]:
        names = [room.__name__ for room in PUBLIC["rooms"]() if room.__name__.split(".")[0] == package]
        config.nav.append({f"Package {package}": [{name: _page_of(name)} for name in names]})


def _paths(nav: Any) -> Iterator[str]:
    if isinstance(nav, str):
        yield nav
    else:
        for item in nav.values() if isinstance(nav, dict) else nav:
            yield from _paths(item)


def _expanded(nav: list[Any], named: set[str]) -> list[Any]:
    """With all pages that a pattern such as howto/*.md stands for, less those that are named."""
    found: list[Any] = []
    for item in nav:
        if isinstance(item, dict):
            ((title, below),) = item.items()
            found.append({title: _expanded(below, named) if isinstance(below, list) else below})
        elif "*" in item:
            pages = (path.relative_to(ROOT / "docs").as_posix() for path in sorted((ROOT / "docs").glob(item)))
            found.extend(page for page in pages if page not in named)
        else:
            found.append(item)
    return found


def on_files(files: Files, config: MkDocsConfig) -> None:
    for source, target in PAGES.items():
        files.append(File.generated(config, target, content=(ROOT / source).read_text(encoding="utf-8")))
    scripts = sorted(path for path in (ROOT / "examples").iterdir() if path.is_file())
    files.append(File.generated(config, "examples/index.md", content=_examples(scripts)))
    for path in scripts:
        files.append(File.generated(config, f"examples/{path.name}", content=path.read_bytes()))
    files.append(
        File.generated(config, "code.css", content=HtmlFormatter(style="friendly").get_style_defs(".highlight"))
    )
    documented: dict[int, str] = {}
    for room in sorted(PUBLIC["rooms"](), key=lambda room: -room.__name__.count(".")):
        page = _reference(room, documented)
        files.append(File.generated(config, _page_of(room.__name__), content=page))


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    here = page.file.src_uri
    source = {target: source for source, target in PAGES.items()}.get(here, f"docs/{here}")

    def turned(link: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(posixpath.dirname(source), link[1]))
        target = {**PAGES, "examples": "examples/index.md"}.get(target, target.removeprefix("docs/"))
        return posixpath.relpath(target, posixpath.dirname(here) or ".")

    return markdown if here.startswith("python/") else LINK.sub(turned, markdown)


def _examples(scripts: list[Path]) -> str:
    rows = ["# Examples", "Scripts and files in `examples/`.", "| file | |\n|---|---|"]
    for path in scripts:
        text = path.read_text(encoding="utf-8")
        about = ast.get_docstring(ast.parse(text)) or "" if path.suffix == ".py" else ""
        rows.append(f"| [`{path.name}`]({path.name}) | {_first_sentence(about)} |")
    return "\n\n".join(rows[:2]) + "\n\n" + "\n".join(rows[2:])


def _page_of(room: str) -> str:
    return f"python/{room}.md"


def _reference(room: ModuleType, documented: dict[int, str]) -> str:
    """The page of a room. documented: where each object is described, grows; rooms inside others come first."""
    rows, details = [], []
    for name in room.__all__:
        value = getattr(room, name)
        if isinstance(value, ModuleType):
            link, summary = f"{value.__name__}.md", inspect.getdoc(value) or ""
        elif PUBLIC["is_documented"](value):
            path = f"{value.__module__}.{value.__qualname__}"
            if id(value) not in documented:
                documented[id(value)] = f"{room.__name__}.md#{path}"
                details.append(f"::: {path}")
            link, summary = documented[id(value)], inspect.getdoc(value) or ""
        else:
            rows.append(f"| `{name}` | {_value(value)} |")
            continue
        rows.append(f"| [`{name}`]({link}) | {_first_sentence(summary)} |")
    about = inspect.getdoc(room) or ""
    table = ["| name | |", "|---|---|", *rows]
    return "\n\n".join([f"# {room.__name__}", about, "\n".join(table), *details])


def _value(value: object) -> str:
    if isinstance(value, int | float | str):
        return f"`{value!r}`"
    if type(value).__module__ in ("typing", "types"):
        return f"<code>{html.escape(str(value).replace('typing.', '')).replace('|', '&#124;')}</code>"
    return f"a `{type(value).__name__}`"


def _first_sentence(text: str) -> str:
    paragraph = " ".join(text.split("\n\n")[0].split())
    sentence = re.split(r"(?<=[\w)\]][.])\s(?=[A-Z])", paragraph)[0]
    return re.sub(r"([*|\[])", r"\\\1", sentence).replace("<", "&lt;")

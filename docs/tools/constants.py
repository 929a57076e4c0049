"""The tables of constants in docs/conventions.md, made from the strings that document them in the code.

    python docs/tools/constants.py

A constant is a name in capitals that a module of geometry or fabkit binds to a number, an expression of numbers or a
tuple of them. The string right below it says what it is; its first sentence is the text of the table.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "conventions.md"
PACKAGES = ("geometry", "fabkit")
FUNCTIONS = {"radians", "sqrt", "cos", "sin", "tan", "log", "exp"}
"""Functions of numpy and math whose results count as numbers."""


@dataclass(frozen=True)
class Constant:
    """path: the file, from the root of the project. names: one, or several that one line binds. value: as written.

    description: the string right below, empty where there is none. has_comment: beside it or in the line above.
    """

    path: str
    names: tuple[str, ...]
    value: str
    description: str
    has_comment: bool

    @property
    def first_sentence(self) -> str:
        text = " ".join(self.description.split())
        return re.split(r"(?<=[^.])\.(?= [A-Z`]|$)", text, maxsplit=1)[0]


def is_number(node: ast.expr) -> bool:
    match node:
        case ast.Constant(value=value):
            return isinstance(value, int | float) and not isinstance(value, bool)
        case ast.UnaryOp(operand=operand):
            return is_number(operand)
        case ast.BinOp(left=left, right=right):
            return is_number(left) and is_number(right)
        case ast.Tuple(elts=parts):
            return len(parts) > 0 and all(map(is_number, parts))
        case ast.Call(func=ast.Attribute(attr=name), args=arguments):
            return name in FUNCTIONS and all(map(is_number, arguments))
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name == "pi" or (name.isupper() and not isinstance(node, ast.Attribute))
        case _:
            return False


def constants_of(path: str, text: str) -> Iterator[Constant]:
    lines, body = text.splitlines(), ast.parse(text).body
    for node, below in zip(body, [*body[1:], None], strict=True):
        if isinstance(node, ast.Assign) and len(node.targets) == 1:
            target, value = node.targets[0], node.value
        elif isinstance(node, ast.AnnAssign) and node.value:
            target, value = node.target, node.value
        else:
            continue
        bound = target.elts if isinstance(target, ast.Tuple) else [target]
        names = tuple(name.id for name in bound if isinstance(name, ast.Name) and name.id.isupper())
        if not names or not is_number(value):
            continue
        description = ""
        if isinstance(below, ast.Expr) and isinstance(below.value, ast.Constant) and isinstance(below.value.value, str):
            description = below.value.value
        above = lines[node.lineno - 2].strip() if node.lineno > 1 else ""
        beside = "#" in "".join(lines[node.lineno - 1 : node.end_lineno])
        written = ast.get_source_segment(text, value) or ""
        yield Constant(path, names, " ".join(written.split()), description, beside or above.startswith("#"))


def constants(package: str) -> list[Constant]:
    """Of all modules of a package, by file."""
    paths = sorted((ROOT / package).rglob("*.py"), key=lambda path: (room_of(path), path))
    return [
        constant
        for path in paths
        for constant in constants_of(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8"))
    ]


def room_of(path: Path) -> str:
    """The folder of a file, or the file itself beside the rooms, from the root of the project."""
    inside = path.relative_to(ROOT) if path.is_absolute() else path
    return (inside if len(inside.parts) == 2 else inside.parent).as_posix()


def offenders() -> set[str]:
    """ "path NAME" of what is not documented by a string alone, and of names that several files bind."""
    found = [constant for package in PACKAGES for constant in constants(package)]
    files = Counter(name.lstrip("_") for constant in found for name in constant.names)
    return {
        f"{constant.path} {name}"
        for constant in found
        for name in constant.names
        if not constant.description or constant.has_comment or files[name.lstrip("_")] > 1
    }


def table(package: str) -> str:
    rows, room = ["| constant | value | what it is |", "|---|---|---|"], ""
    for constant in constants(package):
        if room_of(Path(constant.path)) != room:
            room = room_of(Path(constant.path))
            rows.append(f"| **{room}** | | |")
        names = ", ".join(f"`{name}`" for name in constant.names)
        rows.append(f"| {names} | `{constant.value}` | {constant.first_sentence.replace('|', chr(92) + '|')} |")
    return "\n".join(rows)


def with_tables(page: str) -> str:
    """The page with both tables between their markers."""
    for package in PACKAGES:
        begin, end = f"<!-- constants of {package} -->\n", f"\n<!-- end of constants of {package} -->"
        before, rest = page.split(begin)
        after = rest.split(end)[1]
        page = before + begin + "\n" + table(package) + "\n" + end + after
    return page


if __name__ == "__main__":
    PAGE.write_text(with_tables(PAGE.read_text(encoding="utf-8")), encoding="utf-8")

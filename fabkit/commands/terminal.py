"""What all commands share at the terminal: where they write, and how they report errors."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO, cast

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text
from typer.core import TyperGroup

from fabkit.errors import FabkitError, error_sentence
from fabkit.signals import exit_on_signal
from fabkit.wording import readable
from geometry.errors import GeometryError

__all__ = ["ERR", "OUT", "Commands", "exit_on_error", "facts_table", "printable"]

LONGEST_SENTENCE = 590
"""Characters of an error message: with its prefix, three lines of a wide terminal, of 200 each. The middle of longer
ones is left out."""

GAP = " ... "

Misuse = cast(type[Exception], typer.BadParameter.__base__)
"""UsageError, which typer brings along or takes from click."""


class _StandardError:
    """Standard error where there is one: a build continues where it is closed or its device is full."""

    def write(self, text: str) -> int:
        with suppress(OSError, AttributeError):  # it is None where nothing was opened
            sys.stderr.write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError, AttributeError):
            sys.stderr.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(sys.stderr, name)


OUT = Console(soft_wrap=True, highlight=False, markup=False, emoji=False)
ERR = Console(file=cast(TextIO, _StandardError()), soft_wrap=True, highlight=False, markup=False, emoji=False)


class Commands(TyperGroup):
    """Commands that report every error in one sentence, wrong arguments included."""

    def main(self, *arguments: Any, **settings: Any) -> Any:
        with exit_on_error(), exit_on_signal():
            _escape_unprintable()
            try:
                code = super().main(*arguments, **{**settings, "standalone_mode": False})
            except Misuse as error:
                _report_misuse(error)
                code = 2
            sys.exit(code if isinstance(code, int) else 0)


@contextmanager
def exit_on_error() -> Iterator[None]:
    """Report an error in one sentence on standard error, and exit with code 2."""
    try:
        yield
    except (FabkitError, GeometryError) as error:
        _exit_with_sentence(error_sentence(error))
    except MemoryError:
        _exit_with_sentence("there is not enough memory: take a coarser mesh, or smaller counts")
    except RecursionError:
        _exit_with_sentence("the input is nested too deeply: write it flatter")
    except KeyboardInterrupt:
        raise SystemExit(130) from None
    except OSError as error:
        _discard_output()
        reason = error.strerror or str(error)
        _exit_with_sentence(
            f"{error.filename}: {reason}"
            if error.filename
            else f"{reason}: the output to the terminal is lost, written files are complete"
        )


def printable(text: str) -> str:
    """Text on one line, with control characters escaped, and without its middle where it is long."""
    plain = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in readable(text))
    half = (LONGEST_SENTENCE - len(GAP)) // 2
    return plain if len(plain) <= LONGEST_SENTENCE else f"{plain[:half]}{GAP}{plain[-half:]}"


def facts_table() -> Table:
    """An empty table of facts: a name and a sentence each."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    return table


def _exit_with_sentence(sentence: str) -> None:
    ERR.print(Text.assemble(("fabkit: ", "bold red"), printable(sentence)))
    raise SystemExit(2)


def _report_misuse(error: Any) -> None:
    if "NoArgs" in type(error).__name__:
        error.show()
        return
    command = error.ctx.command_path if error.ctx else "fabkit"
    _exit_with_sentence(
        f"{error.format_message().rstrip('.').replace(' Value error, ', ' ')}; {command} --help lists the options"
    )


def _escape_unprintable() -> None:
    """Print characters that the encoding of the terminal lacks as their numbers from now on."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")


def _discard_output() -> None:
    """Drop buffered output, which would fail again when the program ends."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

"""What all commands share at the terminal: where they write, and how they say what is wrong."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

import typer
from rich.console import Console
from rich.table import Table

from fabkit.errors import FabkitError, in_one_sentence
from geometry.errors import GeometryError

__all__ = ["ERR", "OUT", "end_tidily", "escaped", "facts_table", "one_sentence"]

OUT = Console(soft_wrap=True, highlight=False)
ERR = Console(stderr=True, soft_wrap=True, highlight=False)


def end_tidily() -> None:
    """When told to terminate, leave as on an interrupt: drafts of folders are removed on the way."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))


@contextmanager
def one_sentence() -> Iterator[None]:
    """Say what is wrong in one sentence on standard error, and leave with exit code 2."""
    try:
        yield
    except (FabkitError, GeometryError) as error:
        ERR.print(f"[bold red]fabkit:[/] {escaped(in_one_sentence(error))}")
        raise typer.Exit(2) from None
    except MemoryError:
        ERR.print("[bold red]fabkit:[/] there is not enough memory for so much: take a coarser mesh, or smaller counts")
        raise typer.Exit(2) from None


def escaped(text: str) -> str:
    """Text that rich prints as it is."""
    return text.replace("[", "\\[")


def facts_table() -> Table:
    """An empty table of facts: a name and a sentence each."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column(overflow="fold")
    return table

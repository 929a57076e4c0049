"""Signals that end a program: while it starts, while it works, and while names of folders are exchanged."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

__all__ = ["ENDING", "end_at_once", "ending_tidily", "signals_wait", "starting"]

ENDING = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK") if hasattr(signal, name)
)
"""What an interrupt, a kill and a terminal that closes send, as far as the system has them."""


def end_at_once() -> None:
    """From now on such a signal leaves with 128 + its number at once: where there is nothing to tidy up."""
    _answer(_handlers(), lambda number, frame: os._exit(128 + number))


@contextmanager
def ending_tidily() -> Iterator[None]:
    """Inside, such a signal leaves with 128 + its number through everything that tidies up on the way."""
    before = _handlers()
    try:
        _answer(before, lambda number, frame: sys.exit(128 + number))
        yield
    finally:
        _restore(before)


@contextmanager
def starting() -> Iterator[None]:
    """While the modules of a command are imported, a signal ends it at once, without the traceback of an import.

    Only where this process is that command, as `fabkit`, `python -m` or `python -c` start it: another program that
    imports the package keeps its own answers to signals.
    """
    is_command = Path(sys.argv[0] if sys.argv else "").stem == "fabkit" or sys.argv[:1] in (["-m"], ["-c"])
    before = _handlers() if is_command else {}
    try:
        _answer(before, lambda number, frame: os._exit(128 + number))
        yield
    finally:
        _restore(before)


@contextmanager
def signals_wait() -> Iterator[None]:
    """Such signals that arrive inside are answered at the end. Threads but the main one never see signals."""
    arrived: list[int] = []
    before = _handlers()
    try:
        _answer(before, lambda number, frame: arrived.append(number))
        yield
    finally:
        _restore(before)
        for number in arrived:
            signal.raise_signal(number)


def _handlers() -> dict[int, Any]:
    """What answers each signal now. Not those that are ignored, as under nohup, nor those that Python does not answer;
    none in a thread but the main one, which alone can change them."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    handlers = {number: signal.getsignal(number) for number in ENDING}
    return {number: found for number, found in handlers.items() if found not in (None, signal.SIG_IGN)}


def _answer(signals: Iterable[int], handler: Any) -> None:
    for number in signals:
        signal.signal(number, handler)


def _restore(handlers: dict[int, Any]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)

"""Signals that end a program: how they are handled at the start, during the work, and while folders are renamed."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

__all__ = ["EXIT_SIGNALS", "DeferredSignals", "exit_at_once", "exit_if_signalled", "exit_on_signal"]

_received: list[int] = []
"""Numbers of the signals received inside `exit_on_signal`."""

EXIT_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK") if hasattr(signal, name)
)
"""Signals sent by an interrupt, by a kill and by a closed terminal, as far as the system has them."""


def exit_at_once() -> None:
    """From now on, one of `EXIT_SIGNALS` ends the program at once with exit code 128 + its number, without cleaning
    up."""
    _set_handler(_handlers(), lambda number, frame: os._exit(128 + number))


@contextmanager
def exit_on_signal() -> Iterator[None]:
    """Inside, one of `EXIT_SIGNALS` ends the program with exit code 128 + its number, after all `finally` blocks.

    This holds also where interrupted code turns the exit into another error, as a comparison in numpy does. Where
    Python drops the exit, as it does in destructors, `exit_if_signalled` ends the program later.
    """
    before = _handlers()

    def end(number: int, frame: FrameType | None) -> None:
        _received.append(number)
        sys.exit(128 + number)

    try:
        _set_handler(before, end)
        yield
        exit_if_signalled()
    except BaseException:
        exit_if_signalled()
        raise
    finally:
        _restore(before)
        _received.clear()


def exit_if_signalled() -> None:
    """Exit if one of `EXIT_SIGNALS` was received and its exit was lost."""
    if _received:
        raise SystemExit(128 + _received[0])


class DeferredSignals:
    """Inside, `EXIT_SIGNALS` are deferred while `deferring` is True; at the end they are handled as before. While it is
    False they are handled at once. It is an attribute, and not a method, so that no signal can come between the start
    of a `finally` block and the assignment."""

    def __init__(self) -> None:
        self.deferring = True
        self._deferred: list[int] = []
        self._before = _handlers()

    def __enter__(self) -> DeferredSignals:
        try:
            _set_handler(self._before, self._receive)
        except BaseException:
            _restore(self._before)
            raise
        return self

    def __exit__(self, *error: object) -> None:
        self.deferring = False
        _restore(self._before)
        self.handle()

    def handle(self) -> None:
        """Handle the deferred signals."""
        while self._deferred:
            signal.raise_signal(self._deferred.pop(0))

    def _receive(self, number: int, frame: FrameType | None) -> None:
        handler = self._before[number]
        if self.deferring:
            self._deferred.append(number)
        elif callable(handler):
            handler(number, frame)
        else:  # the default of the system
            signal.signal(number, handler)
            signal.raise_signal(number)


def _handlers() -> dict[int, Any]:
    """The present handler of each signal, without signals that are ignored, as under nohup, or not handled by Python;
    empty outside the main thread, which alone can change handlers."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    handlers = {number: signal.getsignal(number) for number in EXIT_SIGNALS}
    return {number: found for number, found in handlers.items() if found not in (None, signal.SIG_IGN)}


def _set_handler(signals: Iterable[int], handler: Any) -> None:
    for number in signals:
        signal.signal(number, handler)


def _restore(handlers: dict[int, Any]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)

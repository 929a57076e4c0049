"""Signals that end a program: while it starts, while it works, and while names of folders are exchanged."""

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
"""Signals that have come inside `exit_on_signal`."""

EXIT_SIGNALS = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK") if hasattr(signal, name)
)
"""What an interrupt, a kill and a terminal that closes send, as far as the system has them."""


def exit_at_once() -> None:
    """From now on such a signal leaves with 128 + its number at once: where there is nothing to tidy up."""
    _answer(_handlers(), lambda number, frame: os._exit(128 + number))


@contextmanager
def exit_on_signal() -> Iterator[None]:
    """Inside, such a signal leaves with 128 + its number through everything that tidies up on the way.

    Also where what is left turns the exit into an error of its own, as numpy does that was comparing just then. Where
    Python drops it, as it does in destructors, `exit_if_signalled` leaves all the same.
    """
    before = _handlers()

    def end(number: int, frame: FrameType | None) -> None:
        _received.append(number)
        sys.exit(128 + number)

    try:
        _answer(before, end)
        yield
        exit_if_signalled()
    except BaseException:
        exit_if_signalled()
        raise
    finally:
        _restore(before)
        _received.clear()


def exit_if_signalled() -> None:
    """Leave where such a signal has come, and its exit was lost on the way."""
    if _received:
        raise SystemExit(128 + _received[0])


class DeferredSignals:
    """Inside, such signals wait as long as `waiting`, and are answered as before when they no longer need to, and while
    it is False. It is an attribute, so that nothing comes between a `finally` and waiting."""

    def __init__(self) -> None:
        self.waiting = True
        self._arrived: list[int] = []
        self._before = _handlers()

    def __enter__(self) -> DeferredSignals:
        try:
            _answer(self._before, self._hear)
        except BaseException:
            _restore(self._before)
            raise
        return self

    def __exit__(self, *error: object) -> None:
        self.waiting = False
        _restore(self._before)
        self.answer()

    def answer(self) -> None:
        """Answer those that have waited."""
        while self._arrived:
            signal.raise_signal(self._arrived.pop(0))

    def _hear(self, number: int, frame: FrameType | None) -> None:
        handler = self._before[number]
        if self.waiting:
            self._arrived.append(number)
        elif callable(handler):
            handler(number, frame)
        else:  # what the system does
            signal.signal(number, handler)
            signal.raise_signal(number)


def _handlers() -> dict[int, Any]:
    """What answers each signal now. Not those that are ignored, as under nohup, nor those that Python does not answer;
    none in a thread but the main one, which alone can change them."""
    if threading.current_thread() is not threading.main_thread():
        return {}
    handlers = {number: signal.getsignal(number) for number in EXIT_SIGNALS}
    return {number: found for number, found in handlers.items() if found not in (None, signal.SIG_IGN)}


def _answer(signals: Iterable[int], handler: Any) -> None:
    for number in signals:
        signal.signal(number, handler)


def _restore(handlers: dict[int, Any]) -> None:
    for number, handler in handlers.items():
        signal.signal(number, handler)

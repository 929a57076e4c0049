"""The stages of a build: reports which one is running, and measures how long each takes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter
from typing import Protocol

__all__ = ["Listener", "Stages"]


class Listener(Protocol):
    """Called when a stage begins (share 0), while it runs (completed share, where known) and when it ends (share 1)."""

    def __call__(self, stage: str, share: float) -> None: ...


class Stages:
    """Runs stages one after another. seconds: duration of each stage, in the order in which they ended."""

    def __init__(self, listener: Listener | None = None) -> None:
        self.seconds: dict[str, float] = {}
        self._listener: Listener = listener or (lambda stage, share: None)

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        self._listener(stage, 0.0)
        start = perf_counter()
        yield
        self.seconds[stage] = perf_counter() - start
        self._listener(stage, 1.0)

    def progress(self, stage: str, share: float) -> None:
        self._listener(stage, share)

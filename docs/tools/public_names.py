"""What is public: names in the `__all__` of a folder of geometry or fabkit, and in that of modules named there."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from types import ModuleType
from typing import Any

PACKAGES = ("geometry", "fabkit")


def modules() -> Iterator[ModuleType]:
    for package in PACKAGES:
        yield importlib.import_module(package)
        for found in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
            yield importlib.import_module(found.name)


def rooms() -> list[ModuleType]:
    """Modules with public names, the packages themselves first, then by name."""
    found = [module for module in modules() if hasattr(module, "__path__")]
    for room in found:
        named = [getattr(room, name) for name in room.__all__]
        found.extend(module for module in named if isinstance(module, ModuleType) and module not in found)
    return sorted(found, key=lambda room: (room.__name__ not in PACKAGES, room.__name__))


def is_documented(value: object) -> bool:
    """Functions and classes have docstrings; other values and aliases of types have none of their own."""
    return inspect.isclass(value) or inspect.isroutine(value)


def public_objects() -> dict[str, Any]:
    """Functions and classes by their shortest public names."""
    found: dict[int, tuple[str, Any]] = {}
    for room in sorted(rooms(), key=lambda room: room.__name__.count(".")):
        for name in room.__all__:
            value = getattr(room, name)
            if is_documented(value):
                found.setdefault(id(value), (f"{room.__name__}.{name}", value))
    return dict(found.values())

"""From a freeform mesh with planar faces to torsion-free beams, nodes and panels, and the shop's documents.

The names are those of `fabkit.public`, which is imported when one of them is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fabkit.public import *  # noqa: F403
    from fabkit.public import __all__ as __all__
else:

    def __getattr__(name: str) -> Any:
        public = import_module("fabkit.public")
        return globals()[name] if name in globals() else getattr(public, name)  # rooms are there once it is imported

    def __dir__() -> list[str]:
        return import_module("fabkit.public").__all__

"""Meshes with planar faces and meshes parallel to them. No units; angles in radians.

What most people need is here; exact shapes are in `geometry.mesh.shapes` and `geometry.mesh.solids`, what may be asked
of a mesh in `geometry.functionals`, measures of offsets in `geometry.parallel`, combinatorics and signs for Koebe
polyhedra and the meshes parallel to them in `geometry.edge_offset`.

The names are those of `geometry.public`, which is imported when one of them is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geometry.public import *  # noqa: F403
    from geometry.public import __all__ as __all__
else:

    def __getattr__(name: str) -> Any:
        public = import_module("geometry.public")
        return globals()[name] if name in globals() else getattr(public, name)  # rooms are there once it is imported

    def __dir__() -> list[str]:
        return import_module("geometry.public").__all__

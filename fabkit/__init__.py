"""From a freeform mesh with planar faces to torsion-free beams, nodes and panels, and the shop's documents."""

from fabkit.signals import starting

with starting():
    from fabkit.errors import FabkitError
    from fabkit.pipeline import Built, build, design
    from fabkit.project import Project, load_project

__all__ = ["Built", "FabkitError", "Project", "build", "design", "load_project"]

"""From a freeform mesh with planar faces to torsion-free beams, nodes and panels, and the shop's documents."""

from fabkit.signals import exit_while_importing

with exit_while_importing():
    from fabkit.errors import FabkitError
    from fabkit.pipeline import Built, build, design
    from fabkit.project import Project, load_project

__all__ = ["Built", "FabkitError", "Project", "build", "design", "load_project"]

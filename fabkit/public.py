"""What `import fabkit` offers."""

from fabkit.errors import FabkitError
from fabkit.pipeline import Built, build, design, write_built
from fabkit.project import Project, load_project

__all__ = ["Built", "FabkitError", "Project", "build", "design", "load_project", "write_built"]

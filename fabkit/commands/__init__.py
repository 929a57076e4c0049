"""What people type: `fabkit build`, `inspect`, `design`, and how they are answered."""

from fabkit.commands.command_line import app
from fabkit.commands.inspection import Inspection, inspect_mesh, inspect_pair, inspect_project

__all__ = ["Inspection", "app", "inspect_mesh", "inspect_pair", "inspect_project"]

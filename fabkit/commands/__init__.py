"""What people type: `fabkit build`, `inspect`, `design`, and how they are answered.

`--help` waits for no numerics: what a command does is imported when it runs.
"""

from fabkit.commands.command_line import app

__all__ = ["app"]

"""The command `fabkit`, also as `python -m fabkit`: nothing is imported before signals have an answer."""

from __future__ import annotations

from fabkit.signals import exit_at_once

__all__ = ["main"]


def main() -> None:
    """Run the command line. Before and after its commands, which tidy up, a signal ends the process at once."""
    exit_at_once()
    try:
        from fabkit.commands import app

        app()
    finally:
        exit_at_once()


if __name__ == "__main__":
    main()

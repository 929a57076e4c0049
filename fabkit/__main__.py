"""The command `fabkit`, also as `python -m fabkit`: nothing is imported before signals have an answer."""

from __future__ import annotations

import gc

from fabkit.signals import exit_at_once

__all__ = ["main"]

OBJECTS_BETWEEN_COLLECTIONS = 1_000_000
"""Number of objects made from one search for unreachable cycles to the next: of the millions in the tables of a build
none is in a cycle, and looking through them at Python's own 700 takes a tenth of its time; imports make 240 000."""


def main() -> None:
    """Run the command line. Before and after its commands, which tidy up, a signal ends the process at once."""
    exit_at_once()
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS)
    try:
        from fabkit.commands import app

        app()
    finally:
        exit_at_once()
        gc.freeze()  # Python looks for cycles once more when it ends, through all that imports and a build have left


if __name__ == "__main__":
    main()

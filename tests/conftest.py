"""One profile for all property tests: no deadline, since machines are shared; few enough examples to be quick.

Where CI is set, examples are the same in every run, so that a change is judged by itself; elsewhere they explore.
"""

from __future__ import annotations

import os

from hypothesis import settings

settings.register_profile("fabkit", deadline=None, max_examples=50, derandomize=bool(os.environ.get("CI")))
settings.load_profile("fabkit")

for name in ("COLUMNS", "LINES"):  # workers of a run in parallel get those of the terminal; tests say their own
    os.environ.pop(name, None)

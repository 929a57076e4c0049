"""One profile for all property tests: no deadline, since machines are shared; few enough examples to be quick."""

from __future__ import annotations

from hypothesis import settings

settings.register_profile("fabkit", deadline=None, max_examples=50)
settings.load_profile("fabkit")

"""Hubs: round tubes along the node axes, to which the beams are welded, with a cap at either end."""

from __future__ import annotations

import numpy as np

from fabkit.detailing.ends import Ends

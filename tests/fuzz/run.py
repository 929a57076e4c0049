"""Damaged meshes, pairs, project files and command lines, each kind for its share of the time. Ends with 1 on offence.

Run: python tests/fuzz/run.py --seconds 60 --seed 1; one input again: --only pairs --number 17 (and its seed).
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from command_lines import COMMAND_LINES
from driver import bounded, fuzz
from mesh_files import MESH_FILES
from pairs import PAIRS
from project_files import PROJECT_FILES

KINDS = {kind.name: kind for kind in (MESH_FILES, PAIRS, PROJECT_FILES, COMMAND_LINES)}


def main() -> int:
    """Attempt inputs of each kind until its time is over."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=60.0, help="of all kinds together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=KINDS, action="append", help="kinds to attempt; by default all")
    parser.add_argument("--number", type=int, help="only this input of the seed")
    parser.add_argument("--keep", type=Path, default=Path("fuzz-offenders"), help="folder for inputs that offend")
    options = parser.parse_args()
    sys.dont_write_bytecode = True
    bounded()
    names = options.only or list(KINDS)
    share = options.seconds / len(names)
    offend = [
        fuzz(KINDS[name], seconds=share, seed=options.seed, number=options.number, keep=options.keep.absolute())
        for name in names
    ]
    return int(any(offend))


if __name__ == "__main__":
    sys.exit(main())

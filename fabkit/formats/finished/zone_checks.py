"""The zones and the order of erection of a finished folder, in all of its files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import pairwise

from fabkit.formats.finished.contents import Contents
from fabkit.formats.step.text import string

__all__ = ["check_zones"]

_INSIDE = re.compile(
    r"=NEXT_ASSEMBLY_USAGE_OCCURRENCE\('((?:[^']|'')*)','(?:[^']|'')*','',#(\d+),#(\d+),\$\);$", re.MULTILINE
)


def check_zones(contents: Contents) -> Iterator[str]:
    """The zone and the number of each piece against the project, the other tables and the model."""
    if "pieces.csv" not in contents.files:
        return
    pieces = {row["Piece"]: row for row in contents.table("pieces")}
    zones = contents.manifest["settings"].get("zones") or []
    names = [contents.as_read(zone["name"]) for zone in zones]
    chosen = {face: name for zone, name in zip(zones, names, strict=True) for face in zone["faces"] or ()}
    spans: dict[str, list[int]] = {}
    for piece, row in pieces.items():
        if row["Zone"] not in (names or [""]):
            yield f"pieces.csv has {piece} in zone {row['Zone']!r}, which the manifest does not have"
        elif row["Kind"] == "panel" and chosen.get(int(row["Element"]), row["Zone"]) != row["Zone"]:
            yield f"pieces.csv has {piece} in zone {row['Zone']}, the manifest in {chosen[int(row['Element'])]}"
        spans.setdefault(row["Zone"], []).append(int(row["Order"]))
    numbers = {number for span in spans.values() for number in span}
    if numbers != set(range(1, len(numbers) + 1)):
        yield "the numbers of the order in pieces.csv do not run from 1 on"
    orders = [spans[name] for name in names if name in spans]
    for one, other in pairwise(orders):
        if max(one) >= min(other):
            yield f"the order in pieces.csv has a piece of a later zone before number {max(one)} of an earlier one"
    yield from _of_neighbours(contents, pieces, {name: number for number, name in enumerate(names or [""])})
    for file, name in (("survey", "Node"), ("supports", "Support")):
        if f"{file}.csv" in contents.files:
            for row in contents.table(file):
                own = pieces[row[name]]["Zone"]
                if row["Zone"] != own:
                    yield f"{row[name]} is in zone {row['Zone']} in {file}.csv, and in zone {own} in pieces.csv"
    if names and "model.step" in contents.files:
        yield from _of_model(contents, pieces)


def _of_neighbours(contents: Contents, pieces: dict[str, dict[str, str]], numbers: dict[str, int]) -> Iterator[str]:
    """What stands between two zones belongs to the first of them, so that no piece stands on one of a later zone."""
    on = [(row["Piece"], row[end]) for row in pieces.values() for end in ("Node A", "Node B")]
    if "panel_edges.csv" in contents.files:
        on += [(row["Panel"], row["Beam"]) for row in contents.table("panel_edges")]
    for piece, other in on:
        if other in pieces and numbers.get(pieces[piece]["Zone"], 0) < numbers.get(pieces[other]["Zone"], 0):
            yield f"{piece} is in zone {pieces[piece]['Zone']}, and {other} on which it stands in a later one"


def _of_model(contents: Contents, pieces: dict[str, dict[str, str]]) -> Iterator[str]:
    """Sub-assemblies: each piece in a group of its zone."""
    found = [(name, int(into), int(own)) for name, into, own in _INSIDE.findall(contents.text("model.step"))]
    of_groups = {own: into for name, into, own in found if name not in pieces}
    of_zones = {own: contents.as_read(name) for name, _, own in found if name not in pieces}
    for name, into, _ in found:
        if name in pieces and of_zones.get(of_groups.get(into, 0), "") != string(pieces[name]["Zone"]):
            yield f"model.step does not have {name} in zone {pieces[name]['Zone']}"

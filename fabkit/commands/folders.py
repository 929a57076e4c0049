"""The commands of finished folders: `fabkit check` and `fabkit diff`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fabkit.commands.terminal import OUT, exit_on_error, printable

__all__ = ["check_command", "diff_command"]

MAX_LINES = 40
"""Largest number of lines that are printed; of the rest, how many there are."""

Folder = Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder that `fabkit build` wrote.")]


def check_command(
    folder: Folder,
    hashes: Annotated[
        bool, typer.Option("--hashes/--no-hashes", help="Whether files must have the hashes of the manifest.")
    ] = True,
) -> None:
    """Check that a finished folder is as it was written, and that its files agree with each other.

    Solids, areas, masses, counts, placements and contours are compared from the files alone, without a CAD kernel. The
    exit code is 0 where nothing is wrong, and 1 otherwise.
    """
    with exit_on_error():
        from fabkit.formats.finished import check_folder

        found = check_folder(folder, hashes=hashes)
        for sentence in found[:MAX_LINES]:
            OUT.print(printable(sentence))
        if len(found) > MAX_LINES:
            OUT.print(f"and {len(found) - MAX_LINES} more")
        if not found:
            written = "is as it was written, and its files agree" if hashes else "has files that agree with each other"
            OUT.print(f"{printable(str(folder))} {written}")
    if found:
        raise typer.Exit(1)


def diff_command(
    old: Annotated[Path, typer.Argument(metavar="OLD", help="Folder of the earlier build.")],
    new: Annotated[Path, typer.Argument(metavar="NEW", help="Folder of the later build.")],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", metavar="CSV", help="File to write the whole table to.")
    ] = None,
    report: Annotated[
        Path | None, typer.Option("--report", metavar="HTML", help="Page to write that shows the pieces in colours.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace existing files.")] = False,
) -> None:
    """List the pieces that are new, gone or changed from one build to another.

    A changed piece has moved, or its sizes, angles, mass or mark differ. The exit code is 0 where there are none, and 1
    otherwise.
    """
    with exit_on_error():
        from fabkit.formats import whole_file, write_csv
        from fabkit.formats.finished import differences_page, folder_differences

        table = folder_differences(old, new)
        for row in [table.columns, *table.texts[:MAX_LINES]] if table.n_rows else []:
            OUT.print(printable("  ".join(f"{cell:<12}" for cell in row).rstrip()))
        if table.n_rows > MAX_LINES:
            OUT.print(f"and {table.n_rows - MAX_LINES} more")
        changes = table.by_column[0].cells
        counts = ", ".join(f"{changes.count(change)} {change}" for change in ("new", "gone", "changed"))
        OUT.print(counts if changes else "no piece is new, gone or changed")
        if out is not None:
            with whole_file(out, force=force) as draft:
                write_csv(draft, table)
        if report is not None:
            with whole_file(report, force=force) as draft:
                draft.write_text(differences_page(old, new, table), encoding="utf-8", newline="\n")
    if changes:
        raise typer.Exit(1)

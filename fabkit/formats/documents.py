"""All documents of a structure, written into one folder."""

from __future__ import annotations

from collections.abc import Sequence, Set
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fabkit.formats.drawings import write_dxfs
from fabkit.formats.gltf import glb_bytes
from fabkit.formats.legend_table import legend
from fabkit.formats.report import report_html
from fabkit.formats.step import write_part_steps, write_step
from fabkit.formats.tables import write_csv
from fabkit.formats.workbook import write_xlsx
from fabkit.kinds import BEAM, PANEL
from fabkit.parts import Assembly, Column
from fabkit.production import (
    CutList,
    Nest,
    Summary,
    Table,
    build_facts,
    cut_list,
    mark_table,
    panel_drawings,
    part_drawings,
    piece_tables,
    plate_drawings,
    sheet_drawings,
)
from fabkit.rules import DocumentRules
from fabkit.stages import Stages
from geometry.arrays import FloatArray
from geometry.files import write_mesh
from geometry.gauss import Pair
from geometry.mesh import Mesh

__all__ = ["write_documents"]

IN_FILES_ONLY = ("pieces", "placements", "node_facets", "panel_edges", "mark_points")
"""Tables that are CSV files, but not sheets of the workbook: with a row for each piece, facet, edge or corner they
would print on a hundred pages."""


def write_documents(
    folder: Path,
    pair: Pair,
    assembly: Assembly,
    nest: Nest | None,
    summary: Summary,
    stages: Stages,
    rules: DocumentRules | None = None,
) -> None:
    """Write M.obj, S.obj, model.step, parts/, sheets/, panels/, plates/ where there are other plates, drawings/, the
    tables, cutlist.xlsx, model.glb and report.html, or those of them that the rules choose, into an empty folder.

    pair: in millimetres near zero; the parts' elements are edges, vertices and faces of its mesh. M.obj is in the unit
    and at the place of the mesh file, S.obj near the unit sphere about zero.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import write_documents
    >>> from fabkit.stages import Stages
    >>> write_documents(Path(), built.structure.pair, built.assembly, built.nest, built.summary, Stages())
    >>> sorted(path.name for path in Path().glob("*.csv"))[:4], len(list(Path("sheets").iterdir()))
    (['beams.csv', 'legend.csv', 'mark_points.csv', 'node_facets.csv'], 3)
    """
    rules = rules or DocumentRules()
    chosen, issued = set(rules.documents), rules.title_block
    if "meshes" in chosen:
        with stages("Meshes"):
            write_mesh(folder / "M.obj", pair.mesh * (1 / summary.scale_mm), origin=summary.origin)
            write_mesh(folder / "S.obj", pair.gauss_image)
    parts_folder = folder / "parts" if "parts" in chosen else None
    if parts_folder:
        parts_folder.mkdir()
    if "step" in chosen:
        with stages("STEP model and parts" if parts_folder else "STEP model"):  # whose solids are the same text
            write_step(folder / "model.step", assembly, parts_folder=parts_folder, **_step_head(rules))
    elif parts_folder:
        with stages("STEP parts"):
            write_part_steps(parts_folder, assembly.groups, **_step_head(rules))
    drawn = rules.drawings
    title = issued.title_of(summary.name)
    kept: dict[str, Any] = {"labels": drawn.labels, "corner_mm": drawn.corner_mm, "title": title}
    files: dict[str, Any] = {"version": drawn.version, "suffix": drawn.suffix}
    if "sheets" in chosen:
        with stages("DXF of sheets"):
            (folder / "sheets").mkdir()
            sheets = sheet_drawings(nest, assembly.of(PANEL), **kept) if nest else ()
            write_dxfs(folder / "sheets", sheets, **files)
    if "panels" in chosen:
        with stages("DXF of panels"):
            (folder / "panels").mkdir()
            write_dxfs(folder / "panels", panel_drawings(assembly, **kept), **files)
    if "plates" in chosen and (plates := plate_drawings(assembly, labels=drawn.labels != "none", title=title)):
        with stages("DXF of plates"):
            (folder / "plates").mkdir()
            write_dxfs(folder / "plates", plates, **files)
    panel_file = f"panels/{{}}{drawn.suffix}"
    lists = CutList(_of_written_files(cut_list(assembly, nest, panel_file=panel_file).tables, chosen))
    pieces = _of_written_files(piece_tables(assembly, nest, panel_file=panel_file, site=summary.site), chosen)
    tables = [*(table.of_single_values() for table in lists.tables), *pieces]
    if "drawings" in chosen:
        with stages("DXF of beams and nodes"):
            (folder / "drawings").mkdir()
            write_dxfs(folder / "drawings", part_drawings(assembly, lists, title=title), **files)
    tables.append(mark_table(assembly, summary.earlier_marks))
    kinds = [parts.kind for parts in assembly.groups]
    facts = build_facts(summary, assembly, nest)
    if "tables" in chosen:
        with stages("Tables"):
            for table in [legend(summary.site, kinds), *tables]:
                write_csv(folder / table.file, table, rules.tables)
    if "workbook" in chosen:
        with stages("Workbook"):
            write_xlsx(folder / "cutlist.xlsx", tables, summary, facts, issued, apart=IN_FILES_ONLY, kinds=kinds)
    missing = _left_out_lines(pair.mesh, assembly)
    if "glb" in chosen:
        with stages("GLB"):
            (folder / "model.glb").write_bytes(glb_bytes(assembly, missing))
    if "report" in chosen:
        with stages("Report"):
            pictures = sheet_drawings(nest, assembly.of(PANEL)) if nest else ()  # whose marks can be read
            text = report_html(
                summary=summary,
                facts=facts,
                assembly=assembly,
                tables=lists.tables,
                pieces=pieces,
                sheets=pictures,
                left_out_lines=missing,
                issue=issued.issue,
            )
            (folder / "report.html").write_bytes(text.encode())


def _of_written_files(tables: Sequence[Table], folders: Set[str]) -> tuple[Table, ...]:
    """The tables without the names of files in folders that are not written."""
    if {"parts", "panels"} <= folders:
        return tuple(tables)
    return tuple(
        replace(table, by_column=tuple(_of_written(column, folders) for column in table.by_column)) for table in tables
    )


def _of_written(column: Column, folders: Set[str]) -> Column:
    if column.title != "File":
        return column
    return replace(column, cells=[file if str(file).partition("/")[0] in folders else "" for file in column.cells])


def _step_head(rules: DocumentRules) -> dict[str, Any]:
    """What the headers of STEP files say, but for their names."""
    issued = rules.title_block
    head = {key: getattr(issued, key) for key in ("author", "organisation", "revision")}
    dated = {"time_stamp": f"{issued.date}T00:00:00"} if issued.date else {}
    return {"schema": rules.step.schema, **head, **dated}


def _left_out_lines(mesh: Mesh, assembly: Assembly) -> FloatArray:
    """(n, 2, 3) ends in mm of the edges whose beams are left out."""
    edges = np.array([left.element for left in assembly.left_out if left.kind == BEAM.name], dtype=np.int64)
    lines: FloatArray = mesh.vertices[mesh.combinatorics.edges[edges]]
    return lines

"""All documents of a structure, written into one folder."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fabkit.formats.drawings import write_dxf
from fabkit.formats.gltf import glb_bytes
from fabkit.formats.report import report_html
from fabkit.formats.step import write_part_steps, write_step
from fabkit.formats.tables import write_csv, write_xlsx
from fabkit.kinds import BEAM, PANEL
from fabkit.parts import Assembly
from fabkit.production import Nest, Summary, build_facts, cut_list, panel_drawings, sheet_drawings
from fabkit.stages import Stages
from geometry.arrays import FloatArray
from geometry.files import write_mesh
from geometry.gauss import Pair
from geometry.mesh import Mesh

__all__ = ["write_documents"]


def write_documents(
    folder: Path, pair: Pair, assembly: Assembly, nest: Nest | None, summary: Summary, stages: Stages
) -> None:
    """Write M.obj, S.obj, model.step, parts/, sheets/, panels/, the cut lists, model.glb and report.html into an empty
    folder.

    pair: in millimetres near zero; the parts' elements are edges, vertices and faces of its mesh. M.obj is in the unit
    and at the place of the mesh file, S.obj near the unit sphere about zero.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import write_documents
    >>> from fabkit.stages import Stages
    >>> write_documents(Path(), built.structure.pair, built.assembly, built.nest, built.summary, Stages())
    >>> sorted(path.name for path in Path().glob("*.csv")), len(list(Path("sheets").iterdir()))
    (['beams.csv', 'nodes.csv', 'panels.csv'], 3)
    """
    with stages("Meshes"):
        write_mesh(folder / "M.obj", pair.mesh * (1 / summary.scale_mm), origin=summary.origin)
        write_mesh(folder / "S.obj", pair.gauss_image)
    with stages("STEP model"):
        write_step(folder / "model.step", assembly)
    with stages("STEP parts"):
        (folder / "parts").mkdir()
        write_part_steps(folder / "parts", assembly.groups)
    with stages("DXF"):
        sheets = sheet_drawings(nest, assembly.of(PANEL)) if nest else ()
        (folder / "sheets").mkdir()
        for sheet in sheets:
            write_dxf(folder / "sheets" / f"{sheet.name}.dxf", sheet)
        (folder / "panels").mkdir()
        for drawing in panel_drawings(assembly):
            write_dxf(folder / "panels" / f"{drawing.name}.dxf", drawing)
    with stages("Cut lists"):
        lists = cut_list(assembly, nest)
        for table in lists.tables:
            write_csv(folder / f"{table.title}.csv", table)
        facts = build_facts(summary, assembly, nest)
        write_xlsx(folder / "cutlist.xlsx", lists, summary, facts)
    with stages("GLB"):
        glb = glb_bytes(assembly, _left_out_lines(pair.mesh, assembly))
        (folder / "model.glb").write_bytes(glb)
    with stages("Report"):
        text = report_html(summary=summary, facts=facts, assembly=assembly, tables=lists.tables, sheets=sheets, glb=glb)
        (folder / "report.html").write_text(text, encoding="utf-8", newline="\n")


def _left_out_lines(mesh: Mesh, assembly: Assembly) -> FloatArray:
    """(n, 2, 3) ends in mm of the edges whose beams are left out."""
    edges = np.array([left.element for left in assembly.left_out if left.kind == BEAM.name], dtype=np.int64)
    lines: FloatArray = mesh.vertices[mesh.combinatorics.edges[edges]]
    return lines

"""Meshes and tables of curvatures, written in the unit and at the place of the input, and what is printed of them."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.text import Text

from fabkit.commands.facts import findings_facts, moves
from fabkit.commands.printing import MESH_SUFFIXES, add_facts, check_suffix
from fabkit.commands.terminal import OUT, facts_table, printable
from fabkit.fitness import Finding, FitnessRules
from fabkit.fitness.shape import of_planar_mesh
from fabkit.formats import whole_file
from fabkit.gauss_image import GIVEN_PAIR_TOLERANCE, read_given_pair
from fabkit.structure import made_planar
from geometry.arrays import FloatArray
from geometry.curvature import FaceCurvatures, face_curvatures
from geometry.errors import GeometryError
from geometry.exact_offsets import exact_or_approximate_pair, offset
from geometry.files import MeshFile, read_mesh, write_mesh
from geometry.gauss import Pair, nearest_parallel_pair
from geometry.mesh import Mesh

__all__ = ["write_curvature", "write_offset", "write_planar"]


@dataclass(frozen=True, eq=False)
class _Planar:
    """A mesh file near zero, its mesh with planar faces, or the pair of it and the Gauss image that was given, and what
    is unusual about it."""

    file: MeshFile
    mesh: Mesh
    pair: Pair | None
    findings: tuple[Finding, ...]

    @property
    def facts(self) -> list[tuple[str, str]]:
        mended = [("mended", note) for note in self.file.mended]
        planarised = ("planarised", moves(self.file.mesh, self.mesh) or "nothing to do")
        return [*mended, planarised, *findings_facts(self.findings, may_accept=False)]

    @property
    def paired(self) -> Pair:
        """With the Gauss image that was given, or the one with which a build would be made."""
        if self.pair is not None:
            return self.pair
        moved = float(np.linalg.norm(self.mesh.vertices - self.file.mesh.vertices, axis=1).max())
        try:
            return exact_or_approximate_pair(self.mesh, moved=moved, rounding=self.file.rounding)[0]
        except GeometryError as error:
            if self.mesh.combinatorics.face_sizes.max() > 3:
                raise
            raise GeometryError(f"{error.message}, or by `fabkit mesh`") from None


def write_planar(path: Path, out: Path, *, flip: bool, weights: dict[str, Any], force: bool) -> None:
    """Write the mesh with planar faces."""
    check_suffix(out, MESH_SUFFIXES)
    with whole_file(out, force=force, inputs=[path]) as draft:
        planar = _planar(path, None, flip, weights)
        write_mesh(draft, planar.mesh, origin=planar.file.origin)
    _print(planar.facts, out)


def write_offset(
    path: Path,
    out: Path,
    distance: float,
    kind: Any,
    *,
    gauss_image: Path | None,
    flip: bool,
    weights: dict[str, Any],
    force: bool,
) -> None:
    """Write the offset at a distance in the unit of the mesh, with constant distances of edges, faces or vertices."""
    check_suffix(out, MESH_SUFFIXES)
    with whole_file(out, force=force, inputs=_inputs(path, gauss_image)) as draft:
        planar = _planar(path, gauss_image, flip, weights)
        given = planar.pair or (planar.mesh if kind else planar.paired)
        layer = offset(given, distance, None if kind is None else str(kind))  # type: ignore[arg-type]
        write_mesh(draft, layer.mesh, origin=planar.file.origin)
    constant = f"constant distance of the {KIND_NAMES[layer.kind]}" if layer.kind else "no distance is constant"
    facts = [
        ("offset", constant),
        ("edge lines", f"{_range(layer.edge_distances)} apart"),
        ("face planes", f"{_range(layer.face_distances)} apart"),
        ("vertices", f"{_range(layer.vertex_distances)} apart"),
    ]
    _print([*planar.facts, *facts], out)


def write_curvature(
    path: Path,
    out: Path,
    colour: str,
    *,
    gauss_image: Path | None,
    flip: bool,
    weights: dict[str, Any],
    force: bool,
) -> None:
    """Write a table of all faces, or the mesh with planar faces in the colours of a curvature."""
    check_suffix(out, (".csv", *MESH_SUFFIXES))
    with whole_file(out, force=force, inputs=_inputs(path, gauss_image)) as draft:
        planar = _planar(path, gauss_image, flip, weights)
        pair = planar.paired
        curvatures = face_curvatures(pair)
        if out.suffix.lower() == ".csv":
            _write_table(draft, curvatures)
        else:
            values = getattr(curvatures, colour)
            write_mesh(draft, pair.mesh, values=values, on="faces", origin=planar.file.origin)
    facts = [
        (f"{name} curvature", f"{_range(values)}, median {np.median(values):.4g}, {unit}")
        for name, values, unit in (
            ("mean", curvatures.mean, "one over the unit of the mesh; negative on a dome"),
            ("Gaussian", curvatures.gaussian, "one over its square"),
        )
    ]
    _print([*planar.facts, *facts], out)


KIND_NAMES = {"edge": "edge lines", "face": "face planes", "vertex": "vertices"}


def _planar(path: Path, gauss_image: Path | None, flip: bool, weights: dict[str, Any]) -> _Planar:
    if gauss_image is None:
        file, pair = read_mesh(path, flip=flip).near_zero(), None
        mesh = made_planar(file.mesh, weights)
    else:
        given = read_given_pair(path, gauss_image, flip=flip, tolerance=GIVEN_PAIR_TOLERANCE)
        file, pair = (
            given.file,
            nearest_parallel_pair(given.file.mesh, given.gauss_image, tolerance=GIVEN_PAIR_TOLERANCE),
        )
        mesh = pair.mesh
    return _Planar(file, mesh, pair, of_planar_mesh(file.mesh, mesh, FitnessRules()))


def _write_table(path: Path, curvatures: FaceCurvatures) -> None:
    columns = ("Face", "Area", "Mean curvature", "Gaussian curvature", "Principal curvature 1", "Principal curvature 2")
    numbers = np.column_stack((curvatures.areas, curvatures.mean, curvatures.gaussian, curvatures.principal))
    with path.open("w", encoding="ascii", newline="") as stream:
        rows = csv.writer(stream, lineterminator="\n")
        rows.writerow(columns)
        rows.writerows(
            [face, *("" if np.isnan(number) else repr(number) for number in row)]
            for face, row in enumerate(numbers.tolist())
        )


def _inputs(path: Path, gauss_image: Path | None) -> list[Path]:
    return [path] if gauss_image is None else [path, gauss_image]


def _range(values: FloatArray) -> str:
    low, high = f"{values.min():.4g}", f"{values.max():.4g}"
    return low if low == high else f"{low} to {high}"


def _print(facts: Iterable[tuple[str, str]], out: Path) -> None:
    table = facts_table()
    add_facts(table, facts)
    OUT.print(table)
    OUT.print(Text.assemble("written to ", (printable(str(out)), "bold")))

"""STEP, IGES and BREP files, read by the OCCT kernel that build123d and CadQuery bring."""

from __future__ import annotations

import hashlib
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fabkit.errors import FabkitError
from fabkit.wording import readable

if TYPE_CHECKING:
    from OCP.TopoDS import TopoDS_Shape

__all__ = ["EXACT_SUFFIXES", "ShapeFile", "read_shape"]

EXACT_SUFFIXES = (".step", ".stp", ".iges", ".igs", ".brep")

IGES_UNITS = {"IN": "inches", "INCH": "inches", "FT": "feet", "M": "metres", "CM": "centimetres", "KM": "kilometres"}
STEP_UNITS = {"inch": "inches", "foot": "feet", "metre": "metres", "centimetre": "centimetres"}
"""Names of units in files, and ours; others are shown as they are."""


@dataclass(frozen=True, eq=False)
class ShapeFile:
    """shape: of the kernel, in millimetres. sha256: of the bytes that were read. notes: what is to be reported of it,
    such as its unit."""

    shape: TopoDS_Shape
    sha256: str
    notes: tuple[str, ...]


def read_shape(path: Path) -> ShapeFile:
    """What a STEP, IGES or BREP file holds. Raises FabkitError where it cannot be read, or there is no CAD kernel.

    >>> from fabkit import FabkitError
    >>> from fabkit.formats.surfaces import read_shape
    >>> try:
    ...     read_shape(Path("no such surface.step"))
    ... except FabkitError as error:
    ...     print("no such surface.step" in str(error))
    True
    """
    name, suffix = readable(path.name), path.suffix.lower()
    try:
        import OCP.IFSelect  # noqa: F401
    except ModuleNotFoundError as error:
        raise FabkitError(
            f"{name} holds exact surfaces, which the CAD kernel of build123d or CadQuery reads: pip "
            'install "fabkit[build123d]" or "fabkit[cadquery]", or export the surface as a mesh'
        ) from error
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        raise FabkitError(f"there is no file {name}") from error
    except OSError as error:
        raise FabkitError(f"{name} cannot be read: {error.strerror or error}") from error
    with tempfile.TemporaryDirectory() as folder:  # the kernel reads the bytes that the hash is of
        copy = Path(folder, f"shape{suffix}")
        copy.write_bytes(data)
        shape, unit = _of_brep(copy, name) if suffix == ".brep" else _of_exchange_file(copy, name)
    notes = [] if unit in (None, "mm") else [f"lengths are in {unit} in the file, and were read in mm"]
    if solids := _solids(shape):
        skin = "its whole skin is" if solids == 1 else "their whole skins are"
        notes.append(f"{solids} solid{'' if solids == 1 else 's'} in the file: {skin} taken as the surface")
    return ShapeFile(shape, hashlib.sha256(data).hexdigest(), tuple(notes))


def _of_brep(path: Path, name: str) -> tuple[TopoDS_Shape, None]:
    from OCP.BRep import BRep_Builder
    from OCP.BRepTools import BRepTools
    from OCP.TopoDS import TopoDS_Shape

    shape = TopoDS_Shape()
    if not BRepTools.Read_s(shape, str(path), BRep_Builder()) or shape.IsNull():
        raise FabkitError(f"{name} is no BREP file that can be read; export it again")
    return shape, None


def _of_exchange_file(path: Path, name: str) -> tuple[TopoDS_Shape, str | None]:
    """The shape in a STEP or IGES file, and the unit of its lengths."""
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.IGESControl import IGESControl_Reader
    from OCP.STEPControl import STEPControl_Reader

    is_step = path.suffix in (".step", ".stp")
    reader: Any = STEPControl_Reader() if is_step else IGESControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise FabkitError(f"{name} cannot be read by the CAD kernel; export it again")
    unit = _unit_of_step(reader) if is_step else _unit_of_iges(reader)
    if not reader.TransferRoots() or reader.OneShape().IsNull():
        raise FabkitError(f"{name} holds no shape that the CAD kernel reads: export the surface again")
    return reader.OneShape(), unit


def _unit_of_step(reader: Any) -> str | None:
    try:
        from OCP.collections import Sequence_TCollection_AsciiString as Names  # since OCCT 8
    except ModuleNotFoundError:
        from OCP.TColStd import TColStd_SequenceOfAsciiString as Names
    lengths, angles, solid_angles = Names(), Names(), Names()
    reader.FileUnits(lengths, angles, solid_angles)
    found = [each.ToCString().lower() for each in lengths]
    return None if not found else "mm" if found[0] == "millimetre" else STEP_UNITS.get(found[0], readable(found[0]))


def _unit_of_iges(reader: Any) -> str | None:
    name = reader.IGESModel().GlobalSection().UnitName()
    found = "" if name is None else name.ToCString().upper()
    return "mm" if found == "MM" else IGES_UNITS.get(found) or (readable(found) if found else None)


def _solids(shape: TopoDS_Shape) -> int:
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopExp import TopExp_Explorer

    explorer, count = TopExp_Explorer(shape, TopAbs_SOLID), 0
    while explorer.More():
        count += 1
        explorer.Next()
    return count

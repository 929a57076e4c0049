"""What OCCT makes of a STEP file or a shape; works with the OCP wheels of build123d and of CadQuery."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from geometry.arrays import FloatArray

__all__ = ["HAS_KERNEL", "Body", "Placed", "measure", "read_step", "solids_in"]

HAS_KERNEL = find_spec("OCP") is not None


@dataclass(frozen=True)
class Body:
    """What OCCT says about one solid."""

    valid: bool
    closed: bool
    volume: float
    area: float
    centroid: FloatArray
    n_faces: int


@dataclass(frozen=True)
class Placed:
    """A leaf of the tree in a file. path: names of instances from the root on; product: name of the shape.

    stated: volume, area and centroid as the file says, or None; colour: sRGB.
    """

    path: tuple[str, ...]
    product: str
    body: Body
    n_solids: int
    colour: tuple[float, ...] | None
    density: float
    stated: tuple[float, float, FloatArray] | None


def measure(shape: Any) -> Body:
    """Of a shape that is one solid; lengths in mm, in the place where the shape stands."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL

    volume, surface = GProp_GProps(), GProp_GProps()
    valid = BRepCheck_Analyzer(shape).IsValid()
    BRepGProp.VolumeProperties_s(shape, volume)
    BRepGProp.SurfaceProperties_s(shape, surface)
    centre = volume.CentreOfMass()
    shells = explored(shape, TopAbs_SHELL)
    return Body(
        valid=valid,
        closed=len(shells) == 1 and BRep_Tool.IsClosed_s(shells[0]),
        volume=volume.Mass(),
        area=surface.Mass(),
        centroid=np.array([centre.X(), centre.Y(), centre.Z()]),
        n_faces=len(explored(shape, TopAbs_FACE)),
    )


def explored(shape: Any, kind: Any) -> list[Any]:
    from OCP.TopExp import TopExp_Explorer

    explorer, found = TopExp_Explorer(shape, kind), []
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def solids_in(shape: Any) -> list[Any]:
    from OCP.TopAbs import TopAbs_SOLID

    return explored(shape, TopAbs_SOLID)


def read_step(path: Path) -> list[Placed]:
    """All leaves of all roots, in the order of the file."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopLoc import TopLoc_Location
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    reader = STEPCAFControl_Reader()
    for mode in (reader.SetNameMode, reader.SetColorMode, reader.SetPropsMode, reader.SetMatMode):
        mode(True)
    assert reader.ReadFile(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    assert reader.Transfer(document)
    roots = labels()
    XCAFDoc_DocumentTool.ShapeTool_s(document.Main()).GetFreeShapes(roots)
    found: list[Placed] = []
    for root in listed(roots):
        collect(root, root, (), TopLoc_Location(), found)
    return found


def collect(instance: Any, product: Any, path: tuple[str, ...], location: Any, found: list[Placed]) -> None:
    """Add the leaves below a product that stands at a location."""
    from OCP.TDF import TDF_Label
    from OCP.XCAFDoc import XCAFDoc_MaterialTool, XCAFDoc_ShapeTool

    path = (*path, name(instance))
    if XCAFDoc_ShapeTool.IsAssembly_s(product):
        components = labels()
        XCAFDoc_ShapeTool.GetComponents_s(product, components)
        for component in listed(components):
            referred = TDF_Label()
            XCAFDoc_ShapeTool.GetReferredShape_s(component, referred)
            collect(component, referred, path, location * XCAFDoc_ShapeTool.GetLocation_s(component), found)
        return
    shape = XCAFDoc_ShapeTool.GetShape_s(product)
    density = XCAFDoc_MaterialTool.GetDensityForShape_s(product)
    solids = solids_in(shape)
    body = measure(solids[0].Moved(location))
    found.append(Placed(path, name(product), body, len(solids), colour(product), density, stated(product)))


def labels() -> Any:
    """An empty sequence of labels."""
    import OCP.TDF

    if hasattr(OCP.TDF, "TDF_LabelSequence"):
        return OCP.TDF.TDF_LabelSequence()
    from OCP.collections import Sequence_TDF_Label  # its name since OCP 8

    return Sequence_TDF_Label()


def listed(sequence: Any) -> list[Any]:
    return [sequence.Value(n) for n in range(1, sequence.Length() + 1)]


def name(label: Any) -> str:
    from OCP.TDataStd import TDataStd_Name

    attribute = TDataStd_Name()
    return str(attribute.Get().ToExtString()) if label.FindAttribute(TDataStd_Name.GetID_s(), attribute) else ""


def colour(label: Any) -> tuple[float, ...] | None:
    from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
    from OCP.XCAFDoc import XCAFDoc_ColorTool, XCAFDoc_ColorType

    found = Quantity_Color()
    if not XCAFDoc_ColorTool.GetColor_s(label, XCAFDoc_ColorType.XCAFDoc_ColorSurf, found):
        return None
    return tuple(found.Values(Quantity_TypeOfColor.Quantity_TOC_sRGB))


def stated(label: Any) -> tuple[float, float, FloatArray] | None:
    from OCP.XCAFDoc import XCAFDoc_Area, XCAFDoc_Centroid, XCAFDoc_Volume

    volume, area, centroid = XCAFDoc_Volume(), XCAFDoc_Area(), XCAFDoc_Centroid()
    for attribute in (volume, area, centroid):
        if not label.FindAttribute(type(attribute).GetID_s(), attribute):
            return None
    centre = centroid.Get()
    return volume.Get(), area.Get(), np.array([centre.X(), centre.Y(), centre.Z()])

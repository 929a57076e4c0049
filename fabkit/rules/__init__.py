"""What a shop decides, and what a project file may therefore set: a file for each subject, with all default values."""

from fabkit.rules.connections import CONNECTION_KINDS, ConnectionKind, ConnectionRules
from fabkit.rules.detailing import (
    BeamRules,
    Densities,
    DetailingRules,
    NodeRules,
    SecondLayerRules,
)
from fabkit.rules.documents import (
    DOCUMENTS,
    Document,
    DocumentRules,
    DrawingRules,
    StepRules,
    TableRules,
    TitleBlock,
)
from fabkit.rules.fins import FinRules
from fabkit.rules.layers import LayerRules, problem_of_mirrored_panes
from fabkit.rules.lengths import LARGEST_LENGTH_MM, Level, NotNegative, Positive
from fabkit.rules.marks import MarkOrder, MarkRules
from fabkit.rules.sheets import CuttingProcess, SheetRules, SheetSize
from fabkit.rules.site import SiteRules
from fabkit.rules.supports import SupportRules
from fabkit.rules.zones import ZoneRules

__all__ = [
    "CONNECTION_KINDS",
    "DOCUMENTS",
    "LARGEST_LENGTH_MM",
    "BeamRules",
    "ConnectionKind",
    "ConnectionRules",
    "CuttingProcess",
    "Densities",
    "DetailingRules",
    "Document",
    "DocumentRules",
    "DrawingRules",
    "FinRules",
    "LayerRules",
    "Level",
    "MarkOrder",
    "MarkRules",
    "NodeRules",
    "NotNegative",
    "Positive",
    "SecondLayerRules",
    "SheetRules",
    "SheetSize",
    "SiteRules",
    "StepRules",
    "SupportRules",
    "TableRules",
    "TitleBlock",
    "ZoneRules",
    "problem_of_mirrored_panes",
]

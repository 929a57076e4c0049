"""The project file: what to build, checked once at the border."""

from __future__ import annotations

import re
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetPydanticSchema,
    ValidationError,
    field_validator,
    model_validator,
)
from pydantic_core import core_schema

from fabkit.errors import ProjectError
from fabkit.fitness import CRITERIA, FitnessRules
from fabkit.gauss_image import GaussImageRules
from fabkit.optimisation import OptimiseRules
from fabkit.overrides import layer_tables, with_overrides
from fabkit.production import EQUAL_WITHIN_MM
from fabkit.refused_settings import problems, truth_for_number
from fabkit.rules import (
    DOCUMENTS,
    BeamRules,
    ConnectionRules,
    Densities,
    DetailingRules,
    Document,
    DocumentRules,
    DrawingRules,
    FinRules,
    LayerRules,
    MarkRules,
    NodeRules,
    Positive,
    SecondLayerRules,
    SheetRules,
    SiteRules,
    StepRules,
    SupportRules,
    TableRules,
    TitleBlock,
    ZoneRules,
    problem_of_mirrored_panes,
)
from fabkit.surface import SurfaceRules, check_surface
from fabkit.toml_tables import BACKSLASHES, read_tables
from fabkit.units import MM_PER_UNIT, Unit
from fabkit.wording import echo, one_line, readable
from geometry.mesh import Mesh

__all__ = [
    "Nesting",
    "PlanariseWeights",
    "Project",
    "load_project",
    "project_from",
    "surface_rules_from",
]

_STRICT = ConfigDict(extra="forbid", frozen=True)

MeshSource = Annotated[
    Path | Mesh,
    GetPydanticSchema(
        lambda _, handler: core_schema.no_info_wrap_validator_function(
            lambda given, path: given if isinstance(given, Mesh) else path(given), handler(Path)
        )
    ),
]
"""The path of a mesh file, or a mesh in memory."""


class PlanariseWeights(BaseModel):
    """Weight of the shape of the edges against closeness to the given vertices when faces are made planar.

    keep_boundary: vertices of the boundary slide on the curve through them; where they glide on a surface, too, they
    are attracted to that curve.
    """

    model_config = _STRICT

    fairness: Annotated[float, Field(ge=0, allow_inf_nan=False)] | None = None
    keep_boundary: bool | None = None


class Nesting(BaseModel):
    """How panels are laid on sheets; seconds: what `best` may take."""

    model_config = _STRICT

    mode: Literal["quick", "best", "off"] = "quick"
    seconds: Positive = 60.0


class Project(BaseModel):
    """A mesh, or a surface to lay one on, and all settings of a build.

    mesh: the path of a file, or a `Mesh` (then the manifest names no input file). Either unit, the unit of its
    coordinates, or mean_edge_mm, the length to which its mean edge is scaled, is required. flip reverses all faces, and
    so the outside. name: of the structure, by default that of the mesh file. surface: the file is a design surface, and
    a mesh is laid on it; mean_edge_mm is then that of this mesh. gauss_image: weights, or a file, which may also stand
    in the place of the whole table. optimise: mesh and Gauss image together. equal_within_mm: largest difference
    between coordinates of parts that share a mark; marks: what else they have in common, and how they are numbered.
    fitness: bounds from which a finding is noted or refused; accept: findings to accept instead of refusing them.
    layers: of panels, from outside to inside. second_layer, fins, supports: None for a structure without. zones: in
    the order in which they are put up. site: in
    whose coordinates nodes are set out. documents: what is written; title_block, tables, drawings and step: how, see
    `DocumentRules`.

    >>> from geometry.mesh.shapes import dome
    >>> project = Project(mesh=dome(6, 2), unit="m", beams={"width_mm": 60, "height_mm": 150})
    >>> project.rules.beams.profile.name, project.title, Project(mesh="roof.obj", unit="m").title
    ('flat 150x60', 'structure', 'roof')
    """

    model_config = _STRICT

    mesh: MeshSource
    out: Path | None = None
    name: Annotated[str, Field(max_length=120), AfterValidator(one_line)] = ""
    unit: Unit | None = None
    mean_edge_mm: Positive | None = None
    flip: bool = False
    skip_unbuildable: bool = False
    equal_within_mm: Annotated[float, Field(gt=0, le=1, allow_inf_nan=False)] = EQUAL_WITHIN_MM
    accept: tuple[str, ...] = ()
    fitness: FitnessRules = Field(default_factory=FitnessRules)
    surface: SurfaceRules | None = None
    planarise: PlanariseWeights = PlanariseWeights()
    gauss_image: GaussImageRules = GaussImageRules()
    optimise: OptimiseRules | None = None
    nesting: Nesting = Nesting()
    beams: BeamRules = Field(default_factory=BeamRules)
    connection: ConnectionRules = Field(default_factory=ConnectionRules)
    nodes: NodeRules = Field(default_factory=NodeRules)
    layers: tuple[LayerRules, ...] = Field(default_factory=lambda: (LayerRules(),))
    sheets: SheetRules = Field(default_factory=SheetRules)
    marks: MarkRules = Field(default_factory=MarkRules)
    second_layer: SecondLayerRules | None = None
    fins: FinRules | None = None
    supports: SupportRules | None = None
    zones: tuple[ZoneRules, ...] = ()
    densities_kg_m3: Densities = Field(default_factory=lambda: DetailingRules().densities_kg_m3)
    site: SiteRules | None = None
    documents: tuple[Document, ...] = DOCUMENTS
    title_block: TitleBlock = Field(default_factory=TitleBlock)
    tables: TableRules = Field(default_factory=TableRules)
    drawings: DrawingRules = Field(default_factory=DrawingRules)
    step: StepRules = Field(default_factory=StepRules)

    if not TYPE_CHECKING:  # type checkers read the keywords from the fields

        def __init__(self, /, **settings: Any) -> None:
            try:
                super().__init__(**settings)
            except ValidationError as error:
                raise ProjectError(problems(error, Project)) from None
            if wrong := truth_for_number(settings, self):
                raise ProjectError(wrong)

    @model_validator(mode="before")
    @classmethod
    def _panels_are_layers(cls, given: Any) -> Any:
        if isinstance(given, dict) and "panels" in given:
            raise ValueError(
                "[panels] is now [[layers]], a list of layers from outside to inside: write [[layers]] in its place; "
                "thickness_mm and joint_mm keep their names, underside_mm is z_mm"
            )
        return given

    @field_validator("gauss_image", mode="before")
    @classmethod
    def _file_alone(cls, given: Any) -> Any:
        return {"file": given} if isinstance(given, str | Path) else given

    @field_validator("accept")
    @classmethod
    def _known_and_acceptable(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for name in names:
            close = get_close_matches(name, CRITERIA, n=1, cutoff=0.5)
            known = ", ".join(each for each, reason in CRITERIA.items() if not reason)
            if name not in CRITERIA:
                hint = f"did you mean {close[0]}?" if close else f"those that can be accepted are {known}"
                raise ValueError(f"{name!r} is no criterion; {hint}")
            if CRITERIA[name]:
                raise ValueError(f"{name!r} cannot be accepted: {CRITERIA[name]}; those that can be are {known}")
        return tuple(dict.fromkeys(names))

    @model_validator(mode="after")
    def _checked_as_a_whole(self) -> Project:
        if (self.unit is None) == (self.mean_edge_mm is None):
            found = "neither is given" if self.unit is None else "both are given"
            units = ", ".join(MM_PER_UNIT)
            raise ValueError(
                f"either the unit of the mesh or the length of its mean edge is needed, and {found}: say unit "
                f"(--unit) as one of {units}, or mean_edge_mm (--mean-edge) in mm for a model without unit"
            )
        if self.gauss_image.file is not None and isinstance(self.mesh, Mesh):
            raise ValueError("gauss_image.file needs a mesh file beside it: write the mesh, or leave gauss_image out")
        check_surface(self.surface, self.mesh, self.unit, has_image=self.gauss_image.file is not None)
        if self.optimise is not None and self.gauss_image.file is not None:
            raise ValueError(
                "the Gauss image is given by gauss_image.file (--gauss-image), so that it cannot be optimised: take it "
                "out, or [optimise] (--optimise)"
            )
        if self.gauss_image.file is not None and self.planarise.model_dump(exclude_none=True):
            raise ValueError(
                "the Gauss image is given by gauss_image.file, so the mesh is made planar together with it and "
                "[planarise] says nothing: take one of the two out"
            )
        if self.surface is not None and any(layer.parallel for layer in self.layers):
            raise ValueError("a layer with parallel needs a mesh that is given, and this one is laid on a surface")
        if self.nesting.mode == "best" and self.sheets.process == "saw":
            raise ValueError(
                "nesting.mode is 'best', which does not keep to cuts from edge to edge, and sheets.process is 'saw': "
                "take the quick nest, which does, or another process"
            )
        if self.marks.mirrored_panes and (problem := problem_of_mirrored_panes(self.layers)):
            raise ValueError(problem)
        if self.title in {zone.name for zone in self.zones}:
            raise ValueError(f"a zone is called {echo(self.title)}, like the structure: give it another name")
        _ = self.rules, self.document_rules  # they check each other
        return self

    @property
    def rules(self) -> DetailingRules:
        return DetailingRules(
            beams=self.beams,
            connection=self.connection,
            nodes=self.nodes,
            layers=self.layers,
            sheets=self.sheets,
            second_layer=self.second_layer,
            fins=self.fins,
            supports=self.supports,
            zones=self.zones,
            densities_kg_m3=self.densities_kg_m3,
        )

    @property
    def document_rules(self) -> DocumentRules:
        return DocumentRules(
            documents=self.documents,
            title_block=self.title_block,
            tables=self.tables,
            drawings=self.drawings,
            step=self.step,
        )

    @property
    def title(self) -> str:
        """The name of the structure; without one that of the mesh file."""
        return readable(self.name or ("structure" if isinstance(self.mesh, Mesh) else self.mesh.stem))

    @property
    def mesh_path(self) -> Path:
        """The mesh file. Raises ProjectError for a mesh in memory."""
        if isinstance(self.mesh, Mesh):
            raise ProjectError("the mesh of this project is in memory: write it to a file, and give its path")
        return self.mesh

    @property
    def source(self) -> str:
        """The name of the mesh file, or that the mesh was in memory."""
        return "a mesh in memory" if isinstance(self.mesh, Mesh) else readable(self.mesh.name)


def load_project(path: Path, overrides: dict[str, Any]) -> Project:
    """The project in a TOML file; relative paths in it start from its folder. Overrides win, nested as in the file.

    Raises ProjectError with one sentence that names the key, what was found and what would do.

    >>> _ = Path("roof.toml").write_text('mesh = "roof.obj"\\nunit = "m"\\n[[layers]]\\nthickness_mm = 12')
    >>> project = load_project(Path("roof.toml"), {"layers": [{"joint_mm": 8}]})
    >>> project.layers[0].thickness_mm, project.layers[0].joint_mm
    (12.0, 8.0)
    """
    found = read_tables(path)
    _start_paths_from(path, found)
    if "mesh" not in found:
        raise ProjectError(f"{path.name} names no mesh: add a line like mesh = 'roof.obj'")
    return project_from(with_overrides(found, overrides), source=path.name)


def project_from(settings: dict[str, Any], *, source: str = "") -> Project:
    """A project from settings nested as in the file. Raises ProjectError with one sentence."""
    try:
        return Project(**settings)
    except ProjectError as error:
        raise ProjectError(f"{source}: {error}" if source else str(error)) from None


def surface_rules_from(settings: dict[str, Any]) -> SurfaceRules:
    """The table [surface] alone. Raises ProjectError with one sentence."""
    try:
        return SurfaceRules.model_validate(settings)
    except ValidationError as error:
        raise ProjectError(problems(error, Project)) from None


def _start_paths_from(file: Path, found: dict[str, Any]) -> None:
    r"""Make the paths in a project file start from its folder. In "C:\new\table.obj", \n and \t are signs of TOML."""
    image, surface, marks = (found.get(key) for key in ("gauss_image", "surface", "marks"))
    of_tables = [(image, "file"), (surface, "strokes"), (marks, "keep")]
    of_tables += [(layer, "parallel") for layer in layer_tables(found)]
    paths = ((found, "mesh"), (found, "out"), (found, "gauss_image"), *of_tables)
    for table, key in paths:
        if isinstance(table, dict) and isinstance(table.get(key), str):
            if re.search(r"[\x00-\x1f]", table[key]):
                raise ProjectError(
                    f"{file.name}: {key} is {echo(table[key])}, with line breaks, tabs or the like: {BACKSLASHES}"
                )
            table[key] = file.parent / table[key]

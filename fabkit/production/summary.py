"""The figures of one build that the report, the summary sheet and the manifest show."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from fabkit.fitness import Finding
from fabkit.parts import Frame
from fabkit.production.marks import EQUAL_WITHIN_MM, KeptMarks
from geometry.arrays import FloatArray, short_repr

__all__ = ["ExactGaussImage", "GaussImageSource", "GivenGaussImage", "OptimisedGaussImage", "Summary", "SurfaceSummary"]


@dataclass(frozen=True)
class ExactGaussImage:
    """Record of a Gauss image that was computed and is exact. offset: what has a constant distance from the offset
    mesh, "vertex", "edge" or "face".

    >>> from fabkit.production import ExactGaussImage
    >>> ExactGaussImage("edge").origin.split(":")[0]
    'computed, an exact edge offset'
    """

    offset: str

    @property
    def origin(self) -> str:
        """Where it comes from, in words."""
        constant = {
            "edge": "all edges at distance 1 from the origin, so that all beams have one height",
            "vertex": "all vertices at distance 1 from the origin, so that all node axes have one length",
            "face": "all faces at distance 1 from the origin, so that the layers are at one distance from each other",
        }[self.offset]
        return (
            f"computed, an exact {self.offset} offset: {constant}; weights in [gauss_image] replace it by an "
            "approximate one"
        )


@dataclass(frozen=True)
class GivenGaussImage:
    """Record of a Gauss image that was given: name and sha256 of its file; largest and mean displacement of its
    vertices that made it parallel to the planar mesh, in radii of the unit sphere (1 is the nominal height).

    >>> from fabkit.production import GivenGaussImage
    >>> GivenGaussImage("S.obj", "", largest_move=0.0, mean_move=0.0).origin
    'given by S.obj, exact as it is'
    """

    file: str
    sha256: str
    largest_move: float
    mean_move: float

    @property
    def origin(self) -> str:
        """Where it comes from, in words."""
        if self.largest_move == 0:
            return f"given by {self.file}, exact as it is"
        return (
            f"given by {self.file}; its vertices moved by {self.largest_move:.1e} of the nominal height at most to "
            "become parallel"
        )


@dataclass(frozen=True)
class OptimisedGaussImage:
    """The Gauss image where it was optimised together with the mesh; pairs of numbers are before and after.

    targets: "heights", "axes" or both. height_spread: range of the beam heights from the 2.5 % to the 97.5 %
    quantile, over their median. lean_p95_deg: lean of 95 % of the node axes from the normals of the surface on which
    vertices glide. moves_mm: of the vertices, the median and the largest; farthest_vertex: the one that moved most.
    off_surface_p95_mm: distance of 95 % of the vertices from that surface afterwards. no_longer_convex: the faces that
    were convex before only.

    >>> from fabkit.production import OptimisedGaussImage
    >>> image = OptimisedGaussImage(("heights",), (0.62, 0.02), (52.0, 13.0), (180.0, 900.0), 7, 30.0, ())
    >>> image.origin
    'computed, and optimised together with the mesh for beams of nearly constant height'
    """

    targets: tuple[str, ...]
    height_spread: tuple[float, float]
    lean_p95_deg: tuple[float, float]
    moves_mm: tuple[float, float]
    farthest_vertex: int
    off_surface_p95_mm: float
    no_longer_convex: tuple[int, ...]

    @property
    def origin(self) -> str:
        """Where it is from, in words."""
        asked = {"heights": "beams of nearly constant height", "axes": "node axes near the normals"}
        return f"computed, and optimised together with the mesh for {' and '.join(asked[t] for t in self.targets)}"


GaussImageSource = GivenGaussImage | ExactGaussImage | OptimisedGaussImage
"""Where a Gauss image is from, unless it was just computed."""


def irregular_vertices(valences: dict[int, int]) -> str:
    """Numbers of inner vertices by valence, in words.

    >>> from fabkit.production import irregular_vertices
    >>> irregular_vertices({3: 4, 5: 2}), irregular_vertices({})
    ('4 of valence 3, 2 of valence 5', 'none')
    """
    return ", ".join(f"{count} of valence {valence}" for valence, count in valences.items()) or "none"


@dataclass(frozen=True, eq=False)
class SurfaceSummary:
    """Figures of a mesh that was laid on a design surface.

    lines: "principal" or "conjugate"; affine (3, 3): the map whose principal lines they are; crossing_deg: 5 %
    percentile (by area) and median of their crossing angles in degrees. quad_share: share of quads among the faces;
    valences: number of inner vertices of each valence other than 4; aligned_share: share of edges within 10 degrees of
    the lines. distances_mm (N,): of the vertices of the planar mesh from the surface. smoothing_mm: largest
    displacement of a vertex of the surface by smoothing. undirected_share: share of its area that is flat or spherical.
    loop_lengths_mm: of its boundary loops, the longest first.

    >>> from fabkit.production import SurfaceSummary
    >>> rest = (np.zeros(9), 0.0, 0.0, np.zeros(1))
    >>> laid = SurfaceSummary(800, "principal", np.eye(3), (82.0, 90.0), 0.98, {3: 4, 5: 2}, 0.95, *rest)
    >>> laid.irregular
    '4 of valence 3, 2 of valence 5'
    """

    n_triangles: int
    lines: str
    affine: FloatArray
    crossing_deg: tuple[float, float]
    quad_share: float
    valences: dict[int, int]
    aligned_share: float
    distances_mm: FloatArray
    smoothing_mm: float
    undirected_share: float
    loop_lengths_mm: FloatArray

    @property
    def irregular(self) -> str:
        """Numbers of inner vertices with a valence other than 4, in words."""
        return irregular_vertices(self.valences)

    @property
    def distance_shares_mm(self) -> dict[str, float]:
        """Distances from the surface: the median, what 95 % do not exceed, and the largest."""
        return _upper_shares(self.distances_mm)


@dataclass(frozen=True, eq=False)
class Summary:
    """Figures of the mesh and its support structure. Those of the parts are taken from the assembly itself.

    name: of the structure; source: name of the mesh file; scale_mm: millimetres in a unit of the file. origin (3,):
        subtracted from its coordinates, in its unit.
    equal_within_mm: largest difference of each coordinate of parts that share a mark: the requested tolerance, or the
        rounding error of coordinates far from zero if that is larger. earlier_marks: by groups, those of the folder
        whose marks are kept. site: the frame of the mesh file in the coordinates of the site; None for the same.
    mended: sentences on what the reader mended in the file.
    planarity_before, planarity_after: largest distance of a corner from its face's best plane over the face's
        mean edge length. largest_move_mm, mean_move_mm: displacement of the vertices by planarising;
        farthest_vertex: the vertex displaced most, counted from 0.
    edge_lengths_mm (E,): of the planar mesh. heights (E,): distance between the two parallel meshes at each edge
        over the nominal one (1 everywhere for an edge offset mesh).
    leans_deg (N,): angle between each node axis and the normal of the mesh there, NaN where there is none.
    twists_deg (E,): angle between the central planes at the two ends of each edge.
    underside_mm: height of the panels' underside above the mesh faces; underside_reason: what determines it.
    surface: None where the file held the mesh itself.
    fin_direction: the translation x of the Gauss image that was found for fins, empty where none was sought; fin_shade:
        share of the panels in their shade without and with it.
    fitness: the findings, noted or accepted. gauss_image: None where it was computed, and is neither exact nor
        optimised.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> built.summary.n_faces, built.summary.source, round(built.summary.height_shares["median"], 2)
    (12, 'a mesh in memory', 1.03)
    """

    __repr__ = short_repr

    name: str
    source: str
    scale_mm: float
    n_vertices: int
    n_edges: int
    n_faces: int
    n_boundaries: int
    mended: tuple[str, ...]
    planarity_before: float
    planarity_after: float
    largest_move_mm: float
    mean_move_mm: float
    farthest_vertex: int
    edge_lengths_mm: FloatArray
    heights: FloatArray
    leans_deg: FloatArray
    twists_deg: FloatArray
    underside_mm: float
    underside_reason: str
    fitness: tuple[Finding, ...] = ()
    gauss_image: GaussImageSource | None = None
    origin: FloatArray = field(default_factory=lambda: np.zeros(3))
    equal_within_mm: float = EQUAL_WITHIN_MM
    earlier_marks: dict[str, KeptMarks] = field(default_factory=dict)
    site: Frame | None = None
    surface: SurfaceSummary | None = None
    fin_direction: tuple[float, ...] = ()
    fin_shade: tuple[float, float] = (0.0, 0.0)

    @property
    def placed_at(self) -> str:
        """The origin of the model in the mesh file, in words."""
        return ", ".join(f"{each:.0f}" for each in self.origin) + " in the unit of the mesh file"

    @property
    def edge_length_shares_mm(self) -> dict[str, float]:
        """Edge lengths: what 5 %, 50 % and 95 % of the edges do not exceed."""
        found = np.percentile(self.edge_lengths_mm, [5, 50, 95]).tolist()
        return dict(zip(("p5", "median", "p95"), found, strict=True))

    @property
    def height_shares(self) -> dict[str, float]:
        """Beam heights over the nominal height: smallest, median, largest, and the bounds between which 95 % lie."""
        names = {"least": 0, "p2_5": 2.5, "median": 50, "p97_5": 97.5, "largest": 100}
        found = np.percentile(self.heights, list(names.values())).tolist()
        return dict(zip(names, found, strict=True))

    @property
    def lean_shares_deg(self) -> dict[str, float]:
        """Lean of the node axes in degrees: the median, the value that 95 % do not exceed, and the largest."""
        return _upper_shares(self.leans_deg)

    @property
    def gauss_image_origin(self) -> str:
        """Where the Gauss image comes from, in words."""
        return "computed" if self.gauss_image is None else self.gauss_image.origin


def _upper_shares(values: FloatArray) -> dict[str, float]:
    """The median, what 95 % do not exceed, and the largest; NaN is left out."""
    median, most, largest = np.nanpercentile(values, [50, 95, 100]).tolist()
    return {"median": median, "p95": most, "largest": largest}

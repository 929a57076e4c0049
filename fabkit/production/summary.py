"""What is to be told about one build: the facts behind the report, the summary sheet and the manifest."""

from __future__ import annotations

from dataclasses import dataclass

from geometry.arrays import FloatArray

__all__ = ["ExactGaussImage", "GivenGaussImage", "Summary"]


@dataclass(frozen=True)
class ExactGaussImage:
    """The Gauss image where it was computed and is exact: offset says what is at constant distance, "vertex", "edge" or
    "face"."""

    offset: str

    @property
    def origin(self) -> str:
        """Where it is from, in words."""
        constant = {
            "edge": "all edges at distance 1 from the origin, so that all beams have one height",
            "vertex": "all vertices at distance 1 from the origin, so that all node axes have one length",
            "face": "all faces at distance 1 from the origin, so that faces have one distance",
        }[self.offset]
        return f"computed, an exact {self.offset} offset: {constant}; weights in [gauss_image] ask for another"


@dataclass(frozen=True)
class GivenGaussImage:
    """The Gauss image where it was given: name and sha256 of its file; how far its vertices moved to become parallel to
    the planar mesh, in radii of the unit sphere, so that 1 is the nominal height."""

    file: str
    sha256: str
    largest_move: float
    mean_move: float

    @property
    def origin(self) -> str:
        """Where it is from, in words."""
        if self.largest_move == 0:
            return f"given by {self.file}, exact as it is"
        return f"given by {self.file}; its vertices moved by {self.largest_move:.1e} at most to become parallel"


@dataclass(frozen=True, eq=False)
class Summary:
    """Facts about the mesh and its support structure. Facts about parts are read off the assembly itself.

    name: of the structure; source: name of the mesh file; scale_mm: millimetres a unit of the file.
    mended: what the reader mended in the file, a sentence each.
    planarity_before, planarity_after: largest distance of a corner from its face's best plane over the face's
        mean edge length. largest_move_mm, mean_move_mm: how far planarising moved the vertices.
    edge_lengths_mm (E,): of the planar mesh. heights (E,): distance between the two parallel meshes at each edge
        over the nominal one (1 everywhere for an edge offset mesh).
    twists_deg (E,): angle between the central planes at the two ends of each edge.
    lift_mm: height of the panels' lower side above the mesh faces; lift_reason: what asks for it, a sentence.
    gauss_image: None where it was computed and is not exact.
    """

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
    edge_lengths_mm: FloatArray
    heights: FloatArray
    twists_deg: FloatArray
    lift_mm: float
    lift_reason: str
    gauss_image: GivenGaussImage | ExactGaussImage | None = None

    @property
    def gauss_image_origin(self) -> str:
        """Where the Gauss image is from, in words."""
        return "computed" if self.gauss_image is None else self.gauss_image.origin

"""A mesh at constant distance from a given one, in one call [Pottmann2007, 3]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from geometry.arrays import FloatArray, floats, short_repr
from geometry.errors import GeometryError, finite_number, raise_worst
from geometry.exact_offsets.exact_gauss_image import edge_offset_pair, face_offset_pair, vertex_offset_pair
from geometry.exact_offsets.exact_or_approximate import EXACT_OFFSET_TOLERANCE, exact_or_approximate_pair
from geometry.gauss.pair import Pair, as_pair
from geometry.mesh import Mesh, MeshLike

__all__ = ["OffsetKind", "OffsetMesh", "offset"]

OffsetKind: TypeAlias = Literal["edge", "face", "vertex"]
"""What is at constant distance: edge lines, face planes or vertices."""

EXACT_PAIRS = {"edge": edge_offset_pair, "face": face_offset_pair, "vertex": vertex_offset_pair}


@dataclass(frozen=True, eq=False)
class OffsetMesh:
    """The mesh M + d S, and what it was made of.

    mesh: the offset, with the faces of M, parallel to M. pair: M and S. distance: d. kind: what is at the distance |d|
    everywhere, "edge", "face" or "vertex"; None where nothing is, exactly.

    >>> from geometry import offset
    >>> from geometry.mesh import solids
    >>> layer = offset(solids.cube(), 0.1, "edge")
    >>> set(layer.edge_distances.round(9).tolist()), set(layer.face_distances.round(2).tolist())
    ({0.1}, {0.07})
    """

    __repr__ = short_repr

    mesh: Mesh
    pair: Pair
    distance: float
    kind: str | None

    @property
    def edge_distances(self) -> FloatArray:
        """(E,) distances between corresponding edge lines of M and the offset: heights of beams between the two."""
        return floats(abs(self.distance) * self.pair.edge_distances)

    @property
    def face_distances(self) -> FloatArray:
        """(F,) distances between corresponding face planes, positive where the offset is outside."""
        return floats(self.distance * self.pair.face_distances)

    @property
    def vertex_distances(self) -> FloatArray:
        """(N,) distances between corresponding vertices."""
        return floats(abs(self.distance) * self.pair.vertex_distances)


def offset(
    mesh: MeshLike, distance: float, kind: OffsetKind | None = None, *, tolerance: float = EXACT_OFFSET_TOLERANCE
) -> OffsetMesh:
    """The mesh M + d S at a constant distance d from M, outside where d is positive.

    mesh: M, of planar faces; or a pair M, S, or an object that holds one, whose S is used as it is. kind: what is to be
    at constant distance, all edge lines, all face planes or all vertices; None: what the mesh has exactly, edge before
    vertex and face, else the parallel mesh nearest to constant distance from the faces, see
    `exact_or_approximate_pair`. The result says which it was. tolerance: how far distances may be from d, over d.

    Raises GeometryError, with the worst element, how far it is off and what to do, where M has no offset of that kind;
    where an edge of the offset collapses or runs against that of M, naming the edge and the distances between which
    none does; for faces that are not planar, and for a distance that is not finite. Raises as `approximate_pair` does
    where nothing is exact.

    >>> from geometry import offset
    >>> from geometry.mesh import shapes, solids
    >>> larger = offset(solids.cube() * 500.0, 20.0, "face")
    >>> larger.kind, larger.mesh.mean_edge_length, larger.pair.mesh.mean_edge_length
    ('face', 1040.0, 1000.0)
    >>> layer = offset(shapes.dome(16, 5), 0.05)
    >>> layer.kind, set(layer.face_distances.round(9).tolist())
    ('face', {0.05})
    >>> round(larger.pair.distance_range[0])  # at -500 all edges of the cube vanish
    -500
    """
    if kind is not None and kind not in EXACT_PAIRS:
        raise GeometryError(f'the kind of the offset is {kind!r}: "edge", "face", "vertex" or None is needed')
    distance = finite_number("the distance of the offset", distance)
    if hasattr(mesh, "gauss_image"):
        pair = as_pair(mesh)
        found = _kind_of(pair, kind, tolerance)
    elif kind is None:
        pair, found = exact_or_approximate_pair(mesh, tolerance=tolerance)
    else:
        pair, found = EXACT_PAIRS[kind](mesh, tolerance=tolerance), kind
    _refuse_collapsed(pair, distance)
    return OffsetMesh(pair.offset_mesh(distance), pair, distance, found)


def _kind_of(pair: Pair, kind: OffsetKind | None, tolerance: float) -> str | None:
    """The kind of which S is exact: the requested one, or an error."""
    deviations = {name: pair.deviations(name) for name in EXACT_PAIRS}
    if kind is None:
        return next((name for name, off in deviations.items() if off.max() <= tolerance), None)
    raise_worst(
        deviations[kind],
        "<=",
        tolerance,
        lambda element, off: (
            f"the pair has no {kind} offset: {kind} {element} of its Gauss image is {off:.1e} off distance 1 from the "
            f"origin, allowed {tolerance:.0e}; give the mesh without its pair, or leave the kind out"
        ),
    )
    return kind


def _refuse_collapsed(pair: Pair, distance: float) -> None:
    low, high = pair.distance_range
    raise_worst(
        1 + distance * pair.edge_factors,
        ">",
        0.0,
        lambda edge, factor: (
            f"{pair.mesh.combinatorics.edge_name(edge)} is {factor:.3g} times as long in the offset at distance "
            f"{distance:g}, so it collapses or runs the other way: choose a distance between {low:.6g} and {high:.6g}"
        ),
    )

"""Pieces with matching boundaries joined into one mesh with one Gauss image [Pottmann2007, 5, Fig. 19]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geometry.arrays import FloatArray, IntArray, floats, integers, short_repr
from geometry.errors import GeometryError, MeshError
from geometry.gauss.boundary_matches import BoundaryLoop, Fits, Motion, boundary_loops
from geometry.gauss.nearest_pair import nearest_parallel_pair
from geometry.gauss.pair import Pair, PairLike, as_pair
from geometry.mesh import Combinatorics, Mesh

__all__ = ["JoinedPair", "join_pairs"]

LARGEST_GAP = 0.05
"""Largest gap between boundaries that are joined: of M in mean edge lengths of the boundary, of S in radii."""

EQUAL_FITS = 1e-6
"""Difference of root mean square gaps, and of moves, over the size of a boundary, up to which two places count as
equally good: pieces of rotational symmetry fit in many. The square root of rounding is 1e-8."""

LARGEST_KEPT_GAP = 1e-9
"""Gap up to which two kept pieces match, in the units of `LARGEST_GAP`: pairs count as parallel to this."""


@dataclass(frozen=True, eq=False)
class JoinedPair:
    """Pieces joined into one pair.

    pair: M and S of all. pieces (F,): the piece of each face. numbers: for each piece, (n,) the numbers that its
    vertices have in the whole. gaps (k, 2): for each joint, the largest distance of boundary vertices before they were
    joined: of M in mean edge lengths of the boundary, of S in radii.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import dome
    >>> tube, row = Pair(dome(12, 4), dome(12, 4)), np.arange(48) % 4
    >>> lower, upper = (tube.part(np.flatnonzero(half)) for half in (row < 2, row >= 2))
    >>> joined = join_pairs([lower, upper])
    >>> joined.pieces.tolist() == 24 * [0] + 24 * [1], len(joined.vertices_of([0])) == lower.mesh.n_vertices
    (True, True)
    """

    __repr__ = short_repr

    pair: Pair
    pieces: IntArray
    numbers: tuple[IntArray, ...]
    gaps: FloatArray

    def vertices_of(self, pieces: Sequence[int]) -> IntArray:
        """The vertices (n,) of some of the pieces."""
        return _vertices_of(self.numbers, pieces)


def join_pairs(
    pairs: Sequence[PairLike], *, kept: Sequence[int] = (), scaled: bool = False, tolerance: float = LARGEST_GAP
) -> JoinedPair:
    """One pair of several, joined along boundary loops that match.

    The first piece stays where it is. Each of the others is moved, and scaled if `scaled`, to the boundary loop of
    those before it that it fits best; where it fits several as well, it moves as little as possible. It is joined to
    all loops that then match. S turns with M. Joined vertices are in the middle between both; where faces are then not
    planar or edges not parallel, vertices are moved slightly, as by `nearest_parallel_pair`.

    kept: numbers of pieces that keep their shapes exactly; the others adapt to them. tolerance: the largest gap, of M
    in mean edge lengths of the boundary, of S in radii. Curvatures of faces change where there are gaps:
    `optimise_pair` makes them constant again, in all pieces.

    Raises MeshError where a piece has no loop that fits, with the numbers of vertices or the least gaps, and where two
    kept pieces do not match exactly; GeometryError for fewer than two pieces and kept ones that do not exist;
    ConvergenceError where no parallel pair is near.

    >>> from geometry.gauss import Pair
    >>> from geometry.mesh.shapes import dome
    >>> tube, row = Pair(dome(12, 4), dome(12, 4)), np.arange(48) % 4
    >>> lower, upper = (tube.part(np.flatnonzero(half)) for half in (row < 2, row >= 2))
    >>> joined = join_pairs([lower, upper.translated([5.0, 0.0, 0.0])])
    >>> joined.pair.mesh, joined.gaps.round(9).tolist()
    (Mesh(60 vertices, 48 faces, 108 edges), [[0.0, 0.0]])
    """
    given = [as_pair(pair) for pair in pairs]
    if len(given) < 2:
        raise GeometryError(f"{len(given)} pieces are given: at least 2 are needed to be joined", value=len(given))
    for piece in kept:
        if not 0 <= piece < len(given):
            raise GeometryError(f"piece {piece} is to be kept, but there are {len(given)}, counted from 0", value=piece)
    whole = _Whole.of(given[0])
    for piece, pair in enumerate(given[1:], start=1):
        whole = whole.with_piece(piece, pair, frozenset(kept), scaled, tolerance)
    corners = [numbers[pair.mesh.combinatorics.corners] for numbers, pair in zip(whole.numbers, given, strict=True)]
    sizes = np.concatenate([pair.mesh.combinatorics.face_sizes for pair in given])
    c = Combinatorics(len(whole.mesh), np.concatenate(corners), np.concatenate([[0], np.cumsum(sizes)]))
    mesh = Mesh(whole.mesh, c)
    fixed = _vertices_of(whole.numbers, kept)
    pair = nearest_parallel_pair(mesh, mesh.with_vertices(whole.image), fixed=fixed)
    pieces = np.repeat(np.arange(len(given)), [each.mesh.n_faces for each in given])
    return JoinedPair(pair, integers(pieces), whole.numbers, floats(whole.gaps))


def _vertices_of(numbers: Sequence[IntArray], pieces: Sequence[int]) -> IntArray:
    chosen = [numbers[piece] for piece in pieces]
    return integers(np.unique(np.concatenate([np.zeros(0, np.int64), *chosen])))


@dataclass(frozen=True, eq=False)
class _Whole:
    """What is joined so far: positions (N, 3) in M and in S; the vertices of each piece; loops that are still free."""

    mesh: FloatArray
    image: FloatArray
    numbers: tuple[IntArray, ...]
    loops: tuple[BoundaryLoop, ...]
    gaps: tuple[FloatArray, ...]

    @classmethod
    def of(cls, pair: Pair) -> _Whole:
        loops = tuple(boundary_loops(0, pair))
        numbers = integers(np.arange(pair.mesh.n_vertices))
        return cls(pair.mesh.vertices, pair.gauss_image.vertices, (numbers,), loops, ())

    def with_piece(self, piece: int, pair: Pair, kept: frozenset[int], scaled: bool, tolerance: float) -> _Whole:
        given = boundary_loops(piece, pair)
        motion = _best_motion(piece, self.loops, given, scaled, tolerance)
        mesh, image = motion.applied(pair.mesh.vertices, pair.gauss_image.vertices)
        own = [loop.moved(motion) for loop in given]
        numbers = np.full(len(mesh), -1)
        whole_mesh, whole_image = self.mesh.copy(), self.image.copy()
        free, gaps = list(self.loops), list(self.gaps)
        for loop in list(own):
            joint = _joint(free, loop, tolerance)
            if joint is None:
                continue
            other, gap = joint
            _check_kept(other, loop, kept, gap)
            mine, theirs = loop.vertices[loop.beside(other)], other.vertices
            numbers[mine] = theirs
            share = 0.5 if (piece in kept) == (other.piece in kept) else float(piece in kept)
            whole_mesh[theirs] += share * (mesh[mine] - other.mesh)
            whole_image[theirs] += share * (image[mine] - other.image)
            free.remove(other)
            own.remove(loop)
            gaps.append(gap)
        new = numbers < 0
        numbers[new] = len(whole_mesh) + np.arange(int(new.sum()))
        free += [BoundaryLoop(piece, integers(numbers[loop.vertices]), loop.mesh, loop.image) for loop in own]
        return _Whole(
            np.concatenate([whole_mesh, mesh[new]]),
            np.concatenate([whole_image, image[new]]),
            (*self.numbers, integers(numbers)),
            tuple(free),
            tuple(gaps),
        )


def _best_motion(
    piece: int, free: Sequence[BoundaryLoop], own: Sequence[BoundaryLoop], scaled: bool, tolerance: float
) -> Motion:
    """That which fits best; of several as good ones, that which moves the piece least; of these the first."""
    fits = [Fits(fixed, loop, scaled) for fixed in free for loop in own if _alike(fixed, loop)]
    if not fits:
        lengths, others = ([len(loop.vertices) for loop in loops] for loops in (own, free))
        raise MeshError(
            f"piece {piece} fits nowhere: its boundary loops have {lengths} vertices, the free ones of the pieces "
            f"before it {others}; give both sides the same number, or another order"
        )
    deviations = np.concatenate([fit.deviations for fit in fits])
    moves = np.concatenate([fit.moves for fit in fits])
    good = deviations <= deviations.min() + EQUAL_FITS
    best = int(np.flatnonzero(good & (moves <= moves[good].min() + EQUAL_FITS))[0])
    ends = np.cumsum([len(fit.deviations) for fit in fits])
    chosen = int(np.searchsorted(ends, best, side="right"))
    fit = fits[chosen]
    motion = fit.motion(best - int(ends[chosen]) + len(fit.deviations))
    gap = fit.moving.moved(motion).gaps(fit.fixed)
    if not gap.max() <= tolerance:
        raise MeshError(
            f"piece {piece} fits nowhere: where its boundary fits best, it is {gap[0]:.2g} mean edge lengths off that "
            f"of piece {fit.fixed.piece}, and its Gauss image {gap[1]:.2g} radii, allowed {tolerance:g}; give pieces "
            "whose boundaries and axes there are the same, or a larger tolerance",
            value=float(gap.max()),
            bound=tolerance,
        )
    return motion


def _alike(fixed: BoundaryLoop, loop: BoundaryLoop) -> bool:
    return len(fixed.vertices) == len(loop.vertices)


def _joint(
    free: Sequence[BoundaryLoop], loop: BoundaryLoop, tolerance: float
) -> tuple[BoundaryLoop, FloatArray] | None:
    """The free loop that a loop coincides with, and the gaps (2,)."""
    for fixed in free:
        if _alike(fixed, loop) and (gap := loop.gaps(fixed)).max() <= tolerance:
            return fixed, gap
    return None


def _check_kept(other: BoundaryLoop, loop: BoundaryLoop, kept: frozenset[int], gap: FloatArray) -> None:
    if {other.piece, loop.piece} <= kept and not gap.max() <= LARGEST_KEPT_GAP:
        raise MeshError(
            f"pieces {other.piece} and {loop.piece} are both to be kept, but their boundaries are {gap[0]:.1e} mean "
            f"edge lengths apart, and their Gauss images {gap[1]:.1e} radii, allowed {LARGEST_KEPT_GAP:.0e}: keep one "
            "of them",
            value=float(gap.max()),
            bound=LARGEST_KEPT_GAP,
        )

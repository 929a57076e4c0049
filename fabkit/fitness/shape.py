"""Criteria of a mesh and its Gauss image, independent of size: one function for each, which returns None where nothing
is unusual."""

from __future__ import annotations

import numpy as np

from fabkit.fitness.finding import Finding, Level, named
from fabkit.fitness.rules import FitnessRules
from geometry.arrays import FloatArray
from geometry.errors import FoldedError
from geometry.gauss import Pair, SupportStructure, closed_mesh_advice
from geometry.mesh import Mesh
from geometry.mesh.intersections import intersecting_faces, self_crossing_faces

__all__ = [
    "CROSSINGS",
    "crossings",
    "folded",
    "folding",
    "heights",
    "lean",
    "moves",
    "of_gauss_image",
    "of_planar_mesh",
    "self_crossing",
    "self_intersection",
    "tilt",
]

NOTED_PERCENTILE = 95
"""Percentile of the elements that decides whether a whole mesh is noted: a few bad ones at corners do not count, and
the largest value is reported as well."""

CROSSINGS = ("self-crossing", "self-intersection")
"""Names of the findings of `crossings`."""

LINES = (
    "lay the mesh along other lines: along conjugate directions, ideally those of principal curvature; where its lines "
    "are asymptotic (straight on the surface), rotated by 45 degrees"
)
FAIRER = f"{LINES}; or give fairness under [planarise] in the project file a larger value than 0.3"
OTHER_LAYING = (
    "smooth short waves out of the surface by --smooth MM, which needs --unit, lay the mesh along other lines by "
    "--lines, --boundary or --strokes, or choose another number of --faces; `fabkit mesh --study PAGE.html` compares "
    "networks of lines"
)
SEPARATE = "separate or cut the mesh there (parts that overlap are left out with --skip-unbuildable)"


def of_planar_mesh(before: Mesh, after: Mesh, rules: FitnessRules) -> tuple[Finding, ...]:
    """Findings about a mesh made planar. before, after: as read and planar, in one unit."""
    found = (moves(before, after, rules), folding(before, after, rules))
    return (*(finding for finding in found if finding), *crossings(after))


def crossings(mesh: Mesh) -> tuple[Finding, ...]:
    """Findings about a planar mesh that meets itself."""
    return tuple(finding for finding in (self_crossing(mesh), self_intersection(mesh)) if finding)


def of_gauss_image(structure: SupportStructure, rules: FitnessRules) -> tuple[Finding, ...]:
    """Findings about a planar mesh and its Gauss image; the distance of the structure does not matter."""
    found = (tilt(structure, rules), lean(structure.pair, rules), heights(structure, rules))
    return tuple(finding for finding in found if finding)


def moves(before: Mesh, after: Mesh, rules: FitnessRules) -> Finding | None:
    """Displacement of the vertices in mean edge lengths of the mesh as read: of most of them, and the largest."""
    used = np.flatnonzero(before.combinatorics.is_used)
    size = np.linalg.norm(after.vertices - before.vertices, axis=1)[used] / before.mean_edge_length
    percentile, worst = float(np.percentile(size, NOTED_PERCENTILE)), int(used[size.argmax()])
    if percentile < rules.moves_noted and size.max() < rules.moves_refused:
        return None
    is_refused = percentile >= rules.moves_refused
    return Finding(
        "moves",
        "refused" if is_refused else "note",
        percentile,
        rules.moves_refused if is_refused else rules.moves_noted,
        "mean edge lengths",
        f"to make faces planar, {NOTED_PERCENTILE} % of the vertices move by up to {percentile:.2g} mean edge lengths, "
        f"vertex {worst} (counted from 0) by {size.max():.2g}; {_bounds(rules.moves_noted, rules.moves_refused)}",
        LINES,
        "vertex",
        (worst,),
    )


def folding(before: Mesh, after: Mesh, rules: FitnessRules) -> Finding | None:
    """Rotation of face normals while faces are made planar. A face that folds over is refused by planarising itself."""
    cosines = np.einsum("fk,fk->f", before.face_normals, after.face_normals)
    turns = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    face = int(turns.argmax())
    if turns[face] < rules.folding_noted_deg:
        return None
    return Finding(
        "folding",
        "note",
        float(turns[face]),
        rules.folding_noted_deg,
        "degrees",
        f"face {face} (counted from 0) rotates by {turns[face]:.0f} degrees when faces are made planar; noted from "
        f"{rules.folding_noted_deg:g}, refused from 90",
        LINES,
        "face",
        (face,),
    )


def folded(error: FoldedError, *, on_surface: bool = False) -> Finding:
    """The finding for a fold at which planarising stopped. on_surface: the mesh was laid on a surface by fabkit."""
    return Finding(
        "folding",
        "refused",
        error.value or 0.0,
        error.bound or 0.0,
        "",
        f"{error.problem} (counted from 0)",
        OTHER_LAYING if on_surface else FAIRER,
        "",
        error.elements,
    )


def self_crossing(mesh: Mesh) -> Finding | None:
    """Faces whose outline crosses itself."""
    faces = self_crossing_faces(mesh).tolist()
    if not faces:
        return None
    return Finding(
        "self-crossing",
        "refused",
        len(faces),
        0.0,
        "faces",
        f"the outline of {_counted(len(faces), 'face')} crosses itself, allowed none: {named(_numbers(faces))} "
        "(counted from 0)",
        "split these faces, or remove them",
        "face",
        tuple(faces),
    )


def self_intersection(mesh: Mesh) -> Finding | None:
    """Faces that touch or intersect outside the vertices and edges they share."""
    pairs = intersecting_faces(mesh).tolist()
    if not pairs:
        return None
    listed = named([f"{first} with {second}" for first, second in pairs], at_most=5)
    return Finding(
        "self-intersection",
        "refused",
        len(pairs),
        0.0,
        "pairs of faces",
        f"the mesh intersects itself: {_counted(len(pairs), 'pair')} of faces meet where they share no edge, allowed "
        f"none: {listed} (counted from 0)",
        SEPARATE,
        "face",
        tuple(dict.fromkeys(face for pair in pairs for face in pair)),
    )


def tilt(structure: SupportStructure, rules: FitnessRules) -> Finding | None:
    """Angle between each beam and the normals of the faces beside it."""
    c = structure.mesh.combinatorics
    facing = np.einsum(
        "ck,ck->c", structure.height_directions[c.corner_edge], structure.mesh.face_normals[c.corner_face]
    )
    corner = int(facing.argmin())
    angle = float(np.degrees(np.arccos(np.clip(facing[corner], -1.0, 1.0))))
    if facing[corner] > 0 and angle < rules.tilt_noted_deg:
        return None
    edge = int(c.corner_edge[corner])
    i, j = c.edges[edge].tolist()
    beam, face = f"the beam on edge {edge} from vertex {i} to vertex {j}", c.corner_face[corner]
    if facing[corner] <= 0:
        return Finding(
            "tilt",
            "refused",
            angle,
            90.0,
            "degrees",
            f"{beam} does not point to the outside of face {face}: its angle to the normal is {angle:.0f} degrees and "
            "must be less than 90; the Gauss image folds over there (counted from 0)",
            "change the mesh there, or the weights under [gauss_image] in the project file",
            "edge",
            (edge,),
        )
    return Finding(
        "tilt",
        "note",
        angle,
        rules.tilt_noted_deg,
        "degrees",
        f"{beam} is tilted by {angle:.0f} degrees from the normal of face {face} (counted from 0); noted from "
        f"{rules.tilt_noted_deg:g}, impossible from 90",
        LINES,
        "edge",
        (edge,),
    )


def lean(pair: Pair, rules: FitnessRules) -> Finding | None:
    """Angle between node axes and normals."""
    angles = np.degrees(pair.leans)
    median, percentile = np.nanpercentile(angles, [50, NOTED_PERCENTILE]).tolist()
    is_refused = median >= rules.lean_refused_deg
    if percentile < rules.lean_noted_deg and not is_refused:
        return None
    worst = int(np.nanargmax(angles))
    level: Level = "refused" if is_refused else "note"
    return Finding(
        "lean",
        level,
        median if is_refused else percentile,
        rules.lean_refused_deg if is_refused else rules.lean_noted_deg,
        "degrees",
        f"node axes lean from the normals: median {median:.0f} degrees, {NOTED_PERCENTILE} % up to {percentile:.0f}, "
        f"largest {angles[worst]:.0f} at vertex {worst} (counted from 0); noted if {100 - NOTED_PERCENTILE} % reach "
        f"{rules.lean_noted_deg:g}, refused from a median of {rules.lean_refused_deg:g}",
        closed_mesh_advice(pair.mesh)
        or "lay the mesh along the directions of principal curvature, so that axes are near the normals",
        "vertex",
        (worst,),
    )


def heights(structure: SupportStructure, rules: FitnessRules) -> Finding | None:
    """Variation of the distance between the two parallel meshes, over the nominal height."""
    found: FloatArray = structure.heights
    low, high = np.percentile(found, [2.5, 97.5]).tolist()
    if high - low < rules.heights_noted:
        return None
    edge = int(np.abs(found - 1).argmax())
    return Finding(
        "heights",
        "note",
        high - low,
        rules.heights_noted,
        "nominal heights",
        f"at {NOTED_PERCENTILE} % of the beams the distance of the two parallel meshes is {low:.2f} to {high:.2f} "
        f"times the nominal height, a difference of {high - low:.2f}; noted from {rules.heights_noted:g}; it is "
        f"{found[edge]:.2f} at {structure.mesh.combinatorics.edge_name(edge)} (counted from 0)",
        "optimise the mesh together with its Gauss image (--optimise heights), request even heights under "
        "[gauss_image] in the project file (edges = 1, rounds = 5), or take a mesh with an edge offset",
        "edge",
        (edge,),
    )


def _bounds(noted: float, refused: float) -> str:
    return f"noted from {noted:g}, refused from {refused:g}"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _numbers(elements: list[int]) -> list[str]:
    return [str(element) for element in elements]

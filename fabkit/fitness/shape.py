"""What is judged of a mesh and its Gauss image, whatever their size: a function a criterion, None where all is well."""

from __future__ import annotations

import numpy as np

from fabkit.fitness.finding import Finding, Level, named
from fabkit.fitness.rules import FitnessRules
from geometry.arrays import FloatArray
from geometry.errors import FoldedError
from geometry.gauss import Pair, SupportStructure
from geometry.mesh import Mesh
from geometry.mesh.intersections import intersecting_faces, self_crossing_faces

__all__ = [
    "folded",
    "folding",
    "heights",
    "lean",
    "moves",
    "of_gauss_image",
    "of_planar_mesh",
    "outwards",
    "self_crossing",
    "self_intersection",
]

MOST = 95
"""Per cent of the elements that decide what is told of a whole mesh: a few at corners do not condemn it, and the
largest value is said besides."""

LINES = (
    "lay the mesh along other lines: conjugate directions, best those of principal curvature; where its lines are "
    "asymptotic (the surface is straight along them), turned by 45 degrees"
)
APART = "move or cut the mesh apart there (parts that share room are left out with --skip-unbuildable)"


def of_planar_mesh(before: Mesh, after: Mesh, rules: FitnessRules) -> tuple[Finding, ...]:
    """What is unusual about a mesh made planar. before, after: as read and planar, in one unit."""
    found = (moves(before, after, rules), folding(before, after, rules), self_crossing(after), self_intersection(after))
    return tuple(finding for finding in found if finding)


def of_gauss_image(structure: SupportStructure, rules: FitnessRules) -> tuple[Finding, ...]:
    """What is unusual about a planar mesh and its Gauss image; the distance of the structure does not matter."""
    found = (outwards(structure, rules), lean(structure.pair, rules), heights(structure, rules))
    return tuple(finding for finding in found if finding)


def moves(before: Mesh, after: Mesh, rules: FitnessRules) -> Finding | None:
    """How far vertices moved, in mean edge lengths of the mesh as it was: of most of them, and of the one worst."""
    used = np.flatnonzero(before.combinatorics.is_used)
    size = np.linalg.norm(after.vertices - before.vertices, axis=1)[used] / before.mean_edge_length
    most, worst = float(np.percentile(size, MOST)), int(used[size.argmax()])
    if most < rules.moves_told and size.max() < rules.moves_refused:
        return None
    is_refused = most >= rules.moves_refused
    return Finding(
        "moves",
        "refused" if is_refused else "told",
        most,
        rules.moves_refused if is_refused else rules.moves_told,
        "mean edge lengths",
        f"to make faces planar, {MOST} % of the vertices move by up to {most:.2g} mean edge lengths, vertex {worst} "
        f"(counted from 0) by {size.max():.2g}; {_bounds(rules.moves_told, rules.moves_refused)}",
        LINES,
        "vertex",
        (worst,),
    )


def folding(before: Mesh, after: Mesh, rules: FitnessRules) -> Finding | None:
    """By how much normals of faces turned; what folded over is no result of planarising at all."""
    cosines = np.einsum("fk,fk->f", before.face_normals, after.face_normals)
    turns = np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))
    face = int(turns.argmax())
    if turns[face] < rules.turns_told_deg:
        return None
    return Finding(
        "folding",
        "told",
        float(turns[face]),
        rules.turns_told_deg,
        "degrees",
        f"face {face} (counted from 0) turns by {turns[face]:.0f} degrees when faces are made planar; told from "
        f"{rules.turns_told_deg:g}, refused from 90",
        LINES,
        "face",
        (face,),
    )


def folded(error: FoldedError) -> Finding:
    """What stopped planarising, as a finding."""
    return Finding(
        "folding",
        "refused",
        error.value or 0.0,
        error.bound or 0.0,
        "",
        f"{error.problem} (counted from 0)",
        f"{LINES}; or give fairness under [planarise] in the project file a larger value than 0.3",
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
    """Faces that meet elsewhere than in the vertices and edges they share."""
    pairs = intersecting_faces(mesh).tolist()
    if not pairs:
        return None
    told = named([f"{first} with {second}" for first, second in pairs], at_most=5)
    return Finding(
        "self-intersection",
        "refused",
        len(pairs),
        0.0,
        "pairs of faces",
        f"the mesh runs through itself: {_counted(len(pairs), 'pair')} of faces meet where they share no edge, allowed "
        f"none: {told} (counted from 0)",
        APART,
        "face",
        tuple(dict.fromkeys(face for pair in pairs for face in pair)),
    )


def outwards(structure: SupportStructure, rules: FitnessRules) -> Finding | None:
    """How far beams lie over, from the normals of the faces beside them."""
    c = structure.mesh.combinatorics
    facing = np.einsum(
        "ck,ck->c", structure.height_directions[c.corner_edge], structure.mesh.face_normals[c.corner_face]
    )
    corner = int(facing.argmin())
    angle = float(np.degrees(np.arccos(np.clip(facing[corner], -1.0, 1.0))))
    if facing[corner] > 0 and angle < rules.outwards_told_deg:
        return None
    edge = int(c.corner_edge[corner])
    i, j = c.edges[edge].tolist()
    beam, face = f"the beam on edge {edge} from vertex {i} to vertex {j}", c.corner_face[corner]
    if facing[corner] <= 0:
        return Finding(
            "outwards",
            "refused",
            angle,
            90.0,
            "degrees",
            f"{beam} does not point to the outside of face {face} (angle to its normal {angle:.0f} degrees, less than "
            "90 is needed): the Gauss image folds over there (counted from 0)",
            "change the mesh there, or the weights under [gauss_image] in the project file",
            "edge",
            (edge,),
        )
    return Finding(
        "outwards",
        "told",
        angle,
        rules.outwards_told_deg,
        "degrees",
        f"{beam} leans by {angle:.0f} degrees from the normal of face {face} (counted from 0); told from "
        f"{rules.outwards_told_deg:g}, impossible from 90",
        LINES,
        "edge",
        (edge,),
    )


def lean(pair: Pair, rules: FitnessRules) -> Finding | None:
    """How far node axes lean from the normals."""
    angles = np.degrees(pair.leans)
    median, most = np.nanpercentile(angles, [50, MOST]).tolist()
    is_refused = median >= rules.lean_refused_deg
    if most < rules.lean_told_deg and not is_refused:
        return None
    worst = int(np.nanargmax(angles))
    level: Level = "refused" if is_refused else "told"
    return Finding(
        "lean",
        level,
        median if is_refused else most,
        rules.lean_refused_deg if is_refused else rules.lean_told_deg,
        "degrees",
        f"node axes lean from the normals by {median:.0f} degrees in the median, {most:.0f} at {MOST} %, "
        f"{angles[worst]:.0f} at vertex {worst} (counted from 0); told from {rules.lean_told_deg:g} at {MOST} %, "
        f"refused from a median of {rules.lean_refused_deg:g}",
        "lay the mesh along the directions of principal curvature, where axes are near the normals",
        "vertex",
        (worst,),
    )


def heights(structure: SupportStructure, rules: FitnessRules) -> Finding | None:
    """How far the distances between the two parallel meshes are apart, over the nominal one."""
    found: FloatArray = structure.heights
    low, high = np.percentile(found, [2.5, 97.5]).tolist()
    if high - low < rules.heights_told:
        return None
    edge = int(np.abs(found - 1).argmax())
    return Finding(
        "heights",
        "told",
        high - low,
        rules.heights_told,
        "nominal heights",
        f"{MOST} % of the beams lie between parallel meshes that are {low:.2f} to {high:.2f} of the nominal height "
        f"apart, which differ by {high - low:.2f}; told from {rules.heights_told:g}; "
        f"{found[edge]:.2f} at {structure.mesh.combinatorics.edge_name(edge)} (counted from 0)",
        "ask for even heights under [gauss_image] in the project file (edges = 1, rounds = 5), or take a mesh with an "
        "edge offset",
        "edge",
        (edge,),
    )


def _bounds(told: float, refused: float) -> str:
    return f"told from {told:g}, refused from {refused:g}"


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'' if count == 1 else 's'}"


def _numbers(elements: list[int]) -> list[str]:
    return [str(element) for element in elements]

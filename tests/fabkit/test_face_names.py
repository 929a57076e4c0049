"""Names of faces in part files: ends, facets, edges and the outer side are where the tables have them."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from fabkit import Project, design
from fabkit.formats.step import write_part_steps
from fabkit.parts import Assembly
from geometry.mesh.shapes import dome


@pytest.fixture(scope="module", params=["welded", "bolted"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Assembly, Path]:
    sizes = {"beams": {"section": "rhs 120x60x5"}, "connection": {"kind": request.param}}
    assembly = design(Project(mesh=dome(8, 3), mean_edge_mm=2500, **sizes)).assembly
    folder = tmp_path_factory.mktemp("parts")
    write_part_steps(folder, assembly.groups)
    return assembly, folder


def named_faces(path: Path) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Unit normal, and all points of the outer loop, of each face with a name."""
    entities = dict(re.findall(r"^#(\d+)=(.*);$", path.read_text(), re.MULTILINE))

    def refs(number: str) -> list[str]:
        return re.findall(r"#(\d+)", entities[number])

    def numbers(number: str) -> np.ndarray:
        return np.array([float(word) for word in re.findall(r"-?\d+\.\d*(?:E-?\d+)?", entities[number])])

    found: dict[str, tuple[np.ndarray, np.ndarray]] = {}
    for entity in entities.values():
        face = re.match(r"ADVANCED_FACE\('([^']+)',\((.*?)\),#(\d+),\.T\.\)", entity)
        if face is None:
            continue
        name, bounds, surface = face.groups()
        assert name not in found or name == "OUTSIDE"  # of a trimmed block
        assert entities[surface].startswith("PLANE")
        loop = refs(re.findall(r"\d+", bounds)[0])[0]
        edges = [refs(oriented)[0] for oriented in refs(loop)]
        points = np.array([numbers(refs(end)[0]) for edge in edges for end in refs(edge)[:2]])
        found[name] = numbers(refs(refs(surface)[0])[1]), points
    return found


def test_ends_and_outside_of_beams(made: tuple[Assembly, Path]) -> None:
    assembly, folder = made
    beams = assembly["beams"]
    for k in beams.firsts.tolist():
        faces = named_faces(folder / f"{beams.marks[k]}.step")
        assert set(faces) == {"END A", "END B", "OUTSIDE"}
        corners = beams[k].solid.vertices
        for name, sign in (("END A", -1), ("END B", 1)):
            normal, points = faces[name]
            assert sign * normal[0] > 0.5
            assert (sign * (corners @ normal - points[0] @ normal)).max() * sign < 1e-6  # nothing lies beyond
            assert normal[1] == pytest.approx(0, abs=1e-9)
        np.testing.assert_allclose(faces["OUTSIDE"][0], [0, 0, 1], atol=1e-9)
        assert faces["OUTSIDE"][1][:, 2].max() == pytest.approx(corners[:, 2].max(), abs=1e-9)


def test_facets_of_nodes_look_along_their_beams(made: tuple[Assembly, Path]) -> None:
    assembly, folder = made
    nodes = assembly["nodes"]
    for k in nodes.firsts.tolist():
        faces = named_faces(folder / f"{nodes.marks[k]}.step")
        assert "OUTSIDE" in faces
        own = nodes[k].details
        assert len(faces) == 1 + len(own.beams)
        for number, (azimuth, setback) in enumerate(zip(own.azimuths_deg, own.setbacks_mm, strict=True), start=1):
            normal, points = faces[f"FACET {number}"]
            angle = np.radians(azimuth)
            np.testing.assert_allclose(normal, [np.cos(angle), np.sin(angle), 0], atol=1e-9)
            np.testing.assert_allclose(points @ normal, setback, atol=1e-6)


def test_edges_of_panels_have_the_lengths_of_the_table(made: tuple[Assembly, Path]) -> None:
    assembly, folder = made
    panels = assembly["panels"]
    for k in panels.firsts.tolist():
        faces = named_faces(folder / f"{panels.marks[k]}.step")
        lengths = panels[k].details.edge_lengths_mm
        assert set(faces) == {"OUTSIDE", *(f"EDGE {n}" for n in range(1, len(lengths) + 1))}
        for number, length in enumerate(lengths, start=1):
            points = faces[f"EDGE {number}"][1]
            assert np.ptp(points[:, :2], axis=0) @ np.ptp(points[:, :2], axis=0) == pytest.approx(length**2, rel=1e-6)

"""GLB files, read back by trimesh."""

from __future__ import annotations

import io
import json
import struct
from dataclasses import replace

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from fabkit.errors import OutputError
from fabkit.formats.gltf import glb_bytes
from fabkit.formats.shown.faceted import CHORD_ERROR_MM
from fabkit.formats.shown.triangles import Facets, facets
from fabkit.kinds import BEAM, NODE, PANEL
from fabkit.parts import (
    LEFT_OUT_COLOUR,
    Assembly,
    LeftOut,
    Measures,
    Solid,
    Solids,
    Topology,
    prism_topology,
    prism_vertices,
)
from geometry.arrays import FloatArray
from tests.fabkit.assemblies import assembled
from tests.fabkit.gridshell import gridshell, left_out_lines
from tests.fabkit.round_solids import SOLIDS as ROUND_SOLIDS

COLOURS = {kind.name: kind.colour for kind in (BEAM, NODE, PANEL)}
SINGLE = 1e-6  # glTF holds single precision, 24 bits; parts are up to 1.5 m long


@pytest.fixture(scope="module")
def assembly() -> Assembly:
    return gridshell(6, 5)


@pytest.fixture(scope="module")
def scene(assembly: Assembly) -> trimesh.Scene:
    return read(glb_bytes(assembly))


def read(glb: bytes) -> trimesh.Scene:
    return trimesh.load_scene(io.BytesIO(glb), file_type="glb")


def document(glb: bytes) -> dict:
    (length,) = struct.unpack_from("<I", glb, 12)
    return json.loads(glb[20 : 20 + length])


def y_up(points: FloatArray) -> FloatArray:
    """Metres, +Y up, of millimetres, +Z up."""
    return points[..., [0, 2, 1]] * [1, 1, -1] / 1000


def test_every_part_stands_where_it_should_with_its_volume(assembly: Assembly, scene: trimesh.Scene) -> None:
    names = list(scene.graph.nodes_geometry)
    parts = list(assembly.parts())
    assert len(names) == len(parts)
    found = {}
    for name in names:
        transform, geometry = scene.graph[name]
        mesh = scene.geometry[geometry].copy()
        mesh.merge_vertices(merge_norm=True, merge_tex=True)
        assert mesh.is_watertight, name
        mesh.apply_transform(transform)
        found[tuple(np.round(mesh.bounds, 4).ravel())] = mesh.volume
    for part in parts:
        corners = y_up(part.placement.to_world(part.solid.vertices))
        key = np.round([corners.min(axis=0), corners.max(axis=0)], 4).ravel()
        volume = min(found.items(), key=lambda item: np.abs(np.array(item[0]) - key).max())
        assert np.abs(np.array(volume[0]) - key).max() < 2e-4  # the rounding of the keys
        # thickness 12 mm, placed 5 m away: single precision leaves 1e-6 m of it
        assert volume[1] == pytest.approx(part.solid.volume_mm3 * 1e-9, rel=1e-3)


def test_bounds_are_those_of_the_assembly_in_metres(assembly: Assembly, scene: trimesh.Scene) -> None:
    corners = np.concatenate([y_up(part.placement.to_world(part.solid.vertices)) for part in assembly.parts()])
    np.testing.assert_allclose(scene.bounds, [corners.min(axis=0), corners.max(axis=0)], atol=SINGLE)


def test_tree_is_structure_group_part(assembly: Assembly) -> None:
    gltf = document(glb_bytes(assembly))
    root = gltf["nodes"][gltf["scenes"][0]["nodes"][0]]
    assert root["name"] == "Gridshell"
    groups = [gltf["nodes"][child] for child in root["children"]]
    assert [group["name"] for group in groups] == ["beams", "nodes", "panels"]
    leaves = [gltf["nodes"][child] for group in groups for child in group["children"]]
    parts = list(assembly.parts())
    assert [leaf["name"] for leaf in leaves] == [part.mark for part in parts]
    assert [leaf["extras"]["element"] for leaf in leaves] == [part.element for part in parts]


def test_equal_parts_share_a_mesh(assembly: Assembly) -> None:
    gltf = document(glb_bytes(assembly))
    assert len(gltf["meshes"]) == sum(len(group.solids) for group in assembly.groups) < len(list(assembly.parts()))


def test_colours_are_the_palette_in_linear_light_and_glass_lets_through(assembly: Assembly) -> None:
    materials = {each["name"]: each for each in document(glb_bytes(assembly))["materials"]}
    assert set(materials) == {"beam S355", "node S355", "panel glass"}
    for name, material in materials.items():
        *colour, opacity = material["pbrMetallicRoughness"]["baseColorFactor"]
        srgb = [1.055 * c ** (1 / 2.4) - 0.055 if c > 0.0031308 else 12.92 * c for c in colour]
        np.testing.assert_allclose(srgb, COLOURS[name.split()[0]], atol=1e-5)
        assert (opacity < 1) == (material.get("alphaMode") == "BLEND") == (name == "panel glass")


def test_same_input_same_bytes() -> None:
    assert glb_bytes(gridshell(3, 2)) == glb_bytes(gridshell(3, 2))


def test_left_out_beams_are_red_bars_along_their_edges() -> None:
    lines = left_out_lines(left_out=2)
    glb = glb_bytes(gridshell(left_out=2), lines)
    gltf = document(glb)
    (group,) = [node for node in gltf["nodes"] if node["name"] == "left out"]
    bars = [gltf["nodes"][child] for child in group["children"]]
    assert [bar["name"] for bar in bars] == ["left out: edge 69", "left out: edge 70"]
    scene = read(glb)
    for name, (start, end) in zip([bar["name"] for bar in bars], y_up(lines), strict=True):
        transform, geometry = scene.graph[name]
        bar = scene.geometry[geometry].copy().apply_transform(transform)
        np.testing.assert_allclose(bar.vertices.mean(axis=0), (start + end) / 2, atol=SINGLE)
        length = np.linalg.norm(end - start)
        assert bar.volume == pytest.approx(length * (0.03 * length) ** 2, rel=1e-3)
        across = np.linalg.norm(np.cross(bar.vertices - start, (end - start) / length), axis=1)
        np.testing.assert_allclose(across, 0.015 * length * 2**0.5, atol=SINGLE)
    red = gltf["materials"][-1]["pbrMetallicRoughness"]["baseColorFactor"]
    assert gltf["materials"][-1]["name"] == "left out"
    assert red[0] > 5 * max(red[1:3])
    assert LEFT_OUT_COLOUR not in COLOURS.values()


def test_a_left_out_beam_without_its_line_is_refused() -> None:
    with pytest.raises(OutputError, match="1 beams are left out"):
        glb_bytes(gridshell(2, 2, left_out=1))


def test_an_assembly_without_parts_is_still_a_file() -> None:
    empty = assembled("Nothing")
    assert document(glb_bytes(empty))["nodes"][0]["name"] == "Nothing"
    left = replace(empty, left_out=(LeftOut("panel", 3, "too small"),))
    assert "meshes" not in document(glb_bytes(left))


# Triangles


def star(radii: list[float]) -> FloatArray:
    angles = 2 * np.pi * np.arange(len(radii)) / len(radii)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) * np.array(radii)[:, None]


def triangle_areas(shape: Facets) -> tuple[FloatArray, FloatArray]:
    """Area vectors of the triangles of the first solid, and the normals they should have."""
    a, b, c = shape.points[0, shape.triangles[0]].transpose(1, 0, 2)
    return np.cross(b - a, c - a) / 2, shape.normals[0, shape.triangles[0, :, 0]]


@given(st.lists(st.lists(st.floats(30.0, 200.0), min_size=6, max_size=6), min_size=1, max_size=4))
def test_triangles_cover_each_face_once(outlines: list[list[float]]) -> None:
    """Star-shaped sections, as of nodes with unequal setbacks: all triangles look outwards, and areas add up."""
    topology = prism_topology(6)
    flat = [star(radii) for radii in outlines]
    solids = [Solid(prism_vertices(each, -100.0, 20.0), topology) for each in flat]
    (every,) = facets(Solids.of(solids), ["N1"] * len(solids))
    for k, outline in enumerate(flat):
        shape = Facets(every.solids[k:], every.flat, every.points[k:], every.normals[k:], every.triangles[k:])
        areas, normals = triangle_areas(shape)
        along = np.einsum("ti,ti->t", areas, normals)
        assert (along > -1e-6 * np.linalg.norm(areas, axis=1).max()).all()  # a straight corner has no area
        section = shapely.Polygon(outline)
        assert along.sum() == pytest.approx(2 * section.area + 120 * section.length, rel=1e-9)


def tube() -> Solid:
    """A square tube: its ends are faces with a hole."""
    outer = np.array([[0.0, 0], [60, 0], [60, 60], [0, 60]])
    inner = np.array([[5.0, 5], [55, 5], [55, 55], [5, 55]])
    vertices = np.concatenate([prism_vertices(outer, 0.0, 1000.0), prism_vertices(inner, 0.0, 1000.0)])
    bottom, top = [3, 2, 1, 0], [4, 5, 6, 7]
    loops = [bottom, [8, 9, 10, 11], top, [15, 14, 13, 12]]
    loops += [[k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4] for k in range(4)]
    loops += [[k + 12, (k + 1) % 4 + 12, (k + 1) % 4 + 8, k + 8] for k in range(4)]
    corners = np.concatenate(loops)
    return Solid(vertices, Topology(16, corners, np.arange(0, 49, 4), np.array([0, 2, 4, *range(5, 13)])))


def test_a_face_with_a_hole_stays_open() -> None:
    solid = tube()
    assert solid.volume_mm3 == pytest.approx(1000 * (60**2 - 50**2))
    (shape,) = facets(Solids.of([solid]), ["B1"])
    areas, normals = triangle_areas(shape)
    assert (np.einsum("ti,ti->t", areas, normals) > 0).all()
    assert np.linalg.norm(areas, axis=1).sum() == pytest.approx(2 * (60**2 - 50**2) + 4 * 1000 * (60 + 50))
    ends = shape.triangles[0, np.abs(normals[:, 2]) > 0.5]
    centres = shape.points[0, ends].mean(axis=1)[:, :2]
    assert ((centres < 5) | (centres > 55)).any(axis=1).all()


def test_a_bow_tie_is_refused_by_name() -> None:
    crossing = np.array([[0.0, 0], [10, 10], [10, 0], [0, 12]])
    with pytest.raises(OutputError, match="face 0 of P7 cannot be triangulated"):
        facets(Solids.of([Solid(prism_vertices(crossing, 0.0, 5.0), prism_topology(4))]), ["P7"])


@pytest.mark.parametrize("name", ROUND_SOLIDS)
def test_rounds_become_strips(name: str) -> None:
    """Watertight, with the volume of the solid less what the chords cut off, and normals that lead out of the steel."""
    solid = ROUND_SOLIDS[name]
    (shape,) = facets(Solids.of([solid]), ["N1"])
    mesh = trimesh.Trimesh(shape.points[0], shape.triangles[0], process=False)
    mesh.merge_vertices(merge_norm=True)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    of = Measures(solid.topology, solid.vertices[None])
    # a strip of width w cuts off a segment of 2/3 w s, s being the chord error
    cut_off = 0.7 * CHORD_ERROR_MM * (of.round_areas.sum() + of.fillets.areas.sum())
    assert abs(mesh.volume / solid.volume_mm3 - 1) < 1e-9 + cut_off / solid.volume_mm3
    away = np.einsum("tk,tck->tc", mesh.face_normals, shape.normals[0][shape.triangles[0]])
    assert away.min() > np.cos(np.pi / 12) - 1e-6

"""Surfaces that cross themselves or have one side only are refused, and those that only touch at boundaries are not."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry import GeometryError, Mesh, Surface, as_mesh, lay_quads, read_mesh
from geometry.arrays import FloatArray
from geometry.errors import MeshError
from geometry.mesh.intersections import crossing_triangles
from tests.geometry.bent_meshes import rotation
from tests.geometry.design_surfaces import KNOWN, ball, chart, disc
from tests.geometry.topologies import together

Point = Callable[[FloatArray, FloatArray], tuple[FloatArray, ...]]


def sheet(n: int, point: Point) -> Mesh:
    return chart(n, n, point).triangulated


def flat(n: int = 8, *, low: float = -1.0) -> Mesh:
    return sheet(n, lambda u, v: (2 * u - 1, 2 * v + low, 0 * u))


def upright(n: int = 8, *, down: float = -1.0, along: float = 0.03) -> Mesh:
    return sheet(n, lambda u, v: (0 * u + along, 2 * u - 1, 2 * v + down))


def eight(n: int, *, shift: float = 0.5) -> Mesh:
    """A tube over a figure of eight, whose crossing lies between its vertices, or for shift = 0 in two of them."""

    def point(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        angle = 2 * np.pi * (u + shift / n)
        return 3 * np.sin(angle), 3 * np.sin(angle) * np.cos(angle), 5 * v

    return chart(n, n, point, rings="u").triangulated


def klein(n: int = 24) -> list[list[float]]:
    """Points (u, v) of the figure-eight immersion; u and v are closed, v with a flip."""
    points = []
    for k in range(n):
        for j in range(n):
            u, v = 2 * np.pi * k / n, 2 * np.pi * (j + 0.5) / n
            r = 3 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
            z = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
            points.append([r * np.cos(u), r * np.sin(u), z])
    return points


def klein_faces(n: int = 24) -> list[list[int]]:
    def number(k: int, j: int) -> int:
        return k * n + j % n if k < n else (n - 1 - j) % n

    return [
        [number(k, j), number(k + 1, j), number(k + 1, j + 1), number(k, j + 1)] for k in range(n) for j in range(n)
    ]


def moebius(n: int = 40, m: int = 6) -> tuple[FloatArray, list[list[int]]]:
    k, j = (each.ravel() for each in np.meshgrid(np.arange(n), np.arange(m + 1), indexing="ij"))
    u, v = 2 * np.pi * k / n, 2 * j / m - 1
    r = 3 + v * np.cos(u / 2)
    points = np.stack([r * np.cos(u), r * np.sin(u), v * np.sin(u / 2)], axis=1)

    def number(k: int, j: int) -> int:
        return k * (m + 1) + j if k < n else m - j

    quads = [
        (number(k, j), number(k + 1, j), number(k + 1, j + 1), number(k, j + 1)) for k in range(n) for j in range(m)
    ]
    return points, [list(each) for a, b, c, d in quads for each in ((a, b, c), (a, c, d))]


CROSSING: dict[str, Callable[[], Mesh]] = {
    "two sheets": lambda: together(flat(), upright()),
    "two sheets, along edges of one": lambda: together(flat(), upright(along=0.0)),
    "two sheets, along edges of both": lambda: together(flat(), upright(along=0.0, down=-0.75)),
    "a sheet that ends inside another one by a third": lambda: together(flat(12), upright(12, down=-0.667)),
    "a tube over a figure of eight": lambda: eight(41),
    "a tube over a figure of eight, with vertices where it crosses": lambda: eight(40, shift=0.0),
    "a second layer in the same plane": lambda: together(flat(), flat(7, low=-0.3)),
    "the same layer twice": lambda: together(flat(), flat()),
    "balls in each other": lambda: together(ball(2, (1, 1, 1)).triangulated, ball(2, (1.2, 0.9, 0.9)).triangulated),
}


@pytest.mark.parametrize("name", CROSSING)
def test_surfaces_that_cross_themselves_are_refused(name: str) -> None:
    mesh = CROSSING[name]()
    with pytest.raises(MeshError, match="the surface crosses, touches or covers itself: faces") as caught:
        lay_quads(Surface(mesh), n_faces=100)
    assert set(caught.value.elements) <= set(range(mesh.n_faces))
    assert len(caught.value.elements) > 1


def folded_over() -> Mesh:
    """A sheet bent back onto itself: neighbours at the fold share an edge and lie in one plane."""
    points = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.2, 0.3, 0]])
    return Mesh.from_faces(points, [[0, 1, 2], [0, 2, 3], [2, 1, 4]])


def test_neighbours_folded_over_in_one_plane_are_found() -> None:
    assert crossing_triangles(folded_over()).tolist() == [[0, 2], [1, 2]]


def cap_and_ring(height: Callable[[FloatArray, FloatArray], FloatArray]) -> Mesh:
    """A cap and a ring around it, whose boundaries are polylines of 60 and 47 pieces along one circle."""

    def ring(u: FloatArray, v: FloatArray) -> tuple[FloatArray, ...]:
        angle, r = 2 * np.pi * u, 1 + v
        x, y = r * np.cos(angle), r * np.sin(angle)
        return x, y, height(x, y)

    return together(disc(10, height).triangulated, chart(47, 8, ring, rings="u").triangulated)


TOUCHING: dict[str, Callable[[], Mesh]] = {
    "a wall on a floor": lambda: together(flat(), upright(down=0.0)),
    "a wall on a floor, along its edges": lambda: together(flat(), upright(down=0.0, along=0.0)),
    "halves with vertices of their own": lambda: together(flat(), flat(low=1.0)),
    "halves of other triangles": lambda: together(flat(), flat(7, low=1.0)),
    "two polylines along one curve": lambda: cap_and_ring(lambda x, y: 0.3 * x**3 - 0.9 * x * y**2),
    "two polylines along one curve in a plane": lambda: cap_and_ring(lambda x, y: 0 * x),
    "layers above each other": lambda: together(flat(), flat().translated([0, 0, 0.01])),
    "a torus": lambda: KNOWN["torus"][0]().triangulated,
    "an ellipsoid": lambda: KNOWN["ellipsoid"][0]().triangulated,
}


@pytest.mark.parametrize("name", TOUCHING)
def test_boundaries_may_touch(name: str) -> None:
    assert crossing_triangles(TOUCHING[name]()).tolist() == []


@given(st.integers(0, 2**32 - 1), st.integers(-6, 6))
@settings(max_examples=10)
def test_place_and_unit_do_not_matter(seed: int, decades: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = together(flat(5), upright(5, along=float(rng.uniform(-0.9, 0.9))))
    expected = Surface(mesh).crossing_faces.tolist()
    size = 10.0**decades
    moved = mesh.with_vertices(mesh.vertices @ rotation(seed).T * size + rng.normal(size=3) * 1e4 * size)
    assert Surface(moved).crossing_faces.tolist() == expected
    assert expected


def test_one_sided_surfaces_are_called_that_in_files_and_in_memory(tmp_path: Path) -> None:
    for vertices, faces in (moebius(), (np.array(klein()), klein_faces())):
        lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices).tolist()]
        lines += ["f " + " ".join(str(v + 1) for v in face) for face in faces]
        (tmp_path / "band.obj").write_text("\n".join(lines))
        for made in (
            lambda: Surface(Mesh.from_faces(vertices, faces)),  # noqa: B023
            lambda: as_mesh((vertices, faces)),  # noqa: B023
            lambda: Surface((vertices, faces)),  # type: ignore[arg-type]  # noqa: B023
            lambda: read_mesh(tmp_path / "band.obj"),
        ):
            with pytest.raises(GeometryError, match=r"one side only \(it is not orientable\)") as caught:
                made()
            assert len(caught.value.elements) == 2
    triangles = trimesh.Trimesh(*moebius(), process=False)
    with pytest.raises(GeometryError, match="one side only"):
        Surface(triangles)  # type: ignore[arg-type]


def test_a_klein_bottle_cut_open_crosses_itself() -> None:
    n = 24
    cut = [face for k, face in enumerate(klein_faces(n)) if k // n < n - 1]
    with pytest.raises(MeshError, match="crosses, touches or covers itself"):
        lay_quads(Surface(Mesh.from_faces(klein(n), cut)), n_faces=200)


def test_a_roof_that_only_dips_below_itself_is_laid() -> None:
    """Not a height field: an arch of more than half a circle."""
    arch = chart(30, 20, lambda u, v: (np.sin(5 * u - 2.5), -np.cos(5 * u - 2.5), 3 * v))
    assert lay_quads(arch, n_faces=60).mesh.n_faces > 40
    assert not len(disc(6, lambda x, y: x * y).crossing_faces)

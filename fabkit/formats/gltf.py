"""GLB: the whole structure as one binary glTF 2.0 file, for viewers.

glTF wants metres and +Y up; millimetres become metres in the numbers, and the root node turns +Z up into +Y up, so that
a reader which turns it back (Rhino, Blender) shows the coordinates of the project. The origin of the assembly is on the
root node alone, in all its digits: everything below it is near zero, where single precision is fine. The tree is
structure / group / part, with a group "left out", with marks as names; equal parts share one mesh, placed many times.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np

from fabkit.formats.shown import Placed, Surface, facets, left_out_bars, placed_parts
from fabkit.parts import Assembly, Solids
from geometry.arrays import FloatArray, IntArray

__all__ = ["glb_bytes"]

Json = dict[str, Any]

_Z_UP_TO_Y_UP = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]
_FLOAT, _UINT16, _UINT32 = 5126, 5123, 5125
"""Component types of glTF accessors."""
_ARRAY_BUFFER, _ELEMENT_ARRAY_BUFFER = 34962, 34963
"""Targets of glTF buffer views: values of vertices, and indices of them."""
_CHUNK_JSON, _CHUNK_BIN = b"JSON", b"BIN\0"
_NODE = '{"name":%s,"mesh":%s,"translation":[%r,%r,%r],"rotation":[%r,%r,%r,%r]%s}'
_VECTORS = f'"byteOffset":%s,"componentType":{_FLOAT},"count":%s,"type":"VEC3"'
_POSITIONS = f'{{"bufferView":0,{_VECTORS},"min":[%r,%r,%r],"max":[%r,%r,%r]}}'
_NORMALS = f'{{"bufferView":1,{_VECTORS}}}'
_MESH = '{"name":%s,"primitives":[{"attributes":{"POSITION":%s,"NORMAL":%s},"indices":%s,"material":%s}]}'


def glb_bytes(assembly: Assembly, left_out_lines: FloatArray | None = None) -> bytes:
    """The bytes of a .glb file: metres, +Y up, flat-shaded exact triangulations; colours by kind, glass transparent.

    Each part is a node named by its mark, with `extras.element`, its mesh edge, vertex or face; they come in the
    order of `assembly.parts()`. left_out_lines (n, 2, 3), in mm: the ends of the edges of `assembly.left_out`'s
    beams, in that order; they become red bars in the group "left out". The same input gives the same bytes.

    Raises `OutputError` where the lines are not one for each beam left out, and where a face of a part is no
    polygon that can be triangulated.

    >>> from fabkit import Project, design
    >>> from geometry.mesh.shapes import dome
    >>> built = design(Project(mesh=dome(6, 2), mean_edge_mm=1500))
    >>> from fabkit.formats import glb_bytes
    >>> glb_bytes(built.assembly)[:4]
    b'glTF'
    """
    scene = _Scene(assembly.name, assembly.origin_mm)
    for parts in assembly.groups:
        scene.add_group(parts.kind.group, placed_parts(parts), assembly.zones.named(parts))
    scene.add_group("left out", left_out_bars(assembly, left_out_lines))
    return scene.glb()


class _Scene:
    """A glTF document that grows group by group. Node 0 is the structure."""

    def __init__(self, name: str, origin_mm: FloatArray) -> None:
        x, y, z = (origin_mm / 1000).tolist()
        place = {"translation": [x, z, 0.0 - y]} if origin_mm.any() else {}
        self.root: Json = {"name": name, **place, "rotation": _Z_UP_TO_Y_UP}
        self.groups: dict[str, list[int]] = {}  # by the names of their zones
        self.nodes: list[str] = []  # in JSON, as are meshes and accessors: there may be hundreds of thousands
        self.meshes: list[str] = []
        self.accessors: list[str] = []
        self.materials: dict[Surface, int] = {}
        self.index_accessors: dict[bytes, int] = {}
        self.points: list[bytes] = []
        self.normals: list[bytes] = []
        self.indices: list[bytes] = []
        self.n_points = 0
        self.index_offset = 0

    def add_group(self, name: str, placed: Placed, zones: Sequence[str] = ()) -> None:
        """A node for the group, or for its share of each zone, and one for each thing in it; nothing where it is empty.
        zones: the name of the zone of each thing, empty without one."""
        if not placed.names:
            return
        rows: dict[str, list[int]] = {}
        for n, zone in enumerate(zones or [""] * len(placed.names)):
            rows.setdefault(zone, []).append(n)
        first = len(self.nodes) + 1 + len(rows)  # after the root and the nodes of zones
        for zone, own in rows.items():
            self.groups.setdefault(zone, []).append(len(self.nodes) + 1)
            self.nodes.append(_json({"name": f"{zone} {name}".strip(), "children": [first + n for n in own]}))
        columns = zip(
            map(_json, placed.names),
            self._add_meshes(placed),
            np.round(placed.translations / 1000, 9).tolist(),  # a micrometre's thousandth
            np.round(placed.rotations, 12).tolist(),
            [f',"extras":{{"element":{element}}}' if element >= 0 else "" for element in placed.elements.tolist()],
            strict=True,
        )
        self.nodes += [_NODE % (mark, mesh, *place, *turn, extras) for mark, mesh, place, turn, extras in columns]

    def _add_meshes(self, placed: Placed) -> list[int]:
        """Mesh of each thing; one for each pair of solid and material, in the order of first use."""
        pairs = placed.shape * len(placed.surfaces) + placed.surface
        _, first, pair = np.unique(pairs, return_index=True, return_inverse=True)
        order = np.argsort(first)
        distinct = first[order].tolist()
        meshes = np.empty(len(distinct), dtype=np.int64)
        meshes[order] = len(self.meshes) + np.arange(len(distinct))
        surfaces = [self.materials.setdefault(each, len(self.materials)) for each in placed.surfaces]
        names = [placed.names[n] for n in distinct]
        self._write_meshes(names, placed.solids.take(placed.shape[distinct]), placed.surface[distinct], surfaces)
        return list(meshes[pair].tolist())

    def _write_meshes(self, names: Sequence[str], solids: Solids, surface: IntArray, surfaces: Sequence[int]) -> None:
        """Meshes of solids with these names, each with one of the surfaces (materials in the document)."""
        shapes = facets(solids, names)
        counts, kind = np.empty(len(solids), dtype=np.int64), np.empty(len(solids), dtype=np.int64)
        row = np.empty(len(solids), dtype=np.int64)
        for k, shape in enumerate(shapes):
            counts[shape.solids], kind[shape.solids] = shape.points.shape[1], k
            row[shape.solids] = np.arange(len(shape.solids))
        starts = np.concatenate([[0], np.cumsum(counts)])
        points, normals = np.empty((starts[-1], 3), dtype="<f4"), np.empty((starts[-1], 3), dtype="<f4")
        for shape in shapes:
            places = starts[shape.solids][:, None] + np.arange(shape.points.shape[1])
            points[places], normals[places] = shape.points / 1000, shape.normals
        extents = np.concatenate([each.reduceat(points, starts[:-1]) for each in (np.minimum, np.maximum)], axis=1)
        self.points.append(points.tobytes())
        self.normals.append(normals.tobytes())
        offsets = (12 * (self.n_points + starts[:-1])).tolist()
        columns = zip(map(_json, names), offsets, counts.tolist(), extents.tolist(), strict=True)
        for n, (name, offset, count, extent) in enumerate(columns):
            position = len(self.accessors)
            self.accessors += [_POSITIONS % (offset, count, *extent), _NORMALS % (offset, count)]
            indices = self._indices(shapes[kind[n]].triangles[row[n]], count)
            self.meshes.append(_MESH % (name, position, position + 1, indices, surfaces[surface[n]]))
        self.n_points += int(starts[-1])

    def _indices(self, triangles: IntArray, n_points: int) -> int:
        """Accessor of the triangles; meshes with the same ones share it."""
        narrow = n_points < 0xFFFF
        data = triangles.astype("<u2" if narrow else "<u4").tobytes()
        if data not in self.index_accessors:
            self.index_accessors[data] = len(self.accessors)
            accessor = {
                "bufferView": 2,
                "byteOffset": self.index_offset,
                "componentType": _UINT16 if narrow else _UINT32,
                "count": triangles.size,
                "type": "SCALAR",
            }
            self.accessors.append(_json(accessor))
            self.indices.append(data + bytes(-len(data) % 4))
            self.index_offset += len(self.indices[-1])
        return self.index_accessors[data]

    def glb(self) -> bytes:
        """The file: header, JSON chunk, binary chunk."""
        blocks = [b"".join(self.points), b"".join(self.normals), b"".join(self.indices)]
        starts = np.cumsum([0, *map(len, blocks)]).tolist()
        views: list[Json] = [
            {"buffer": 0, "byteOffset": start, "byteLength": len(block), "target": _ARRAY_BUFFER, "byteStride": 12}
            for start, block in zip(starts[:2], blocks[:2], strict=True)
        ]
        views.append(
            {"buffer": 0, "byteOffset": starts[2], "byteLength": len(blocks[2]), "target": _ELEMENT_ARRAY_BUFFER}
        )
        children = self.groups.pop("", [])
        for zone, groups in self.groups.items():
            children.append(len(self.nodes) + 1)
            self.nodes.append(_json({"name": zone, "children": groups}))
        root = _json({**self.root, "children": children})
        members = [
            '"asset":{"version":"2.0","generator":"fabkit"},"scene":0,"scenes":[{"nodes":[0]}]',
            f'"nodes":[{",".join([root, *self.nodes])}]',
        ]
        if self.meshes:
            members += [
                f'"meshes":[{",".join(self.meshes)}]',
                f'"materials":{_json([_material(each) for each in self.materials])}',
                f'"accessors":[{",".join(self.accessors)}]',
                f'"bufferViews":{_json(views)}',
                f'"buffers":[{{"byteLength":{starts[3]}}}]',
            ]
        text = f"{{{','.join(members)}}}".encode()
        body = _chunk(_CHUNK_JSON, text, b" ") + (_chunk(_CHUNK_BIN, b"".join(blocks), b"\0") if self.meshes else b"")
        return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


_json = json.JSONEncoder(separators=(",", ":")).encode


def _chunk(kind: bytes, data: bytes, padding: bytes) -> bytes:
    data += padding * (-len(data) % 4)
    return struct.pack("<I4s", len(data), kind) + data


def _material(of: Surface) -> Json:
    surface: Json = {
        "baseColorFactor": [*_linear(of.colour), of.opacity],
        "metallicFactor": 0.0,
        "roughnessFactor": 0.6,
    }
    material: Json = {"name": of.name, "pbrMetallicRoughness": surface}
    return {**material, "alphaMode": "BLEND", "doubleSided": True} if of.opacity < 1 else material


def _linear(colour: tuple[float, float, float]) -> list[float]:
    """The colour in linear light, which glTF wants, of an sRGB colour [IEC 61966-2-1]."""
    return [round(c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4, 6) for c in colour]

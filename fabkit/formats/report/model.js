"use strict";

// The model: a GLB as this project writes it, as one set of flat arrays a layer (each group of parts, left out).
// Coordinates are metres, +Z up, about the centre of the model: neither the root's turn to +Y up nor its move to the
// place of the model is wanted here.

/** Uint8Array of a base64 text. */
function bytesOfBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let n = 0; n < bytes.length; n++) bytes[n] = binary.charCodeAt(n);
  return bytes;
}

/** {layers, radius}; a layer has a name, its parts, and the arrays that the viewer draws. */
function readModel(bytes) {
  const jsonLength = new DataView(bytes.buffer).getUint32(12, true);
  const gltf = JSON.parse(new TextDecoder().decode(bytes.subarray(20, 20 + jsonLength)));
  const meshes = readMeshes(gltf, bytes.buffer, 28 + jsonLength);
  const groups = gltf.nodes[0].children.map((index) => gltf.nodes[index]);
  const centre = middle(groups.flatMap((group) => group.children.map((index) => placedMiddle(gltf, gltf.nodes[index]))));
  let firstId = 1; // 0 is the background
  const layers = groups.map((group) => {
    const layer = readLayer(group.name, group.children.map((index) => gltf.nodes[index]), meshes, centre, firstId);
    firstId += layer.parts.length;
    return layer;
  });
  let radius = 0;
  for (const { positions } of layers) {
    for (let k = 0; k < positions.length; k += 3) {
      radius = Math.max(radius, Math.hypot(positions[k], positions[k + 1], positions[k + 2]));
    }
  }
  return { layers, radius };
}

/** Middle of a part's own box, where the part stands. */
function placedMiddle(gltf, node) {
  const { min, max } = gltf.accessors[gltf.meshes[node.mesh].primitives[0].attributes.POSITION];
  const own = min.map((value, axis) => (value + max[axis]) / 2);
  return turn(node.rotation).map((row, axis) => node.translation[axis] + row[0] * own[0] + row[1] * own[1] + row[2] * own[2]);
}

function middle(points) {
  return [0, 1, 2].map((axis) => {
    let least = Infinity, most = -Infinity;
    for (const point of points) {
      least = Math.min(least, point[axis]);
      most = Math.max(most, point[axis]);
    }
    return (least + most) / 2;
  });
}

/** {positions, normals, triangles, outline, colour} of each mesh; the first four are typed arrays. */
function readMeshes(gltf, buffer, start) {
  const outlines = new Map(); // meshes with the same triangles share them, so they share the outline too
  const array = (index, Type, width) => {
    const accessor = gltf.accessors[index];
    const offset = start + gltf.bufferViews[accessor.bufferView].byteOffset + (accessor.byteOffset || 0);
    return new Type(buffer, offset, accessor.count * width);
  };
  return (gltf.meshes || []).map((mesh) => {
    const primitive = mesh.primitives[0];
    const narrow = gltf.accessors[primitive.indices].componentType === 5123;
    const triangles = array(primitive.indices, narrow ? Uint16Array : Uint32Array, 1);
    if (!outlines.has(primitive.indices)) outlines.set(primitive.indices, outlineOf(triangles));
    return {
      positions: array(primitive.attributes.POSITION, Float32Array, 3),
      normals: array(primitive.attributes.NORMAL, Float32Array, 3),
      triangles,
      outline: outlines.get(primitive.indices),
      colour: screenColour(gltf.materials[primitive.material].pbrMetallicRoughness.baseColorFactor),
    };
  });
}

/** Edges that bound one triangle only: since faces share no corner, these are the edges of the faces. */
function outlineOf(triangles) {
  const once = new Map();
  for (let t = 0; t < triangles.length; t += 3) {
    for (let k = 0; k < 3; k++) {
      const a = triangles[t + k], b = triangles[t + ((k + 1) % 3)];
      const key = Math.min(a, b) * 4294967296 + Math.max(a, b);
      if (!once.delete(key)) once.set(key, [a, b]);
    }
  }
  return Uint32Array.from([...once.values()].flat());
}

/** sRGB and opacity, 0 to 255, of a colour in linear light. */
function screenColour([r, g, b, opacity]) {
  const curved = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
  return [curved(r), curved(g), curved(b), opacity].map((c) => Math.round(255 * c));
}

function readLayer(name, nodes, meshes, centre, firstId) {
  let nCorners = 0, nIndices = 0, nLines = 0;
  for (const node of nodes) {
    nCorners += meshes[node.mesh].positions.length / 3;
    nIndices += meshes[node.mesh].triangles.length;
    nLines += meshes[node.mesh].outline.length;
  }
  const layer = {
    name,
    parts: [],
    positions: new Float32Array(3 * nCorners),
    normals: new Int8Array(4 * nCorners),
    ids: new Uint8Array(4 * nCorners),
    triangles: new Uint32Array(nIndices),
    outline: new Uint32Array(nLines),
  };
  let corner = 0, index = 0, line = 0;
  nodes.forEach((node, row) => {
    const mesh = meshes[node.mesh], count = mesh.positions.length / 3;
    const origin = node.translation.map((value, axis) => value - centre[axis]);
    placeCorners(layer, mesh, corner, origin, turn(node.rotation), firstId + row);
    for (const k of mesh.triangles) layer.triangles[index++] = corner + k;
    for (const k of mesh.outline) layer.outline[line++] = corner + k;
    layer.parts.push({ name: node.name, id: firstId + row, first: corner, count, colour: mesh.colour });
    corner += count;
  });
  return layer;
}

function placeCorners(layer, mesh, first, origin, m, id) {
  const { positions: p, normals: n } = mesh;
  for (let k = 0, to = first; k < p.length; k += 3, to++) {
    for (let axis = 0; axis < 3; axis++) {
      const [x, y, z] = m[axis];
      layer.positions[3 * to + axis] = origin[axis] + x * p[k] + y * p[k + 1] + z * p[k + 2];
      layer.normals[4 * to + axis] = 127 * (x * n[k] + y * n[k + 1] + z * n[k + 2]);
    }
    layer.ids.set([id & 255, (id >> 8) & 255, (id >> 16) & 255, 255], 4 * to);
  }
}

/** Rows of the rotation matrix of a unit quaternion. */
function turn([x, y, z, w]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
  ];
}

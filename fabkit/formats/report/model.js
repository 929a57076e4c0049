"use strict";

// The model, as fabkit/formats/report/model.py describes it: each shape once, placed many times. Metres, +Z up, about
// the middle of the model.

/** Uint8Array of a base64 text. */
function bytesOfBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let n = 0; n < bytes.length; n++) bytes[n] = binary.charCodeAt(n);
  return bytes;
}

/** {layers, points, shapes, cuts, radius}; a layer has a name, and for its parts their origins, turns, shapes, own
    colours, middles (x, y, z and radius) and box corners; a cut has the triangles and edges of shapes. */
function readModel(head, bytes) {
  return withBoxes(readArrays(head, bytes));
}

/** The same without middles, boxes and radius. */
function readArrays(head, bytes) {
  let at = 0;
  const next = (Type, count) => new Type(bytes.buffer, (at += 4 * count) - 4 * count, count);
  const layers = head.layers.map(({ name, count, colours }) => {
    const [origins, turns] = [next(Float32Array, 3 * count), next(Float32Array, 4 * count)];
    const [shapes, colour] = [next(Uint32Array, count), next(Uint32Array, count)];
    return { name, count, origins, turns, shapes, colourOf: (row) => colours[colour[row]] };
  });
  const points = next(Float32Array, 3 * head.points), pairs = next(Uint32Array, 2 * head.shapes);
  const shapes = Array.from({ length: head.shapes }, (_, k) => ({ first: pairs[2 * k], cut: pairs[2 * k + 1] }));
  shapes.forEach((shape, k) => {
    shape.box = boxOf(points, shape.first, k + 1 < shapes.length ? shapes[k + 1].first : head.points);
  });
  const cuts = head.cuts.map(([triangles, edges]) => ({
    triangles: next(Uint32Array, 3 * triangles),
    edges: next(Uint32Array, 2 * edges),
  }));
  return { layers, points, shapes, cuts };
}

/** The model with the boxes of its parts, and its radius about the origin. */
function withBoxes({ layers, points, shapes, cuts }) {
  for (const layer of layers) placeBoxes(layer, shapes);
  let radius = 0;
  for (const { corners } of layers) {
    for (let k = 0; k < corners.length; k += 3) radius = Math.max(radius, Math.hypot(corners[k], corners[k + 1], corners[k + 2]));
  }
  return { layers, points, shapes, cuts, radius: radius || 1 };
}

function boxOf(points, first, end) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let k = 3 * first; k < 3 * end; k++) {
    low[k % 3] = Math.min(low[k % 3], points[k]);
    high[k % 3] = Math.max(high[k % 3], points[k]);
  }
  return [low, high];
}

/** Middle and radius of each part, and the corners of its own box, where it stands. */
function placeBoxes(layer, shapes) {
  layer.middles = new Float32Array(4 * layer.count);
  layer.corners = new Float32Array(24 * layer.count);
  for (let row = 0; row < layer.count; row++) {
    const [low, high] = shapes[layer.shapes[row]].box;
    const half = low.map((value, axis) => (high[axis] - value) / 2);
    layer.middles.set(placed(layer, row, low.map((value, axis) => value + half[axis])), 4 * row);
    layer.middles[4 * row + 3] = Math.hypot(...half);
    for (let k = 0; k < 8; k++) {
      const corner = [k & 1, k & 2, k & 4].map((upper, axis) => (upper ? high : low)[axis]);
      layer.corners.set(placed(layer, row, corner), 24 * row + 3 * k);
    }
  }
}

/** A point of a part's own frame, where the part stands. */
function placed({ origins, turns }, row, point) {
  return turned(turns.subarray(4 * row, 4 * row + 4), point).map((value, axis) => value + origins[3 * row + axis]);
}

/** A vector turned by a unit quaternion; `back`: by its inverse. */
function turned([x, y, z, w], [a, b, c], back = false) {
  const s = back ? -w : w;
  const [p, q, r] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + s * p + y * r - z * q, b + s * q + z * p - x * r, c + s * r + x * q - y * p];
}

/** {row, distance} of the foremost part of a layer on a ray, null without one. `moved`: how far parts are apart; `seen`
    (row, point): whether that point of a part is in sight. */
function hitOf(model, layer, from, along, moved, seen) {
  let found = null;
  for (let row = 0; row < layer.count; row++) {
    const [x, y, z, radius] = layer.middles.subarray(4 * row, 4 * row + 4);
    const apart = [x, y, z].map((value, axis) => value * (1 + moved) - from[axis]);
    const ahead = apart[0] * along[0] + apart[1] * along[1] + apart[2] * along[2];
    const aside = apart[0] ** 2 + apart[1] ** 2 + apart[2] ** 2 - ahead ** 2;
    if (aside > radius ** 2 || (found && ahead - radius > found.distance)) continue;
    const turn = layer.turns.subarray(4 * row, 4 * row + 4);
    const start = from.map((value, axis) => value - layer.origins[3 * row + axis] - moved * [x, y, z][axis]);
    const inSight = (distance) => seen(row, from.map((value, axis) => value + distance * along[axis]));
    const most = found ? found.distance : Infinity;
    const distance = nearest(model, layer.shapes[row], turned(turn, start, true), turned(turn, along, true), most, inSight);
    if (distance < most) found = { row, distance };
  }
  return found;
}

/** Distance along a ray in a shape's own frame to its first triangle that is in sight, `most` without one nearer. */
function nearest({ points, shapes, cuts }, shape, [ox, oy, oz], [dx, dy, dz], most, inSight) {
  const { first, cut } = shapes[shape], { triangles } = cuts[cut];
  for (let k = 0; k < triangles.length; k += 3) {
    const [a, b, c] = [0, 1, 2].map((n) => 3 * (first + triangles[k + n]));
    const [ux, uy, uz] = [points[b] - points[a], points[b + 1] - points[a + 1], points[b + 2] - points[a + 2]];
    const [vx, vy, vz] = [points[c] - points[a], points[c + 1] - points[a + 1], points[c + 2] - points[a + 2]];
    const [px, py, pz] = [dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx];
    const size = ux * px + uy * py + uz * pz;
    if (size === 0) continue;
    const [tx, ty, tz] = [ox - points[a], oy - points[a + 1], oz - points[a + 2]];
    const u = (tx * px + ty * py + tz * pz) / size;
    if (u < 0 || u > 1) continue;
    const [qx, qy, qz] = [ty * uz - tz * uy, tz * ux - tx * uz, tx * uy - ty * ux];
    const v = (dx * qx + dy * qy + dz * qz) / size, distance = (vx * qx + vy * qy + vz * qz) / size;
    if (v >= 0 && u + v <= 1 && distance > 0 && distance < most && inSight(distance)) most = distance;
  }
  return most;
}

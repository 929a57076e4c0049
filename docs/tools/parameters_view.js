"use strict";

// The picture of one mesh: faces, edges as ribbons of constant width, beams and the unit sphere, seen by a Camera of the
// report (formats/report/camera.js). Meshes come as they are to be drawn; nothing is computed but what is on the screen.

const FACE_SHADER = [
  `#version 300 es
   in vec3 position; uniform mat4 camera; out vec3 place;
   void main() { place = position; gl_Position = camera * vec4(position, 1.0); }`,
  `#version 300 es
   precision highp float;
   in vec3 place; uniform vec3 eye; uniform vec4 colour; uniform bool isRound; out vec4 shade;
   void main() {
     vec3 towards = normalize(eye - place);
     vec3 n = isRound ? normalize(place) : normalize(cross(dFdx(place), dFdy(place)));
     if (dot(n, towards) < 0.0) n = -n;
     float light = 0.62 + 0.18 * dot(n, towards) + 0.24 * max(dot(n, normalize(vec3(-0.4, -0.5, 0.8))), 0.0);
     shade = vec4(colour.rgb * light, colour.a);
   }`,
];
const RIBBON_SHADER = [
  `#version 300 es
   in vec3 start; in vec3 end; uniform mat4 camera; uniform vec2 size; uniform float width;
   void main() {
     vec4 a = camera * vec4(start, 1.0), b = camera * vec4(end, 1.0);
     vec2 along = (b.xy / b.w - a.xy / a.w) * size;
     along = length(along) > 1e-4 ? normalize(along) : vec2(1.0, 0.0);
     float side = float(gl_VertexID % 2) * 2.0 - 1.0, ahead = gl_VertexID > 1 ? 1.0 : -1.0;
     vec4 p = ahead > 0.0 ? b : a;
     p.xy += (vec2(-along.y, along.x) * side + along * ahead * 0.5) * width / size * p.w;
     p.z -= 0.0012 * p.w;
     gl_Position = p;
   }`,
  `#version 300 es
   precision highp float; uniform vec4 colour; out vec4 shade;
   void main() { shade = colour; }`,
];
const SPHERE_STEPS = 64;

class View {
  /** Raises an Error where the browser has no WebGL 2. `colours` are names of variables of the style sheet. */
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { alpha: false, antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("no WebGL 2");
    this.faceProgram = linkedProgram(this.gl, FACE_SHADER);
    this.ribbonProgram = linkedProgram(this.gl, RIBBON_SHADER);
    this.camera = new Camera({ layers: [], radius: 1 });
    this.layers = [];
    this.hovered = -1;
    this.onHover = () => {};
    this.camera.listen(canvas, () => {}, (x, y) => this.onHover(this.faceAt(x, y)));
    canvas.addEventListener("pointerleave", () => this.onHover(-1));
    this.ball = this.sphereLayer();
    new ResizeObserver(() => this.redraw()).observe(canvas);
  }

  /** shape: {positions, topology {faces, edges}, isReversed, isTurned, beams: positions of the other side or null}. */
  show(shape, hasSphere) {
    for (const { buffer } of this.layers) this.gl.deleteBuffer(buffer);
    this.shape = shape;
    this.hasSphere = hasSphere;
    const { positions: p, topology, isReversed, isTurned, beams } = shape;
    const faces = topology.faces.map((_, face) => face), edges = topology.edges.map((_, edge) => edge);
    const point = (from, v) => [from[3 * v], from[3 * v + 1], from[3 * v + 2]];
    const triangles = (chosen) => chosen.flatMap((face) => fan(topology.faces[face]).flatMap((v) => point(p, v)));
    const lines = (from, chosen) => chosen.flatMap((edge) => topology.edges[edge].flatMap((v) => point(from, v)));
    const fins = (chosen) => chosen.flatMap((edge) => {
      const [i, j] = topology.edges[edge], [a, b, c, d] = [point(p, i), point(p, j), point(beams, j), point(beams, i)];
      return [...a, ...b, ...c, ...a, ...c, ...d];
    });
    const [kept, reversed] = [edges.filter((e) => !isReversed[e]), edges.filter((e) => isReversed[e])];
    this.faceTriangles = triangles;
    this.layers = [
      this.layer("--face", triangles(faces.filter((face) => !isTurned[face])), 0, 1),
      this.layer("--turned", triangles(faces.filter((face) => isTurned[face])), 0, 2),
    ];
    if (beams) {
      this.layers.push(this.layer("--beam", fins(kept), 0, 1), this.layer("--beam-reversed", fins(reversed), 0, 1));
      this.layers.push(this.layer("--kept", lines(beams, kept), 1.1), this.layer("--reversed", lines(beams, reversed), 1.1));
    }
    this.layers.push(this.layer("--kept", lines(p, kept), 1.7), this.layer("--reversed", lines(p, reversed), 2.4));
    this.hover(-1);
  }

  /** width: of ribbons in pixels, 0 for triangles; back: how far these stay behind what is in the same place. */
  layer(colour, numbers, width, back = 0) {
    const gl = this.gl, buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(numbers), gl.STATIC_DRAW);
    return { colour, buffer, count: numbers.length / 3, width, back };
  }

  sphereLayer() {
    const numbers = [], at = (i, j) => {
      const u = (Math.PI * i) / SPHERE_STEPS - Math.PI / 2, v = (Math.PI * j) / SPHERE_STEPS;
      return [Math.cos(u) * Math.cos(v), Math.cos(u) * Math.sin(v), Math.sin(u)];
    };
    for (let i = 0; i < SPHERE_STEPS; i++) {
      for (let j = 0; j < 2 * SPHERE_STEPS; j++) {
        const [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        numbers.push(...a, ...b, ...c, ...a, ...c, ...d);
      }
    }
    return this.layer("--sphere", numbers, 0);
  }

  hover(face) {
    if (this.hoverLayer) this.gl.deleteBuffer(this.hoverLayer.buffer);
    this.hovered = face;
    this.hoverLayer = face < 0 ? null : this.layer("--hover", this.faceTriangles([face]), 0);
    this.redraw();
  }

  /** Frames all these points, which lie about the origin, seen from where the camera is. */
  frame(positions) {
    let radius = 0;
    for (let k = 0; k < positions.length; k += 3) {
      radius = Math.max(radius, Math.hypot(positions[k], positions[k + 1], positions[k + 2]));
    }
    const layers = [{ corners: positions, middles: new Float32Array(positions.length) }]; // nothing is taken apart
    Object.assign(this.camera, { model: { layers }, radius });
    const { azimuth, elevation } = this.camera;
    this.camera.showAll(azimuth, elevation, this.canvas.clientWidth / this.canvas.clientHeight);
  }

  redraw() {
    if (this.isWaiting) return;
    this.isWaiting = true;
    requestAnimationFrame(() => {
      this.isWaiting = false;
      this.draw();
    });
  }

  draw() {
    const { gl, canvas } = this, dots = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * dots), Math.round(canvas.clientHeight * dots)];
    if (width === 0 || height === 0) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clearColor(...colourOf("--paper"), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    this.matrix = this.camera.matrix(width / height);
    for (const layer of this.layers.filter((each) => !each.width)) this.drawFaces(layer);
    if (this.hoverLayer) this.drawFaces(this.hoverLayer);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    for (const layer of this.layers.filter((each) => each.width)) this.drawRibbons(layer, layer.width * dots);
    if (this.hasSphere) this.drawSphere();
  }

  /** Glass: only its nearer side, over what it covers. */
  drawSphere() {
    const gl = this.gl;
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.enable(gl.CULL_FACE);
    gl.depthMask(false);
    this.drawFaces(this.ball, 0.24, true);
    gl.depthMask(true);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
  }

  drawFaces({ colour, buffer, count, back }, opacity = 1, isRound = false) {
    const gl = this.gl, program = this.faceProgram;
    this.use(program, colour, opacity);
    gl.uniform3fv(gl.getUniformLocation(program, "eye"), this.camera.eye());
    gl.uniform1i(gl.getUniformLocation(program, "isRound"), isRound);
    gl.polygonOffset(back, back);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    const position = this.attribute(program, "position", 12, 0, 0);
    gl.drawArrays(gl.TRIANGLES, 0, count);
    gl.disableVertexAttribArray(position);
  }

  drawRibbons({ colour, buffer, count }, width) {
    const gl = this.gl, program = this.ribbonProgram;
    this.use(program, colour, 1);
    gl.uniform2f(gl.getUniformLocation(program, "size"), this.canvas.width, this.canvas.height);
    gl.uniform1f(gl.getUniformLocation(program, "width"), width);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    const places = [this.attribute(program, "start", 24, 0, 1), this.attribute(program, "end", 24, 12, 1)];
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count / 2);
    for (const place of places) gl.disableVertexAttribArray(place);
  }

  use(program, colour, opacity) {
    const gl = this.gl;
    gl.useProgram(program);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "camera"), false, this.matrix);
    gl.uniform4f(gl.getUniformLocation(program, "colour"), ...colourOf(colour), opacity);
  }

  /** Enabled only while it is drawn: one whose buffer was deleted makes all drawing fail. */
  attribute(program, name, stride, offset, divisor) {
    const gl = this.gl, place = gl.getAttribLocation(program, name);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, stride, offset);
    gl.vertexAttribDivisor(place, divisor);
    return place;
  }

  /** The foremost face at a point of the canvas, -1 where there is none. */
  faceAt(x, y) {
    if (!this.shape || !this.matrix) return -1;
    const { canvas, matrix: m, shape } = this;
    const at = [(2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight];
    const seen = Array.from({ length: shape.positions.length / 3 }, (_, v) => {
      const p = shape.positions.subarray(3 * v, 3 * v + 3);
      const [X, Y, Z, W] = [0, 1, 2, 3].map((k) => m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]);
      return [X / W, Y / W, Z / W];
    });
    let found = -1, nearest = Infinity;
    shape.topology.faces.forEach((corners, face) => {
      const triangles = fan(corners);
      for (let t = 0; t < triangles.length; t += 3) {
        const depth = depthAt(at, ...triangles.slice(t, t + 3).map((v) => seen[v]));
        if (depth < nearest) [found, nearest] = [face, depth];
      }
    });
    return found;
  }
}

/** Corners of the triangles of a face. */
function fan(corners) {
  return corners.slice(2).flatMap((corner, k) => [corners[0], corners[k + 1], corner]);
}

/** Depth of a triangle of the screen at a point in it, Infinity outside. */
function depthAt([x, y], a, b, c) {
  const doubled = (p, q) => (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x);
  const parts = [doubled(b, c), doubled(c, a), doubled(a, b)], whole = parts[0] + parts[1] + parts[2];
  if (whole === 0 || parts.some((part) => part * whole < 0)) return Infinity;
  return (parts[0] * a[2] + parts[1] * b[2] + parts[2] * c[2]) / whole;
}

const colours = new Map();
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => colours.clear());

/** [r, g, b], 0 to 1, of a colour #rrggbb of the style sheet. */
function colourOf(name) {
  if (!colours.has(name)) {
    const text = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
    colours.set(name, [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255));
  }
  return colours.get(name);
}

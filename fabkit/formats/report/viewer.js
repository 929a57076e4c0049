"use strict";

// The viewer: draws a model (model.js) as a camera (camera.js) sees it, and says which part is where.

const WIDTH_BITS = 11; // of the pictures that hold numbers for the shaders
const SLOW_FRAME = 45; // milliseconds; where frames take longer, those of a movement are coarse
const REST = 180; // milliseconds after a movement until the picture is drawn finely

/** Where a corner of a part lies: shared by all programs. All parts of a batch are drawn in one call without buffers,
    since one call for each, or instances of few corners, are slow; what the corners need lies in pictures. */
const PLACE = `#version 300 es
  precision highp float; precision highp sampler2D; precision highp usampler2D;
  uniform sampler2D points, places, colours; uniform usampler2D corners;
  uniform mat4 camera; uniform vec3 eye; uniform float apart; uniform int firstPart, firstCorner, nCorners;
  out vec3 world; vec4 colour;
  ivec2 at(int k) { return ivec2(k & ${(1 << WIDTH_BITS) - 1}, k >> ${WIDTH_BITS}); }
  vec3 turned(vec4 q, vec3 v) { vec3 t = 2.0 * cross(q.xyz, v); return v + q.w * t + cross(q.xyz, t); }
  vec3 pointOf(int part, int k, int first, vec3 eye);
  void place() {
    int own = gl_VertexID / nCorners, part = firstPart + own;
    colour = texelFetch(colours, at(part), 0);
    if (colour.a == 0.0) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
    vec4 origin = texelFetch(places, at(5 * part), 0), turn = texelFetch(places, at(5 * part + 1), 0);
    vec3 stands = origin.xyz + apart * texelFetch(places, at(5 * part + 2), 0).xyz;
    vec3 from = turned(vec4(-turn.xyz, turn.w), eye - stands);
    world = turned(turn, pointOf(part, gl_VertexID - own * nCorners, int(origin.w), from)) + stands;
    gl_Position = camera * vec4(world, 1.0);
  }`;
/** The own point of the k-th corner of a part. */
const EXACT = `${PLACE}
  vec3 pointOf(int part, int k, int first, vec3 eye) {
    return texelFetch(points, at(first + int(texelFetch(corners, at(firstCorner + k), 0).r)), 0).xyz;
  }`;
/** The same of the three sides of a part's box that face the eye. */
const BOX = `${PLACE}
  vec3 pointOf(int part, int k, int first, vec3 eye) {
    vec3 low = texelFetch(places, at(5 * part + 3), 0).xyz, high = texelFetch(places, at(5 * part + 4), 0).xyz;
    int axis = k / 6, n = k % 6;
    bvec3 upper = bvec3(eye[axis] > 0.5 * (low[axis] + high[axis]), n == 1 || n == 2 || n == 4, n == 2 || n > 3);
    vec3 sides = vec3(upper);
    vec3 share = axis == 0 ? sides : axis == 1 ? sides.zxy : sides.yzx;
    return mix(low, high, share);
  }`;
const BOX_CORNERS = 18;
const CUT_AWAY = `#version 300 es
  precision highp float; in vec3 world; uniform vec4 section;
  void cutAway() { if (dot(section.xyz, world) > section.w) discard; }`;
const SOLID_SHADER = [
  `${EXACT} flat out vec4 shade; void main() { place(); shade = colour; }`,
  `${CUT_AWAY}
   flat in vec4 shade; uniform vec3 eye; out vec4 ink;
   void main() {
     cutAway();
     vec3 towards = normalize(eye - world), n = normalize(cross(dFdx(world), dFdy(world)));
     if (dot(n, towards) < 0.0) n = -n;
     float light = 0.58 + 0.22 * dot(n, towards) + 0.22 * max(dot(n, normalize(vec3(-0.4, -0.5, 0.8))), 0.0);
     bool inside = !gl_FrontFacing && shade.a == 1.0; // seen where a part is cut
     ink = inside ? vec4(0.45 * shade.rgb, 1.0) : vec4(shade.rgb * light, shade.a);
   }`,
];
const BOX_SHADER = [`${BOX} flat out vec4 shade; void main() { place(); shade = colour; }`, SOLID_SHADER[1].replace("!gl_FrontFacing", "false")];
const LINE_SHADER = [
  `${EXACT} void main() { place(); }`,
  `${CUT_AWAY} uniform vec4 line; out vec4 ink; void main() { cutAway(); ink = line; }`,
];
const SPOT_SHADER = [
  `#version 300 es
   in vec3 position; in vec4 colour; uniform mat4 camera; uniform vec3 eye; uniform float size, lift; out vec4 shade;
   void main() {
     shade = colour;
     gl_Position = camera * vec4(position + lift * normalize(eye - position), 1.0);
     gl_PointSize = size;
   }`,
  `#version 300 es
   precision mediump float; in vec4 shade; uniform float hole; out vec4 ink;
   void main() {
     float r = 2.0 * length(gl_PointCoord - 0.5);
     if (r > 1.0 || r < hole) discard;
     ink = shade;
   }`,
];
const PICTURES = ["points", "places", "corners", "colours"];

class Viewer {
  /** plates: names of the layers of plates. Raises an Error where the browser has no WebGL 2. `onHover` and `onClick`
      are told {layer, row} or null. */
  constructor(canvas, model, plates) {
    const options = { antialias: true, preserveDrawingBuffer: true }; // kept, so that it prints
    this.gl = canvas.getContext("webgl2", options);
    if (!this.gl) throw new Error("no WebGL 2");
    Object.assign(this, { canvas, model, plates, hidden: new Set(), apart: 0, section: [0, 0, 0, 1], lastFrame: 0, pace: 0 });
    this.solid = linkedProgram(this.gl, SOLID_SHADER);
    this.boxes = linkedProgram(this.gl, BOX_SHADER);
    this.line = linkedProgram(this.gl, LINE_SHADER);
    this.spot = linkedProgram(this.gl, SPOT_SHADER);
    this.spots = { n: 0, position: this.gl.createBuffer(), colour: this.gl.createBuffer() };
    this.shapes = model.layers.map((layer) => ({ layer, clear: false }));
    this.upload();
    this.onHover = this.onClick = () => {};
    this.camera = new Camera(model);
    this.camera.onMove = () => this.soon("draw", () => this.drawMoving());
    this.showAll("home");
    this.camera.listen(
      canvas,
      (x, y) => this.onClick(this.partAt(x, y)),
      (x, y) => this.soon("hover", () => this.onHover(this.partAt(x, y))),
    );
    canvas.addEventListener("pointerleave", () => this.soon("hover", () => this.onHover(null)));
    this.paint((layer, row) => layer.colourOf(row));
    new ResizeObserver(() => (this.camera.side ? this.showAll(this.camera.side) : this.draw())).observe(canvas);
  }

  /** Sorts the parts of each layer into batches of those whose shapes are cut alike, and puts what their corners need
      into pictures. */
  upload() {
    const { gl, model } = this, places = [], corners = [];
    const cuts = model.cuts.map(({ triangles, edges }) => {
      const starts = [corners.length, corners.length + triangles.length];
      for (const list of [triangles, edges]) for (const corner of list) corners.push(corner);
      return { triangles: [starts[0], triangles.length], edges: [starts[1], edges.length], box: [0, BOX_CORNERS] };
    });
    for (const shape of this.shapes) {
      const { layer } = shape, rows = new Map();
      layer.shapes.forEach((number, row) => {
        const { cut } = model.shapes[number];
        if (!rows.has(cut)) rows.set(cut, []);
        rows.get(cut).push(row);
      });
      shape.batches = [...rows].map(([cut, own]) => {
        const firstPart = places.length / 20;
        for (const row of own) {
          places.push(...layer.origins.subarray(3 * row, 3 * row + 3), model.shapes[layer.shapes[row]].first);
          places.push(...layer.turns.subarray(4 * row, 4 * row + 4), ...layer.middles.subarray(4 * row, 4 * row + 4));
          for (const corner of model.shapes[layer.shapes[row]].box) places.push(...corner, 0);
        }
        return { rows: own, firstPart, ...cuts[cut] };
      });
    }
    this.nParts = places.length / 20;
    this.picture(0, gl.RGB32F, gl.RGB, gl.FLOAT, 3, model.points);
    this.picture(1, gl.RGBA32F, gl.RGBA, gl.FLOAT, 4, Float32Array.from(places));
    this.picture(2, gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, 1, Uint32Array.from(corners));
  }

  /** A picture whose pixels hold the numbers, `size` each; kept for the shaders. */
  picture(unit, inside, format, type, size, numbers) {
    const gl = this.gl, rows = Math.max(1, Math.ceil(numbers.length / size / (1 << WIDTH_BITS)));
    const full = new numbers.constructor(size * rows << WIDTH_BITS);
    full.set(numbers);
    this.pictures ??= PICTURES.map(() => gl.createTexture());
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, this.pictures[unit]);
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, 1 << WIDTH_BITS, rows, 0, format, type, full);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  }

  /** Colours the parts: colourOf(layer, row) is [r, g, b, opacity], 0 to 255; with opacity 0 a part is not there. */
  paint(colourOf) {
    const gl = this.gl, all = new Uint8Array(4 * this.nParts);
    for (const shape of this.shapes) {
      const colours = new Uint8Array(4 * shape.layer.count);
      for (let row = 0; row < shape.layer.count; row++) colours.set(colourOf(shape.layer, row), 4 * row);
      shape.clear = colours.some((value, k) => k % 4 === 3 && value > 0 && value < 255);
      shape.colours = colours;
      for (const { rows, firstPart } of shape.batches) {
        rows.forEach((row, k) => all.set(colours.subarray(4 * row, 4 * row + 4), 4 * (firstPart + k)));
      }
    }
    this.picture(3, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, 4, all);
    this.redraw();
  }

  show(name, visible) {
    if (visible) this.hidden.delete(name);
    else this.hidden.add(name);
    this.redraw();
  }

  /** Parts moved away from the middle of the model by this share of their distance from it. */
  explode(apart) {
    this.apart = this.camera.apart = apart;
    this.placeSpots();
    this.redraw();
  }

  /** Cuts away what lies beyond a share of the model along an axis (0, 1, 2); null shows all. */
  cutAt(axis, share) {
    const [least, most] = axis === null ? [0, 0] : this.camera.extent([0, 1, 2].map((k) => Number(k === axis)));
    this.section = axis === null ? [0, 0, 0, 1] : [0, 1, 2].map((k) => Number(k === axis)).concat(least + share * (most - least));
    this.redraw();
  }

  /** side: home, top or front; kept until the camera is moved, however the canvas changes. */
  showAll(side) {
    const [azimuth, elevation] = { home: [-1.0, 0.5], top: [-Math.PI / 2, STEEPEST], front: [-Math.PI / 2, 0] }[side];
    this.camera.showAll(azimuth, elevation, this.canvas.clientWidth / this.canvas.clientHeight);
    this.camera.side = side;
    this.redraw(); // finely, as nothing moves
  }

  /** Spots on parts, which would be too small to be seen: [{layer, row, colour}]; rings for parts that were picked
      show through everything, discs only where their part is in sight. */
  mark(found, ring) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.spots.colour);
    gl.bufferData(gl.ARRAY_BUFFER, Uint8Array.from(found.flatMap((each) => each.colour)), gl.DYNAMIC_DRAW);
    Object.assign(this.spots, { n: found.length, ring, of: found[0]?.layer.name, found });
    this.placeSpots();
    this.redraw();
  }

  placeSpots() {
    const gl = this.gl, middles = (this.spots.found ?? []).flatMap((each) => this.middleOf(each));
    gl.bindBuffer(gl.ARRAY_BUFFER, this.spots.position);
    gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(middles), gl.DYNAMIC_DRAW);
  }

  middleOf({ layer, row }) {
    return [...layer.middles.subarray(4 * row, 4 * row + 3)].map((value) => (1 + this.apart) * value);
  }

  /** The camera turns about this part from now on; `near`: and comes near it. */
  centreOn(found, near = false) {
    this.camera.turnAbout(this.middleOf(found), near ? 5 * found.layer.middles[4 * found.row + 3] : null);
  }

  redraw() {
    this.soon("draw", () => this.draw());
  }

  /** Runs a task with the next frame, the last one of its name only. */
  soon(name, task) {
    this.tasks ??= new Map();
    if (this.tasks.size === 0) {
      requestAnimationFrame(() => {
        const tasks = [...this.tasks.values()];
        this.tasks.clear();
        tasks.forEach((each) => each());
      });
    }
    this.tasks.set(name, task);
  }

  /** Draws coarsely where frames follow each other slowly, and finely once nothing moves. */
  drawMoving() {
    const now = performance.now(), since = now - this.lastFrame;
    this.lastFrame = now;
    this.pace = since < 3 * REST ? 0.5 * (this.pace + since) : 0;
    const coarse = this.pace > (this.coarse ? SLOW_FRAME / 3 : SLOW_FRAME);
    this.draw(coarse);
    clearTimeout(this.rest);
    if (coarse) this.rest = setTimeout(() => this.draw(), REST);
  }

  draw(coarse = false) {
    const { gl, canvas } = this, dots = (window.devicePixelRatio || 1) * (coarse ? 0.5 : 1);
    const [width, height] = [Math.round(canvas.clientWidth * dots), Math.round(canvas.clientHeight * dots)];
    if (width === 0 || height === 0) return;
    this.coarse = coarse;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    gl.viewport(0, 0, width, height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const shapes = this.shapes.filter(({ layer }) => !this.hidden.has(layer.name));
    for (const shape of shapes.filter(({ clear }) => !clear)) this.drawShape(shape);
    gl.depthMask(false);
    for (const shape of shapes.filter(({ clear }) => clear)) this.drawShape(shape);
    gl.depthMask(true);
    this.drawSpots();
  }

  drawShape({ layer, batches, clear }) {
    const gl = this.gl, missing = layer.name === "left out";
    gl[missing ? "disable" : "enable"](gl.DEPTH_TEST); // what is missing shows through everything
    gl.enable(gl.POLYGON_OFFSET_FILL); // behind the outlines
    gl.polygonOffset(1, 1);
    gl[clear ? "enable" : "disable"](gl.BLEND);
    const boxes = this.coarse && !this.plates.has(layer.name); // plates beside each other have boxes that overlap
    const program = boxes ? this.boxes : this.solid;
    this.use(program);
    this.drawBatches(program, batches, boxes ? "box" : "triangles");
    gl.disable(gl.POLYGON_OFFSET_FILL);
    const line = missing ? [0.84, 0.1, 0.12, 1] : [0.1, 0.13, 0.16, this.coarse ? 0 : this.inkOpacity()];
    if (line[3] > 0) {
      gl.enable(gl.BLEND);
      this.use(this.line);
      gl.uniform4fv(gl.getUniformLocation(this.line, "line"), line);
      this.drawBatches(this.line, batches, "edges");
    }
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
  }

  drawBatches(program, batches, what) {
    const gl = this.gl, place = (name) => gl.getUniformLocation(program, name);
    for (const { rows, firstPart, [what]: [firstCorner, nCorners] } of batches) {
      gl.uniform1i(place("firstPart"), firstPart);
      gl.uniform1i(place("firstCorner"), firstCorner);
      gl.uniform1i(place("nCorners"), nCorners);
      gl.drawArrays(what === "edges" ? gl.LINES : gl.TRIANGLES, 0, nCorners * rows.length);
    }
  }

  drawSpots() {
    if (this.spots.n === 0 || this.hidden.has(this.spots.of)) return;
    const gl = this.gl, { ring } = this.spots, dots = this.canvas.width / this.canvas.clientWidth;
    this.use(this.spot);
    for (const [name, size, type] of [["position", 3, gl.FLOAT], ["colour", 4, gl.UNSIGNED_BYTE]]) {
      const place = gl.getAttribLocation(this.spot, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.spots[name]);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, type, type === gl.UNSIGNED_BYTE, 0, 0);
    }
    gl.uniform1f(gl.getUniformLocation(this.spot, "size"), (ring ? 24 : 7) * dots);
    gl.uniform1f(gl.getUniformLocation(this.spot, "hole"), ring ? 0.8 : 0);
    gl.uniform1f(gl.getUniformLocation(this.spot, "lift"), ring ? 0 : 0.3); // metres: out of the part and its cover
    if (ring) gl.disable(gl.DEPTH_TEST);
    gl.drawArrays(gl.POINTS, 0, this.spots.n);
    for (const name of ["position", "colour"]) gl.disableVertexAttribArray(gl.getAttribLocation(this.spot, name));
    gl.enable(gl.DEPTH_TEST);
  }

  /** Outlines fade with the distance, where they would blacken the picture. */
  inkOpacity() {
    const pixelsPerMetre = this.canvas.clientHeight / this.camera.distance;
    return Math.max(0, Math.min(0.5, (pixelsPerMetre - 5) / 140));
  }

  use(program) {
    const gl = this.gl, place = (name) => gl.getUniformLocation(program, name); // what a program lacks is ignored
    gl.useProgram(program);
    gl.uniformMatrix4fv(place("camera"), false, this.camera.matrix(this.canvas.width / this.canvas.height));
    gl.uniform3fv(place("eye"), this.camera.eye());
    gl.uniform1f(place("apart"), this.apart);
    gl.uniform4fv(place("section"), this.section);
    PICTURES.forEach((name, unit) => gl.uniform1i(place(name), unit));
  }

  /** {layer, row} of the foremost part at a point of the canvas, null where there is none. */
  partAt(x, y) {
    const { canvas, section } = this, from = this.camera.eye();
    const along = this.camera.ray(2 * x / canvas.clientWidth - 1, 1 - 2 * y / canvas.clientHeight, canvas.clientWidth / canvas.clientHeight);
    const uncut = (point) => section[0] * point[0] + section[1] * point[1] + section[2] * point[2] <= section[3];
    let found = null;
    for (const { layer, colours } of this.shapes) {
      if (this.hidden.has(layer.name)) continue;
      const hit = hitOf(this.model, layer, from, along, this.apart, (row, point) => colours[4 * row + 3] > 0 && uncut(point));
      if (hit && (!found || hit.distance < found.distance)) found = { layer, ...hit };
    }
    return found && { layer: found.layer, row: found.row };
  }
}

"use strict";

// The viewer: draws a model (model.js) as a camera (camera.js) sees it, and says which part is where.

const SOLID_SHADER = [
  `attribute vec3 position; attribute vec3 normal; attribute vec4 colour;
   uniform mat4 camera; uniform vec3 eye; varying vec4 shade;
   void main() {
     vec3 towards = normalize(eye - position), n = normalize(normal);
     if (dot(n, towards) < 0.0) n = -n;
     float light = 0.58 + 0.22 * dot(n, towards) + 0.22 * max(dot(n, normalize(vec3(-0.4, -0.5, 0.8))), 0.0);
     shade = vec4(colour.rgb * light, colour.a);
     gl_Position = camera * vec4(position, 1.0);
   }`,
  "precision mediump float; varying vec4 shade; void main() { gl_FragColor = shade; }",
];
const LINE_SHADER = [
  "attribute vec3 position; uniform mat4 camera; void main() { gl_Position = camera * vec4(position, 1.0); }",
  "precision mediump float; uniform vec4 ink; void main() { gl_FragColor = ink; }",
];
const SPOT_SHADER = [
  `attribute vec3 position; attribute vec4 colour; uniform mat4 camera; uniform vec3 eye; uniform float size, lift;
   varying vec4 shade;
   void main() {
     shade = colour;
     gl_Position = camera * vec4(position + lift * normalize(eye - position), 1.0);
     gl_PointSize = size;
   }`,
  `precision mediump float; varying vec4 shade; uniform float hole;
   void main() {
     float r = 2.0 * length(gl_PointCoord - 0.5);
     if (r > 1.0 || r < hole) discard;
     gl_FragColor = shade;
   }`,
];
const ID_SHADER = [
  `attribute vec3 position; attribute vec4 id; uniform mat4 camera; varying vec4 name;
   void main() { name = id; gl_Position = camera * vec4(position, 1.0); }`,
  "precision highp float; varying vec4 name; void main() { gl_FragColor = name; }",
];

class Viewer {
  /** Raises an Error where the browser has no WebGL. `onHover` and `onClick` are told {layer, row} or null. */
  constructor(canvas, model) {
    const options = { antialias: true, preserveDrawingBuffer: true }; // kept, so that it prints
    this.gl = canvas.getContext("webgl2", options) || canvas.getContext("webgl", options);
    if (!this.gl) throw new Error("no WebGL");
    this.gl.getExtension("OES_element_index_uint");
    this.canvas = canvas;
    this.hidden = new Set();
    this.solid = linkedProgram(this.gl, SOLID_SHADER);
    this.line = linkedProgram(this.gl, LINE_SHADER);
    this.spot = linkedProgram(this.gl, SPOT_SHADER);
    this.spots = { n: 0, position: this.gl.createBuffer(), colour: this.gl.createBuffer() };
    this.id = linkedProgram(this.gl, ID_SHADER);
    this.shapes = model.layers.map((layer) => this.upload(layer));
    this.onHover = this.onClick = () => {};
    this.camera = new Camera(model);
    this.camera.onMove = () => this.redraw();
    this.showAll("home");
    this.camera.listen(
      canvas,
      (x, y) => this.onClick(this.partAt(x, y)),
      (x, y) => this.soon("hover", () => this.onHover(this.partAt(x, y))),
    );
    canvas.addEventListener("pointerleave", () => this.soon("hover", () => this.onHover(null)));
    this.paint(() => null);
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  upload(layer) {
    const gl = this.gl;
    const buffer = (target, data) => {
      const made = gl.createBuffer();
      gl.bindBuffer(target, made);
      gl.bufferData(target, data, gl.STATIC_DRAW);
      return made;
    };
    return {
      layer,
      position: buffer(gl.ARRAY_BUFFER, layer.positions),
      normal: buffer(gl.ARRAY_BUFFER, layer.normals),
      id: buffer(gl.ARRAY_BUFFER, layer.ids),
      colour: gl.createBuffer(),
      triangles: buffer(gl.ELEMENT_ARRAY_BUFFER, layer.triangles),
      outline: buffer(gl.ELEMENT_ARRAY_BUFFER, layer.outline),
      clear: false,
    };
  }

  /** Colours the parts: colourOf(layer, row) is [r, g, b, opacity], 0 to 255, or null for the part's own. */
  paint(colourOf) {
    const gl = this.gl;
    for (const shape of this.shapes) {
      const { parts, positions } = shape.layer, colours = new Uint8Array((4 * positions.length) / 3);
      shape.clear = false;
      parts.forEach((part, row) => {
        const colour = colourOf(shape.layer, row) || part.colour;
        if (colour[3] < 255) shape.clear = true;
        for (let k = part.first; k < part.first + part.count; k++) colours.set(colour, 4 * k);
      });
      gl.bindBuffer(gl.ARRAY_BUFFER, shape.colour);
      gl.bufferData(gl.ARRAY_BUFFER, colours, gl.DYNAMIC_DRAW);
    }
    this.redraw();
  }

  show(name, visible) {
    if (visible) this.hidden.delete(name);
    else this.hidden.add(name);
    this.redraw();
  }

  /** side: home, top or front. */
  showAll(side) {
    const [azimuth, elevation] = { home: [-1.0, 0.5], top: [-Math.PI / 2, STEEPEST], front: [-Math.PI / 2, 0] }[side];
    this.camera.showAll(azimuth, elevation, this.canvas.clientWidth / this.canvas.clientHeight);
  }

  /** Spots on parts, which would be too small to be seen: [{layer, row, colour}]; rings for parts that were picked
      show through everything, discs only where their part is in sight. */
  mark(found, ring) {
    const gl = this.gl, { position, colour } = this.spots;
    gl.bindBuffer(gl.ARRAY_BUFFER, position);
    gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(found.flatMap((each) => middleOf(each))), gl.DYNAMIC_DRAW);
    gl.bindBuffer(gl.ARRAY_BUFFER, colour);
    gl.bufferData(gl.ARRAY_BUFFER, Uint8Array.from(found.flatMap((each) => each.colour)), gl.DYNAMIC_DRAW);
    Object.assign(this.spots, { n: found.length, ring, of: found[0]?.layer.name });
    this.redraw();
  }

  /** The camera turns about this part from now on. */
  centreOn(found) {
    this.camera.turnAbout(middleOf(found));
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

  draw() {
    const { gl, canvas } = this, dots = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * dots), Math.round(canvas.clientHeight * dots)];
    if (width === 0 || height === 0) return;
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

  drawShape(shape) {
    const gl = this.gl, missing = shape.layer.name === "left out";
    gl[missing ? "disable" : "enable"](gl.DEPTH_TEST); // what is missing shows through everything
    gl.enable(gl.POLYGON_OFFSET_FILL); // behind the outlines
    gl.polygonOffset(1, 1);
    gl[shape.clear ? "enable" : "disable"](gl.BLEND);
    this.use(this.solid, shape, ["position", "normal", "colour"]);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, shape.triangles);
    gl.drawElements(gl.TRIANGLES, shape.layer.triangles.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.enable(gl.BLEND);
    this.use(this.line, shape, ["position"]);
    const ink = missing ? [0.84, 0.1, 0.12, 1] : [0.1, 0.13, 0.16, this.inkOpacity()];
    gl.uniform4fv(gl.getUniformLocation(this.line, "ink"), ink);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, shape.outline);
    if (ink[3] > 0) gl.drawElements(gl.LINES, shape.layer.outline.length, gl.UNSIGNED_INT, 0);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
  }

  drawSpots() {
    if (this.spots.n === 0 || this.hidden.has(this.spots.of)) return;
    const gl = this.gl, { ring } = this.spots, dots = this.canvas.width / this.canvas.clientWidth;
    this.use(this.spot, this.spots, ["position", "colour"]);
    gl.uniform1f(gl.getUniformLocation(this.spot, "size"), (ring ? 24 : 7) * dots);
    gl.uniform1f(gl.getUniformLocation(this.spot, "hole"), ring ? 0.8 : 0);
    gl.uniform1f(gl.getUniformLocation(this.spot, "lift"), ring ? 0 : 0.3); // metres: out of the part and its cover
    if (ring) gl.disable(gl.DEPTH_TEST);
    gl.drawArrays(gl.POINTS, 0, this.spots.n);
    gl.enable(gl.DEPTH_TEST);
  }

  /** Outlines fade with the distance, where they would blacken the picture. */
  inkOpacity() {
    const pixelsPerMetre = this.canvas.clientHeight / this.camera.distance;
    return Math.max(0, Math.min(0.5, (pixelsPerMetre - 5) / 140));
  }

  use(program, shape, attributes) {
    const gl = this.gl;
    gl.useProgram(program);
    for (const name of attributes) {
      const place = gl.getAttribLocation(program, name), bytes = name !== "position";
      gl.bindBuffer(gl.ARRAY_BUFFER, shape[name]);
      gl.enableVertexAttribArray(place);
      if (name === "normal") gl.vertexAttribPointer(place, 3, gl.BYTE, true, 4, 0);
      else gl.vertexAttribPointer(place, bytes ? 4 : 3, bytes ? gl.UNSIGNED_BYTE : gl.FLOAT, bytes, 0, 0);
    }
    const matrix = this.camera.matrix(this.canvas.width / this.canvas.height);
    gl.uniformMatrix4fv(gl.getUniformLocation(program, "camera"), false, matrix);
    gl.uniform3fv(gl.getUniformLocation(program, "eye"), this.camera.eye()); // unused by some: ignored there
  }

  /** {layer, row} of the foremost part at a point of the canvas, null where there is none. */
  partAt(x, y) {
    const { gl, canvas } = this, dots = canvas.width / canvas.clientWidth;
    const [column, row] = [Math.floor(x * dots), canvas.height - 1 - Math.floor(y * dots)];
    this.pickTarget(canvas.width, canvas.height);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(column, row, 1, 1);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    for (const shape of this.shapes.filter(({ layer }) => !this.hidden.has(layer.name))) {
      this.use(this.id, shape, ["position", "id"]);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, shape.triangles);
      gl.drawElements(gl.TRIANGLES, shape.layer.triangles.length, gl.UNSIGNED_INT, 0);
    }
    const pixel = new Uint8Array(4);
    gl.readPixels(column, row, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.disable(gl.SCISSOR_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const id = pixel[0] + 256 * pixel[1] + 65536 * pixel[2];
    for (const { layer } of this.shapes) {
      const found = id - (layer.parts.length ? layer.parts[0].id : Infinity);
      if (id > 0 && found >= 0 && found < layer.parts.length) return { layer, row: found };
    }
    return null;
  }

  /** Binds a picture of this size that nobody sees; the names of the parts are drawn into it as colours. */
  pickTarget(width, height) {
    const gl = this.gl;
    this.hiddenPicture ??= { frame: gl.createFramebuffer(), colour: gl.createTexture(), depth: gl.createRenderbuffer() };
    const { frame, colour, depth } = this.hiddenPicture;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    if (this.hiddenPicture.width === width && this.hiddenPicture.height === height) return;
    Object.assign(this.hiddenPicture, { width, height });
    gl.bindTexture(gl.TEXTURE_2D, colour);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, width, height, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT16, width, height);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, colour, 0);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
  }
}

/** Middle of the corners of a part. */
function middleOf({ layer, row }) {
  const { first, count } = layer.parts[row], sum = [0, 0, 0];
  for (let k = 3 * first; k < 3 * (first + count); k++) sum[k % 3] += layer.positions[k];
  return sum.map((value) => value / count);
}

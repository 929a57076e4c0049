"use strict";

// The camera: turns about a target under mouse, fingers and keys.

const FIELD_OF_VIEW = 0.6; // radians, of the shorter side of the picture
const STEEPEST = 1.55; // radians; straight down would lose its right hand
const CLICK_REACH = 4; // pixels that a click may slip

class Camera {
  /** model: of `readModel`; its sphere lies about the origin. `onMove` is called after each change. */
  constructor(model) {
    this.model = model;
    this.radius = model.radius;
    this.target = [0, 0, 0];
    this.apart = 0; // of an exploded view
    this.side = null; // that is shown, until something moves
    this.distance = this.radius;
    this.turnTo(-1.0, 0.5);
    this.onMove = () => {};
  }

  /** Shows the whole model from this side, as large as fits. */
  showAll(azimuth, elevation, aspect) {
    this.turnTo(azimuth, elevation);
    const { right, up, back } = this.axes(), t = Math.tan(FIELD_OF_VIEW / 2);
    const [wide, high] = [t * Math.max(aspect, 1), t / Math.min(aspect, 1)];
    const [middleRight, middleUp] = [right, up].map((axis) => this.extent(axis).reduce((a, b) => a + b) / 2);
    this.target = right.map((value, k) => middleRight * value + middleUp * up[k]);
    this.distance = this.radius / 100;
    this.forEachCorner((along) => {
      const aside = Math.max(Math.abs(along(right) - middleRight) / wide, Math.abs(along(up) - middleUp) / high);
      this.distance = Math.max(this.distance, along(back) + aside);
    });
    this.distance *= 1.04;
    this.onMove();
  }

  /** Least and largest place of the model along a unit vector. */
  extent(axis) {
    let least = Infinity, most = -Infinity;
    this.forEachCorner((along) => {
      const value = along(axis);
      if (value < least) least = value;
      if (value > most) most = value;
    });
    return [least, most];
  }

  /** Calls task(along) for each corner of a box of a part; along(axis) is where it lies along a unit vector. */
  forEachCorner(task) {
    for (const { corners: p, middles: m } of this.model.layers) {
      for (let k = 0; k < p.length; k += 3) {
        const n = 4 * Math.floor(k / 24);
        const [x, y, z] = [p[k] + this.apart * m[n], p[k + 1] + this.apart * m[n + 1], p[k + 2] + this.apart * m[n + 2]];
        task((axis) => axis[0] * x + axis[1] * y + axis[2] * z);
      }
    }
  }

  turnTo(azimuth, elevation) {
    this.azimuth = azimuth;
    this.elevation = Math.max(-STEEPEST, Math.min(STEEPEST, elevation));
  }

  orbit(right, down) {
    this.side = null;
    this.turnTo(this.azimuth - right, this.elevation + down);
    this.onMove();
  }

  /** right, down: in pixels of a picture whose shorter side has `side` of them. */
  pan(right, down, side) {
    this.side = null;
    const scale = (2 * this.distance * Math.tan(FIELD_OF_VIEW / 2)) / side;
    const axes = this.axes();
    this.target = this.target.map((v, k) => v + scale * (down * axes.up[k] - right * axes.right[k]));
    this.onMove();
  }

  zoom(factor) {
    this.side = null;
    this.distance = Math.min(10 * this.radius, Math.max(this.radius / 500, this.distance * factor));
    this.onMove();
  }

  turnAbout(point, distance = null) {
    this.side = null;
    this.target = point;
    this.distance = distance ?? this.distance;
    this.onMove();
  }

  /** Unit vectors to the right, upwards and backwards. */
  axes() {
    const [ca, sa] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [ce, se] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    return { right: [-sa, ca, 0], up: [-se * ca, -se * sa, ce], back: [ce * ca, ce * sa, se] };
  }

  /** Unit vector from the eye through a point of the picture, whose sides are at -1 and 1. */
  ray(x, y, aspect) {
    const { right, up, back } = this.axes(), t = Math.tan(FIELD_OF_VIEW / 2);
    const [wide, high] = [x * t * Math.max(aspect, 1), (y * t) / Math.min(aspect, 1)];
    const along = back.map((value, k) => wide * right[k] + high * up[k] - value), length = Math.hypot(...along);
    return along.map((value) => value / length);
  }

  eye() {
    const { back } = this.axes();
    return this.target.map((value, k) => value + this.distance * back[k]);
  }

  /** Column-major 4 x 4 matrix from model to clip space; aspect: width over height of the picture. */
  matrix(aspect) {
    const { right, up, back } = this.axes(), eye = this.eye();
    const reach = (1 + this.apart) * this.radius + Math.hypot(...this.target), far = this.distance + reach;
    const near = Math.max(this.distance - reach, far / 2000);
    const f = 1 / Math.tan(FIELD_OF_VIEW / 2);
    const a = (far + near) / (near - far), b = (2 * far * near) / (near - far);
    const row = (axis, scale, offset) => [
      ...axis.map((v) => scale * v),
      offset - scale * (axis[0] * eye[0] + axis[1] * eye[1] + axis[2] * eye[2]),
    ];
    const rows = [
      row(right, f / Math.max(aspect, 1), 0),
      row(up, f * Math.min(aspect, 1), 0),
      row(back, a, b),
      row(back, -1, 0),
    ];
    return Float32Array.from([0, 1, 2, 3].flatMap((column) => rows.map((each) => each[column])));
  }

  /** Lets the person turn, move and zoom on the canvas; `onClick` and `onHover` are told (x, y) in the canvas. */
  listen(canvas, onClick, onHover) {
    const held = new Map(); // pointers that are down: where they were last
    let travelled = 0;
    const at = (event) => [event.offsetX, event.offsetY];
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      if (held.size === 0) travelled = 0;
      held.set(event.pointerId, at(event));
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = held.get(event.pointerId);
      if (!before) return onHover(...at(event));
      const now = at(event), [right, down] = [now[0] - before[0], now[1] - before[1]];
      travelled += Math.abs(right) + Math.abs(down);
      if (held.size > 1) this.pinch(held, event.pointerId, now, canvas);
      else if (event.buttons & 6 || event.shiftKey) this.pan(right, down, shorterSide(canvas));
      else this.orbit(right / 160, down / 160);
      held.set(event.pointerId, now);
    });
    const release = (event) => {
      if (held.delete(event.pointerId) && held.size === 0 && event.type === "pointerup" && event.button === 0) {
        if (travelled <= CLICK_REACH) onClick(...at(event));
      }
    };
    canvas.addEventListener("pointerup", release);
    canvas.addEventListener("pointercancel", release);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener(
      "wheel",
      (event) => {
        if (document.activeElement !== canvas && !event.ctrlKey) return; // the page scrolls until the model is clicked
        event.preventDefault();
        this.zoom(Math.exp(Math.sign(event.deltaY) * Math.min(0.25, Math.abs(event.deltaY) / 500)));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  /** Two fingers: their distance zooms, their middle moves. */
  pinch(held, moving, now, canvas) {
    const [other] = [...held.keys()].filter((id) => id !== moving), fixed = held.get(other), before = held.get(moving);
    const apart = (point) => Math.max(1, Math.hypot(point[0] - fixed[0], point[1] - fixed[1]));
    this.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2, shorterSide(canvas));
    this.zoom(apart(before) / apart(now));
  }

  key(event) {
    const moves = {
      ArrowLeft: () => this.orbit(-0.1, 0),
      ArrowRight: () => this.orbit(0.1, 0),
      ArrowUp: () => this.orbit(0, -0.1),
      ArrowDown: () => this.orbit(0, 0.1),
      "+": () => this.zoom(0.8),
      "-": () => this.zoom(1.25),
    };
    if (!(event.key in moves)) return;
    event.preventDefault();
    moves[event.key]();
  }
}

function shorterSide(canvas) {
  return Math.min(canvas.clientWidth, canvas.clientHeight);
}

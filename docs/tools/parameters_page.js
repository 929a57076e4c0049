"use strict";

// The page: which study is open, where its sliders stand, and the numbers of the mesh that they choose.

const data = JSON.parse(document.getElementById("data").textContent);
const element = (id) => document.getElementById(id);
const made = (tag, attributes = {}, ...children) => {
  const node = Object.assign(document.createElement(tag), attributes);
  node.append(...children);
  return node;
};

/** A base64 text as an array of this type, little-endian as the page is written. */
function decoded(text, Type) {
  return new Type(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer);
}

const arrays = data.arrays.map(([low, step, text]) => {
  const b = decoded(text, Uint8Array);
  return Float32Array.from({ length: b.length / 3 }, (_, k) => low + step * (b[3 * k] + 256 * b[3 * k + 1] + 65536 * b[3 * k + 2]));
});
const topologies = data.topologies.map(({ sizes, corners, edges }) => {
  const flat = decoded(corners, Uint16Array), ends = decoded(edges, Uint16Array);
  let first = 0;
  return {
    faces: [...decoded(sizes, Uint8Array)].map((size) => [...flat.subarray(first, (first += size))]),
    edges: Array.from({ length: ends.length / 2 }, (_, edge) => [ends[2 * edge], ends[2 * edge + 1]]),
  };
});
/** Whether each of n things has its bit set; the first bit of a byte is its highest. */
const flags = (text, n) => {
  const bytes = decoded(text, Uint8Array);
  return Array.from({ length: n }, (_, k) => Boolean((bytes[k >> 3] >> (7 - (k & 7))) & 1));
};

const now = { study: 0, moved: 0, places: data.studies.map((study) => study.parameters.map(({ start }) => start)) };
const study = () => data.studies[now.study];
const places = () => now.places[now.study];

/** The state at these places of the sliders; the last slider runs fastest. */
function stateAt(chosen) {
  const index = study().parameters.reduce((sum, { values }, k) => sum * values.length + chosen[k], 0);
  return study().states[index];
}

/** All states along the slider that was moved last. */
function statesAlong() {
  const { values } = study().parameters[now.moved];
  return values.map((_, place) => stateAt(places().map((each, k) => (k === now.moved ? place : each))));
}

// --- pictures

let views = null;
try {
  views = { mesh: new View(element("mesh")), image: new View(element("image")) };
  for (const [view, other] of [[views.mesh, views.image], [views.image, views.mesh]]) {
    view.camera.onMove = () => {
      other.camera.turnTo(view.camera.azimuth, view.camera.elevation);
      view.redraw();
      other.redraw();
    };
    view.onHover = (face) => {
      if (face !== view.hovered) [view, other].forEach((each) => each.hover(face));
    };
  }
} catch (error) {
  for (const caption of document.querySelectorAll("figcaption span")) {
    caption.textContent = `cannot be drawn: ${error.message}`;
  }
}

function drawn({ mesh, image, topology, reversed, turned }) {
  const each = topologies[topology], shared = {
    topology: each,
    isReversed: flags(reversed, each.edges.length),
    isTurned: flags(turned, each.faces.length),
  };
  const [m, s] = [arrays[mesh], arrays[image]];
  const beams = element("beams").checked ? offset(m, s) : null;
  views.mesh.show({ positions: m, beams, ...shared }, false);
  views.image.show({ positions: s, beams: null, ...shared }, element("sphere").checked);
}

const SPHERE_BOX = [1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1];

/** Both pictures as large as all meshes along the moved slider allow, so that they stay in place while it moves. */
function frame() {
  const along = statesAlong(), all = (positionsOf) => Float32Array.from(along.flatMap((state) => [...positionsOf(state)]));
  const joined = all(({ mesh }) => arrays[mesh]), beams = all(({ mesh, image }) => offset(arrays[mesh], arrays[image]));
  views.mesh.frame(Float32Array.from([...joined, ...beams]));
  views.image.frame(Float32Array.from([...all(({ image }) => arrays[image]), ...SPHERE_BOX]));
}

/** The other side of the beams. */
function offset(m, s) {
  return m.map((value, k) => value + study().beam * s[k]);
}

// --- controls

function listStudies() {
  const families = new Map();
  data.studies.forEach(({ family, title }, index) => {
    if (!families.has(family)) families.set(family, made("p"));
    families.get(family).append(made("button", { type: "button", textContent: title, onclick: () => open(index) }));
  });
  for (const [family, buttons] of families) {
    document.querySelector("nav").append(made("div", {}, made("span", { textContent: family }), buttons));
  }
}

function slider({ name, sentence, values }, k) {
  const output = made("output", { textContent: values[places()[k]] });
  const input = made("input", { type: "range", min: 0, max: values.length - 1, step: 1, value: places()[k] });
  input.setAttribute("aria-valuetext", output.textContent);
  input.addEventListener("input", () => {
    output.textContent = values[input.valueAsNumber];
    input.setAttribute("aria-valuetext", output.textContent);
    turn(k, input.valueAsNumber);
  });
  const label = made("span", {}, name, output);
  return made("div", { className: "control" }, made("label", {}, label, input), made("small", { textContent: sentence }));
}

function choice({ name, sentence, values }, k) {
  const buttons = values.map((text, place) => {
    const button = made("button", { type: "button", textContent: text });
    button.setAttribute("aria-pressed", place === places()[k]);
    button.addEventListener("click", () => {
      buttons.forEach((each) => each.setAttribute("aria-pressed", each === button));
      turn(k, place);
    });
    return button;
  });
  const row = made("div", {}, ...buttons);
  return made("fieldset", { className: "control" }, made("legend", { textContent: name }), row, made("small", { textContent: sentence }));
}

/** A slider moves within the frame of its own; anything else is framed anew. */
function turn(k, place) {
  const { isChoice } = study().parameters[k], isSame = k === now.moved;
  places()[k] = place;
  if (!isChoice) now.moved = k;
  update(isChoice || !isSame);
}

function open(index) {
  now.study = index;
  now.moved = study().parameters.findLastIndex(({ isChoice }) => !isChoice);
  document.querySelectorAll("nav button").forEach((button, k) => button.setAttribute("aria-pressed", k === index));
  element("title").textContent = study().title;
  element("sentence").textContent = study().sentence;
  element("controls").replaceChildren(
    ...study().parameters.map((parameter, k) => (parameter.isChoice ? choice : slider)(parameter, k)),
  );
  if (views) Object.values(views).forEach(({ camera }) => camera.turnTo(...study().view));
  history.replaceState(null, "", `#${index + 1}`);
  update(true);
}

function update(isFramed) {
  const state = stateAt(places());
  if (views) {
    drawn(state);
    if (isFramed) frame();
  }
  const along = statesAlong();
  element("numbers").replaceChildren(...data.rows.map(({ label, kind }, row) => {
    const values = along.map(({ numbers }) => numbers.slice(2 * row, 2 * row + 2));
    const cell = made("td", { textContent: written(kind, ...state.numbers.slice(2 * row, 2 * row + 2)) });
    return made("tr", {}, made("th", { textContent: label, scope: "row" }), cell, made("td", {}, curve(kind, values)));
  }));
}

// --- numbers

function figure(value) {
  const size = Math.abs(value);
  const text = size === 0 ? "0" : size >= 1000 ? value.toFixed(0) : String(Number(value.toPrecision(size < 1 ? 3 : 4)));
  return text.replace("-", "\u2212");
}

function written(kind, low, high) {
  if (kind === "share") return `${low} of ${high}`;
  if (kind === "pair") return `${figure(low)} \u00d7 ${figure(high)}`;
  return low === high ? figure(low) : `${figure(low)} to ${figure(high)}`;
}

/** The numbers over the slider, a band from the low to the high ones, and where the slider is; "" where none changes. */
function curve(kind, values) {
  const bands = kind === "share" || kind === "pair" ? values.map(([first]) => [first, first]) : values;
  const least = Math.min(...bands.flat()), most = Math.max(...bands.flat());
  if (bands.every(([low, high]) => low === bands[0][0] && high === bands[0][1])) return "";
  const x = (k) => ((64 * k) / (values.length - 1)).toFixed(1), y = (v) => (19 - (18 * (v - least)) / (most - least)).toFixed(1);
  const points = [...bands.map(([, high], k) => `${x(k)},${y(high)}`), ...bands.map(([low], k) => `${x(k)},${y(low)}`).reverse()];
  const place = places()[now.moved], [low, high] = bands[place];
  const holder = made("span");
  holder.innerHTML =
    `<svg viewBox="0 0 64 20" preserveAspectRatio="none" aria-hidden="true"><polygon class="band" points="${points.join(" ")}"/>` +
    `<line class="now" x1="${x(place)}" x2="${x(place)}" y1="${Number(y(high)) - 2}" y2="${Number(y(low)) + 2}"/></svg>`;
  return holder.firstChild;
}

// --- start

listStudies();
for (const id of ["beams", "sphere"]) element(id).addEventListener("change", () => update(false));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => views && Object.values(views).forEach((v) => v.redraw()));
const asked = Number(location.hash.slice(1)) - 1;
open(asked in data.studies ? asked : 0);
document.documentElement.dataset.ready = "yes";

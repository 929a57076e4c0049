"use strict";

// The page of differences: the later model, what is gone of the earlier one, and a row for each piece that differs.

const CHANGES = JSON.parse(document.getElementById("data").textContent);
const PICKED = [214, 33, 124, 255];
const rowsOfNames = new Map(); // row of the table by the name of a piece before or now
const found = new Map(); // {layer, row} of the pieces in the model by name
let viewer = null, picked = null;

const columnOf = (name) => CHANGES.table.cells[CHANGES.table.columns.indexOf(name)];

/** Layers of the parts by how they differ: of the later model, and of the earlier one what is gone. */
function comparedModel({ earlier, later, colours }) {
  const [change, before, now] = ["Change", "Piece before", "Piece now"].map(columnOf);
  const of = { new: new Set(), changed: new Set(), gone: new Set() };
  change.forEach((kind, row) => {
    of[kind].add(kind === "gone" ? before[row] : now[row]);
    for (const name of [before[row], now[row]]) if (name) rowsOfNames.set(name, row);
  });
  const old = readArrays(earlier.model, bytesOfBase64(earlier.arrays)), model = readArrays(later.model, bytesOfBase64(later.arrays));
  const apart = earlier.middle_mm.map((value, axis) => (value - later.middle_mm[axis]) / 1000);
  const points = new Float32Array(old.points.length + model.points.length);
  points.set(model.points);
  points.set(old.points, model.points.length);
  const shapes = [...model.shapes, ...old.shapes.map((shape) => ({ ...shape, first: shape.first + model.points.length / 3, cut: shape.cut + model.cuts.length }))];
  const known = (name) => of.new.has(name) || of.changed.has(name);
  const layers = [
    chosen("same", model, later.names, (name) => !known(name), [0, 0, 0], 0, colours),
    chosen("changed", model, later.names, (name) => of.changed.has(name), [0, 0, 0], 0, colours),
    chosen("new", model, later.names, (name) => of.new.has(name), [0, 0, 0], 0, colours),
    chosen("gone", old, earlier.names, (name) => of.gone.has(name), apart, model.shapes.length, colours),
  ];
  return withBoxes({ layers: layers.filter(({ count }) => count), points, shapes, cuts: [...model.cuts, ...old.cuts] });
}

/** The parts whose names are wanted as a layer: moved by a vector, shapes counted from `firstShape`. */
function chosen(name, model, names, wanted, moved, firstShape, colours) {
  const origins = [], turns = [], shapes = [], own = [], opacity = [];
  let first = 0;
  for (const layer of model.layers.filter((each) => each.name !== "left out")) {
    for (let row = 0; row < layer.count; row++) {
      if (!wanted(names[first + row])) continue;
      for (let axis = 0; axis < 3; axis++) origins.push(layer.origins[3 * row + axis] + moved[axis]);
      turns.push(...layer.turns.subarray(4 * row, 4 * row + 4));
      shapes.push(firstShape + layer.shapes[row]);
      opacity.push(layer.colourOf(row)[3]);
      own.push(names[first + row]);
    }
    first += layer.count;
  }
  const moves = own.map((each) => Number(columnOf("Moved (mm)")[rowsOfNames.get(each)] ?? 0)), most = Math.max(1e-9, ...moves);
  const share = (row) => (name === "changed" ? 0.25 + 0.75 * Math.sqrt(moves[row] / most) : 1); // pale where little moved
  const colourOf = (row) => [
    ...colours[name].map((value) => Math.round(255 + share(row) * (value - 255))),
    opacity[row] < 255 ? (name === "same" ? 70 : 140) : 255,
  ];
  return {
    name, names: own, count: own.length, colourOf, most,
    origins: Float32Array.from(origins), turns: Float32Array.from(turns), shapes: Uint32Array.from(shapes),
  };
}

/** Shows a piece by its name before or now; null shows none. Returns how many there are. */
function pick(name) {
  const at = name === null ? undefined : found.get(name), card = document.getElementById("part");
  picked = at ?? null;
  document.getElementById("mark").value = name ?? "";
  document.getElementById("found").textContent = name === null ? "" : at ? "1 found" : "0 found";
  card.hidden = !at;
  if (at) {
    const { columns, cells } = CHANGES.table, row = rowsOfNames.get(name), list = element("dl");
    if (row !== undefined) columns.forEach((column, k) => cells[k][row] && list.append(element("dt", column), element("dd", cells[k][row])));
    const head = element("header");
    head.append(element("strong", name), element("span", row === undefined ? "same in both" : "", "soft"));
    card.replaceChildren(head, list);
  }
  viewer?.paint((layer, row) => (at && layer === at.layer && row === at.row ? PICKED : layer.colourOf(row)));
  viewer?.mark(at ? [{ ...at, colour: PICKED }] : [], true);
  return at ? 1 : 0;
}

function startModel() {
  viewer = startViewer(() => comparedModel(CHANGES), ["same"]);
  if (!viewer) return;
  for (const { layer } of viewer.shapes) layer.names.forEach((name, row) => found.set(name, { layer, row }));
  CHANGES.table.cells[0].forEach((change, row) => { // names before, of pieces that are shown as they are now
    const [before, now] = [2, 3].map((column) => CHANGES.table.cells[column][row]);
    if (change === "changed" && !found.has(before)) found.set(before, found.get(now));
  });
  const changed = viewer.shapes.find(({ layer }) => layer.name === "changed")?.layer;
  if (changed) document.querySelector('#layers input[value="changed"]').parentNode.append(element("small", `by up to ${changed.most.toFixed(1)} mm, darker`, "soft"));
  viewer.onHover = (at) => (at ? showUnder(at.layer.names[at.row], at.layer.name) : showUnder(null));
  viewer.onClick = (at) => pick(at ? at.layer.names[at.row] : null);
}

startTables({ differences: CHANGES.table });
startModel();
startPicking(pick);
showUnder(null);
document.documentElement.dataset.ready = "yes";

"use strict";

// The page: joins the viewer, the controls beside it, the sheets and the tables.

const SEQUENCE = ["#352a87", "#1f6fb4", "#22a39f", "#8fc05a", "#f3d23b"]; // least to most
const BOTH_SIGNS = ["#2166ac", "#92c5de", "#eceff1", "#f4a582", "#b2182b"]; // below, at and above zero
const DISTINCT = ["#1f6fb4", "#e08214", "#2a9d5c", "#c0392b", "#7b5bb5", "#8c6d46", "#d6579c", "#5f6b76", "#a8a400", "#1ba3b8"];
const MUTED = [214, 219, 223, 255];
const MUTED_PLATE = [214, 219, 223, 40];
const PICKED = [214, 33, 124, 255];
const SAME_MARK = [241, 150, 196, 255]; // as a picked piece
const GONE = [0, 0, 0, 0];

const data = JSON.parse(document.getElementById("data").textContent);
const state = { column: null, scale: null, wanted: null, pinned: null, hidden: new Set(), only: null };
const layers = []; // of the model: {name, first, count}, first: row of the layer's first part in the table of pieces
const places = new Map(); // {layer, row} of all pieces by their marks and names
let viewer = null;

const pieces = data.pieces.cells, [pieceNames, marks] = [pieces[0] ?? [], pieces[1] ?? []];
const columnOf = (table, name) => table.cells[table.columns.indexOf(name)] ?? [];

/** Name and mark of a part of the model. */
function nameOf({ layer, row }) {
  return layer.first === null ? data.labels[layer.name][row] : pieceNames[layer.first + row];
}

function markOf({ layer, row }) {
  return layer.first === null ? "" : marks[layer.first + row];
}

function colourAt(ramp, share) {
  const stops = ramp.map(channels), at = Math.min(0.9999, Math.max(0, share)) * (stops.length - 1), n = Math.floor(at);
  return stops[n].map((value, k) => Math.round(value + (at - n) * (stops[n + 1][k] - value)));
}

function channels(text) {
  return [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16));
}

const ALL_PARTS = "all parts"; // the group of columns that parts of all kinds have

/** All that parts can be coloured by: {group, title, unit, decimals, signed, values}, a value for each part. */
function colourColumns() {
  const found = [], known = new Set(data.measures.map(({ group, title }) => `${group} ${title}`));
  const add = (group, title, values) => {
    if (known.has(`${group} ${title}`) || new Set(values).size < 2) return;
    known.add(`${group} ${title}`);
    const numbers = values.map((text) => (text === "" || text === null ? null : Number(text)));
    const numeric = !numbers.some(Number.isNaN);
    const decimals = numeric ? Math.max(...values.map((text) => (text?.split(".")[1] ?? "").length)) : 0;
    const [, name, unit] = title.match(/^(.*?)(?: \((\S+)\))?$/);
    found.push({ group, title: name, unit: unit ?? "", decimals, signed: false, values: numeric ? numbers : values });
  };
  for (const title of ["Zone", "Order"]) add(ALL_PARTS, title, pieces[data.pieces.columns.indexOf(title)]);
  found.push(...data.measures.map((measure) => ({ ...measure })));
  for (const layer of layers.filter(({ first }) => first !== null)) {
    const own = (texts) => texts.slice(layer.first, layer.first + layer.count);
    const table = data.tables[layer.name], rowOf = new Map(columnOf(table, "Mark").map((mark, row) => [mark, row]));
    table.columns.forEach((title, column) => {
      if (title !== "File") add(layer.name, title, own(marks).map((mark) => table.cells[column][rowOf.get(mark)]));
    });
    data.pieces.columns.forEach((title, column) => {
      if (!["Piece", "File"].includes(title)) add(layer.name, title, own(pieces[column]));
    });
  }
  return found;
}

/** {least, most, ramp} of numbers, {words} of texts: their colours. */
function scaleOf({ values, signed }) {
  const known = values.filter((value) => value !== null && value !== "");
  if (typeof known[0] === "string") {
    const words = [...new Set(known)].sort(NATURAL.compare);
    return { words: new Map(words.map((word, k) => [word, DISTINCT[k % DISTINCT.length]])) };
  }
  let least = known.reduce((a, b) => Math.min(a, b), Infinity), most = known.reduce((a, b) => Math.max(a, b), -Infinity);
  if (signed) [least, most] = [-Math.max(-least, most), Math.max(-least, most)];
  return { least, most, ramp: signed ? BOTH_SIGNS : SEQUENCE };
}

/** Colour of a part by the chosen column. */
function columnColour(layer, row) {
  const { column, scale } = state, own = layer.colourOf(row);
  if (layer.first === null) return own;
  const isPlate = data.forms[layer.name] === "plate"; // which hides what lies below it
  if (!column) return state.wanted !== null && isPlate ? [...own.slice(0, 3), Math.min(own[3], 50)] : own;
  const isOfAll = column.group === ALL_PARTS;
  if (layer.name !== column.group && !isOfAll) return isPlate ? MUTED_PLATE : MUTED;
  const value = column.values[isOfAll ? layer.first + row : row];
  if (value === null || value === "") return MUTED;
  if (scale.words) return [...channels(scale.words.get(value)), 255];
  const share = scale.most > scale.least ? (value - scale.least) / (scale.most - scale.least) : 0.5;
  return [...colourAt(scale.ramp, share), 255];
}

/** Paints all parts; rings show the picked ones, discs the blocks where they are what is measured. */
function paint() {
  if (!viewer) return;
  const picked = [], measured = [], mark = state.pinned && markOf(state.pinned);
  viewer.paint((layer, row) => {
    const own = markOf({ layer, row });
    if (state.hidden.has(own) || (state.only !== null && own !== state.only && layer.first !== null)) return GONE;
    const colour = columnColour(layer, row);
    if (data.forms[layer.name] === "block" && state.column?.group === layer.name) measured.push({ layer, row, colour });
    if (!mark || own !== mark) return colour;
    if (state.wanted !== mark && (layer !== state.pinned.layer || row !== state.pinned.row)) return SAME_MARK;
    picked.push({ layer, row, colour: PICKED });
    return PICKED;
  });
  viewer.mark(picked.length ? picked : measured, picked.length > 0);
}

function say(value, decimals) {
  return value === null ? "\u2013" : typeof value === "string" ? value : value.toFixed(decimals);
}

/** Shows all parts with a mark, or one piece; null shows none. Returns how many there are. */
function pick(wanted, found = null) {
  const known = wanted === null ? [] : places.get(wanted) ?? [];
  Object.assign(state, { wanted: known.length ? wanted : null, pinned: found ?? known[0] ?? null });
  const mark = state.pinned && markOf(state.pinned), alike = mark ? places.get(mark).length : 0;
  if (state.hidden.delete(mark) || (state.only !== null && mark && state.only !== mark)) state.only = null;
  document.getElementById("mark").value = wanted ?? "";
  document.getElementById("found").textContent = wanted === null ? "" : known.length > 1 || alike === known.length ? `${known.length} found` : `1 of ${alike} of ${mark}`;
  if (wanted === null || known.length) writeAddress(wanted);
  showPart();
  showHidden();
  paint();
  return known.length;
}

/** The picked mark or piece is in the address, where no section of the page is. */
function writeAddress(wanted) {
  const now = decodeURIComponent(location.hash.slice(1));
  if (wanted === null && !places.has(now)) return;
  history.replaceState(null, "", wanted === null ? location.pathname + location.search : `#${encodeURIComponent(wanted)}`);
}

function readAddress() {
  const wanted = decodeURIComponent(location.hash.slice(1));
  if (wanted === "" || document.getElementById(wanted)) return;
  pick(wanted);
  document.getElementById("model").scrollIntoView();
}

function hide(mark) {
  state.hidden.add(mark);
  pick(null);
}

function showOnly(mark) {
  state.only = mark;
  showHidden();
  paint();
}

function showAllMarks() {
  state.hidden.clear();
  state.only = null;
  showHidden();
  paint();
}

function showHidden() {
  const line = document.getElementById("hidden"), names = [...state.hidden];
  line.hidden = names.length === 0 && state.only === null;
  line.querySelector("span").textContent = state.only !== null ? `Only ${state.only} is shown.` : `Hidden: ${names.slice(0, 4).join(", ")}${names.length > 4 ? ` and ${names.length - 4} more` : ""}.`;
}

function chooseColumn(column) {
  state.column = column;
  state.scale = column && scaleOf(column);
  const legend = document.getElementById("scale"), words = legend.querySelector("ul");
  legend.hidden = !column;
  legend.classList.toggle("words", Boolean(state.scale?.words));
  words.replaceChildren();
  if (state.scale?.words) {
    const all = [...state.scale.words];
    for (const [word, colour] of all.slice(0, DISTINCT.length)) {
      const item = element("li", word), spot = element("i");
      spot.style.background = colour;
      item.prepend(spot);
      words.append(item);
    }
    if (all.length > DISTINCT.length) words.append(element("li", `and ${all.length - DISTINCT.length} more; colours repeat`, "soft"));
  } else if (column) {
    const { least, most, ramp } = state.scale, { decimals, unit } = column, [low, high] = legend.querySelectorAll("b");
    legend.querySelector("i").style.background = `linear-gradient(to right, ${ramp.join(",")})`;
    low.textContent = say(least, decimals);
    high.textContent = `${say(most, decimals)} ${unit}`;
  }
  paint();
}

/** The choices of colours, one group of them for each layer. */
function startColumns() {
  const columns = colourColumns(), select = document.getElementById("column");
  select.append(new Option("Kind of part", ""));
  for (const group of new Set(columns.map((each) => each.group))) {
    const choices = element("optgroup");
    choices.label = group[0].toUpperCase() + group.slice(1);
    columns.forEach(({ group: own, title }, k) => own === group && choices.append(new Option(title, k)));
    select.append(choices);
  }
  select.addEventListener("change", () => chooseColumn(select.value === "" ? null : columns[Number(select.value)]));
}

/** The layers and the places of their parts. */
function startModel() {
  const plates = Object.keys(data.forms).filter((name) => data.forms[name] === "plate");
  viewer = startViewer(() => readModel(data.model, bytesOfBase64(document.getElementById("model-data").textContent.trim())), plates);
  if (!viewer) return;
  let first = 0;
  for (const { layer } of viewer.shapes) {
    layer.first = layer.name === "left out" ? null : first;
    first += layer.count;
    layers.push(layer);
    for (let row = 0; row < layer.count && layer.first !== null; row++) {
      const found = { layer, row }, mark = markOf(found);
      places.set(nameOf(found), [found]);
      if (!places.has(mark)) places.set(mark, []);
      if (mark !== nameOf(found)) places.get(mark).push(found);
    }
  }
  viewer.onHover = (found) => (found ? showUnder(nameOf(found), found.layer.first === null ? "" : data.labels[found.layer.name][found.row]) : showUnder(null));
  viewer.onClick = (found) => pick(found && (places.get(markOf(found))?.length === 1 ? markOf(found) : nameOf(found)), found);
  const canvas = document.querySelector("#model canvas");
  canvas.addEventListener("dblclick", () => state.pinned && viewer.centreOn(state.pinned));
  canvas.dataset.parts = first;
}

function startSheets() {
  const dialog = document.querySelector("dialog");
  for (const button of document.querySelectorAll(".sheets button")) {
    button.addEventListener("click", () => {
      dialog.querySelector("h3").textContent = button.closest("figure").querySelector("figcaption").textContent;
      dialog.querySelector("svg")?.remove();
      dialog.append(button.querySelector("svg").cloneNode(true));
      dialog.showModal();
    });
  }
}

startTables(data.tables);
startSheets();
startModel();
startColumns();
startPicking(pick);
document.querySelector("#hidden button").addEventListener("click", showAllMarks);
window.addEventListener("hashchange", readAddress);
showUnder(null);
readAddress();
document.documentElement.dataset.ready = "yes";

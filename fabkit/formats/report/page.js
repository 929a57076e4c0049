"use strict";

// The page: joins the viewer, the controls beside it, the sheets and the tables.

const SEQUENCE = ["#352a87", "#1f6fb4", "#22a39f", "#8fc05a", "#f3d23b"]; // least to most
const BOTH_SIGNS = ["#2166ac", "#92c5de", "#eceff1", "#f4a582", "#b2182b"]; // below, at and above zero
const MUTED = [214, 219, 223, 255];
const MUTED_PLATE = [214, 219, 223, 40];
const PICKED = [214, 33, 124, 255];

const data = JSON.parse(document.getElementById("data").textContent);
const state = { measure: null, scale: null, mark: null, pinned: null };
let viewer = null;

function colourAt(ramp, share) {
  const stops = ramp.map((text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16)));
  const at = Math.min(0.9999, Math.max(0, share)) * (stops.length - 1), n = Math.floor(at);
  return stops[n].map((value, k) => Math.round(value + (at - n) * (stops[n + 1][k] - value)));
}

/** {least, most, ramp} of a measure's colours. */
function scaleOf(measure) {
  const known = measure.values.filter((value) => value !== null);
  let least = known.reduce((a, b) => Math.min(a, b), Infinity), most = known.reduce((a, b) => Math.max(a, b), -Infinity);
  if (measure.signed) [least, most] = [-Math.max(-least, most), Math.max(-least, most)];
  return { least, most, ramp: measure.signed ? BOTH_SIGNS : SEQUENCE };
}

/** Colour of a part by the chosen measure; null for its own. */
function measuredColour(layer, row) {
  const { measure, scale } = state, part = layer.parts[row];
  if (layer.name === "left out") return null;
  const isPlate = data.forms[layer.name] === "plate"; // which hides what lies below it
  if (!measure) return state.mark !== null && isPlate ? [...part.colour.slice(0, 3), 50] : null;
  if (layer.name !== measure.group) return isPlate ? MUTED_PLATE : MUTED;
  const value = measure.values[row];
  if (value === null) return MUTED;
  const share = scale.most > scale.least ? (value - scale.least) / (scale.most - scale.least) : 0.5;
  return [...colourAt(scale.ramp, share), 255];
}

/** Paints all parts; rings show the picked ones, discs the blocks where they are what is measured. */
function paint() {
  if (!viewer) return;
  const picked = [], measured = [];
  viewer.paint((layer, row) => {
    const colour = measuredColour(layer, row);
    if (data.forms[layer.name] === "block" && state.measure?.group === layer.name) measured.push({ layer, row, colour });
    if (state.mark === null || layer.parts[row].name !== state.mark) return colour;
    picked.push({ layer, row, colour: PICKED });
    return PICKED;
  });
  viewer.mark(picked.length ? picked : measured, picked.length > 0);
}

function say(value, decimals) {
  return value === null ? "\u2013" : value.toFixed(decimals);
}

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

function showPart(found) {
  const card = document.getElementById("part");
  if (!found) return card.replaceChildren(element("p", "Point at a part to read its mark; click to keep it.", "soft"));
  const { layer, row } = found, list = element("dl");
  card.replaceChildren(element("strong", layer.parts[row].name), element("p", data.labels[layer.name][row], "soft"), list);
  for (const measure of data.measures.filter((each) => each.group === layer.name)) {
    list.append(element("dt", measure.title), element("dd", `${say(measure.values[row], measure.decimals)} ${measure.unit}`));
  }
}

/** Shows all parts with a mark; null shows none. Returns how many there are. */
function pick(mark, found = null) {
  Object.assign(state, { mark, pinned: found });
  let count = 0;
  for (const { layer } of viewer ? viewer.shapes : []) {
    layer.parts.forEach((part, row) => {
      if (mark === null || part.name !== mark) return;
      count += 1;
      state.pinned ??= { layer, row };
    });
  }
  document.getElementById("mark").value = mark ?? "";
  document.getElementById("found").textContent = mark === null ? "" : count === 1 ? "1 part" : `${count} parts`;
  showPart(state.pinned);
  paint();
  return count;
}

function chooseMeasure(index) {
  state.measure = index === "" ? null : data.measures[Number(index)];
  state.scale = state.measure && scaleOf(state.measure);
  const legend = document.getElementById("scale");
  legend.hidden = !state.measure;
  if (state.measure) {
    const { least, most, ramp } = state.scale, { decimals, unit } = state.measure;
    legend.querySelector("i").style.background = `linear-gradient(to right, ${ramp.join(",")})`;
    const [low, high] = legend.querySelectorAll("b");
    low.textContent = say(least, decimals);
    high.textContent = `${say(most, decimals)} ${unit}`;
  }
  paint();
}

function startViewer(canvas) {
  const text = document.getElementById("model-data").textContent;
  try {
    viewer = new Viewer(canvas, readModel(bytesOfBase64(text.trim())));
  } catch (error) {
    canvas.replaceWith(element("p", `The model cannot be shown here (${error.message}); the GLB file opens in any viewer.`, "hint"));
    return;
  }
  viewer.onHover = (found) => state.pinned || showPart(found);
  viewer.onClick = (found) => pick(found && found.layer.parts[found.row].name, found);
  canvas.addEventListener("dblclick", () => state.pinned && viewer.centreOn(state.pinned));
  for (const box of document.querySelectorAll("#layers input")) {
    box.addEventListener("change", () => viewer.show(box.value, box.checked));
  }
  for (const button of document.querySelectorAll(".views button")) {
    button.addEventListener("click", () => viewer.showAll(button.value));
  }
  document.getElementById("measure").addEventListener("change", (event) => chooseMeasure(event.target.value));
  document.getElementById("mark").addEventListener("change", (event) => pick(event.target.value.trim() || null));
  canvas.dataset.parts = viewer.shapes.reduce((sum, { layer }) => sum + layer.parts.length, 0);
}

function startTables() {
  for (const box of document.querySelectorAll(".table")) {
    new LongTable(box, document.querySelector(`input[data-table="${box.id}"]`));
    box.addEventListener("mouseover", ({ target }) => {
      if (target.tagName === "TD" && target.scrollWidth > target.clientWidth) target.title = target.textContent;
    });
  }
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

document.addEventListener("click", (event) => {
  const button = event.target.closest("button.mark");
  if (button && pick(button.textContent) > 0) document.getElementById("model").scrollIntoView({ behavior: "smooth" });
});
startTables();
startSheets();
startViewer(document.querySelector("#model canvas"));
showPart(null);
document.documentElement.dataset.ready = "yes";

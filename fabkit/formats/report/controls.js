"use strict";

// What the report and the page of differences have in common: elements, and the controls beside a model.

function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.append(text);
  if (className) made.className = className;
  return made;
}

/** The viewer of a model, whose controls work; null where it cannot be shown, which the page then says. plates: names of
    layers that hide what lies below them. */
function startViewer(readModel, plates) {
  const canvas = document.querySelector("#model canvas");
  let viewer = null;
  try {
    viewer = new Viewer(canvas, readModel(), new Set(plates));
  } catch (error) {
    canvas.replaceWith(element("p", `The model cannot be shown here (${error.message}); the GLB file opens in any viewer.`, "hint"));
    return null;
  }
  for (const box of document.querySelectorAll("#layers input")) box.addEventListener("change", () => viewer.show(box.value, box.checked));
  for (const button of document.querySelectorAll(".views button")) button.addEventListener("click", () => viewer.showAll(button.value));
  const [apart, axis, cut] = ["apart", "axis", "cut"].map((name) => document.getElementById(name));
  const place = () => {
    viewer.explode(Number(apart.value));
    cut.disabled = axis.value === "";
    viewer.cutAt(axis.value === "" ? null : Number(axis.value), Number(cut.value));
  };
  for (const control of [apart, axis, cut]) control.addEventListener("input", place);
  return viewer;
}

/** pick(name) shows what has this mark or name, null nothing, and returns how many there are: for the field beside the
    model, and the names in tables. */
function startPicking(pick) {
  document.getElementById("mark").addEventListener("change", (event) => pick(event.target.value.trim() || null));
  document.addEventListener("click", (event) => {
    const button = event.target.closest("button.mark");
    if (button && pick(button.textContent) > 0 && !button.closest("#part")) document.getElementById("model").scrollIntoView({ behavior: "smooth" });
  });
}

/** tables: their data by name. */
function startTables(tables) {
  for (const box of document.querySelectorAll(".table")) {
    new LongTable(box, document.querySelector(`input[data-table="${box.id}"]`), tables[box.dataset.table]);
    box.addEventListener("mouseover", ({ target }) => {
      if (target.tagName === "TD" && target.scrollWidth > target.clientWidth) target.title = target.textContent;
    });
  }
}

/** A line about the part under the pointer: its name, and more about it; or how to read it. */
function showUnder(name, more) {
  const line = document.getElementById("under");
  if (name === null) line.replaceChildren(element("span", "Point at a part to read its name; click to see all about it.", "soft"));
  else line.replaceChildren(element("strong", name), element("br"), element("span", more, "soft"));
}

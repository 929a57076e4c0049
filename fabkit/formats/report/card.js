"use strict";

// The card of the part that is picked: everything the tables have of it.

/** Everything about the picked part: the row of its mark, what is its own, and what goes around it. */
function showPart() {
  const card = document.getElementById("part"), found = state.pinned;
  card.hidden = !found;
  if (!found) return card.replaceChildren();
  const { layer, row } = found, head = element("header"), body = element("div", undefined, "blocks");
  head.append(element("strong", nameOf(found)), element("span", data.labels[layer.name][row], "soft"));
  card.replaceChildren(head, body);
  if (layer.first === null) return;
  head.append(...actions(found));
  const name = nameOf(found), mark = markOf(found), table = data.tables[layer.name];
  body.append(facts("This piece", [
    ...data.pieces.columns.map((title, k) => [title, pieces[k][layer.first + row]]).slice(2),
    ...data.measures.filter((each) => each.group === layer.name && each.values[row] !== null).map((each) => [each.title, `${say(each.values[row], each.decimals)} ${each.unit}`]),
  ]));
  const at = columnOf(table, "Mark").indexOf(mark);
  body.append(facts(`Mark ${mark}`, table.columns.map((title, k) => [title, table.cells[k][at]]).slice(1)));
  for (const [heading, around, ...names] of data.around) {
    const rows = columnOf(around, names[0]).map((_, k) => k).filter((k) => names.some((each) => columnOf(around, each)[k] === name));
    if (rows.length) body.append(rowsAround(heading, around, rows, name));
  }
}

function actions(found) {
  const button = (text, task) => {
    const made = element("button", text);
    made.type = "button";
    made.addEventListener("click", task);
    return made;
  };
  return [
    button("Zoom to it", () => viewer?.centreOn(found, true)),
    button("Hide this mark", () => hide(markOf(found))),
    button("Only this mark", () => showOnly(markOf(found))),
  ];
}

function facts(heading, rows) {
  const block = element("section"), list = element("dl");
  for (const [title, text] of rows) {
    if (text === "" || text === null) continue;
    const value = element("dd", contentOf(title, text));
    if (text.length > 24) value.className = "long";
    list.append(element("dt", title), value);
  }
  block.append(element("h3", heading), list);
  return block;
}

/** Rows of a table of facets or edges, without the columns that say whose they are. */
function rowsAround(heading, table, rows, name) {
  const block = element("section", undefined, "around"), shown = element("table"), head = shown.createTHead().insertRow();
  const kept = table.columns.map((_, k) => k).filter((k) => table.columns[k] !== "Mark" && rows.some((row) => ![name, ""].includes(table.cells[k][row])));
  for (const k of kept) head.append(element("th", table.columns[k]));
  const body = shown.createTBody(), end = table.cells[table.columns.indexOf("End")];
  if (end && table.cells[0][rows[0]] !== name) rows.sort((a, b) => NATURAL.compare(end[a], end[b])); // of a beam, A first
  for (const row of rows) {
    const line = body.insertRow();
    for (const k of kept) line.insertCell().append(contentOf(table.columns[k], table.cells[k][row]));
  }
  block.append(element("h3", heading), shown);
  return block;
}

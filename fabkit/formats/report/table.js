"use strict";

// Tables: sorting, filtering, and only those rows in the page that can be seen, so that thousands stay quick.

const NATURAL = new Intl.Collator("en", { numeric: true });
const SPARE_ROWS = 20; // above and below what can be seen
const PRINTED_ROWS = 22; // of each table: a page

class LongTable {
  /** box: the scrolling element around a table whose rows all have one height; table: {columns, classes, cells}, the
      last the texts of each column. */
  constructor(box, filter, table) {
    Object.assign(this, { box, table, body: box.querySelector("tbody"), note: box.nextElementSibling });
    this.rows = table.cells[0].map((_, row) => row); // sorted
    this.shown = this.rows; // sorted and filtered
    this.wanted = "";
    this.spacers = [0, 1].map(() => document.createElement("tr"));
    this.heads = [...box.querySelectorAll("th")];
    this.heads.forEach((head, column) => {
      head.querySelector("button").addEventListener("click", () => this.sort(column));
    });
    filter.addEventListener("input", () => this.filter(filter.value));
    box.addEventListener("scroll", () => this.place());
    window.addEventListener("beforeprint", () => this.print());
    window.addEventListener("afterprint", () => this.place());
    new ResizeObserver(() => this.place()).observe(box); // also once at the start
  }

  /** An element for a row. */
  row(number) {
    const made = document.createElement("tr");
    this.table.cells.forEach((texts, column) => {
      const cell = made.insertCell(), name = this.table.columns[column];
      cell.className = this.table.classes[column];
      cell.append(contentOf(name, texts[number]));
    });
    return made;
  }

  /** Puts the rows around the visible part into the page, between spacers for the others. */
  place() {
    const height = this.rowHeight ?? 28, { scrollTop, clientHeight } = this.box;
    const first = Math.max(0, Math.floor(scrollTop / height) - SPARE_ROWS);
    const last = Math.min(this.shown.length, Math.ceil((scrollTop + clientHeight) / height) + SPARE_ROWS);
    const [above, below] = this.spacers;
    above.style.height = `${first * height}px`;
    below.style.height = `${(this.shown.length - last) * height}px`;
    const rows = this.shown.slice(first, last).map((number) => this.row(number));
    this.body.replaceChildren(above, ...rows, below);
    if (this.rowHeight === undefined && clientHeight > 0 && rows.length > 0) {
      this.rowHeight = rows[0].getBoundingClientRect().height || undefined;
      if (this.rowHeight) this.place();
    }
  }

  print() {
    const printed = this.shown.slice(0, PRINTED_ROWS);
    this.body.replaceChildren(...printed.map((number) => this.row(number)));
    const of = this.shown.length < this.rows.length ? `${this.shown.length} that hold "${this.wanted.trim()}", of ${this.rows.length}` : `${this.rows.length}`;
    this.note.textContent = printed.length < this.shown.length ? `The first ${printed.length} rows of ${of}; all are in the CSV files and in cutlist.xlsx.` : "";
  }

  sort(column) {
    const head = this.heads[column], down = head.getAttribute("aria-sort") === "ascending", sign = down ? -1 : 1;
    this.heads.forEach((each) => each.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const texts = this.table.cells[column], numbers = texts.map(Number);
    const numeric = texts.every((text, row) => text === "" || !Number.isNaN(numbers[row]));
    const order = numeric ? (a, b) => numbers[a] - numbers[b] : (a, b) => NATURAL.compare(texts[a], texts[b]);
    this.rows = [...this.rows].sort((a, b) => sign * order(a, b));
    this.filter(this.wanted);
  }

  filter(text) {
    this.wanted = text;
    const wanted = text.trim().toLowerCase();
    const has = (row) => this.table.cells.some((texts) => texts[row].toLowerCase().includes(wanted));
    this.shown = wanted ? this.rows.filter(has) : this.rows;
    this.box.scrollTop = 0;
    this.place();
  }
}

const NAMING = new Set(["Mark", "Piece", "Node", "Node A", "Node B", "Beam", "Panel", "Neighbour", "Piece before", "Piece now"]); // columns of names

/** A cell's text; a button that shows a mark or piece, a link to a file. */
function contentOf(column, text) {
  if (NAMING.has(column) && text && text !== "left out") {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", className: "mark", textContent: text });
    return button;
  }
  if (column !== "File" || !text) return text;
  const link = document.createElement("a");
  Object.assign(link, { href: text, textContent: text });
  return link;
}

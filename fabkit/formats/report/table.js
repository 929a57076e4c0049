"use strict";

// Tables: sorting, filtering, and only those rows in the page that can be seen, so that thousands stay quick.

const NATURAL = new Intl.Collator("en", { numeric: true });
const SPARE_ROWS = 20; // above and below what can be seen

class LongTable {
  /** box: the scrolling element around a table whose rows all have one height. */
  constructor(box, filter) {
    this.box = box;
    this.body = box.querySelector("tbody");
    this.rows = [...this.body.rows];
    this.body.replaceChildren(); // before anything asks how high the page is
    this.shown = this.rows; // sorted and filtered
    this.wanted = "";
    this.spacers = [0, 1].map(() => document.createElement("tr"));
    this.heads = [...box.querySelectorAll("th")];
    this.heads.forEach((head, column) => {
      head.querySelector("button").addEventListener("click", () => this.sort(column));
    });
    filter.addEventListener("input", () => this.filter(filter.value));
    box.addEventListener("scroll", () => this.place());
    window.addEventListener("beforeprint", () => this.body.replaceChildren(...this.shown));
    window.addEventListener("afterprint", () => this.place());
    new ResizeObserver(() => this.place()).observe(box); // also once at the start
  }

  /** Puts the rows around the visible part into the page, between spacers for the others. */
  place() {
    const height = this.rowHeight ?? 28, { scrollTop, clientHeight } = this.box;
    const first = Math.max(0, Math.floor(scrollTop / height) - SPARE_ROWS);
    const last = Math.min(this.shown.length, Math.ceil((scrollTop + clientHeight) / height) + SPARE_ROWS);
    const [above, below] = this.spacers;
    above.style.height = `${first * height}px`;
    below.style.height = `${(this.shown.length - last) * height}px`;
    this.body.replaceChildren(above, ...this.shown.slice(first, last), below);
    if (this.rowHeight === undefined && clientHeight > 0 && last > first) {
      this.rowHeight = this.shown[first].getBoundingClientRect().height || undefined;
      if (this.rowHeight) this.place();
    }
  }

  sort(column) {
    const head = this.heads[column], down = head.getAttribute("aria-sort") === "ascending", sign = down ? -1 : 1;
    this.heads.forEach((each) => each.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", down ? "descending" : "ascending");
    const keyed = this.rows.map((row) => [row.cells[column].textContent, row]);
    const numbers = keyed.every(([text]) => text === "" || !Number.isNaN(Number(text)));
    const order = numbers ? (a, b) => Number(a) - Number(b) : NATURAL.compare;
    this.rows = keyed.sort(([a], [b]) => sign * order(a, b)).map(([, row]) => row);
    this.filter(this.wanted);
  }

  filter(text) {
    this.wanted = text;
    const wanted = text.trim().toLowerCase();
    const has = (cell) => cell.textContent.toLowerCase().includes(wanted);
    this.shown = wanted ? this.rows.filter((row) => [...row.cells].some(has)) : this.rows;
    this.box.scrollTop = 0;
    this.place();
  }
}

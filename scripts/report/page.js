"use strict";
// Tables sort by a column: press its heading, or Enter or Space on it; once more turns the order round. A cell counts
// by its first number, or as text; "none" stays last. Figures grow across the page. Folded lists open for the printer.

const cellKey = (row, column) => {
  const words = (row.cells[column].firstChild?.textContent ?? "").trim();  // a model's name without the words for it
  // a name with a number in it ("left-10mm") is a name
  const number = /^[-+]?\d+(\.\d+)?(e[-+]?\d+)?(?![\w-])/i.exec(words);
  return { words, number: number ? Number(number[0]) : null, none: /^(none|nan|)$/.test(words) };
};

const compare = (a, b) =>
  a.number !== null && b.number !== null
    ? a.number - b.number
    : a.words.localeCompare(b.words, "en", { numeric: true });

const sortBy = (heading) => {
  const table = heading.closest("table");
  const descending = heading.getAttribute("aria-sort") === "ascending";
  const rows = [...table.tBodies[0].rows].map((row) => ({ row, key: cellKey(row, heading.dataset.column) }));
  rows.sort((a, b) => a.key.none - b.key.none || (descending ? -1 : 1) * compare(a.key, b.key));
  table.tBodies[0].append(...rows.map((entry) => entry.row));
  for (const other of table.tHead.querySelectorAll("th")) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", descending ? "descending" : "ascending");
};

for (const heading of document.querySelectorAll("th[data-column]")) {
  const button = document.createElement("button");
  button.type = "button";
  button.append(...heading.childNodes);
  button.addEventListener("click", () => sortBy(heading));
  heading.append(button);
}

for (const figure of document.querySelectorAll("figure:not(:first-child)")) {
  const picture = figure.querySelector("img");
  const button = document.createElement("button");
  button.type = "button";
  button.setAttribute("aria-pressed", "false");
  picture.replaceWith(button);
  button.append(picture);
  button.addEventListener("click", () => {
    button.setAttribute("aria-pressed", String(figure.classList.toggle("across")));
  });
}

addEventListener("beforeprint", () => {
  for (const list of document.querySelectorAll("details")) list.open = true;
});

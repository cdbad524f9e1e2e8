"use strict";
// Every heading that stands above one column becomes a button that sorts the rows of each group.
const valueAt = (row, column) => {
  let at = 0;
  for (const cell of row.cells) {
    if (at === column) return (cell.querySelector(".value") || cell).textContent.trim();
    at += cell.colSpan;
  }
  return "";
};
const isNumber = (text) => !Number.isNaN(parseFloat(text));
// A column of numbers is sorted by number, and what is no number stays below, up or down.
const sorted = (rows, column, up) => {
  const numeric = rows.some((row) => isNumber(valueAt(row, column)));
  const known = rows.filter((row) => !numeric || isNumber(valueAt(row, column)));
  const rest = rows.filter((row) => !known.includes(row));
  known.sort((one, other) => {
    const [a, b] = [valueAt(one, column), valueAt(other, column)];
    return numeric ? parseFloat(a) - parseFloat(b) : a < b ? -1 : Number(a > b);
  });
  return [...(up ? known : known.reverse()), ...rest];
};
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = table.querySelectorAll("thead th[data-column]");
  for (const head of heads) {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const column = Number(head.dataset.column);
      for (const body of table.tBodies) {
        const rows = [...body.rows].filter((row) => !row.classList.contains("group"));
        body.append(...sorted(rows, column, up));
      }
    });
  }
}

// Parts of results that all tabs share: cards, tables, notes, buttons that save.

import { minus } from "./charts.js";
import { element } from "./fields.js";

const FILES = { toml: "Case file", nc: "NetCDF", csv: "CSV", png: "PNG", svg: "SVG", py: "Python" };

/** A card with a title. */
export function card(title, wide, ...children) {
  return element("section", { class: wide ? "card wide" : "card" }, element("h3", {}, title), ...children);
}

/** Buttons that save the files of a tab. */
export function saves(tools) {
  const bar = element("div", { class: "saves" }, element("h3", {}, "Save"));
  for (const [kind, label] of Object.entries(FILES)) {
    const button = element("button", { type: "button", "data-save": kind }, label);
    button.addEventListener("click", () => tools.save(kind, button));
    bar.append(button);
  }
  return element("section", { class: "card wide" }, bar);
}

/** A table of texts; kind: "words" aligns the first column left, "remarks" the last one too. */
export function table(columns, rows, caption, kind = "") {
  const head = element("tr", {}, ...columns.map((column) => element("th", { scope: "col" }, Array.isArray(column) ? `${column[0]} (${column[1]})` : column)));
  const body = rows.map((row) => element("tr", {}, ...row.map((cell) => element("td", {}, minus(cell)))));
  const made = element("table", { class: kind }, element("thead", {}, head), element("tbody", {}, ...body));
  if (caption) made.prepend(element("caption", {}, caption));
  return element("div", { class: "scroll" }, made);
}

export function notes(list) {
  return element("ul", { class: "notes wide", hidden: !list.length }, ...list.map((line) => element("li", {}, line)));
}

// The tab *Compare formulas*: thin-layer and substrate formulas against the exact contact.

import { card, notes, saves, table } from "./cards.js";
import { lines } from "./charts.js";
import { element } from "./fields.js";

// as in the picture that is saved: three colours, each with four kinds of lines
const COLOURS = ["var(--two)", "var(--four)", "var(--grey)"];
const DASHES = ["7 4", "2 3", "9 3 2 3", "4 2"];
const FAR = 0.5; // errors beyond this are not drawn

function show(box, result, tools) {
  const [factors, errors] = [element("div"), element("div")];
  box.replaceChildren(
    element(
      "div",
      { class: "grid" },
      notes(result.notes),
      card("Force over that of the half-space formula", false, factors),
      card("Error of each formula", false, errors),
      card("How far each formula can be trusted", true, table(result.columns, result.rows, `Exact contact by the method ${result.method}.`, "words remarks")),
      saves(tools),
    ),
  );
  const x = { label: "indentation depth", unit: "m" };
  const top = 1.25 * (result.largest ?? 1);
  const within = (values, most) => values.map((value) => (value === null || Math.abs(value) > most ? null : value));
  const look = (i) => ({ colour: COLOURS[i % COLOURS.length], dash: DASHES[Math.floor(i / COLOURS.length) % DASHES.length], label: result.names[i] });
  const drawn = (series) => series.filter(({ y }) => y.some((value) => value !== null));
  lines(factors, {
    x,
    y: { label: "force / half-space" },
    series: [
      { x: result.depth, y: result.factor, colour: "var(--one)", width: 4, label: "exact" },
      ...drawn(result.names.map((_, i) => ({ x: result.depth, y: within(result.factors[i], top), ...look(i) }))),
    ],
    title: "Force over that of the half-space formula",
  });
  lines(errors, {
    x,
    y: { label: "error of the force (%)" },
    series: [
      { x: [0, result.depth.at(-1)], y: [0, 0], colour: "var(--one)", width: 4, label: "exact" },
      ...drawn(result.names.map((_, i) => ({ x: result.depth, y: within(result.deviation[i], FAR).map((value) => (value === null ? null : 100 * value)), ...look(i) }))),
    ],
    title: "Errors of the formulas over depth",
  });
}

const fields = () => [element("p", { class: "about" }, "There are formulas for spheres, cones, flat ends and four-sided pyramids on one layer; of a stack they see the layer at the surface. Errors above 50 % are not drawn.")];

export const COMPARE = { title: "Compare formulas", fields, show };

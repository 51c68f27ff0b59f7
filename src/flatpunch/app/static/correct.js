// The tab *Correct*: what was reported, the modulus of the layer, published formulas beside it.

import { card, notes, saves, table } from "./cards.js";
import { lines, quantity } from "./charts.js";
import { element, field } from "./fields.js";

const MODELS = { "": "the usual one of the tip", hertz: "Hertz (sphere)", sneddon: "Sneddon (cone)", flat: "flat punch", bilodeau: "Bilodeau (pyramid)", rico: "Rico (pyramid)" };
const OVER = { curve: "fitted to the curve", depth: "from the force at the depth" };

function fields() {
  return [
    element("p", { class: "about" }, "A program fitted a half-space formula to a curve of this sample and reported a modulus. The modulus of the top layer above does not matter here: it is looked for."),
    field("correct.reported", { label: "Reported modulus", kind: "quantity", value: "8 kPa", slides: true }),
    field("correct.depth", { label: "Depth of the fit", kind: "quantity", value: "300 nm", slides: true }),
    field("correct.over", { label: "It was", kind: "choice", value: "curve", choices: Object.keys(OVER), words: OVER }),
    field("correct.model", { label: "Formula", kind: "choice", value: "", choices: Object.keys(MODELS), words: MODELS }),
    field("correct.poisson", { label: "Poisson ratio used", kind: "number", value: "", example: "that of the layer" }),
  ];
}

function show(box, result, tools) {
  const curve = element("div");
  const words = [
    ["layer", quantity(result.young, "Pa")],
    ["reported", quantity(result.reported, "Pa")],
    ["reported over layer", result.factor.toPrecision(4)],
    ["1 % more reported gives", `${result.sensitivity?.toPrecision(2) ?? "many"} % more in the layer`],
  ];
  box.replaceChildren(
    element(
      "div",
      { class: "grid" },
      notes(result.notes),
      card("Modulus of the layer", true, element("ul", { class: "readout large" }, ...words.map(([name, value]) => element("li", {}, `${name} `, element("b", {}, value))))),
      card("Exact contact and published formulas", true, table(result.columns, result.rows, "Each formula turns the same reported modulus into one of the layer.", "words remarks")),
      card("What the half-space formula gives at each depth", true, curve),
      saves(tools),
      card("As the command line prints it", true, element("pre", {}, result.summary)),
    ),
  );
  const ends = [0, result.depth.at(-1)];
  lines(curve, {
    x: { label: "indentation depth", unit: "m" },
    y: { label: "Young's modulus", unit: "Pa" },
    series: [
      { x: result.depth, y: result.apparent, colour: "var(--two)", label: "half-space formula at this depth" },
      { x: ends, y: [result.young, result.young], colour: "var(--one)", dash: "6 4", label: "layer" },
      { x: [ends[1]], y: [result.reported], colour: "var(--three)", points: 4, label: "reported" },
    ],
    title: "Modulus of the half-space formula over depth",
  });
}

export const CORRECT = { title: "Correct", fields, show };

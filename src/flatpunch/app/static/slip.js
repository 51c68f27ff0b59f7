// The tab *Slip*: the pressed tip is pulled along the surface; first loading, cycle, table.

import { card, notes, saves, table } from "./cards.js";
import { lines } from "./charts.js";
import { element, field } from "./fields.js";

const ALONG = { displacement: ["Displacement along the surface", "150 nm"], tangential_force: ["Tangential force", "1 uN"], stick_radius: ["Radius of the stick zone", "50 nm"] };

function fields() {
  return [
    element("p", { class: "about" }, "A round tip under the force of the last step is pulled along the surface: it sticks in the middle and slips around. With none of the last three fields, from full stick until the whole contact slides; else one of them, a quantity, or a list or range as in a case file."),
    field("slip.friction", { label: "Friction", kind: "number", value: "0.3", example: "0.3" }),
    ...Object.entries(ALONG).map(([name, [label, example]]) => field(`slip.${name}`, { label, kind: "text", value: "", example })),
  ];
}

function show(box, result, tools) {
  const loop = element("div");
  box.replaceChildren(
    element(
      "div",
      { class: "grid" },
      notes(result.notes),
      card("Tangential force over displacement", true, loop, element("p", { class: "about" }, "The cycle goes to and fro by the largest displacement; its area is the energy lost.")),
      card(result.title || "Result", true, table(result.table.columns, result.table.rows, result.table.caption)),
      saves(tools),
    ),
  );
  const drawn = ([x, y], label, colour) => ({ x, y, label, colour });
  lines(loop, {
    x: { label: "displacement along the surface", unit: "m" },
    y: { label: "tangential force", unit: "N" },
    series: [drawn(result.cycle, "cycle", "var(--two)"), drawn(result.first, "first loading", "var(--one)")],
    title: "Tangential force over displacement",
  });
}

export const SLIP = { title: "Slip", fields, show };

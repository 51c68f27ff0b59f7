// The tab *Coating*: stresses in section, the first failure, and its load over the thickness of the film.

import { card, notes, saves, table } from "./cards.js";
import { lines } from "./charts.js";
import { element, field } from "./fields.js";
import { cells, inside, KINDS } from "./maps.js";

// in the order of the server's list
const QUANTITIES = ["von Mises stress", "largest principal stress", "largest shear stress", "mean normal stress", "σxx", "σzz", "σxz", "von Mises over yield stress"];
const VARIED = {
  "layers.0.thickness": ["Film thickness", "0.5 um:20 um:16:log"],
  "layers.0.young": ["Film modulus", ""],
  "base.young": ["Base modulus", ""],
  "indenter.radius": ["Tip radius", ""],
  "stress.friction": ["Friction", ""],
};

function fields() {
  const map = element("label", { class: "inline" }, element("input", { type: "checkbox", name: "map", value: "on" }), "load of the first failure over film thickness");
  const ranges = element("details", {}, element("summary", {}, "Ranges of the map"));
  ranges.append(element("p", { class: "about" }, "from : to : how many : log. Fill one for a curve, two for a map."));
  for (const [path, [label, value]] of Object.entries(VARIED)) ranges.append(field(`vary.${path}`, { label, kind: "text", value, example: value ? "" : "not varied" }));
  return [
    element("p", { class: "about" }, "Stresses are those of the last step. Strengths are beside each layer and the base; with one, the load of the first failure is found."),
    field("stress.friction", { label: "Friction", kind: "number", value: "", example: "0" }),
    map,
    ranges,
  ];
}

function show(box, result, tools) {
  box.replaceChildren(result.study ? study(result.study, tools) : stresses(result, tools));
}

function stresses(result, tools) {
  const [map, axis] = [element("div"), element("div")];
  const choose = element("select", { "aria-label": "What is drawn" });
  QUANTITIES.slice(0, result.judged ? undefined : -1).forEach((name, i) => choose.append(element("option", { value: i }, name)));
  const failure = result.first
    ? [element("p", {}, result.first.line), element("p", {}, result.first.loads), table(["criterion", "strength over stress"], result.first.margins, "At the load of the first failure.", "words")]
    : [element("p", { class: "about" }, "Give a strength of a layer or the base, and the load of the first failure is found.")];
  const drawn = result.section ? [element("div", { class: "steps" }, choose), map] : [element("p", { class: "about" }, "The points of this case are no section through the layers.")];
  const grid = element(
    "div",
    { class: "grid" },
    notes(result.notes),
    card("Section through the layers", true, element("p", { class: "about" }, result.about), ...drawn),
    card("First failure", false, ...failure),
    card("Along the axis", false, result.axis ? axis : ""),
    card("Largest values by layer", true, table(result.columns, result.rows, "Layers are counted from the surface; the base comes last.")),
    saves(tools),
  );
  const paint = (section) => inside(map, { ...section, label: QUANTITIES[choose.value], title: `${QUANTITIES[choose.value]} in section` });
  // once the cards have their width
  queueMicrotask(() => {
    if (result.section) paint(result.section);
    if (result.axis) alongAxis(axis, result.axis, result.section?.faces ?? []);
  });
  choose.addEventListener("change", async () => {
    const found = await tools.detail("quantity", Number(choose.value));
    if (!found.none) paint(found);
  });
  return grid;
}

/** Stresses along the axis; lines are broken at interfaces, where the lateral stress jumps. */
function alongAxis(box, axis, faces) {
  const jumps = faces.map((face) => axis.z.findIndex((z) => z > face)).filter((i) => i > 0).reverse();
  const broken = (values, at) => jumps.reduce((list, i) => list.toSpliced(i, 0, at), values);
  lines(box, {
    x: { label: "depth below the surface", unit: "m" },
    y: { label: "stress", unit: "Pa" },
    series: [["xx", "σxx", "var(--three)", "none"], ["zz", "σzz", "var(--one)", "6 4"]].map(([key, label, colour, dash]) => ({ x: broken(axis.z, null), y: broken(axis[key], null), colour, dash, label })),
    title: "Stresses along the axis",
  });
}

const label = (path) => (VARIED[path] ?? [path])[0];

function study(found, tools) {
  const map = element("div");
  const grid = element("div", { class: "grid" }, card("Load of the first failure", true, map, element("p", { class: "about" }, found.caption)), saves(tools));
  const axis = (i) => ({ label: label(found.names[i]).toLowerCase(), unit: found.units[i], log: found.values[i].every((value) => value > 0) && found.values[i].at(-1) > 8 * found.values[i][0] });
  queueMicrotask(() => {
    if (found.names.length > 1) {
      cells(map, { x: axis(0), y: axis(1), columns: found.values[0], rows: found.values[1], values: found.force, places: found.places, unit: "N", title: "Map of the first failure" });
      return;
    }
    const kinds = [...new Set(found.places)];
    const [x] = found.values;
    lines(map, {
      x: { ...axis(0), zero: false },
      y: { label: "load of the first failure", unit: "N", log: true },
      series: [
        { x, y: found.force, colour: "var(--grey)", width: 1.5 },
        ...kinds.map((kind, i) => ({ x, y: found.force.map((value, k) => (found.places[k] === kind ? value : null)), colour: KINDS[i % KINDS.length], points: 5, label: kind })),
      ],
      title: "Load of the first failure over film thickness",
    });
  });
  return grid;
}

export const COATING = { title: "Coating", fields, show };

// The tab *Press*: curve, outline, pressure, table.

import { card, notes, saves, table } from "./cards.js";
import { legend, lines, quantity, section } from "./charts.js";
import { element } from "./fields.js";
import { EARLIER, OUTLINE, plane } from "./maps.js";

const kept = []; // curves to compare with, until the page is closed
const KEPT = ["var(--three)", "var(--four)", "var(--five)", "var(--grey)"];

function show(box, result, tools) {
  const { curve } = result;
  const own = new URLSearchParams(tools.form());
  const steps = curve.depth.length;
  const [drawing, force, outline, map] = [0, 1, 2, 3].map(() => element("div"));
  const slide = element("input", { type: "range", min: 0, max: steps - 1, value: bestStep(curve), "aria-label": "Step" });
  const readout = element("ul", { class: "readout", "aria-live": "off" });
  const history = "time" in curve;
  const pressureCard = card("Contact pressure", false, map);
  const button = element("button", { type: "button", class: "main" }, "Compute the pressure of this step");
  const grid = element(
    "div",
    { class: "grid" },
    notes([...result.notes, ...result.leaving]),
    card(history ? "Force over time" : "Force and stiffness over depth", false, force, ...(history ? [] : [keeping(result, own, () => draw())])),
    card("Section, to scale", false, result.sketch ? drawing : element("p", { class: "about" }, "Two bodies are not drawn.")),
    card("Step of the curve", true, element("div", { class: "steps" }, slide), readout),
    card("Contact outline", false, outline),
    pressureCard,
    card(result.title || "Result", true, table(result.table.columns, result.table.rows, result.table.caption)),
    saves(tools),
  );
  box.replaceChildren(grid);
  if (result.sketch) section(drawing, { ...result.sketch, title: "Section through layers and tip" });

  const draw = () => {
    const i = Number(slide.value);
    curvePicture(force, result, i, own);
    const widest = Math.max(...result.contour.flat().filter(Number.isFinite)) || curve.radius[i] || 1e-9;
    const earlier = [0.25, 0.5, 0.75].map((share) => Math.round(share * i)).filter((each) => each !== i);
    const outlines = [...earlier.map((each) => ({ phi: result.phi, r: result.contour[each], faint: true })), { phi: result.phi, r: result.contour[i] }];
    plane(outline, { half: 1.2 * widest, outlines, title: "Contact outline" });
    legend(outline, [{ ...OUTLINE, label: "this step" }, ...(earlier.length ? [{ ...EARLIER, label: "earlier steps" }] : [])]);
    const said = [["step", `${i + 1} of ${steps}`]];
    if (history) said.push(["time", quantity(curve.time[i], "s")]);
    said.push(["depth", quantity(curve.depth[i], "m", 6)], ["force", quantity(curve.force[i], "N", 6)], ["radius", quantity(curve.radius[i], "m", 6)]);
    if (!history) said.push(["stiffness", quantity(curve.stiffness[i], "N/m", 6)]);
    if (!history) said.push(...kept.map((other, k) => [`force / ${called(other, k, own)}`, ratio(curve.force[i], forceAt(other, curve.depth[i]))]));
    if (result.exact) said.push(["error", "exact (round tip)"]);
    else if (curve.force_error) said.push(["force error", `${percent(curve.force_error[i])}`], ["outline error", `${percent(curve.contour_error?.[i])}`]);
    if (curve.strain_factor) said.push(["force / linear theory", String(Number(curve.strain_factor[i].toPrecision(4)))]);
    if (!curve.valid[i]) said.push(["theory", "does not hold here"]);
    readout.replaceChildren(...said.map(([name, value]) => element("li", {}, `${name} `, element("b", {}, value))));
  };
  const pressure = async () => {
    const i = Number(slide.value);
    const found = await tools.detail("pressure", i);
    if (!box.contains(map) || i !== Number(slide.value)) return;
    if (found.none) {
      map.replaceChildren(element("p", { class: "about" }, found.none));
      return;
    }
    map.replaceChildren();
    plane(map, {
      half: found.half,
      map: { ...found, label: "pressure", unit: "Pa" },
      outlines: [{ phi: result.phi, r: result.contour[i] }],
      title: "Contact pressure",
    });
    map.append(element("p", { class: "about" }, `Mean pressure ${quantity(found.mean, "Pa")}, typical error ${percent(found.error / found.mean)} of it.`));
  };
  const askForPressure = () => {
    if (!box.contains(map)) return null; // another tab is shown
    if (history) map.replaceChildren(element("p", { class: "about" }, "There is no map of pressure for histories of relaxing bodies."));
    else if (result.round) return pressure();
    else {
      button.disabled = false;
      map.replaceChildren(button);
    }
    return null;
  };
  button.addEventListener("click", async () => {
    button.disabled = true;
    await pressure();
  });
  let waiting = null;
  slide.addEventListener("input", () => {
    draw();
    clearTimeout(waiting);
    waiting = setTimeout(askForPressure, 300);
  });
  draw();
  waiting = setTimeout(askForPressure, 400);
}

const percent = (value) => (value === null || value === undefined ? "–" : `${Number((100 * value).toPrecision(2))} %`);

const ratio = (force, other) => (force === null || !other ? "–" : String(Number((force / other).toPrecision(4))));

/** A kept curve by its number and what its form had other than the one that is shown. */
function called({ form }, k, own) {
  const names = [...new Set([...form.keys(), ...own.keys()])].filter((name) => form.get(name) !== own.get(name));
  const said = names.slice(0, 2).map((name) => `${name} ${form.get(name) ?? "empty"}`);
  return [`kept ${k + 1}`, [...said, ...(names.length > 2 ? ["..."] : [])].join(", ")].filter(Boolean).join(": ");
}

/** The force of a kept curve at a depth, between its steps; null outside of them. */
function forceAt(curve, depth) {
  for (let i = 1; i < curve.depth.length; i++) {
    const [low, high] = [curve.depth[i - 1], curve.depth[i]];
    if ((depth - low) * (depth - high) > 0 || low === high || curve.force[i - 1] === null || curve.force[i] === null) continue;
    return curve.force[i - 1] + ((depth - low) / (high - low)) * (curve.force[i] - curve.force[i - 1]);
  }
  return null;
}

/** Buttons that keep the curve beside later ones, and drop those that were kept. */
function keeping(result, form, draw) {
  const keep = element("button", { type: "button", id: "keep", title: "Draw this curve beside those of later forms" }, "Keep this curve");
  const drop = element("button", { type: "button", id: "drop-kept", hidden: "" }, "Forget kept curves");
  const update = () => {
    drop.hidden = !kept.length;
    keep.disabled = kept.length === KEPT.length || kept.some(({ of }) => of === result);
  };
  keep.addEventListener("click", () => {
    const valid = result.curve.force.map((value, i) => (result.curve.valid[i] ? value : null));
    kept.push({ of: result, form, depth: result.curve.depth, force: valid });
    update();
    draw();
  });
  drop.addEventListener("click", () => {
    kept.length = 0;
    update();
    draw();
  });
  update();
  return element("div", { class: "saves" }, keep, drop);
}

/** The last step at which the theory holds and there is a contact. */
function bestStep(curve) {
  for (let i = curve.depth.length - 1; i >= 0; i--) if (curve.valid[i] && curve.radius[i] > 0) return i;
  return curve.depth.length - 1;
}

function curvePicture(box, result, i, own) {
  const { curve } = result;
  if ("time" in curve) {
    lines(box, {
      x: { label: "time", unit: "s" },
      y: { label: "force", unit: "N", colour: "var(--one)" },
      right: { label: "depth", unit: "m", colour: "var(--two)" },
      series: [
        { x: curve.time, y: curve.force, colour: "var(--one)", label: "force" },
        { x: curve.time, y: curve.depth, colour: "var(--two)", dash: "6 4", label: "depth", right: true },
      ],
      marker: { x: curve.time[i], ys: [{ y: curve.force[i], colour: "var(--one)" }, { y: curve.depth[i], right: true, colour: "var(--two)" }] },
      title: "Force and depth over time",
    });
    return;
  }
  const held = (values, yes) => values.map((value, k) => (curve.valid[k] === yes ? value : null));
  const error = curve.force_error?.map((value) => value ?? 0);
  const series = [
    { x: curve.depth, y: held(curve.force, true), colour: "var(--one)", label: "force" },
    { x: curve.depth, y: held(curve.stiffness, true), colour: "var(--two)", dash: "6 4", label: "stiffness", right: true },
  ];
  if (error && !result.exact) series[0].band = [-1, 1].map((sign) => curve.force.map((value, k) => (value === null ? null : value * (1 + sign * error[k]))));
  if (error && !result.exact) series[0].label = `force (error at most ${percent(Math.max(...error))})`;
  if (curve.valid.includes(false)) {
    series.push({ x: curve.depth, y: held(curve.force, false), colour: "var(--grey)", label: "force where the theory does not hold" });
  }
  kept.forEach((other, k) => series.push({ x: other.depth, y: other.force, colour: KEPT[k], dash: "2 3", label: called(other, k, own) }));
  lines(box, {
    x: { label: "indentation depth", unit: "m" },
    y: { label: "force", unit: "N", colour: "var(--one)" },
    right: { label: "stiffness", unit: "N/m", colour: "var(--two)" },
    series,
    marker: { x: curve.depth[i], ys: [{ y: curve.force[i], colour: "var(--one)" }, { y: curve.stiffness[i], right: true, colour: "var(--two)" }] },
    title: "Force and stiffness over indentation depth",
  });
}

export const PRESS = { title: "Press", fields: () => [], show };

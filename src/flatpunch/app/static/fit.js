// The tab *Fit*: a measured file, its preview, the fit.

import { card, notes, saves, table } from "./cards.js";
import { lines, quantity } from "./charts.js";
import { element, field } from "./fields.js";

const MOST = 50e6; // bytes of a file
const ROLES = ["depth", "force", "piezo", "deflection", "time"];

const DRAWN = {
  measured: { colour: "var(--one)", points: 1.6 },
  before: { colour: "var(--grey)", points: 1.6 },
  approach: { colour: "var(--one)", points: 1.6 },
  hold: { colour: "var(--ink)", points: 1.6 },
  retract: { colour: "var(--two)", points: 1.6 },
  "further cycles": { colour: "var(--grey)", points: 1.6 },
  baseline: { colour: "var(--four)", width: 1.5 },
  contact: { colour: "var(--grey)", width: 1.5, dash: "3 3" },
  "left out": { colour: "var(--three)", points: 2.2 },
}; // how the picture of a reading draws its parts
let box = null; // where the preview is
let asked = ""; // for which the preview was asked
let unread = []; // what the preview found wrong with the file

function fields(tools) {
  const file = element("input", { type: "file", id: "curve-file", hidden: true });
  const key = element("input", { type: "hidden", name: "upload", id: "upload" });
  const name = element("span", { id: "curve-name" }, "No file yet");
  const pick = element("button", { type: "button", id: "choose-curve" }, "Choose a file");
  const drop = element("div", { class: "drop", id: "drop" }, element("div", {}, "Drop a measured curve here"), pick, element("div", {}, name));
  const take = async (taken) => {
    if (!taken) return;
    if (taken.size > MOST) {
      tools.problems([{ field: "upload", text: `${taken.name} has ${(taken.size / 1e6).toFixed(0)} MB; files of up to 50 MB are taken.` }]);
      return;
    }
    name.textContent = `Sending ${taken.name} …`;
    const sent = await tools.ask(`/api/curve?name=${encodeURIComponent(taken.name)}`, { method: "POST", body: taken });
    if (!sent.upload) {
      tools.problems(sent.problems);
      return;
    }
    key.value = sent.upload;
    tools.changed();
  };
  pick.addEventListener("click", () => file.click());
  file.addEventListener("change", () => take(file.files[0]).then(() => (file.value = "")));
  drop.addEventListener("dragover", (event) => {
    event.preventDefault();
    drop.classList.add("over");
  });
  drop.addEventListener("dragleave", () => drop.classList.remove("over"));
  drop.addEventListener("drop", (event) => {
    event.preventDefault();
    drop.classList.remove("over");
    take(event.dataTransfer.files[0]);
  });
  const holder = element("div", { class: "field file", "data-name": "upload" }, drop, file, key, element("p", { class: "error", id: "upload-error" }));
  const columns = element("details", {}, element("summary", {}, "Columns and reading"));
  columns.append(element("datalist", { id: "columns" }));
  for (const role of ROLES) {
    const made = field(`curve.columns.${role}`, { label: `${role[0].toUpperCase()}${role.slice(1)}`, kind: "text", value: "", example: "recognised by its title" });
    made.querySelector("input").setAttribute("list", "columns");
    columns.append(made);
  }
  for (const [key_, label, example] of [["units.depth", "Unit of depth", "nm"], ["units.force", "Unit of force", "nN"], ["units.piezo", "Unit of piezo", "um"], ["sheet", "Sheet", ""], ["index", "Curve number, from 0", "0"]]) {
    columns.append(field(`curve.${key_}`, { label, kind: "text", value: "", example }));
  }
  columns.append(field("curve.decimal", { label: "Decimal mark", kind: "choice", value: "", choices: [".", ","] }));
  for (const [key_, label] of [["flip", "Heights grow upwards"], ["skip_nan", "Drop rows with gaps"]]) {
    columns.append(field(`curve.${key_}`, { label, kind: "choice", value: "", choices: ["true", "false"], words: { true: "yes", false: "no" } }));
  }
  const more = element("details", {}, element("summary", {}, "How to fit"));
  for (const [key_, label, choices] of [
    ["segment", "Segment", ["auto", "approach", "retract", "both"]],
    ["loss", "Loss", ["linear", "soft_l1", "huber", "cauchy"]],
    ["adhesion", "Adhesion dip", ["refuse", "above", "ignore"]],
  ]) more.append(field(`fit.${key_}`, { label, kind: "choice", value: "", choices }));
  for (const [key_, label, example] of [["contact", "Contact point", "free, or 300 nm"], ["depth_to", "Up to the position", "500 nm"], ["force_to", "Up to the force", "2 nN"], ["level", "Confidence level", "0.95"]]) {
    more.append(field(`fit.${key_}`, { label, kind: "text", value: "", example }));
  }
  // the choice that most often matters is beside the button, outside the form's element
  const baseline = field("fit.baseline", { label: "Baseline", kind: "choice", value: "", choices: ["auto", "constant", "linear", "none"] });
  baseline.dataset.tabs = "fit";
  const choose = baseline.querySelector("select");
  choose.setAttribute("form", "form");
  choose.addEventListener("input", () => choose.form.dispatchEvent(new CustomEvent("form-changed")));
  document.getElementById("long").before(baseline);
  const all = element("label", { class: "inline" }, element("input", { type: "checkbox", name: "all", value: "on" }), "fit every curve of the file");
  return [
    holder,
    field("curve.spring_constant", { label: "Spring constant", kind: "quantity", value: "", example: "0.05 N/m" }),
    field("curve.sensitivity", { label: "Sensitivity", kind: "quantity", value: "", example: "70 nm/V" }),
    columns,
    more,
    element("p", { class: "about" }, "Tick “fit” under each value of the sample that is looked for; the value is where the search begins."),
    all,
  ];
}

/** After each change: show what the file holds. */
async function changed(tools, shown) {
  const form = new URLSearchParams(tools.form());
  const upload = form.get("upload");
  const name = document.getElementById("curve-name");
  if (!upload) {
    name.textContent = "No file yet";
    unread = [];
    return;
  }
  const file = upload.slice(upload.indexOf("/") + 1);
  const part = [...form].filter(([key]) => key === "upload" || key.startsWith("curve.")).join();
  if (part === asked && box && shown.contains(box)) return;
  asked = part;
  unread = [];
  name.textContent = `Reading ${file} …`;
  const found = await tools.preview("preview");
  if (part !== asked) return;
  name.textContent = file;
  unread = found.problems ?? [];
  box ??= element("div");
  showPreview(found);
  if (!shown.contains(box)) shown.append(box);
  if (unread.length) tools.problems(unread);
}

function showPreview(found) {
  const list = document.getElementById("columns");
  list.replaceChildren(...(found.columns ?? []).map(([name]) => element("option", { value: name })));
  const said = [...(found.read ?? [])];
  if (found.count > 1) said.push(`The file holds ${found.count} curves; choose one by its number, or fit every curve.`);
  const picture = element("div");
  const parts = [element("h3", {}, `File ${found.name ?? ""}`), ...said.map((line) => element("p", { class: "about" }, line)), picture];
  if (found.columns) {
    const roles = Object.fromEntries(Object.entries(found.roles).map(([role, at]) => [at, role]));
    const heads = found.columns.map(([name, unit], i) => [roles[i] ? `${name} → ${roles[i]}` : name, unit]);
    parts.push(table(heads, found.rows, "The first rows, and which column is taken for what."));
  }
  box.className = "card preview";
  box.replaceChildren(...parts);
  if (found.traces) {
    lines(picture, {
      x: { label: "position as measured", unit: "m", zero: false },
      y: { label: "force", unit: "N", zero: false },
      series: found.traces.map(({ name, depth, force }) => ({ x: depth, y: force, label: name, ...DRAWN[name] })),
      height: 260,
      title: "Curve as it was read",
    });
  }
}

function show(place, result, tools) {
  const keep = box && place.contains(box) ? box : null;
  const save = saves(tools);
  if (result.all) {
    const grid = element("div", { class: "grid" }, card("Every curve of the file", true, table(result.all.columns, result.all.rows, result.all.caption, "words")), save);
    place.replaceChildren(grid, ...(keep ? [keep] : []));
    return;
  }
  const [curve, residual, drift] = [0, 1, 2].map(() => element("div"));
  const button = element("button", { type: "button" }, "Fit up to several depths");
  const { picture } = result;
  const columns = ["", "value", `${result.level} interval`, "standard error"];
  const grid = element(
    "div",
    { class: "grid" },
    notes(result.notes),
    card("What was found", true, table(columns, result.rows, `${picture.points} points fitted${picture.left_out ? `, ${picture.left_out} left out` : ""}`, "words")),
    card("Curve and fit", false, curve),
    card("Residuals", false, residual),
    card("Drift over depth, beside a half-space model", true, drift),
    save,
    card("As the command line prints it", true, element("pre", {}, result.summary)),
  );
  place.replaceChildren(grid, ...(keep ? [keep] : []));
  const x = { label: picture.along[0], unit: picture.along[1], zero: false };
  lines(curve, {
    x,
    y: { label: "force", unit: "N" },
    series: [
      { x: picture.x, y: picture.force, colour: "var(--one)", points: 3.5, label: "measured" },
      { x: picture.x, y: picture.fitted, colour: "var(--two)", label: "fitted", width: 1.5 },
    ],
    title: "Measured and fitted force",
  });
  lines(residual, {
    x,
    y: { label: "measured minus fitted", unit: "N" },
    series: [
      { x: picture.x, y: picture.residual, colour: "var(--one)", points: 1.6 },
      { x: [picture.x[0], picture.x.at(-1)], y: [0, 0], colour: "var(--two)" },
    ],
    title: "Residuals of the fit",
  });
  if (!result.drifts) {
    drift.append(element("p", { class: "about" }, "The modulus of the top layer is not fitted, so there is no drift of it."));
    return;
  }
  drift.append(element("p", { class: "about" }, "A right model finds the same modulus at every largest fitted depth."), button);
  button.addEventListener("click", async () => {
    button.disabled = true;
    const found = await tools.detail("drift", 0);
    button.disabled = false;
    if (found.none) {
      drift.replaceChildren(element("p", { class: "about" }, found.none));
      return;
    }
    drift.replaceChildren();
    const series = [["layered", "layered model", "var(--one)"], ["half_space", "half-space", "var(--two)"]].map(([key, label, colour]) => ({
      x: found[key].depth,
      y: found[key].value,
      band: [found[key].low, found[key].high],
      colour,
      label,
      points: 4,
      joined: true,
    }));
    lines(drift, { x: { label: "fitted up to a depth of", unit: "m" }, y: { label: "Young's modulus", unit: "Pa" }, series, title: "Modulus over the fitted depth" });
    drift.append(element("p", { class: "about" }, `Layered model ${quantity(found.layered.value[0], "Pa")} to ${quantity(found.layered.value.at(-1), "Pa")}, half-space ${quantity(found.half_space.value[0], "Pa")} to ${quantity(found.half_space.value.at(-1), "Pa")}.`));
  });
}

export const FIT = { title: "Fit", verb: "Fit", fields, show, changed, standing: () => unread };

// The form: fields made from the tables of case files, and the texts of all fields as one address.

import { element, field, FITTED, tell } from "./fields.js";
import { addLayer, number, strengths } from "./layers.js";

const STEPS = {
  depth: { start: "10 nm", stop: "300 nm", points: "60" },
  force: { start: "10 pN", stop: "10 nN", points: "60" },
  radius: { start: "50 nm", stop: "1 um", points: "60" },
};
const PROPOSED = ["control", "correct", "vary"]; // tables whose fields are proposed where a case has none of them

let tables = null;
let form = null;

/** Build the form. `onChange` is called after each change, with "slide" while a slider moves. */
export function build(start, box, onChange) {
  tables = start;
  form = box;
  part("base", "Base", [...Object.keys(tables.base), "two bodies"], "half-space");
  part("indenter", "Tip", Object.keys(tables.indenter), "sphere");
  document.getElementById("add-layer").addEventListener("click", () => {
    addLayer(tables);
    number();
    document.querySelector("#layers .layer:last-child input").focus();
    tell(form);
  });
  form.addEventListener("input", (event) => {
    if (event.target.name) onChange();
  });
  form.addEventListener("form-changed", (event) => onChange(event.detail));
  form.addEventListener("submit", (event) => event.preventDefault());
}

/** A section whose fields depend on its kind. */
function part(section, title, kinds, first) {
  const box = document.getElementById(section);
  const choose = element("select", { name: `${section}.kind`, id: `${section}-kind`, "aria-describedby": `${section}-kind-error` });
  for (const kind of kinds) choose.append(element("option", { value: kind }, kind.replaceAll("-", " ")));
  choose.value = first;
  const inner = element("div");
  choose.addEventListener("change", () => {
    fill(section, inner, choose.value);
    tell(box);
  });
  box.className = "part";
  box.append(
    element("div", { class: "field", "data-name": `${section}.kind` }, element("label", { for: `${section}-kind` }, element("h3", {}, title)), choose, element("p", { class: "error", id: `${section}-kind-error` })),
    inner,
  );
  fill(section, inner, first);
}

function fill(section, inner, kind) {
  inner.replaceChildren();
  if (kind === "two bodies") {
    inner.append(element("p", { class: "about" }, "Give [upper] and [lower] in the lines of the case file below."));
    return;
  }
  const { about, fields } = tables[section][kind];
  if (section === "indenter") inner.append(element("p", { class: "about" }, about));
  const extra = element("details", {}, element("summary", {}, section === "indenter" ? "Wear, tilt and more" : "More"));
  for (const spec of fields) {
    const slides = spec.kind === "quantity" && spec.value !== "";
    const made = field(`${section}.${spec.name}`, { ...spec, slides, fits: FITTED.includes(spec.name) });
    (spec.value === "" ? extra : inner).append(made);
  }
  if (extra.children.length > 1) inner.append(extra);
  if (section === "base" && kind !== "rigid") inner.append(strengths("base", tables));
}

/** Texts of all fields of a tab that are not empty. */
export function read(tab) {
  const found = new URLSearchParams();
  for (const input of form.elements) {
    if (!input.name || input.value.trim() === "" || (input.type === "checkbox" && !input.checked)) continue;
    if (input.hidden || input.type === "file") continue;
    const owner = input.closest("[data-tabs]");
    if (owner && !owner.dataset.tabs.split(" ").includes(tab)) continue;
    found.append(input.name, input.value.trim());
  }
  return found;
}

/** Set all fields; those that are not named become empty. */
export function write(fields) {
  const list = document.getElementById("layers");
  list.replaceChildren();
  const count = Math.max(-1, ...[...fields.keys()].map((name) => Number(/^layers\.(\d+)\./.exec(name)?.[1] ?? -1))) + 1;
  for (let i = 0; i < count; i++) addLayer(tables, fields.get(`layers.${i}.kind`) ?? "");
  number();
  for (const section of ["base", "indenter"]) {
    const kind = fields.get(`${section}.kind`);
    const choose = form.elements[`${section}.kind`];
    if (kind && [...choose.options].some((option) => option.value === kind)) choose.value = kind;
    fill(section, document.getElementById(section).lastElementChild, choose.value);
  }
  // what the page has no field for is kept and sent along
  for (const kept of form.querySelectorAll(".kept")) kept.remove();
  for (const [name, value] of fields) if (!form.elements[name]) form.append(element("input", { type: "hidden", class: "kept", name, value }));
  const groups = new Set([...fields.keys()].map((name) => name.split(".")[0]));
  for (const input of form.elements) {
    if (!input.name || /\.kind$/.test(input.name)) continue;
    const table = input.name.split(".")[0];
    const proposed = PROPOSED.includes(table) && !groups.has(table) ? input.dataset.proposed : "";
    const value = fields.get(input.name) ?? proposed ?? "";
    if (input.type === "checkbox") input.checked = value === "on";
    else if (input.type !== "file") input.value = value;
    if (input.tagName === "SELECT" && input.selectedIndex < 0) input.selectedIndex = 0;
    if (input.tagName === "SELECT" && value === "" && /bonded$/.test(input.name)) input.value = "true";
    if (input.type === "checkbox" || input.tagName === "SELECT") input.dispatchEvent(new Event("change"));
  }
  for (const details of form.querySelectorAll("details")) details.open = [...details.querySelectorAll("input, textarea")].some((input) => input.value !== "" && input.type !== "range" && input.type !== "checkbox");
}

/** The form as it is where nothing is known. */
export function defaults() {
  document.getElementById("layers").replaceChildren();
  addLayer(tables);
  number();
}

/** Show problems beside their fields; return those that belong to none. */
export function showProblems(problems) {
  for (const input of document.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
  for (const place of document.querySelectorAll(".error")) place.textContent = "";
  const elsewhere = [];
  for (const { field: name, text } of problems) {
    const box = name && document.querySelector(`[data-name="${CSS.escape(name)}"]`);
    if (!box || !box.offsetParent) {
      const details = box && box.closest("details");
      if (!details) {
        elsewhere.push(text);
        continue;
      }
      details.open = true;
    }
    const place = box.querySelector(":scope > .error");
    place.textContent = place.textContent ? `${place.textContent} ${text}` : text;
    box.querySelector("input, select, textarea").setAttribute("aria-invalid", "true");
  }
  return elsewhere;
}

/** What tabs have in common: before their own fields what is prescribed, after them method and adhesion. */
export function sharedFields() {
  const methods = ["", "first-order", "second-order", "fourth-order", "refined", "bem"];
  const words = { "": "chosen by itself", bem: "boundary elements" };
  const adhesion = element(
    "details",
    { "data-tabs": "press fit coating" },
    element("summary", {}, "Adhesion, outline"),
    field("work_of_adhesion", { label: "Work of adhesion", kind: "quantity", value: "", example: "50 mJ/m^2", fits: true }),
    field("range_of_action", { label: "Range of action", kind: "quantity", value: "", example: "1 nm", fits: true }),
    field("strength", { label: "Adhesive strength", kind: "quantity", value: "", example: "10 MPa", fits: true }),
    field("angles", { label: "Polar angles", kind: "number", value: "", example: "360" }),
  );
  const law = field("material.finite_strain", { label: "Large strains", kind: "choice", value: "", choices: ["neo-hookean"], words: { "": "linear theory", "neo-hookean": "neo-Hookean" } });
  law.dataset.tabs = "press fit compare";
  return [[controlFields()], [field("method", { label: "Method", kind: "choice", value: "", choices: methods, words }), law, adhesion]];
}

/** Fields of what is prescribed. */
function controlFields() {
  const box = element("div", { class: "control", "data-tabs": "press coating compare" });
  const quantity = field("control.quantity", { label: "Prescribed", kind: "choice", value: "depth", choices: ["depth", "force", "radius", "history"], words: { radius: "contact radius", history: "history, in lines below" } });
  const range = element("div");
  for (const [name, label] of [["start", "From"], ["stop", "To"]]) range.append(field(`control.${name}`, { label, kind: "quantity", value: STEPS.depth[name], slides: name === "stop" }));
  range.append(field("control.points", { label: "Steps", kind: "number", value: "60" }));
  range.append(field("control.spacing", { label: "Spacing", kind: "choice", value: "linear", choices: ["linear", "log"] }));
  const listed = element("details", {}, element("summary", {}, "One value or a list instead"), field("control.values", { label: "Values", kind: "text", value: "", example: '["50 nm", "200 nm"]' }));
  const choose = quantity.querySelector("select");
  choose.addEventListener("change", () => {
    for (const each of [range, listed]) each.hidden = choose.value === "history";
  });
  choose.addEventListener("input", () => {
    for (const name of ["start", "stop", "points"]) {
      const proposed = STEPS[choose.value]?.[name];
      if (proposed) form.elements[`control.${name}`].value = proposed;
    }
  });
  box.append(quantity, range, listed);
  return box;
}

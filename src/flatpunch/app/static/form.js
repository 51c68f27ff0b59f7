// The form: fields made from the tables of case files, layers that can be moved, and the texts of all fields as one address.

const UNITS = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(\s*)(.*)$/;
const STEPS = {
  depth: { start: "10 nm", stop: "300 nm", points: "60" },
  force: { start: "10 pN", stop: "10 nN", points: "60" },
  radius: { start: "50 nm", stop: "1 um", points: "60" },
};

let tables = null;
let form = null;
let changed = () => {};

/** Build the form. `onChange` is called after each change. */
export function build(start, element, onChange) {
  tables = start;
  form = element;
  changed = onChange;
  part("base", "Base", [...Object.keys(tables.base), "two bodies"], "half-space");
  part("indenter", "Tip", Object.keys(tables.indenter), "sphere");
  document.getElementById("add-layer").addEventListener("click", () => {
    addLayer();
    number();
    document.querySelector("#layers .layer:last-child input").focus();
    changed();
  });
  form.addEventListener("input", (event) => {
    if (event.target.name) changed();
  });
  form.addEventListener("submit", (event) => event.preventDefault());
}

export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (value === true) made.setAttribute(key, "");
    else if (value !== false && value !== undefined && value !== null) made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

/** One field with its label and the place for its problem. spec: {label, kind, value, example, choices}. */
export function field(name, spec) {
  const id = name.replaceAll(".", "-");
  const shared = { id, name, "aria-describedby": `${id}-error` };
  let input;
  if (spec.kind === "switch" || spec.kind === "choice") {
    input = element("select", shared);
    for (const choice of spec.value === "" && spec.kind !== "given" ? ["", ...spec.choices.filter((each) => each !== "")] : spec.choices) {
      input.append(element("option", { value: choice }, spec.words?.[choice] ?? (choice || "–")));
    }
    input.value = spec.value;
  } else {
    input = element("input", { ...shared, type: "text", value: spec.value, placeholder: spec.example || false, spellcheck: "false" });
    if (spec.kind === "quantity") input.addEventListener("keydown", nudge);
  }
  const box = element("div", { class: "field", "data-name": name }, element("label", { for: id }, spec.label), input);
  if (spec.kind === "quantity" && spec.slides) box.append(knob(input, spec.label));
  if (spec.fits) box.append(fitMark(name, spec));
  box.append(element("p", { class: "error", id: `${id}-error` }));
  return box;
}

function knob(input, label) {
  const slide = element("input", { type: "range", class: "knob", min: "-1", max: "1", step: "0.01", value: "0", "aria-label": `${label}, a tenth to ten times` });
  let anchor = null;
  slide.addEventListener("input", () => {
    anchor ??= UNITS.exec(input.value);
    if (!anchor) return;
    input.value = scaled(anchor, 10 ** Number(slide.value));
    changed("slide");
  });
  input.addEventListener("input", () => {
    anchor = null;
    slide.value = "0";
  });
  return slide;
}

const scaled = ([, number, space, unit], factor) => `${Number((Number(number) * factor).toPrecision(3))}${space || " "}${unit}`;

/** Arrow up and down change a quantity by 5 %. */
function nudge(event) {
  if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
  const match = UNITS.exec(event.target.value);
  if (!match) return;
  event.preventDefault();
  event.target.value = scaled(match, event.key === "ArrowUp" ? 1.05 : 1 / 1.05);
  event.target.dispatchEvent(new Event("input", { bubbles: true }));
}

const FITTED = ["young", "poisson", "thickness", "radius", "inclination", "half_opening_angle", "work_of_adhesion"];

function fitMark(name, spec) {
  const check = element("input", { type: "checkbox", name: `${name}.fit`, value: "on" });
  const limits = ["min", "max"].map((end) => element("input", { type: "text", name: `${name}.${end}`, placeholder: end, "aria-label": `${spec.label}, ${end}`, hidden: true }));
  check.addEventListener("change", () => limits.forEach((each) => (each.hidden = !check.checked)));
  return element("div", { class: "inline fit-only" }, element("label", {}, check, "fit"), ...limits);
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
    changed();
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
}

/** Append a layer; its names are set by `number`. */
export function addLayer() {
  const list = document.getElementById("layers");
  const layer = element("div", { class: "layer" });
  const button = (text, label, action) => element("button", { type: "button", "aria-label": label, title: label, onclick: action }, text);
  const move = (step) => () => {
    const other = step < 0 ? layer.previousElementSibling : layer.nextElementSibling;
    if (!other) return;
    step < 0 ? other.before(layer) : other.after(layer);
    number();
    changed();
  };
  const handle = element("span", { class: "handle", title: "Drag to move", "aria-hidden": "true" }, "⠿");
  const bar = element("div", { class: "bar" }, handle, element("h3"), button("↑", "Move up", move(-1)), button("↓", "Move down", move(1)), button("✕", "Remove", () => {
    layer.remove();
    number();
    changed();
  }));
  layer.append(bar);
  for (const spec of tables.layers) {
    const words = { true: "bonded", false: "sliding" };
    layer.append(field(`layers.0.${spec.name}`, { ...spec, words, slides: spec.kind === "quantity", fits: FITTED.includes(spec.name) }));
  }
  const strengths = element("details", { class: "coating-only" }, element("summary", {}, "Strengths"));
  for (const spec of tables.strengths) strengths.append(field(`strengths.0.${spec.name}`, spec));
  layer.append(strengths);
  dragging(layer, handle);
  list.append(layer);
  return layer;
}

function dragging(layer, handle) {
  handle.addEventListener("pointerdown", () => (layer.draggable = true));
  handle.addEventListener("pointerup", () => (layer.draggable = false));
  layer.addEventListener("dragstart", (event) => {
    layer.classList.add("dragged");
    event.dataTransfer.effectAllowed = "move";
    event.dataTransfer.setData("text/plain", "layer");
  });
  layer.addEventListener("dragend", () => {
    layer.draggable = false;
    layer.classList.remove("dragged");
  });
  layer.addEventListener("dragover", (event) => {
    const moved = document.querySelector(".layer.dragged");
    if (!moved || moved === layer) return;
    event.preventDefault();
    const { top, height } = layer.getBoundingClientRect();
    const below = event.clientY > top + height / 2;
    layer.classList.toggle("below", below);
    layer.classList.toggle("above", !below);
  });
  layer.addEventListener("dragleave", () => layer.classList.remove("above", "below"));
  layer.addEventListener("drop", (event) => {
    const moved = document.querySelector(".layer.dragged");
    if (!moved || moved === layer) return;
    event.preventDefault();
    layer.classList.contains("below") ? layer.after(moved) : layer.before(moved);
    layer.classList.remove("above", "below");
    number();
    changed();
  });
}

/** Name the fields of all layers by their order. */
export function number() {
  document.querySelectorAll("#layers .layer").forEach((layer, i) => {
    layer.querySelector("h3").textContent = i ? `Layer ${i + 1}` : "Layer 1, at the surface";
    for (const box of layer.querySelectorAll("[name], [data-name]")) {
      for (const key of ["name", "data-name"]) {
        if (box.hasAttribute(key)) box.setAttribute(key, box.getAttribute(key).replace(/^(layers|strengths)\.\d+/, `$1.${i}`));
      }
    }
    for (const box of layer.querySelectorAll("[id], [for], [aria-describedby]")) {
      for (const key of ["id", "for", "aria-describedby"]) {
        if (box.hasAttribute(key)) box.setAttribute(key, box.getAttribute(key).replace(/^(layers|strengths)-\d+/, `$1-${i}`));
      }
    }
  });
}

/** Texts of all fields that are not empty. */
export function read() {
  const found = new URLSearchParams();
  for (const input of form.elements) {
    if (!input.name || input.value.trim() === "" || (input.type === "checkbox" && !input.checked)) continue;
    if (input.hidden) continue;
    if (input.name.startsWith("control.") && !input.offsetParent && input.closest("[data-off]")) continue;
    found.append(input.name, input.value.trim());
  }
  return found;
}

/** Set all fields; those that are not named become empty. */
export function write(fields) {
  const list = document.getElementById("layers");
  list.replaceChildren();
  const count = Math.max(-1, ...[...fields.keys()].map((name) => Number(/^layers\.(\d+)\./.exec(name)?.[1] ?? -1))) + 1;
  for (let i = 0; i < count; i++) addLayer();
  number();
  for (const section of ["base", "indenter"]) {
    const kind = fields.get(`${section}.kind`);
    const choose = form.elements[`${section}.kind`];
    if (kind && [...choose.options].some((option) => option.value === kind)) choose.value = kind;
    fill(section, document.getElementById(section).lastElementChild, choose.value);
  }
  for (const input of form.elements) {
    if (!input.name || /\.kind$/.test(input.name)) continue;
    const value = fields.get(input.name) ?? "";
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
  addLayer();
  number();
}

/** Show problems beside their fields; return those that belong to none. */
export function showProblems(problems) {
  for (const input of form.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
  for (const place of form.querySelectorAll(".error")) place.textContent = "";
  const elsewhere = [];
  for (const { field: name, text } of problems) {
    const box = name && form.querySelector(`[data-name="${CSS.escape(name)}"]`);
    if (!box || !box.offsetParent) {
      const details = box && box.closest("details");
      if (!details || details.classList.contains("coating-only")) {
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

/** Fields of what is prescribed. */
export function controlFields() {
  const box = element("div", { class: "control" });
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

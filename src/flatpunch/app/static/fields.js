// One field of the form: label, input, slider, marks of a fit, and the place for what is wrong with it.

const UNITS = /^\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(\s*)(.*)$/;

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

/** Tell the form that something has changed; "slide" while a slider moves. */
export function tell(box, how = "") {
  box.dispatchEvent(new CustomEvent("form-changed", { bubbles: true, detail: how }));
}

/** One field with its label and the place for its problem. spec: {label, kind, value, example, choices}. */
export function field(name, spec) {
  const id = name.replaceAll(".", "-");
  const shared = { id, name, "aria-describedby": `${id}-error`, "data-proposed": spec.value || false };
  let input;
  if (spec.kind === "switch" || spec.kind === "choice") {
    input = element("select", shared);
    for (const choice of spec.value === "" && spec.kind !== "given" ? ["", ...spec.choices.filter((each) => each !== "")] : spec.choices) {
      input.append(element("option", { value: choice }, spec.words?.[choice] ?? (choice || "default")));
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
    tell(slide, "slide");
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

export const FITTED = ["young", "poisson", "thickness", "radius", "inclination", "half_opening_angle", "work_of_adhesion", "range_of_action", "strength"];

function fitMark(name, spec) {
  const check = element("input", { type: "checkbox", name: `${name}.fit`, value: "on" });
  const limits = ["min", "max"].map((end) => element("input", { type: "text", name: `${name}.${end}`, placeholder: end, "aria-label": `${spec.label}, ${end}`, hidden: true }));
  check.addEventListener("change", () => limits.forEach((each) => (each.hidden = !check.checked)));
  return element("div", { class: "inline", "data-tabs": "fit" }, element("label", {}, check, "fit"), ...limits);
}

// The layers of the sample: added, moved and removed; their names follow their order.

import { element, field, FITTED, tell } from "./fields.js";

const listed = () => document.getElementById("layers");

/** Strengths and residual stress of a layer or the base, for the tab *Coating*. */
export function strengths(owner, tables) {
  const box = element("details", { "data-tabs": "coating", class: "strengths" }, element("summary", {}, "Strength and residual stress"));
  for (const spec of tables.strengths) box.append(field(`${owner}.stress.${spec.name}`, spec));
  return box;
}

/** Append a layer of a kind, "" for the usual one; its names are set by `number`. */
export function addLayer(tables, kind = "") {
  const list = listed();
  const layer = element("div", { class: "layer" });
  const button = (text, label, action) => element("button", { type: "button", "aria-label": label, title: label, onclick: action }, text);
  const move = (step) => () => {
    const other = step < 0 ? layer.previousElementSibling : layer.nextElementSibling;
    if (!other) return;
    step < 0 ? other.before(layer) : other.after(layer);
    number();
    tell(list);
  };
  const handle = element("span", { class: "handle", title: "Drag to move", "aria-hidden": "true" }, "⠿");
  const bar = element("div", { class: "bar" }, handle, element("h3"), button("↑", "Move up", move(-1)), button("↓", "Move down", move(1)), button("✕", "Remove", () => {
    layer.remove();
    number();
    tell(list);
  }));
  layer.append(bar);
  const inner = element("div");
  const kinds = Object.keys(tables.layers);
  if (kinds.length > 1) {
    const choose = field("layers.0.kind", { label: "Kind", kind: "choice", value: kind, choices: kinds, words: { "": "elastic" } });
    choose.addEventListener("change", (event) => {
      if (!event.target.name.endsWith(".kind")) return;
      fill(inner, tables, event.target.value);
      number();
      tell(list);
    });
    layer.append(choose);
  }
  fill(inner, tables, kind in tables.layers ? kind : "");
  layer.append(inner, strengths("layers.0", tables));
  dragging(layer, handle);
  list.append(layer);
  return layer;
}

function fill(inner, tables, kind) {
  inner.replaceChildren();
  const extra = element("details", {}, element("summary", {}, "Interface with springs or a membrane, lift-off, moduli along z"));
  for (const spec of tables.layers[kind].fields) {
    const words = spec.name === "bonded" ? { true: "bonded", false: "sliding" } : { "": "no", true: "yes", false: "no" };
    const slides = spec.kind === "quantity" && spec.value !== "";
    (spec.value === "" ? extra : inner).append(field(`layers.0.${spec.name}`, { ...spec, words, slides, fits: FITTED.includes(spec.name) }));
  }
  inner.append(extra);
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
    tell(layer);
  });
}

/** Name the fields of all layers by their order. */
export function number() {
  document.querySelectorAll("#layers .layer").forEach((layer, i) => {
    layer.querySelector("h3").textContent = i ? `Layer ${i + 1}` : "Layer 1, at the surface";
    for (const box of layer.querySelectorAll("[name], [data-name]")) {
      for (const key of ["name", "data-name"]) {
        if (box.hasAttribute(key)) box.setAttribute(key, box.getAttribute(key).replace(/^(layers)\.\d+/, `$1.${i}`));
      }
    }
    for (const box of layer.querySelectorAll("[id], [for], [aria-describedby]")) {
      for (const key of ["id", "for", "aria-describedby"]) {
        if (box.hasAttribute(key)) box.setAttribute(key, box.getAttribute(key).replace(/^(layers)-\d+/, `$1-${i}`));
      }
    }
  });
}

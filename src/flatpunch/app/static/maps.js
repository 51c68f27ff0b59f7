// Maps of numbers: outlines in the plane, sections through the layers, cells over two values.

import { Axis, draw, frame, legend, node, path, quantity, readable, ticks, word } from "./charts.js";

const VIRIDIS = ["#440154", "#482878", "#3e4a89", "#31688e", "#26828e", "#1f9e89", "#35b779", "#6dcd59", "#b4de2c", "#fde725"];
const DIVERGING = ["#2166ac", "#4393c3", "#92c5de", "#d1e5f0", "#f7f7f7", "#fddbc7", "#f4a582", "#d6604d", "#b2182b"];

let clips = 0;

export const OUTLINE = { colour: "var(--three)", width: 2.2, opacity: 1 };
export const EARLIER = { ...OUTLINE, width: 1, opacity: 0.45 };

/** Outlines in the plane, with a map of values below them if there is one. outlines: [{phi, r, faint}] */
export function plane(box, spec) {
  draw(box, (svg, width) => {
    const bar = spec.map ? 92 : 14;
    const side = Math.max(120, Math.min(width - 58 - bar, 320));
    const height = side + 56;
    const area = { left: 58, right: 58 + side, top: 10, bottom: 10 + side };
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    const ends = [[-spec.half, spec.half]];
    const x = new Axis({ label: "x", unit: "m", tight: true }, ends, [area.left, area.right]);
    const y = new Axis({ label: "y", unit: "m", tight: true }, ends, [area.bottom, area.top]);
    frame(svg, area, x, y, null, { y: {} });
    const shape = (outline) => {
      const xs = outline.r.map((r, i) => (r === null ? null : r * Math.cos(outline.phi[i])));
      const ys = outline.r.map((r, i) => (r === null ? null : r * Math.sin(outline.phi[i])));
      xs.push(xs[0]);
      ys.push(ys[0]);
      return path(xs, ys, x, y);
    };
    if (spec.map) {
      // the map ends at the outline itself, not at the last of its points inside
      const id = `inside-${clips++}`;
      node("path", { d: shape(spec.outlines.at(-1)) }, node("clipPath", { id }, svg));
      const image = node("image", { x: area.left, y: area.top, width: side, height: side, preserveAspectRatio: "none", "clip-path": `url(#${id})` }, svg);
      image.setAttribute("href", picture({ ...spec.map, values: continued(spec.map.values) }));
      colourBar(svg, area, spec.map);
    }
    for (const outline of spec.outlines) {
      const look = outline.faint ? EARLIER : OUTLINE;
      node("path", { d: shape(outline), fill: "none", stroke: look.colour, "stroke-width": look.width, opacity: look.opacity }, svg);
    }
  }, spec.title);
}

/** Values over a plane through the layers, depth downwards. spec: {x, z: ends, values: rows from the surface down, faces, radius, label, unit} */
export function inside(box, spec) {
  draw(box, (svg, width) => {
    const area = { left: 58, right: width - 92, top: 10, bottom: 0 };
    const shape = (spec.z[1] - spec.z[0]) / (spec.x[1] - spec.x[0]);
    const tall = Math.min(Math.max(shape * (area.right - area.left), 140), 420);
    area.bottom = area.top + tall;
    const height = area.bottom + 42;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    const x = new Axis({ label: "x", unit: "m", tight: true }, [spec.x], [area.left, area.right]);
    const z = new Axis({ label: "z", unit: "m", tight: true }, [spec.z], [area.top, area.bottom]);
    const finite = spec.values.flat().filter((value) => value !== null);
    const [low, high] = [Math.min(...finite), Math.max(...finite)];
    const top = Math.max(high, -low) || 1;
    const map = { ...spec, top, bottom: low < 0 && high > 0 ? -top : low < 0 ? low : 0, signed: low < 0 && high > 0, down: true };
    if (!map.signed && low < 0) map.top = 0;
    const image = node("image", { x: area.left, y: area.top, width: area.right - area.left, height: tall, preserveAspectRatio: "none" }, svg);
    image.setAttribute("href", picture(map));
    frame(svg, area, x, z, null, { y: {}, plain: true });
    for (const face of spec.faces) node("line", { x1: area.left, x2: area.right, y1: z.at(face), y2: z.at(face), stroke: "#fff", "stroke-width": 1.2, "stroke-dasharray": "7 4" }, svg);
    if (spec.radius) node("line", { x1: x.at(-spec.radius), x2: x.at(spec.radius), y1: area.top, y2: area.top, stroke: "var(--three)", "stroke-width": 5 }, svg);
    colourBar(svg, area, map);
  }, spec.title);
}

/** Colours of kinds. */
export const KINDS = ["#5aa9d6", "#e08b2d", "#6fae5a", "#c96a76", "#9a7fc0", "#a59a8c"];

/** A number for each pair of two values, coloured by kind. spec: {x, y: axes, columns, rows: their values, values, places, unit} */
export function cells(box, spec) {
  const kinds = [...new Set(spec.places.flat())];
  draw(box, (svg, width) => {
    const height = Math.min(480, Math.max(220, 34 * spec.rows.length + 60));
    const area = { left: 64, right: width - 14, top: 10, bottom: height - 42 };
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    const [wide, tall] = [(area.right - area.left) / spec.columns.length, (area.bottom - area.top) / spec.rows.length];
    spec.columns.forEach((column, i) => {
      spec.rows.forEach((row, j) => {
        const [px, py] = [area.left + i * wide, area.bottom - (j + 1) * tall];
        const kind = spec.places[i][j];
        const said = spec.values[i][j] === null ? "none" : quantity(spec.values[i][j], spec.unit, 3);
        const cell = node("rect", { x: px, y: py, width: wide, height: tall, fill: KINDS[kinds.indexOf(kind) % KINDS.length], stroke: "var(--card)" }, svg);
        node("title", {}, cell, `${spec.x.label} ${quantity(column, spec.x.unit)}, ${spec.y.label} ${quantity(row, spec.y.unit)}: ${said}, ${kind}`);
        if (wide > 46 && tall > 15) node("text", { class: "in-cell", x: px + wide / 2, y: py + tall / 2 + 4, "text-anchor": "middle" }, svg, said);
      });
    });
    const every = Math.ceil(62 / wide);
    const [x, y] = [spec.columns, spec.rows].map((values, k) => readable(Math.max(...values.map(Math.abs)), k ? spec.y.unit : spec.x.unit));
    spec.columns.forEach((value, i) => i % every === 0 && node("text", { x: area.left + (i + 0.5) * wide, y: area.bottom + 16, "text-anchor": "middle" }, svg, word(value * x[0])));
    const skip = Math.ceil(16 / tall);
    spec.rows.forEach((value, j) => j % skip === 0 && node("text", { x: area.left - 7, y: area.bottom - (j + 0.5) * tall + 4, "text-anchor": "end" }, svg, word(value * y[0])));
    const named = (axis, unit) => (unit ? `${axis.label} (${unit})` : axis.label);
    node("text", { x: (area.left + area.right) / 2, y: area.bottom + 35, "text-anchor": "middle" }, svg, named(spec.x, x[1]));
    node("text", { transform: `translate(14 ${(area.top + area.bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, svg, named(spec.y, y[1]));
  }, spec.title);
  legend(box, kinds.map((kind, i) => ({ label: kind, square: true, colour: KINDS[i % KINDS.length] })));
}

/** Values with those beside an edge continued by one point, the mean of their neighbours. */
function continued(values) {
  const around = [-1, 0, 1];
  return values.map((row, i) =>
    row.map((value, j) => {
      if (value !== null) return value;
      const near = around.flatMap((di) => around.map((dj) => values[i + di]?.[j + dj] ?? null)).filter((each) => each !== null);
      return near.length ? near.reduce((sum, each) => sum + each, 0) / near.length : null;
    }),
  );
}

function picture({ values, top, bottom, signed, down }) {
  const [tall, wide] = [values.length, values[0].length];
  const canvas = document.createElement("canvas");
  canvas.width = wide;
  canvas.height = tall;
  const context = canvas.getContext("2d");
  const pixels = context.createImageData(wide, tall);
  const low = Math.min(0, bottom);
  for (let row = 0; row < tall; row++) {
    for (let column = 0; column < wide; column++) {
      const value = values[down ? row : tall - 1 - row][column];
      const [r, g, b] = value === null ? [0, 0, 0] : colour((value - low) / (top - low), signed);
      pixels.data.set([r, g, b, value === null ? 0 : 255], 4 * (row * wide + column));
    }
  }
  context.putImageData(pixels, 0, 0);
  return canvas.toDataURL();
}

function colour(share, signed = false) {
  const scale = signed ? DIVERGING : VIRIDIS;
  const place = Math.min(Math.max(share, 0), 1) * (scale.length - 1);
  const i = Math.min(Math.floor(place), scale.length - 2);
  const parts = [scale[i], scale[i + 1]].map((hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)));
  return parts[0].map((value, k) => Math.round(value + (place - i) * (parts[1][k] - value)));
}

function colourBar(svg, area, { top, bottom, label, unit, signed }) {
  const low = Math.min(0, bottom);
  const [factor, prefixed] = readable(Math.max(Math.abs(top), Math.abs(low)), unit);
  const left = area.right + 14;
  const tall = area.bottom - area.top;
  for (let i = 0; i < 60; i++) {
    const [r, g, b] = colour(i / 59, signed);
    node("rect", { x: left, y: area.bottom - ((i + 1) * tall) / 60, width: 14, height: tall / 60 + 0.5, fill: `rgb(${r},${g},${b})` }, svg);
  }
  for (const value of ticks(low * factor, top * factor)) {
    const py = area.bottom - ((value / factor - low) / (top - low)) * tall;
    node("text", { x: left + 19, y: py + 4 }, svg, word(value));
  }
  node("text", { transform: `translate(${left + 70} ${(area.top + area.bottom) / 2}) rotate(90)`, "text-anchor": "middle" }, svg, prefixed ? `${label} (${prefixed})` : label);
}

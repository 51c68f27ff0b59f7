// Pictures of numbers, as SVG: lines over an axis, maps, sections to scale. Colours come from the style sheet.

const SVG = "http://www.w3.org/2000/svg";
const PREFIXES = { "-18": "a", "-15": "f", "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T" };

/** Factor and unit that bring `largest` between 1 and 1000: 3.2e-7 m reads 320 nm. */
export function readable(largest, unit) {
  if (!Number.isFinite(largest) || largest === 0 || unit === "" || unit === "%") return [1, unit];
  const power = unit === "m^2" ? 2 : 1;
  let exponent = 3 * Math.floor(Math.log10(Math.abs(largest)) / (3 * power) + 1e-9);
  exponent = Math.min(Math.max(exponent, -18), unit === "s" ? 0 : 12);
  return [10 ** (-exponent * power), (PREFIXES[exponent] + unit).replace("^2", "²")];
}

/** Numbers with a true minus sign in the place of a hyphen. */
export const minus = (text) => String(text).replace(/(^|[\s(]|e)-(?=\d)/g, "$1\u2212");

/** A quantity as people read it. */
export function quantity(value, unit, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const [factor, prefixed] = readable(value, unit);
  return minus(`${Number((value * factor).toPrecision(digits))} ${prefixed}`.trim());
}

export function node(name, attributes, parent, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

function largestOf(lists) {
  let largest = 0;
  for (const list of lists) for (const value of list) if (value !== null && Math.abs(value) > largest) largest = Math.abs(value);
  return largest;
}

/** Round numbers from `low` to `high`. */
export function ticks(low, high, count = 5) {
  const raw = (high - low) / count;
  if (!(raw > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].find((each) => each * power >= raw * 0.999) * power;
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return found;
}

function logTicks(low, high) {
  const found = [];
  const wide = Math.log10(high / low);
  for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); e++) {
    for (const m of wide > 4 ? [1] : wide > 1.5 ? [1, 3] : [1, 2, 5]) {
      const value = m * 10 ** e;
      if (value >= low * 0.999 && value <= high * 1.001) found.push(value);
    }
  }
  return found;
}

export const word = (value) => minus(String(Number(value.toPrecision(3))));

export class Axis {
  constructor(spec, lists, pixels) {
    const [factor, unit] = readable(largestOf(lists), spec.unit ?? "");
    Object.assign(this, { factor, unit, log: Boolean(spec.log), label: spec.label });
    let low = Infinity;
    let high = -Infinity;
    for (const list of lists) {
      for (const value of list) {
        if (value === null || (this.log && value <= 0)) continue;
        low = Math.min(low, value * factor);
        high = Math.max(high, value * factor);
      }
    }
    if (!(low <= high)) [low, high] = this.log ? [0.1, 1] : [0, 1];
    if (!this.log) {
      if (spec.zero !== false) [low, high] = [Math.min(low, 0), Math.max(high, 0)];
      if (low === high) high = low + 1;
      const pad = 0.04 * (high - low);
      low = low === 0 || spec.tight ? low : low - pad;
      high = high === 0 || spec.tight ? high : high + pad;
    } else {
      const pad = low === high ? 2 : (high / low) ** 0.03;
      [low, high] = [low / pad, high * pad];
    }
    Object.assign(this, { low, high, pixels });
  }

  at(value) {
    if (value === null || value === undefined || (this.log && value <= 0)) return null;
    const scaled = value * this.factor;
    const share = this.log ? Math.log(scaled / this.low) / Math.log(this.high / this.low) : (scaled - this.low) / (this.high - this.low);
    return this.pixels[0] + share * (this.pixels[1] - this.pixels[0]);
  }

  get ticks() {
    return this.log ? logTicks(this.low, this.high) : ticks(this.low, this.high);
  }

  get title() {
    return this.unit ? `${this.label} (${this.unit})` : this.label;
  }
}

export function path(xs, ys, x, y) {
  let d = "";
  let pen = "M";
  for (let i = 0; i < xs.length; i++) {
    const [px, py] = [x.at(xs[i]), y.at(ys[i])];
    if (px === null || py === null || !Number.isFinite(px) || !Number.isFinite(py)) {
      pen = "M";
      continue;
    }
    d += `${pen}${px.toFixed(2)} ${py.toFixed(2)}`;
    pen = "L";
  }
  return d;
}

let clips = 0;

/** Lines over an axis. series: [{x, y, colour, label, dash, points, right, band: [low, high], width}]; marker: {x, ys: [{y, right}]}. */
export function lines(box, spec) {
  draw(box, (svg, width) => {
    const height = spec.height ?? 270;
    const right = spec.series.some((each) => each.right);
    const area = { left: 58, right: width - (right ? 58 : 14), top: 10, bottom: height - 42 };
    const own = spec.series.filter((each) => !each.right);
    const x = new Axis(spec.x, spec.series.map((each) => each.x), [area.left, area.right]);
    const y = new Axis(spec.y, own.flatMap((each) => [each.y, ...(each.band ?? [])]), [area.bottom, area.top]);
    const second = right ? new Axis(spec.right, spec.series.filter((each) => each.right).map((each) => each.y), [area.bottom, area.top]) : null;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    frame(svg, area, x, y, second, spec);
    const id = `clip-${clips++}`;
    node("rect", { x: area.left, y: area.top, width: area.right - area.left, height: area.bottom - area.top }, node("clipPath", { id }, svg));
    const inside = node("g", { "clip-path": `url(#${id})` }, svg);
    for (const each of spec.series) {
      const scale = each.right ? second : y;
      if (each.band) {
        const there = path(each.x, each.band[1], x, scale);
        const back = path([...each.x].reverse(), [...each.band[0]].reverse(), x, scale);
        node("path", { d: `${there}${back.replace("M", "L")}Z`, fill: each.colour, opacity: 0.2, stroke: "none" }, inside);
      }
      if (each.points) {
        for (let i = 0; i < each.x.length; i++) {
          const [px, py] = [x.at(each.x[i]), scale.at(each.y[i])];
          if (px !== null && py !== null) node("circle", { cx: px.toFixed(1), cy: py.toFixed(1), r: each.points, fill: each.colour, opacity: 0.6 }, inside);
        }
      }
      if (each.points && !each.joined) continue;
      const d = path(each.x, each.y, x, scale);
      node("path", { d, fill: "none", stroke: each.colour, "stroke-width": each.width ?? 2, "stroke-dasharray": each.dash ?? "none", "stroke-linejoin": "round" }, inside);
      if (each.x.length === 1) node("circle", { cx: x.at(each.x[0]), cy: scale.at(each.y[0]), r: 4, fill: each.colour }, inside);
    }
    if (spec.marker) {
      const px = x.at(spec.marker.x);
      if (px !== null) {
        node("line", { x1: px, x2: px, y1: area.top, y2: area.bottom, stroke: "var(--grey)", "stroke-dasharray": "3 3" }, svg);
        for (const { y: value, right: onRight, colour } of spec.marker.ys) {
          const py = (onRight ? second : y).at(value);
          if (py !== null && Number.isFinite(py)) node("circle", { cx: px, cy: py, r: 4.5, fill: colour, stroke: "var(--card)", "stroke-width": 1.5 }, svg);
        }
      }
    }
  }, spec.title);
  legend(box, spec.series);
}

export function frame(svg, area, x, y, second, spec) {
  for (const value of x.ticks) {
    const px = x.at(value / x.factor);
    if (!spec.plain) node("line", { class: "rule", x1: px, x2: px, y1: area.top, y2: area.bottom }, svg);
    node("text", { x: px, y: area.bottom + 16, "text-anchor": "middle" }, svg, word(value));
  }
  for (const value of y.ticks) {
    const py = y.at(value / y.factor);
    if (!spec.plain) node("line", { class: "rule", x1: area.left, x2: area.right, y1: py, y2: py }, svg);
    node("text", { x: area.left - 7, y: py + 4, "text-anchor": "end" }, svg, word(value));
  }
  const middle = (area.top + area.bottom) / 2;
  if (second) {
    for (const value of second.ticks) node("text", { x: area.right + 7, y: second.at(value / second.factor) + 4 }, svg, word(value));
    node("text", { transform: `translate(${area.right + 50} ${middle}) rotate(90)`, "text-anchor": "middle" }, svg, second.title).style.fill = spec.right.colour ?? "";
  }
  node("path", { class: "axis", d: `M${area.left} ${area.top}V${area.bottom}H${area.right}${second ? `V${area.top}` : ""}` }, svg);
  node("text", { x: (area.left + area.right) / 2, y: area.bottom + 35, "text-anchor": "middle" }, svg, x.title);
  node("text", { transform: `translate(14 ${middle}) rotate(-90)`, "text-anchor": "middle" }, svg, y.title).style.fill = spec.y.colour ?? "";
}

/** Layers, base and tip to one scale. */
export function section(box, spec) {
  draw(box, (svg, width) => {
    const height = 300;
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    const total = spec.layers.reduce((sum, layer) => sum + layer.thickness, 0);
    const above = 70;
    const wanted = Math.max(1.25 * total, total > 0 ? 0 : 3 * spec.radius);
    const scale = Math.min((height - above) / wanted, width / (3.6 * spec.radius || wanted));
    const deep = (height - above) / scale;
    const surface = above;
    let z = 0;
    spec.layers.forEach((layer, i) => {
      const top = surface + z * scale;
      const thick = layer.thickness * scale;
      node("rect", { x: 0, y: top, width, height: Math.max(thick, 0.75), fill: i % 2 ? "var(--layer-b)" : "var(--layer-a)" }, svg);
      z += layer.thickness;
      node("line", { x1: 0, x2: width, y1: surface + z * scale, y2: surface + z * scale, stroke: "var(--faint)", "stroke-dasharray": layer.bonded ? "none" : "6 5" }, svg);
    });
    node("rect", { x: 0, y: surface + z * scale, width, height: height - surface - z * scale, fill: "var(--base)" }, svg);
    const { x, height: rise } = spec.tip;
    const tip = x.map((value, i) => [width / 2 + value * scale, surface + (spec.depth - rise[i]) * scale]);
    const edges = [`${tip[tip.length - 1][0]} -10`, `${tip[0][0]} -10`];
    node("path", { d: `M${tip.map((p) => p.map((v) => v.toFixed(2)).join(" ")).join("L")}L${edges.join("L")}Z`, fill: "var(--tip)", opacity: 0.75 }, svg);
    node("line", { x1: 0, x2: width, y1: surface, y2: surface, stroke: "var(--ink)", "stroke-width": 1.2 }, svg);
    const contact = spec.radius * scale;
    node("line", { x1: width / 2 - contact, x2: width / 2 + contact, y1: surface, y2: surface, stroke: "var(--three)", "stroke-width": 3 }, svg);
    let last = -100;
    z = 0;
    for (const layer of [...spec.layers, { label: spec.base, thickness: deep - total }]) {
      const py = Math.min(surface + (z + layer.thickness / 2) * scale + 4, height - 6);
      z += layer.thickness;
      if (py - last < 13) continue;
      last = py;
      node("text", { x: 8, y: py }, svg, layer.label);
    }
    const third = width / scale / 3;
    const power = 10 ** Math.floor(Math.log10(third));
    const length = power * [5, 2, 1].find((each) => each * power <= third);
    const bar = length * scale;
    node("path", { d: `M${width - 12 - bar} ${height - 26}v-8m0 4H${width - 12}m0 -4v8`, fill: "none", stroke: "var(--ink)", "stroke-width": 1.2 }, svg);
    node("text", { x: width - 12, y: height - 10, "text-anchor": "end" }, svg, quantity(length, "m", 3));
  }, spec.title);
}

export function draw(box, paint, title) {
  box.classList.add("chart");
  const again = () => {
    const svg = node("svg", { role: "img", "aria-label": title ?? "" });
    paint(svg, Math.max(box.clientWidth, 240));
    box.querySelector(":scope > svg")?.remove();
    box.prepend(svg);
  };
  again();
  box.observer?.disconnect();
  let width = box.clientWidth;
  box.observer = new ResizeObserver(() => {
    if (Math.abs(box.clientWidth - width) < 2) return;
    width = box.clientWidth;
    again();
  });
  box.observer.observe(box);
}

export function legend(box, series) {
  box.querySelector(":scope > .legend")?.remove();
  const named = series.filter((each) => each.label);
  if (!named.length) return;
  const list = document.createElement("div");
  list.className = "legend";
  for (const each of named) {
    const entry = document.createElement("span");
    const sample = node("svg", { viewBox: "0 0 26 10", "aria-hidden": "true" }, entry);
    if (each.square) node("rect", { x: 6, y: 0, width: 14, height: 10, fill: each.colour }, sample);
    else if (each.points && !each.joined) node("circle", { cx: 13, cy: 5, r: Math.max(each.points, 2.5), fill: each.colour }, sample);
    else node("line", { x1: 0, x2: 26, y1: 5, y2: 5, stroke: each.colour, "stroke-width": each.width ?? 2, "stroke-dasharray": each.dash ?? "none" }, sample);
    entry.append(each.label);
    list.append(entry);
  }
  box.append(list);
}

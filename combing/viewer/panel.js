// A panel with axes, curves and a line that marks where the scrubber is.
const SVG = "http://www.w3.org/2000/svg";
const EDGE = { left: 52, right: 12, top: 10, bottom: 34 };

function drawn(parent, name, attributes, text) {
  const made = parent.appendChild(document.createElementNS(SVG, name));
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function ticks([low, high]) {
  const rough = (high - low) / 5;
  const unit = 10 ** Math.floor(Math.log10(rough));
  const step = unit * [1, 2, 5, 10].find((k) => k * unit >= rough);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-12); k++) found.push(k * step);
  return found.map((value) => [value, Number(value.toPrecision(6)).toString()]);
}

function range(values) {
  const all = values.filter(Number.isFinite);
  const low = all.reduce((a, b) => Math.min(a, b), 0);
  const high = all.reduce((a, b) => Math.max(a, b), 0);
  return [low, high > low ? high + 0.05 * (high - low) : low + 1];
}

class Panel {
  constructor(parent, { x, y, xLabel, yLabel, rest }) {
    Object.assign(this, { x, y, xLabel, yLabel, rest });
    this.curves = new Map();
    this.marks = new Map();
    this.svg = drawn(parent, "svg", {});
  }

  across(value) {
    return EDGE.left + ((value - this.x[0]) / (this.x[1] - this.x[0])) * (this.width - EDGE.left - EDGE.right);
  }

  up(value) {
    const inner = this.height - EDGE.top - EDGE.bottom;
    return EDGE.top + (1 - (value - this.y[0]) / (this.y[1] - this.y[0])) * inner;
  }

  // Lay everything out anew, in the room that there is.
  fit() {
    this.width = Math.max(this.svg.clientWidth, 120);
    this.height = Math.max(this.svg.clientHeight, 100);
    this.svg.replaceChildren();
    const [left, right] = [this.across(this.x[0]), this.across(this.x[1])];
    const [bottom, top] = [this.up(this.y[0]), this.up(this.y[1])];
    drawn(this.svg, "path", { class: "frame", d: `M${left} ${top}H${right}V${bottom}H${left}Z` });
    for (const [value, text] of ticks(this.x)) {
      drawn(this.svg, "path", { class: "frame", d: `M${this.across(value)} ${bottom}v-4` });
      drawn(this.svg, "text", { x: this.across(value), y: bottom + 14, "text-anchor": "middle" }, text);
    }
    for (const [value, text] of ticks(this.y)) {
      drawn(this.svg, "path", { class: "frame", d: `M${left} ${this.up(value)}h4` });
      drawn(this.svg, "text", { x: left - 5, y: this.up(value) + 4, "text-anchor": "end" }, text);
    }
    drawn(this.svg, "text", { x: (left + right) / 2, y: this.height - 4, "text-anchor": "middle" }, this.xLabel);
    const turned = `translate(13 ${(top + bottom) / 2}) rotate(-90)`;
    drawn(this.svg, "text", { transform: turned, "text-anchor": "middle" }, this.yLabel);
    if (this.rest !== undefined) {
      drawn(this.svg, "path", { class: "rest", d: `M${left} ${this.up(this.rest)}H${right}` });
    }
    for (const [name, curve] of this.curves) this.curve(name, curve.x, curve.y, curve.colour);
    for (const [name, mark] of this.marks) this.mark(name, mark.x, mark.colour);
  }

  path(name, colour, d) {
    this.svg.querySelector(`[data-name="${name}"]`)?.remove();
    drawn(this.svg, "path", { "data-name": name, stroke: colour, d });
  }

  curve(name, x, y, colour) {
    this.curves.set(name, { x, y, colour });
    let [d, pen] = ["", "M"];
    for (let k = 0; k < x.length; k++) {
      if (!Number.isFinite(y[k])) { pen = "M"; continue; }
      d += `${pen}${this.across(x[k]).toFixed(1)} ${this.up(y[k]).toFixed(1)}`;
      pen = "L";
    }
    this.path(name, colour, d);
  }

  mark(name, x, colour) {
    this.marks.set(name, { x, colour });
    const d = Number.isFinite(x) ? `M${this.across(x)} ${this.up(this.y[0])}V${this.up(this.y[1])}` : "";
    this.path(`mark ${name}`, colour, d);
  }
}

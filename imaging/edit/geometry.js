// Polylines: arrays of [x, y] in pixels of the picture. Nothing here knows of the page.

const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1];
const cross = (a, b) => a[0] * b[1] - a[1] * b[0];
const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
const mix = (a, b, t) => [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
const back = (a) => [-a[0], -a[1]];
const last = (list) => list[list.length - 1];
const turned = (line) => line.slice().reverse();
const upright = (line) => (line[0][1] > last(line)[1] ? turned(line) : line);

function unit(a) {
  const n = Math.hypot(a[0], a[1]) || 1;
  return [a[0] / n, a[1] / n];
}

// Angle between two undirected lines, 0 to pi/2.
const between = (a, b) => Math.atan2(Math.abs(cross(a, b)), Math.abs(dot(a, b)));

function length(line) {
  let sum = 0;
  for (let i = 1; i < line.length; i++) sum += distance(line[i - 1], line[i]);
  return sum;
}

// Where a line passes nearest to a point: the place, its arclength, how far it is.
function nearest(line, point) {
  let best = { far: Infinity }, s = 0;
  for (let i = 1; i < line.length; i++) {
    const a = line[i - 1], step = minus(line[i], a), size = dot(step, step) || 1e-12;
    const t = Math.min(1, Math.max(0, dot(minus(point, a), step) / size));
    const at = mix(a, line[i], t), far = distance(at, point);
    if (far < best.far) best = { at, far, s: s + t * Math.sqrt(size) };
    s += Math.sqrt(size);
  }
  return best;
}

// The part of a line between two arclengths.
function part(line, from, to) {
  const found = [];
  let s = 0;
  for (let i = 1; i < line.length; i++) {
    const step = distance(line[i - 1], line[i]), end = s + step;
    if (end >= from && s <= to && step > 0) {
      const a = mix(line[i - 1], line[i], Math.max(0, (from - s) / step));
      const b = mix(line[i - 1], line[i], Math.min(1, (to - s) / step));
      if (!found.length) found.push(a);
      if (distance(last(found), b) > 1e-6) found.push(b);
    }
    s = end;
  }
  return found;
}

function pointAt(line, s) {
  let left = Math.max(0, s);
  for (let i = 1; i < line.length; i++) {
    const step = distance(line[i - 1], line[i]);
    if (left <= step && step > 0) return mix(line[i - 1], line[i], left / step);
    left -= step;
  }
  return last(line);
}

// Direction at an arclength, by a chord that reaches `half` to both sides.
const directionAt = (line, s, half) =>
  unit(minus(pointAt(line, s + half), pointAt(line, s - half)));

function evenly(line, step) {
  const many = Math.max(2, Math.round(length(line) / step) + 1), found = [line[0]];
  let i = 1, left = length(line) / (many - 1), from = line[0];
  const wanted = left;
  while (i < line.length && found.length < many - 1) {
    const far = distance(from, line[i]);
    if (far >= left) {
      from = mix(from, line[i], left / (far || 1));
      found.push(from);
      left = wanted;
    } else {
      left -= far;
      from = line[i++];
    }
  }
  found.push(last(line));
  return found;
}

// Share of a line's length within `near` of another line.
function shareAlong(line, other, near) {
  const points = evenly(line, Math.max(2, near / 3));
  return points.filter((p) => nearest(other, p).far <= near).length / points.length;
}

// Mean distance of a line from another.
function apart(line, other) {
  const points = evenly(line, 5);
  return points.reduce((sum, p) => sum + nearest(other, p).far, 0) / points.length;
}

// Where two lines cross.
function meetings(one, other) {
  const found = [];
  for (let i = 1; i < one.length; i++) {
    const p = one[i - 1], r = minus(one[i], p);
    for (let j = 1; j < other.length; j++) {
      const q = other[j - 1], s = minus(other[j], q), d = cross(r, s);
      if (!d) continue;
      const t = cross(minus(q, p), s) / d, u = cross(minus(q, p), r) / d;
      if (t >= 0 && t < 1 && u >= 0 && u < 1) found.push(mix(p, one[i], t));
    }
  }
  return found;
}

// Fewer points, none farther than `off` from the line (Douglas and Peucker).
function simplified(line, off) {
  if (line.length < 3) return line;
  const chord = minus(last(line), line[0]), size = Math.hypot(...chord);
  let worst = 0, at = 0;
  for (let i = 1; i < line.length - 1; i++) {
    const from = minus(line[i], line[0]);
    const far = size > 1e-9 ? Math.abs(cross(from, chord)) / size : Math.hypot(...from);
    if (far > worst) [worst, at] = [far, i];
  }
  if (worst <= off) return [line[0], last(line)];
  return simplified(line.slice(0, at + 1), off).slice(0, -1)
    .concat(simplified(line.slice(at), off));
}

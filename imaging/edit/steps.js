// What a hand says, done to strands and crossings. Each step leads from one state to the next, so
// that undo is to do all but the last. The program does the same with what it measures
// (imaging/correct/steps.py), and to the picture besides.

const ASKEW = (40 * Math.PI) / 180; // between a strand's direction and the one noted
const PIECE = 0.6; // of a strand's length along a line, for it to be a piece of it
const COVERED = 0.8; // of a line's length along a strand, for the two to be the same
const SAME = 0.95; // of a drawn line along a strand, for it to be drawn already

const CLOSE = 1.5; // px; of strands along a line to be deleted, those farther than twice the next stay

const APPLIED = "applied", ALREADY = "already so", MISFIT = "no longer fits";
const reach = (strand) => Math.max(6, strand.width);
const beside = (strand) => reach(strand) / 2; // farther, a line is its neighbour's
const along = (strand, s) => directionAt(strand.line, s, Math.max(2, strand.width));
const anchor = (strand, s, sign = 1) => ({
  at: rounded(pointAt(strand.line, s)),
  along: along(strand, s).map((v) => +(sign * v).toFixed(4)),
});
const rounded = (point) => point.map((v) => +v.toFixed(2));

function firstState(data) {
  const strands = data.strands.map((one, id) => ({ ...one, id, by: "" }));
  const crossings = data.crossings.map((one) => ({ ...one, by: "" }));
  return { strands, crossings, nextId: strands.length };
}

// All steps in turn; with what became of each.
function replay(state, steps) {
  const outcomes = [];
  for (const step of steps) {
    const [next, outcome = APPLIED] = DO[step.do](state, step);
    outcomes.push(outcome);
    state = next;
  }
  return { ...state, outcomes };
}

function passing(state, here) {
  let best = null, least = Infinity;
  for (const strand of state.strands) {
    const { far, s } = nearest(strand.line, here.at);
    const askew = between(along(strand, s), here.along);
    const misfit = far / reach(strand) + askew / ASKEW;
    if (far <= reach(strand) && askew <= ASKEW && misfit < least) {
      [best, least] = [{ strand, s }, misfit];
    }
  }
  return best;
}

function ending(state, end) {
  let best = null, least = Infinity;
  for (const strand of state.strands) {
    for (const isLast of [false, true]) {
      const s = isLast ? length(strand.line) : 0, point = pointAt(strand.line, s);
      const out = isLast ? along(strand, s) : back(along(strand, s));
      const far = distance(point, end.at);
      if (far <= 3 * reach(strand) && dot(out, unit(end.along)) >= Math.cos(ASKEW) && far < least) {
        [best, least] = [{ strand, isLast }, far];
      }
    }
  }
  return best;
}

// New lines in the place of old strands; crossings go with the line they lie on.
function substitute(state, old, lines, by) {
  const width = old[0].width;
  const made = lines.map((line, i) => ({ line: upright(line), width, by, id: state.nextId + i }));
  const gone = new Set(old.map((one) => one.id));
  const places = old.map((one) => state.strands.indexOf(one)).sort((a, b) => a - b);
  const strands = state.strands.filter((one) => !gone.has(one.id));
  made.forEach((one, i) => strands.splice(places[Math.min(i, places.length - 1)] +
    Math.max(0, i - places.length + 1), 0, one));
  const heir = (id, at) => {
    if (!gone.has(id)) return id;
    const parent = old.find((one) => one.id === id);
    const way = along(parent, nearest(parent.line, at).s);
    let best = null, least = 2;
    for (const one of made) {
      const { far, s } = nearest(one.line, at);
      const misfit = far / reach(one) + between(along(one, s), way);
      if (misfit < least) [best, least] = [one.id, misfit];
    }
    return best;
  };
  const crossings = state.crossings
    .map((one) => {
      const on = one.on.map((id) => heir(id, one.at));
      const over = one.over === null ? null : on[one.on.indexOf(one.over)];
      return { ...one, on, over };
    })
    .filter(({ on }) => on[0] !== null && on[1] !== null && on[0] !== on[1]);
  return { strands, crossings, nextId: state.nextId + made.length };
}

function without(state, ids) {
  return {
    ...state,
    strands: state.strands.filter((one) => !ids.has(one.id)),
    crossings: state.crossings.filter(({ on }) => !on.some((id) => ids.has(id))),
  };
}

// Add a strand and the crossings that it makes with all others.
function added(state, line) {
  const strand = { line: upright(line), width: state.width, by: "drawn", id: state.nextId };
  const crossings = state.strands.flatMap((one) =>
    meetings(one.line, strand.line)
      .map((at) => ({ at, on: [one.id, strand.id], over: null, by: "" })));
  return {
    strands: [...state.strands, strand],
    crossings: [...state.crossings, ...crossings],
    nextId: state.nextId + 1,
  };
}

const cut = (line, s) => [part(line, 0, s), part(line, s, Infinity)];

const DO = {
  delete(state, step) {
    const found = state.strands.filter((one) => shareAlong(one.line, step.line, beside(one)) >= PIECE);
    const far = found.map((one) => apart(one.line, step.line)), least = Math.min(...far);
    const gone = found.filter((_, i) => far[i] <= Math.max(CLOSE, 2 * least));
    if (!gone.length) {
      const lies = state.strands.some((one) => shareAlong(step.line, one.line, beside(one)) >= 1 - PIECE);
      return [state, lies ? MISFIT : ALREADY];
    }
    return [without(state, new Set(gone.map((one) => one.id)))];
  },

  split(state, step) {
    const found = passing(state, step.here);
    if (!found) return [state, MISFIT];
    const { strand, s } = found;
    if (Math.min(s, length(strand.line) - s) < strand.width) return [state, ALREADY];
    return [substitute(state, [strand], cut(strand.line, s), "split")];
  },

  join(state, step) {
    const [a, b] = [ending(state, step.from), ending(state, step.to)];
    if (!a || !b) {
      const [p, q] = [passing(state, step.from), passing(state, step.to)];
      return [state, p && q && p.strand === q.strand ? ALREADY : MISFIT];
    }
    if (a.strand === b.strand) return [state, MISFIT];
    const first = a.isLast ? a.strand.line : turned(a.strand.line);
    const second = b.isLast ? turned(b.strand.line) : b.strand.line;
    return [substitute(state, [a.strand, b.strand], [[...first, ...step.through, ...second]], "joined")];
  },

  exchange(state, step) {
    const ways = step.ways.map((way) => [passing(state, way.from), passing(state, way.to)]);
    if (ways.some(([come, go]) => !come || !go)) return [state, MISFIT];
    const [[a, b], [c, d]] = ways;
    if (a.strand === b.strand && c.strand === d.strand) return [state, ALREADY];
    const pair = [a.strand, c.strand];
    if (pair[0] === pair[1] || !pair.includes(b.strand) || !pair.includes(d.strand)) return [state, MISFIT];
    const half = ({ strand, s }) => {
      const middle = nearest(strand.line, step.at).s, [before, after] = cut(strand.line, middle);
      return s <= middle ? turned(before) : after; // from the middle outwards
    };
    const lines = ways.map(([come, go]) => [...turned(half(come)), ...half(go)]);
    const next = substitute(state, pair, lines, "exchanged");
    const ids = [next.nextId - 2, next.nextId - 1];
    const here = (one) => distance(one.at, step.at) < reach(pair[0]) && ids.every((id) => one.on.includes(id));
    const rest = next.crossings.filter((one) => !here(one));
    const crossed = rest.length < next.crossings.length;
    if (!crossed) rest.push({ at: step.at, on: ids, over: null, by: "" });
    return [{ ...next, crossings: rest }];
  },

  draw(state, step) {
    const found = state.strands.filter((one) => one.by !== "drawn");
    if (found.some((one) => shareAlong(step.points, one.line, beside(one)) >= SAME)) {
      return [state, ALREADY];
    }
    const pieces = found.filter((one) => shareAlong(one.line, step.points, beside(one)) >= PIECE);
    const rest = without(state, new Set(pieces.map((one) => one.id)));
    const width = pieces.length ? pieces[0].width : typicalWidth;
    return [added({ ...rest, width }, step.points)];
  },

  top(state, step) {
    const found = crossingAt(state, step);
    if (!found) return [state, MISFIT];
    const { crossing, over } = found;
    const said = { ...crossing, over: step.known ? over : null, by: "hand" };
    const crossings = state.crossings.map((one) => (one === crossing ? said : one));
    return [{ ...state, crossings }, crossing.over === said.over ? ALREADY : APPLIED];
  },

  only(state, step) {
    const same = (one, line) => Math.min(shareAlong(one.line, line, beside(one)),
      shareAlong(line, one.line, beside(one))) > COVERED;
    const kept = state.strands.filter((one) => step.lines.some((line) => same(one, line)));
    const gone = state.strands.filter((one) => !kept.includes(one)).map((one) => one.id);
    const missing = step.lines.filter((line) => !kept.some((one) => same(one, line)));
    const rest = { ...without(state, new Set(gone)), width: typicalWidth };
    return [missing.reduce((next, line) => added({ ...next, width: typicalWidth }, line), rest)];
  },
};

function crossingAt(state, step) {
  let best = null, least = Infinity;
  for (const crossing of state.crossings) {
    const far = distance(crossing.at, step.at);
    const pair = crossing.on.map((id) => state.strands.find((one) => one.id === id));
    const near = 2 * Math.max(...pair.map(reach));
    if (far > near) continue;
    const ways = pair.map((one) => along(one, nearest(one.line, crossing.at).s));
    const askew = [0, 1].map((i) => between(ways[i], step.over) + between(ways[1 - i], step.under));
    const i = askew[0] <= askew[1] ? 0 : 1;
    if (askew[i] <= 2 * ASKEW && far / near + askew[i] < least) {
      [best, least] = [{ crossing, over: crossing.on[i] }, far / near + askew[i]];
    }
  }
  return best;
}

// ---- steps as they are said of what is on the screen

const sayDelete = (strand) => ({ do: "delete", line: simplified(strand.line, 1).map(rounded) });
const saySplit = (strand, s) => ({ do: "split", here: anchor(strand, s) });
const sayDraw = (points) => ({ do: "draw", points: points.map(rounded) });

function sayTop(state, crossing, over) {
  const [a, b] = crossing.on.map((id) => state.strands.find((one) => one.id === id));
  const way = (one) => along(one, nearest(one.line, crossing.at).s).map((v) => +v.toFixed(4));
  const [top, bottom] = over === b.id ? [b, a] : [a, b];
  return { do: "top", at: rounded(crossing.at), over: way(top), under: way(bottom), known: over !== null };
}

// The two ends that are joined with the least gap and turn.
function sayJoin(one, other) {
  const ends = (strand) => [anchor(strand, 0, -1), anchor(strand, length(strand.line))];
  let best = null, least = Infinity;
  for (const from of ends(one)) {
    for (const to of ends(other)) {
      const gap = distance(from.at, to.at);
      const price = gap + one.width * 3 * (1 + dot(from.along, to.along));
      if (price < least) [best, least] = [{ do: "join", from, to, through: [] }, price];
    }
  }
  return best;
}

// Two strands that touch at a place go on as each other, each the way that turns less.
function sayExchange(a, b, at) {
  const [p, q] = [nearest(a.line, at).s, nearest(b.line, at).s];
  const same = dot(along(a, p), along(b, q)) >= 0 ? 1 : -1;
  const ahead = 4 * a.width;
  const on = (strand, s) => anchor(strand, Math.min(Math.max(s, 0), length(strand.line)));
  return {
    do: "exchange", at: rounded(at),
    ways: [
      { from: on(a, p - ahead), to: on(b, q + same * ahead) },
      { from: on(b, q - same * ahead), to: on(a, p + ahead) },
    ],
  };
}

// N-body interactions: components of the crossing graph in equal sections of the curl's axis.
function interactions(state, sections) {
  if (state.strands.length < 2) return {};
  let axis = [0, 0];
  for (const { line } of state.strands) {
    const way = unit(minus(last(line), line[0]));
    axis = [axis[0] + way[0], axis[1] + way[1]];
  }
  axis = unit(axis);
  const places = state.strands.flatMap(({ line }) => line.map((p) => dot(p, axis)));
  const low = places.reduce((a, b) => Math.min(a, b)), high = places.reduce((a, b) => Math.max(a, b));
  const counts = {};
  for (let section = 0; section < sections; section++) {
    const group = new Map();
    const root = (id) => (group.has(id) && group.get(id) !== id ? root(group.get(id)) : id);
    for (const { at, on } of state.crossings) {
      const place = Math.floor(((dot(at, axis) - low) / (high - low)) * sections);
      if (Math.min(Math.max(place, 0), sections - 1) !== section) continue;
      on.forEach((id) => group.has(id) || group.set(id, id));
      group.set(root(on[0]), root(on[1]));
    }
    const sizes = new Map();
    for (const id of group.keys()) sizes.set(root(id), (sizes.get(root(id)) || 0) + 1);
    for (const n of sizes.values()) counts[n] = (counts[n] || 0) + 1;
  }
  return counts;
}

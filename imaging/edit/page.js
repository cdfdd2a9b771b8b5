// The page: the photograph, what was measured, and a hand that corrects it.

const $ = (id) => document.getElementById(id);
const view = $("view");
const typicalWidth = data.width;
const measured = firstState(data);

let said = { ground: [], colours: [], strands: null, steps: [] }; // what is saved
let state = measured; // what it makes of the measurement
let past = [], future = [];
let mode = "select"; // select, join, draw, ground, colour
let chosen = null; // { strand, s } or { crossing }
let under = null; // the same, below the pointer
let pen = { points: [], path: [] }; // what is being drawn
let wire = null;
let savedText = null;
let box = { x: 0, y: 0, w: data.photograph.width, h: data.photograph.height };

// ---- what is said

function say(changes) {
  past.push(said);
  future = [];
  said = { ...said, ...changes };
  settle();
}

const sayStep = (step) => step && say({ steps: [...said.steps, step] });

function undo() {
  if (!past.length) return;
  future.push(said);
  said = past.pop();
  settle();
}

function redo() {
  if (!future.length) return;
  past.push(said);
  said = future.pop();
  settle();
}

function settle() {
  state = replay(measured, said.steps);
  [chosen, under] = [null, null];
  if (mode === "join") mode = "select";
  show();
}

// ---- what lies below the pointer

function pictureAt(event) {
  const frame = view.getBoundingClientRect(), scale = screenScale();
  return [
    box.x + box.w / 2 + (event.clientX - frame.left - frame.width / 2) * scale - 0.5,
    box.y + box.h / 2 + (event.clientY - frame.top - frame.height / 2) * scale - 0.5,
  ];
}

// Picture pixels to one of the screen.
function screenScale() {
  return Math.max(box.w / view.clientWidth, box.h / view.clientHeight);
}

function thingAt(point) {
  const slack = 8 * screenScale();
  let best = null, least = Math.max(ringRadius(), slack);
  for (const crossing of state.crossings) {
    const far = distance(crossing.at, point);
    if (far <= least) [best, least] = [{ crossing }, far];
  }
  return best && mode !== "join" ? best : strandAt(point, slack);
}

function strandAt(point, slack) {
  let best = null, least = Infinity;
  for (const strand of state.strands) {
    const { far, s, at } = nearest(strand.line, point);
    if (far <= Math.max(strand.width / 2, slack) && far < least) [best, least] = [{ strand, s, at }, far];
  }
  return best;
}

const ringRadius = () => 1.1 * typicalWidth;
const byId = (id) => state.strands.find((one) => one.id === id);
const number = (strand) => state.strands.indexOf(strand) + 1;

// ---- what a hand does

const ACTIONS = {
  delete: { key: "x", label: "Delete", on: "strand", act: ({ strand }) => sayStep(sayDelete(strand)) },
  split: { key: "s", label: "Split here", on: "strand", act: ({ strand, s }) => sayStep(saySplit(strand, s)) },
  join: { key: "j", label: "Join to...", on: "strand", act: () => setMode("join") },
  exchange: { key: "e", label: "Exchange", on: "both", act: (thing) => sayStep(exchangeAt(thing)) },
  swap: { key: "t", label: "Swap top", on: "crossing", act: ({ crossing }) => sayStep(swapped(crossing)) },
  unknown: { key: "u", label: "Unknown top", on: "crossing", act: ({ crossing }) => sayStep(sayTop(state, crossing, null)) },
};

const applies = (action, thing) =>
  thing && (action.on === "both" || (thing.crossing ? "crossing" : "strand") === action.on);

function swapped(crossing) {
  const [a, b] = crossing.on;
  return sayTop(state, crossing, crossing.over === a ? b : a);
}

function exchangeAt(thing) {
  if (thing.crossing) {
    const [a, b] = thing.crossing.on.map(byId);
    return sayExchange(a, b, thing.crossing.at);
  }
  const near = state.strands
    .filter((one) => one !== thing.strand)
    .map((one) => ({ one, far: nearest(one.line, thing.at).far }))
    .sort((a, b) => a.far - b.far)[0];
  if (!near || near.far > 4 * typicalWidth) return hint("no other strand is near enough to be exchanged here");
  return sayExchange(thing.strand, near.one, thing.at);
}

function act(name) {
  const thing = chosen || under;
  if (applies(ACTIONS[name], thing)) {
    chosen = thing;
    ACTIONS[name].act(thing);
  }
}

function click(point, event) {
  if (mode === "draw") return addPoint(point, event.shiftKey);
  if (mode === "ground" || mode === "colour") return nameColour(point);
  const thing = thingAt(point);
  if (mode === "join" && thing && thing.strand && chosen && thing.strand !== chosen.strand) {
    return sayStep(sayJoin(chosen.strand, thing.strand));
  }
  chosen = thing;
  setMode("select");
}

function setMode(to) {
  if (mode === "draw" && to !== "draw") pen = { points: [], path: [] };
  mode = to;
  show();
}

// ---- drawing

function addPoint(point, straight) {
  const previous = last(pen.points);
  if (previous && distance(previous, point) < 2 * screenScale()) return finish();
  const leg = previous ? legTo(point, straight) : [point];
  pen.points.push(point);
  pen.path.push(leg);
  if (wire) wire.start(point);
  pen.ahead = [];
  show();
}

const legTo = (point, straight) =>
  (wire && wire.seed && !straight ? wire.to(point) : [last(pen.points), point]);
const drawn = () => pen.path.reduce((line, leg) => [...line, ...leg.slice(line.length ? 1 : 0)], []);

function takeBack() {
  pen.points.pop();
  pen.path.pop();
  pen.ahead = [];
  if (pen.points.length && wire) wire.start(last(pen.points));
  show();
}

function finish() {
  const line = drawn();
  setMode("select");
  if (line.length > 1) sayStep(sayDraw(line));
}

// ---- colours

async function nameColour(point) {
  const key = mode === "ground" ? "ground" : "colours";
  const colour = await colourAt(point);
  if (!said[key].includes(colour)) say({ [key]: [...said[key], colour] });
}

// Median of five by five pixels of the photograph.
async function colourAt([x, y]) {
  const canvas = Object.assign(document.createElement("canvas"), { width: 5, height: 5 });
  const pencil = canvas.getContext("2d");
  pencil.drawImage(await decoded(data.picture), 2 - Math.round(x), 2 - Math.round(y));
  const rgba = pencil.getImageData(0, 0, 5, 5).data;
  const middle = (k) => Array.from({ length: 25 }, (_, i) => rgba[4 * i + k]).sort((a, b) => a - b)[12];
  return "#" + [0, 1, 2].map((k) => middle(k).toString(16).padStart(2, "0")).join("");
}

// ---- files

function fileText() {
  const { name, width, height } = data.photograph;
  const whole = { format: "combing corrections", version: 1, photograph: { name, width, height }, ...said };
  if (!whole.strands) delete whole.strands;
  return JSON.stringify(whole, null, 1) + "\n";
}

async function save() {
  const text = fileText();
  const file = data.photograph.name + ".corrections.json";
  const blob = new Blob([text], { type: "application/json" });
  if (window.showSaveFilePicker) {
    try {
      const handle = await window.showSaveFilePicker({ suggestedName: file });
      const stream = await handle.createWritable();
      await stream.write(blob);
      await stream.close();
      savedText = text;
      return hint(`saved; it is picked up when it lies beside ${data.photograph.name}`, true);
    } catch (error) {
      if (error.name === "AbortError") return hint("not saved");
    }
  }
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = file;
  link.click();
  savedText = text;
  return hint(`${file} is in your downloads: put it beside ${data.photograph.name}`, true);
}

function load(text, from) {
  let read;
  try {
    read = JSON.parse(text);
  } catch (error) {
    return hint(`${from}: not JSON (${error.message})`);
  }
  if (read.format !== "combing corrections" || read.version !== 1) {
    return hint(`${from}: not corrections of version 1`);
  }
  const size = read.photograph;
  if (size && (size.width !== data.photograph.width || size.height !== data.photograph.height)) {
    return hint(`${from}: of a photograph of ${size.width} x ${size.height} pixels, not this one`);
  }
  const { ground = [], colours = [], strands = null, steps = [] } = read;
  return say({ ground, colours, strands, steps });
}

// ---- showing

const SVG = "http://www.w3.org/2000/svg";

function element(kind, attributes, text) {
  const made = document.createElementNS(SVG, kind);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

// SVG counts from the corner of the first pixel.
const svgPoints = (line) => line.map(([x, y]) => `${(x + 0.5).toFixed(2)},${(y + 0.5).toFixed(2)}`).join(" ");
const hue = (strand) => `hsl(${(strand.id * 137.5) % 360} 90% 38%)`;
const isThing = (a, strand, crossing) => a && ((strand && a.strand === strand) || (crossing && a.crossing === crossing));
const classes = (...names) => names.filter(Boolean).join(" ");

function show() {
  showLines();
  showRings();
  showPen();
  showPanel();
  showHint();
  for (const name of ["select", "draw", "ground", "colour"]) {
    $(`mode-${name}`).classList.toggle("on", mode === name || (mode === "join" && name === "select"));
  }
  $("undo").disabled = !past.length;
  $("redo").disabled = !future.length;
  if (document.activeElement !== $("strands")) $("strands").value = said.strands || "";
}

function showLines() {
  const scale = screenScale();
  $("lines").replaceChildren(...state.strands.flatMap((strand) => {
    const mark = classes(isThing(under, strand) && "near", isThing(chosen, strand) && "chosen");
    const points = svgPoints(strand.line), [x, y] = strand.line[0];
    const ends = [strand.line[0], last(strand.line)].map((end) =>
      element("circle", { cx: end[0] + 0.5, cy: end[1] + 0.5, r: 3.5 * scale, fill: hue(strand) }));
    const row = 13 * (number(strand) % 3); // neighbours' numbers take turns
    const label = element("text", { transform: `translate(${x + 0.5} ${y + 0.5}) scale(${scale})`,
      x: 0, y: -6 - row, "text-anchor": "middle", fill: hue(strand) }, number(strand));
    return [element("polyline", { class: "halo", points }),
      element("polyline", { class: mark, points, stroke: hue(strand), "data-strand": strand.id }), ...ends, label];
  }));
}

function showRings() {
  const r = ringRadius();
  $("rings").replaceChildren(...state.crossings.map((crossing, i) => {
    const [x, y] = crossing.at.map((v) => v + 0.5);
    const ring = element("g", { "data-crossing": i, class: classes(crossing.over === null && "unknown",
      crossing.by === "hand" && "hand", isThing(under, null, crossing) && "near", isThing(chosen, null, crossing) && "chosen") });
    ring.append(element("circle", { cx: x, cy: y, r }));
    const top = byId(crossing.over);
    if (top) {
      const [dx, dy] = along(top, nearest(top.line, crossing.at).s);
      ring.append(element("line", { x1: x - r * dx, y1: y - r * dy, x2: x + r * dx, y2: y + r * dy }));
    }
    return ring;
  }));
}

function showPen() {
  const parts = [element("polyline", { class: "drawn", points: svgPoints(drawn()) })];
  if (pen.ahead && pen.ahead.length > 1) parts.push(element("polyline", { class: "wire", points: svgPoints(pen.ahead) }));
  for (const [x, y] of pen.points) parts.push(element("circle", { cx: x + 0.5, cy: y + 0.5, r: 4 * screenScale() }));
  $("pen").replaceChildren(...parts);
}

function html(kind, text, properties = {}) {
  return Object.assign(document.createElement(kind), { textContent: text }, properties);
}

function showPanel() {
  showChosen();
  $("count").textContent = state.strands.length + (said.strands ? ` of ${said.strands}` : "");
  $("table").replaceChildren(interactionTable());
  $("many").textContent = said.steps.length || "";
  $("done").replaceChildren(...said.steps.map(stepItem));
  $("named").replaceChildren(...["ground", "colours"].flatMap((key) => said[key].map((colour) => namedItem(key, colour))));
  if (!$("named").childNodes.length) $("named").textContent = "none";
}

function showChosen() {
  $("chosen").replaceChildren();
  if (!chosen) return;
  const { strand, crossing } = chosen;
  const title = strand ? `strand ${number(strand)}, ${length(strand.line).toFixed(0)} px long`
    : `crossing of ${crossing.on.map((id) => number(byId(id))).join(" and ")}; on top: ` +
      (crossing.over === null ? "unknown" : number(byId(crossing.over)));
  const actions = html("div", "", { className: "actions" });
  for (const [name, action] of Object.entries(ACTIONS)) {
    if (applies(action, chosen)) {
      actions.append(html("button", action.label, { id: `do-${name}`, title: action.key.toUpperCase(), onclick: () => act(name) }));
    }
  }
  $("chosen").append(html("div", title), actions);
}

function interactionTable() {
  const counts = interactions(state, data.sections), table = html("table", "");
  const sizes = Object.keys(counts).map(Number).sort((a, b) => a - b);
  const row = (head, values) => {
    const made = html("tr", "");
    made.append(html("th", head), ...values.map((value) => html("td", value)));
    return made;
  };
  if (!sizes.length) return html("span", "no interactions");
  table.append(row("N", sizes), row("count", sizes.map((n) => counts[n])));
  table.title = `N-body interactions in ${data.sections} sections; combing photo has the last word`;
  return table;
}

function stepItem(step, i) {
  const [x, y] = step.at || (step.here || step.from || {}).at || (step.line || step.points || step.lines[0])[0];
  const what = step.do === "top" && !step.known ? "top unknown" : step.do;
  const outcome = state.outcomes[i];
  const item = html("li", `${what} at ${x.toFixed(0)}, ${y.toFixed(0)}${outcome === APPLIED ? "" : ": " + outcome}`,
    { className: outcome === MISFIT ? "misfit" : "", onclick: () => lookAt([x, y]) });
  item.append(html("button", "\u00d7", { title: "take this back", onclick: (event) => {
    event.stopPropagation();
    say({ steps: said.steps.filter((_, k) => k !== i) });
  } }));
  return item;
}

function namedItem(key, colour) {
  const item = html("div", ""), swatch = html("span", "", { className: "swatch" });
  swatch.style.background = colour;
  item.append(swatch, ` ${key === "ground" ? "ground" : "strand"} ${colour} `, html("button", "\u00d7",
    { onclick: () => say({ [key]: said[key].filter((one) => one !== colour) }) }));
  return item;
}

const HINTS = {
  select: "click a strand or a crossing",
  join: "click the strand it goes on as",
  draw: "click along the strand (Shift: straight); click its end twice, or Enter",
  ground: "click the ground",
  colour: "click strands, one of each colour",
};

function hint(text, good = false) {
  $("hint").textContent = text;
  $("hint").classList.toggle("good", good);
}

const showHint = () => hint(HINTS[mode]);

function showNotes() {
  $("notes").replaceChildren(...data.notes.map((note) => html("p", note)));
  $("contacts").replaceChildren(...data.contacts.map((line) =>
    element("polyline", { points: svgPoints(line), "stroke-width": 2 * typicalWidth })));
}

// ---- looking closer

function look(to) {
  box = to;
  view.setAttribute("viewBox", `${box.x} ${box.y} ${box.w} ${box.h}`);
  show();
}

function zoom(factor, [x, y] = [box.x + box.w / 2, box.y + box.h / 2]) {
  const w = Math.min(Math.max(box.w * factor, 30), 3 * data.photograph.width), k = w / box.w;
  look({ x: x + (box.x - x) * k, y: y + (box.y - y) * k, w, h: box.h * k });
}

function whole() {
  const { width, height } = data.photograph, rim = 0.04 * height; // for the numbers above the roots
  look({ x: -rim, y: -rim, w: width + 2 * rim, h: height + 2 * rim });
}

function lookAt([x, y]) {
  const w = Math.min(box.w, 60 * typicalWidth), h = (w * box.h) / box.w;
  look({ x: x - w / 2, y: y - h / 2, w, h });
}

// ---- pointer and keys

let press = null;

view.addEventListener("pointerdown", (event) => {
  press = { x: event.clientX, y: event.clientY, box, moved: false };
  view.setPointerCapture(event.pointerId);
});

view.addEventListener("pointermove", (event) => {
  if (press && (press.moved || Math.hypot(event.clientX - press.x, event.clientY - press.y) > 4)) {
    press.moved = true;
    view.classList.add("grab");
    const scale = screenScale();
    look({ ...press.box, x: press.box.x - (event.clientX - press.x) * scale, y: press.box.y - (event.clientY - press.y) * scale });
  } else if (!press) hover(pictureAt(event), event.shiftKey);
});

view.addEventListener("pointerup", (event) => {
  const wasClick = press && !press.moved;
  press = null;
  view.classList.remove("grab");
  view.focus();
  if (wasClick) click(pictureAt(event), event);
});

view.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoom(Math.exp(Math.sign(event.deltaY) * 0.2), pictureAt(event));
}, { passive: false });

function hover(point, straight) {
  if (mode === "draw") {
    if (pen.points.length) {
      pen.ahead = legTo(point, straight);
      showPen();
    }
    return;
  }
  const now = thingAt(point);
  const same = now && under && now.strand === under.strand && now.crossing === under.crossing;
  under = now;
  if (!same) {
    showLines();
    showRings();
  }
}

const KEYS = {
  Escape: () => { chosen = null; setMode("select"); },
  d: () => setMode("draw"), g: () => setMode("ground"), c: () => setMode("colour"),
  Enter: () => mode === "draw" && finish(),
  Backspace: () => (mode === "draw" ? takeBack() : act("delete")),
  Delete: () => act("delete"),
  h: () => view.classList.toggle("bare"),
  "+": () => zoom(0.7), "=": () => zoom(0.7), "-": () => zoom(1 / 0.7), 0: whole,
};
for (const [name, action] of Object.entries(ACTIONS)) KEYS[action.key] = () => act(name);

const CONTROL_KEYS = { z: (shift) => (shift ? redo() : undo()), y: redo, s: save };

document.addEventListener("keydown", (event) => {
  if (event.target.tagName === "INPUT") return;
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const control = event.ctrlKey || event.metaKey;
  const found = control ? CONTROL_KEYS[key] : !event.altKey && KEYS[key];
  if (!found || (event.target.tagName === "BUTTON" && key === "Enter")) return;
  event.preventDefault();
  found(event.shiftKey);
});

for (const name of ["select", "draw", "ground", "colour"]) {
  $(`mode-${name}`).onclick = () => setMode(name);
}
$("undo").onclick = undo;
$("redo").onclick = redo;
$("save").onclick = save;
$("load").onclick = () => $("file").click();
$("file").onchange = async () => {
  const [file] = $("file").files;
  if (file) load(await file.text(), file.name);
  $("file").value = "";
};
$("strands").onchange = () => say({ strands: Number($("strands").value) || null });
window.addEventListener("resize", show);
window.addEventListener("beforeunload", (event) => {
  if (past.length && savedText !== fileText()) event.preventDefault(); // "leave without saving?"
});

// ---- begin

const image = view.querySelector("image");
for (const [key, value] of Object.entries({ href: data.picture, width: data.photograph.width, height: data.photograph.height })) {
  image.setAttribute(key, value);
}
said = { ...said, ...data.corrections };
state = replay(measured, said.steps);
showNotes();
whole();
Wire.from(data.wire.picture, data.picture, data.wire.scale).then((ready) => {
  wire = ready;
  document.body.dataset.ready = "yes";
});

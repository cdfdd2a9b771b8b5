// One scrubber over all runs: strands in space, force and link density.
const { runs, maps } = JSON.parse(document.getElementById("data").textContent);
const $ = (id) => document.getElementById(id);
const combed = runs.every((run) => run.D !== undefined);
const driven = runs.every((run) => run.tine);
const INKS = runs[0].inks;

// How far a run has come at a snapshot: x = d/D, else the displacement or the time.
function progress(run) {
  if (combed) return run.displacement.map((d) => d / run.D);
  return driven ? run.displacement.map((d) => 1e3 * d) : run.time;
}

const ways = runs.map(progress);
const scrub = $("scrub");
const furthest = Math.max(...ways.map((way) => way.at(-1)));
const steps = Math.max(...ways.map((way) => way.length)) - 1;
scrub.max = steps;

const spaces = runs.map((run) => {
  const place = $("spaces").appendChild(document.createElement("div"));
  place.className = "space";
  const told = place.appendChild(document.createElement("p"));
  return { space: spaceIn(place, run), told };
});

// A browser without WebGL still shows the panels.
function spaceIn(place, run) {
  try {
    return new Space(place, run);
  } catch {
    place.append("This browser draws nothing in space (no WebGL).");
    return null;
  }
}

// Shares of a colour map at every node of every snapshot; the ends of its range, and their words.
const COLOURS = { strand: { name: "strand" } };
const bends = runs.map((run) => unpacked(run.bend));
const most = bends.reduce((top, bend) => bend.reduce((a, b) => Math.max(a, b), top), 1e-12);
COLOURS.bend = { name: "strain of bending, r κ", map: colourMap(maps.bend), values: bends, range: [0, most],
                 words: ["0", most.toPrecision(2)] };
if (combed) {
  COLOURS.link = { name: "link density, λ/λ₀", map: colourMap(maps.link),
                   values: runs.map((run) => unpacked(run.link)), range: [0, 2], words: ["0", "2"] };
}
for (const [key, { name }] of Object.entries(COLOURS)) $("colour").add(new Option(name, key));

const strandInks = INKS.map((ink) => [1, 3, 5].map((k) => parseInt(ink.slice(k, k + 2), 16) / 255));

function painter(index, snapshot) {
  const { space } = spaces[index];
  const chosen = COLOURS[$("colour").value];
  if (!chosen.values) return (node) => strandInks[space.strandOf[node] % strandInks.length];
  const [low, high] = chosen.range;
  const from = space.nodes * snapshot;
  return (node) => chosen.map((chosen.values[index][from + node] - low) / (high - low));
}

const panels = [];
if (combed) {
  const force = new Panel($("panels"), {
    x: [0, Math.max(1, furthest)], y: range(runs.flatMap((run) => run.force.F)),
    xLabel: "x = d/D", yLabel: "force F (N)",
  });
  runs.forEach((run, k) => force.curves.set(`run ${k}`, {
    x: run.force.d.map((d) => d / run.D), y: run.force.F, colour: INKS[k % INKS.length],
  }));
  const links = runs.map((run) => unpacked(run.links));
  const link = new Panel($("panels"), {
    x: range(runs.flatMap((run) => run.length).map((l) => 1e3 * l)),
    y: range(links.flatMap((one) => [...one])), rest: 1,
    xLabel: "s along the pair (mm)", yLabel: "λ/λ₀",
  });
  panels.push({ panel: force, show: showForce }, { panel: link, show: showLink(links) });
}

function showForce(panel, index, snapshot) {
  panel.mark(`run ${index}`, ways[index][snapshot], INKS[index % INKS.length]);
}

function showLink(links) {
  const places = (runs[0].links && links[0].length / runs[0].time.length) || 0;
  return (panel, index, snapshot) => {
    const [run, ink] = [runs[index], INKS[index % INKS.length]];
    const x = Array.from({ length: places }, (_, k) => (1e3 * run.length[snapshot] * k) / (places - 1));
    panel.curve(`run ${index}`, x, links[index].subarray(places * snapshot, places * (snapshot + 1)), ink);
    panel.mark(`run ${index}`, 1e3 * run.place[snapshot], ink);
  };
}

// The snapshot of a run that is nearest to where the scrubber is.
function nearest(way, target) {
  return way.reduce((best, here, k) => (Math.abs(here - target) < Math.abs(way[best] - target) ? k : best), 0);
}

function told(run, snapshot) {
  const d = run.tine ? `d = ${(1e3 * run.displacement[snapshot]).toFixed(1)} mm, ` : "";
  return `${runs.length > 1 ? `${run.title}\n` : ""}${d}t = ${run.time[snapshot].toPrecision(3)} s`;
}

function show() {
  const target = (furthest * scrub.value) / Math.max(steps, 1);
  runs.forEach((run, index) => {
    const snapshot = runs.length > 1 ? nearest(ways[index], target) : Number(scrub.value);
    spaces[index].space?.show(snapshot, painter(index, snapshot));
    spaces[index].told.textContent = told(run, snapshot);
    for (const { panel, show: showOn } of panels) showOn(panel, index, snapshot);
  });
  const here = runs.length > 1 ? target : ways[0][Number(scrub.value)];
  $("where").textContent = combed ? `x = ${here.toFixed(3)}` : driven ? `d = ${here.toFixed(1)} mm` : `t = ${here.toPrecision(3)} s`;
}

function showScale() {
  const { map, words } = COLOURS[$("colour").value];
  $("scale").style.visibility = map ? "visible" : "hidden";
  if (!map) return;
  [$("least").textContent, $("most").textContent] = words;
  const pen = $("bar").getContext("2d");
  for (let k = 0; k < 160; k++) {
    pen.fillStyle = `rgb(${map(k / 159).map((part) => Math.round(255 * part)).join(" ")})`;
    pen.fillRect(k, 0, 1, 10);
  }
}

function fit() {
  for (const { space } of spaces) space?.fit();
  for (const { panel } of panels) panel.fit();
  show();
}

let playing = null;
function play() {
  if (playing === null && Number(scrub.value) >= steps) scrub.value = 0;
  playing = playing === null ? setInterval(() => {
    if (Number(scrub.value) >= steps) return play();
    scrub.value = Number(scrub.value) + 1;
    show();
  }, Math.max(33, 8000 / (steps + 1))) : clearInterval(playing) ?? null;
  $("play").textContent = playing === null ? "\u25b6" : "\u275a\u275a";
}

$("play").addEventListener("click", play);
scrub.addEventListener("input", show);
$("colour").addEventListener("change", () => { showScale(); show(); });
window.addEventListener("resize", fit);
window.addEventListener("keydown", (event) => {
  if (event.target.closest("select, button")) return;
  const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (event.key === " ") { event.preventDefault(); play(); }
  if (step && event.target !== scrub) { scrub.value = Number(scrub.value) + step; show(); }
});
if (combed) $("colour").value = "link";
showScale();
fit();
document.body.dataset.ready = "yes";

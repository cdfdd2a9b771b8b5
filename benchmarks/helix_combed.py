"""lambda(s) on both sides of a tine: rendered combings at other pitches, views and lights.

Each picture is a moment of a simulated combing, seen from a side drawn at random, in colours, on a
cloth and in a light drawn at random; its truth is the topology of the strands in space.
"""

import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree
from tqdm import tqdm

import sim
from combing import unlinking
from combing.camera import Sensor, expose, project
from combing.render import Clamp, Tine, render
from combing.runs import tine_at
from combing.virtual_lab.photographs import CLAMP_HEIGHT, broadside, frame, smooth
from imaging import Photo, Unmeasurable, jump_across, link_before, link_jump
from imaging.helix import helix
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.sequence import mean_link
from sim.records.run import open_run
from sim.topology import common_arclength, partners

FIRST = 50_000  # seed; 40 000 to 49 999 are to develop with
COLOURS = (
    ((0.85, 0.13, 0.1), (0.1, 0.32, 0.85)),
    ((0.1, 0.5, 0.2), (0.9, 0.7, 0.1)),
    ((0.6, 0.2, 0.6), (0.2, 0.65, 0.4)),
)
SIZES = (6, 8, 11)  # px a strand radius
Mean = tuple[float, float]


def seen(
    run: sim.Run, snapshot: int, size: float, rng: np.random.Generator
) -> tuple[Photo, pd.DataFrame]:
    """Photograph a moment of a combing -> picture, and truth ``s, link, x, y`` in metres and px."""
    strands = [smooth(strand) for strand in run.strands(snapshot)]
    radius, turn = run.scene.rods[0].radius, rng.uniform(0, 2 * np.pi)
    towards = np.array([np.cos(turn), np.sin(turn), 0.0])
    if rng.random() < 0.5:
        towards = broadside(strands)
    camera = frame(strands, towards, radius / size)
    d = float(run.displacements[snapshot])
    (centre, axis), tine = tine_at(run, d), run.scene.tines[0]
    width = 2.2 * max(np.abs(strand[0, :2]).max() for strand in strands) + 0.004
    dark = rng.random() < 0.5
    ideal = render(
        strands, [radius] * 2, COLOURS[rng.integers(3)], camera,
        tine=None if snapshot == 0 else Tine(centre, axis, tine.radius, min(tine.length, 0.02)),
        clamp=Clamp(np.array([0, 0, CLAMP_HEIGHT / 2]), (width, width, CLAMP_HEIGHT)),
        background=tuple(rng.uniform(0.03, 0.12, 3) if dark else rng.uniform(0.8, 0.95, 3)),
    )  # fmt: skip
    sensor = Sensor(blur=rng.uniform(0.7, 1.4), noise=rng.uniform(0.01, 0.03),
                    uneven=rng.uniform(0, 0.4))  # fmt: skip
    photo = Photo(expose(ideal, sensor, rng=rng))
    return photo, truth_in(strands, lambda points: project(points, camera))


def truth_in(strands: Sequence[np.ndarray], to_picture) -> pd.DataFrame:
    """Link density of a pair in space and where its centreline is seen."""
    a, b = strands
    table = sim.link_density(a, b)
    turns = abs(table.attrs["total_link"])
    index, place = np.arange(len(b)), partners(a, b, turns)
    middle = 0.5 * (a + np.column_stack([np.interp(place, index, b[:, k]) for k in range(3)]))
    s, points = common_arclength(a, b, turns)[0], to_picture(middle)
    link = np.interp(s, table["s"], table["link"])
    return pd.DataFrame({"s": s, "link": link, "x": points[:, 0], "y": points[:, 1]})


def mean_between(truth: pd.DataFrame, start: float, end: float) -> Mean:
    """Mean link density of a truth between two arclengths; exact, hence an sd of 0."""
    s = np.linspace(start, end, 2001)
    return float(np.interp(s, truth["s"], truth["link"]).mean()), 0.0


def link_in_space(truth: pd.DataFrame) -> Mean:
    """Return the link density of strands before they are combed, as `first_link` has it."""
    return link_before(partial(mean_between, truth), float(truth["s"].iloc[-1]))


def errors(found: HelixMeasurement, truth: pd.DataFrame, before: Mean, exact: Mean) -> pd.DataFrame:
    """Errors over lambda_0, and their sd, of windows on both sides of the tine and of the jump.

    Windows of a pitch, a quarter of one apart, that leave out the tine's reach and the truth's last
    pitch; places are those where the photograph shows the strands.
    """
    rest, nearest = abs(exact[0]), cKDTree(truth[["x", "y"]]).query(found.axis)[1]
    pitch, end = 1 / rest, float(truth["s"].iloc[-1])
    place = partial(np.interp, xp=found.phase["s"], fp=truth["s"].to_numpy()[nearest])
    true = partial(mean_between, truth)
    reach, rows = pitch / 4, []
    spans = ("behind", 0.0, found.tine - reach), ("ahead", found.tine + reach, end - pitch)
    for side, low, high in spans:
        for start in np.arange(low, high - pitch, pitch / 4):
            mean, sd = mean_link(found, start, start + pitch)
            error = mean - true(*place([start, start + pitch]))[0]
            rows.append((side, start - found.tine, error / rest, sd / rest))
    jump = link_jump(found, before)
    there = jump_across(true, float(place(found.tine)), end, exact)
    for name, unit in (("mean behind", rest), ("mean ahead", rest), ("jump", 1.0)):
        one = name.removeprefix("mean ")
        rows.append((name, 0.0, (jump[one] - there[one]) / unit, jump[f"{one}_sd"] / unit))
    return pd.DataFrame(rows, columns=["what", "place", "error", "sd"])


def measured(run: sim.Run, snapshot: int, seed: int) -> tuple[HelixMeasurement, pd.DataFrame]:
    """Photograph a moment, measure it with the scale stated, and return it with its truth."""
    rng = np.random.default_rng(seed)
    size = float(rng.choice(SIZES))
    photo, truth = seen(run, snapshot, size, rng)
    return helix(photo, scale=size / run.scene.rods[0].radius), truth


def combed(runs: Sequence[Path], count: int, first: int) -> pd.DataFrame:
    """Errors over `count` pictures, moments of the runs in turn; a refused one gives a row."""
    tables = []
    for number in tqdm(range(count), disable=not sys.stderr.isatty()):
        path = runs[number % len(runs)]
        run, seed = open_run(path), first + number
        rng = np.random.default_rng(seed + 1_000_000)
        share = run.displacements / unlinking.combing_ends(run)
        moments = np.flatnonzero((share > 0.15) & (share < 0.6))
        exact = (unlinking.first_link(run), 0.0)
        about = {"run": path.stem, "seed": seed}
        try:
            found, truth = measured(run, int(rng.choice(moments)), seed)
        except Unmeasurable as error:
            tables.append(pd.DataFrame([about | {"what": "refused", "said": str(error)}]))
            continue
        if found.tine is None:
            tables.append(pd.DataFrame([about | {"what": "no tine"}]))
            continue
        known = float(found.phase["resolved"].mean())
        tables.append(errors(found, truth, (exact[0], 0.005 * abs(exact[0])), exact)
                      .assign(**about, resolved=known))  # fmt: skip
    return pd.concat(tables, ignore_index=True)


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """RMS, share within and share held of each kind of error."""
    rows = []
    for what, one in table.dropna(subset="error").groupby("what", sort=False):
        size = one["error"].abs()
        rows.append({"what": what, "values": len(one), "rms": np.sqrt(np.mean(size**2)),
                     "median": size.median(), "within 0.06": np.mean(size < 0.06),
                     "held": np.mean(size < 1.96 * one["sd"])})  # fmt: skip
    return pd.DataFrame(rows)


def main(runs: Sequence[Path], count: int, first: int) -> None:
    """Print the errors over lambda_0 and how many intervals hold."""
    table = combed(runs, count, first)
    print(summary(table).round(3).to_string(index=False))
    refused = table[table["what"].isin(["refused", "no tine"])]
    seen = table.groupby("seed")["resolved"].first().dropna()
    print(f"resolved {seen.mean():.0%}, at least {seen.min():.0%}; {len(refused)} not measured")
    print(refused[["run", "seed", "what"]].to_string(index=False) if len(refused) else "")

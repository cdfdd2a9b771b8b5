"""Errors and coverage of f_max, D, W and noise; of the mean band; recall and precision of events.

python benchmarks/instron_accuracy.py            # all
python benchmarks/instron_accuracy.py --logs 40  # scaling only, fewer logs
"""

import argparse
from collections.abc import Callable

import numpy as np
import pandas as pd

import instron
from instron import virtual
from instron.repeats import simultaneous_band

X = np.linspace(0, 1, 101)
FINE = np.linspace(0, 1, 5000)


def smooth(n: int, rng: np.random.Generator) -> np.ndarray:
    """Return n curves of five random modes, of true mean 0."""
    modes = np.sin(np.pi * np.outer(np.arange(1, 6), X))
    return (rng.normal(size=(n, 5)) / np.arange(1, 6)) @ modes + rng.normal(size=(n, 1)) * 0.3


def jams(n: int, rng: np.random.Generator) -> np.ndarray:
    """Return n curves with one jam, whose place scatters by half its width."""
    places = 0.5 + 0.025 * rng.standard_normal((n, 1))
    return np.exp(-(((X - places) / 0.05) ** 2)) + 0.3 * smooth(n, rng)


def coverage(n: int, draw: Callable[..., np.ndarray], trials: int = 1000) -> float:
    """Return how often the 95 % band of n repeats holds the whole true mean curve."""
    truth = draw(40_000, np.random.default_rng(0)).mean(axis=0)
    rng = np.random.default_rng(n)
    bands = (simultaneous_band(draw(n, rng), 0.95, 500, rng) for _ in range(trials))
    return sum(bool(np.all((low <= truth) & (high >= truth))) for low, high in bands) / trials


def detection(prominence: float, curves: int = 200) -> tuple[float, float]:
    """Return recall and precision for nine peaks a curve, of ``prominence`` times the noise."""
    rng = np.random.default_rng(0)
    hits = missed = false = 0
    for _ in range(curves):
        places = np.arange(0.1, 0.95, 0.1) + rng.uniform(-0.02, 0.02, 9)
        f = sum(prominence * np.exp(-(((FINE - p) / 0.012) ** 2) / 2) for p in places)
        table = pd.DataFrame({"x": FINE, "f": f + rng.standard_normal(len(FINE))})
        table.attrs["f_noise"] = 1.0
        found = instron.events(table)
        found = found.loc[found["kind"] != "plateau", "x"].to_numpy()
        near = np.abs(found[:, None] - places[None]) < 0.02
        hits += int(near.any(axis=0).sum())
        missed += int((~near.any(axis=0)).sum())
        false += int((~near.any(axis=1)).sum())
    return hits / (hits + missed), hits / max(1, hits + false)


RIG = instron.Rig(r=4.25e-4, E=2.8e9)  # averages over 1.275 mm
HEIGHT = 0.5  # N


def triangles(d: np.ndarray) -> np.ndarray:
    """Return two triangular jams, 6 and 9 mm wide at the foot, the second as high as 1."""
    tops = ((0.014, 3e-3, 0.7), (0.035, 4.5e-3, 1.0))
    return sum(h * np.clip(1 - np.abs(d - p) / half, 0, None) for p, half, h in tops)


def half_sine(d: np.ndarray) -> np.ndarray:
    """Return half a sine up to the end of combing."""
    return np.where(d < virtual.GONE, np.sin(np.pi * d / virtual.GONE), 0.0)


def truth(shape: Callable[..., np.ndarray], length: float) -> tuple[float, float, float]:
    """Return highest averaged force [N], D [m] and W [J] of a shape, in closed form where known.

    A triangle of half foot s averages to h (1 - L/4s), half a sine of length D to
    sin(pi L/2D)/(pi L/2D). The others are averaged on 100 000 places.
    """
    d = np.linspace(0, virtual.STROKE, 100_001)
    F = HEIGHT * shape(d)
    D = float(d[np.flatnonzero(RIG.end_fraction * F.max() < F)[-1]])
    inside = F[d <= D]
    W = float(np.sum(inside[1:] + inside[:-1]) * (d[1] - d[0]) / 2)
    angle = np.pi * length / (2 * virtual.GONE)
    closed = {triangles: 1 - length / (4 * 4.5e-3), half_sine: np.sin(angle) / angle}
    if shape in closed:
        return HEIGHT * float(closed[shape]), D, W
    size = round(length / (d[1] - d[0]))
    area = np.concatenate([[0], np.cumsum((F[1:] + F[:-1]) / 2)])
    return float((area[size:] - area[:-size]).max() / size), D, W


SHAPES = [virtual.hump, virtual.jams, virtual.teeth, virtual.release, triangles, half_sine]
# Name: rows, averaging length [m], sd [N], kind of noise, drift over the log [N].
SETTINGS: dict[str, tuple[int, float, float, virtual.Noise, float]] = {
    "as usual": (1500, 1.275e-3, 5e-3, virtual.white, 0),
    "5 times the rate": (7500, 1.275e-3, 5e-3, virtual.white, 0),
    "a fifth of the rate": (300, 1.275e-3, 5e-3, virtual.white, 0),
    "20 mN": (1500, 1.275e-3, 0.02, virtual.white, 0),
    "60 mN": (1500, 1.275e-3, 0.06, virtual.white, 0),
    "averaged over 0.5 mm": (1500, 0.5e-3, 0.02, virtual.white, 0),
    "averaged over 3 mm": (1500, 3e-3, 0.02, virtual.white, 0),
    "AR(1), 0.9": (1500, 1.275e-3, 0.02, virtual.lagging, 0),
    "Butterworth, 20 rows": (1500, 1.275e-3, 0.02, virtual.filtered, 0),
    "Butterworth, 60 rows": (1500, 1.275e-3, 0.02,
                             lambda n, rng: virtual.filtered(n, rng, 0.0167), 0),
    "hum": (1500, 1.275e-3, 0.02, virtual.hum, 0),
    "drift 50 mN": (1500, 1.275e-3, 5e-3, virtual.white, 0.05),
    "drift -50 mN": (1500, 1.275e-3, 5e-3, virtual.white, -0.05),
}  # fmt: skip


def measured(
    setting: tuple[int, float, float, virtual.Noise, float],
    shape: Callable[..., np.ndarray],
    seed: int,
) -> dict[str, float]:
    """Return relative errors of one log, and whether its intervals cover."""
    rows, length, sd, noise, drift = setting
    rig = RIG.model_copy(update={"average_over": length})
    log = virtual.combing(shape, rows, height=HEIGHT, sd=sd, noise=noise, rng=seed)
    log["force"] += drift * np.linspace(0, 1, rows)
    found = instron.scale(log, rig).attrs
    per_f = rig.rigidity / rig.l0**2
    F, D, W = truth(shape, length)
    return {
        "F": found["f_max"] * per_f / F - 1,
        "F covered": found["f_max_low"] * per_f <= F <= found["f_max_high"] * per_f,
        "D": found["D"] / D - 1,
        "D covered": found["D_low"] <= D <= found["D_high"],
        "W": found["W"] / W - 1,
        "noise": found["noise"] / sd - 1,
    }


def scaling(logs: int, only: str = "") -> None:
    """Print errors and coverage by setting, over ``logs`` logs of six shapes."""
    for name, setting in SETTINGS.items():
        if only not in name:
            continue
        every = [measured(setting, SHAPES[k % len(SHAPES)], k) for k in range(logs)]
        table = pd.DataFrame(every).astype(float)
        mean, rms = table.mean(), np.sqrt((table**2).mean())
        print(
            f"{name}: f_max {mean['F']:+.2%}, RMS {rms['F']:.2%}, in its interval"
            f" {mean['F covered']:.1%}; D {mean['D']:+.2%}, RMS {rms['D']:.2%}, in its interval"
            f" {mean['D covered']:.1%}; W {mean['W']:+.2%}, RMS {rms['W']:.2%};"
            f" noise {mean['noise']:+.1%}, RMS {rms['noise']:.1%}",
            flush=True,
        )


def main() -> None:
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int)
    parser.add_argument("--only", default="", help="settings with this in their name")
    options = parser.parse_args()
    scaling(options.logs or 204, options.only)
    if options.logs or options.only:
        return
    for n in (3, 4, 5, 8, 12, 20):
        print(f"95 % band of {n} repeats, true mean covered in 1000 trials: "
              f"smooth {coverage(n, smooth):.1%}, jams {coverage(n, jams):.1%}")  # fmt: skip
    for prominence in (2.0, 3.0, 5.0, 8.0):
        recall, precision = detection(prominence)
        print(f"peaks of {prominence:g} x noise: recall {recall:.3f}, precision {precision:.3f}")


if __name__ == "__main__":
    main()

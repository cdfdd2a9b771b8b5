"""The ripple of a combing's force at the passing of elements, and its first jam, over the mesh.

    PYTHONPATH=. python benchmarks/sim_ripple.py [pi1:elements_per_pitch ...]

Double helix, height 0.06 m, no friction. Ripple: rms of f less its running mean over one element's
length, from 5 to 12 mm, over the mean there. f at 10 mm: its mean over the P/6 around. Jam: highest
mean over P/6 before that first falls by a twentieth.
"""

import sys
import time

import numpy as np

import sim
from sim.march.state import rigidities

R, L0 = 4.25e-4, 0.01  # m
REACH = 0.022  # m
SCENES = [(18, 8), (18, 12), (18, 24), (24, 8), (24, 12), (24, 24), (36, 12), (36, 24)]


def combed(pi1, elements):
    """Return d [m], f, the steps and the processor time [s] of a combing."""
    whole = sim.double_helix(pi1=pi1, height=0.06, elements_per_pitch=elements, snapshots=2)
    tine = whole.tines[0]
    ends = tine.insertion + 0.5 * tine.ramp_at(tine.speed) + REACH / tine.speed
    began = time.process_time()
    run = sim.simulate(whole.model_copy(update={"duration": min(ends, whole.duration)}))
    seconds = time.process_time() - began
    log = run.force_log()
    bend, _ = rigidities(whole.rods[0].material, R)
    d, first = np.unique(log["displacement"].to_numpy(), return_index=True)
    return d, L0**2 / bend * log["force"].to_numpy()[first], run.data.attrs["steps"], seconds


def mean(d, f, low, high):
    """Return the mean of f between two places."""
    area = np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * np.diff(d))])
    return (np.interp(high, d, area) - np.interp(low, d, area)) / (high - low)


def ripple(d, f, length):
    """Return the rms of f less its mean over one element's length, over the mean of f."""
    place = np.linspace(5e-3, 12e-3, 2001)
    left = np.interp(place, d, f) - mean(d, f, place - length / 2, place + length / 2)
    return np.sqrt(np.mean(left**2)) / np.interp(place, d, f).mean()


def first_jam(d, f, window):
    """Return the highest mean of f over a window before that first falls, and where."""
    ends = np.arange(window, d[-1], window / 30)
    smooth = mean(d, f, ends - window, ends)
    highest = np.maximum.accumulate(smooth)
    fallen = np.flatnonzero((smooth < 0.95 * highest) & (ends > 5e-3))
    top = int(np.argmax(smooth[: fallen[0] if fallen.size else None]))
    return smooth[top], ends[top]


def main():
    print("| P/r | elements a pitch | ripple | f at 10 mm | first jam | at | steps | CPU |")
    for pi1, elements in [tuple(map(float, w.split(":"))) for w in sys.argv[1:]] or SCENES:
        d, f, steps, seconds = combed(pi1, elements)
        window = pi1 * R / 6
        jam, place = first_jam(d, f, window)
        at_10 = mean(d, f, 0.01 - window / 2, 0.01 + window / 2)
        part = f"{100 * ripple(d, f, pi1 * R / elements):.2f} %"
        cells = (f"{pi1:g}", f"{elements:g}", part, f"{at_10:.3f}", f"{jam:.2f}",
                 f"{1e3 * place:.1f} mm", steps)  # fmt: skip
        print("|", " | ".join(map(str, cells)), f"| {seconds:.0f} s |", flush=True)


if __name__ == "__main__":
    main()

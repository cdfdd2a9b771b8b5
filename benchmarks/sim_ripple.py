"""The ripple of a combing's force at the passing of elements, and its first jam, over the mesh.

    PYTHONPATH=. python benchmarks/sim_ripple.py [pi1 ...]

Double helix, height 0.06 m, no friction, d up to 20 mm. Ripple: rms of f less its running mean over
one element's length, from 5 to 12 mm, over the mean there. f: highest mean over 3 r before.
"""

import sys
import time

import numpy as np

import sim
from sim.state import rigidities

R, L0 = 4.25e-4, 0.01  # m
REACH = 0.02  # m


def combed(pi1, elements):
    """Return d [m], f, the steps and the processor time [s] of a combing."""
    whole = sim.double_helix(pi1=pi1, height=0.06, elements_per_pitch=elements, snapshots=2)
    tine = whole.tines[0]
    ends = tine.insertion + 0.5 * tine.ramp_at(tine.speed) + REACH / tine.speed
    began = time.process_time()
    run = sim.simulate(whole.model_copy(update={"duration": ends}))
    seconds = time.process_time() - began
    log = run.force_log()
    bend, _ = rigidities(whole.rods[0].material, R)
    d, first = np.unique(log["displacement"].to_numpy(), return_index=True)
    return d, L0**2 / bend * log["force"].to_numpy()[first], run.data.attrs["steps"], seconds


def mean(d, f, low, high):
    """Return the mean of f between two places."""
    area = np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * np.diff(d))])
    return (np.interp(high, d, area) - np.interp(low, d, area)) / (high - low)


def main():
    for pi1 in [float(word) for word in sys.argv[1:]] or [18.0, 24.0, 36.0]:
        for elements in (6, 8, 12, 18):
            d, f, steps, seconds = combed(pi1, elements)
            length, place = pi1 * R / elements, np.linspace(5e-3, 12e-3, 2001)
            left = np.interp(place, d, f) - mean(d, f, place - length / 2, place + length / 2)
            ripple = np.sqrt(np.mean(left**2)) / np.interp(place, d, f).mean()
            ends = np.arange(3 * R, d[-1], R / 10)
            smooth = mean(d, f, ends - 3 * R, ends)
            top = int(np.argmax(smooth))
            jam = f"{smooth[top]:.2f} at {1e3 * ends[top]:.1f} mm"
            cells = (f"{pi1:g}", elements, f"{100 * ripple:.2f} %", jam, steps, f"{seconds:.0f} s")
            print("|", *cells, "|", sep=" | ", flush=True)


if __name__ == "__main__":
    main()

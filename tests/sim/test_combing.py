"""Whole combings of the preset: force, link density and topology have the paper's features."""

import numpy as np
import pytest

import sim
from sim.scene.presets import NYLON_SCALED

from .ribbon import link_twist_writhe

pytestmark = pytest.mark.slow
R, HEIGHT = 4.25e-4, 0.15
SCALE = 1e-4 / (NYLON_SCALED * np.pi * R**4 / 4)  # f = l0^2 F/B
_runs = {}


def combed(pi1):
    """Return the run of a combing from one pitch below the clamp; each is made once."""
    if pi1 not in _runs:
        _runs[pi1] = sim.simulate(sim.double_helix(pi1=pi1))
    return _runs[pi1]


def smoothed(pi1, window=0.01):
    """Return x = d/D and f, averaged over `window` of x: the tooth of single pitches gone."""
    log = combed(pi1).force_log()
    x = log["displacement"].to_numpy() / log["displacement"].iloc[-1]
    f = SCALE * log["force"].to_numpy()
    moving = np.concatenate([[True], np.diff(x) > 0])
    grid = np.arange(window / 2, 1, window)
    bins = np.digitize(x[moving], np.arange(window, 1, window))
    return grid, np.array([f[moving][bins == i].mean() for i in range(len(grid))])


@pytest.mark.parametrize(("pi1", "low", "high"), [(18, 30, 60), (24, 12, 25)])
def test_a_tight_helix_rises_jams_and_drops(pi1, low, high):
    x, f = smoothed(pi1)
    peak = int(np.argmax(f))
    assert low < f[peak] < high
    first = int(np.argmax(f > 0.5 * f[peak]))
    assert x[first] < 0.2  # rises at once
    assert (np.diff(f[: first + 1]) > 0).mean() > 0.8  # and steadily
    loaded = f > 0.4 * f[peak]
    assert loaded.mean() > 0.3  # jammed over a good part of the way
    last = len(f) - 1 - int(np.argmax(loaded[::-1]))
    assert f[last + 3 :].max(initial=0.0) < 0.4 * f[peak]
    assert abs(f[-10:]).max() < 0.01 * f[peak]  # free at the end


def test_the_force_falls_with_the_pitch_and_a_loose_helix_has_no_peak_to_speak_of():
    peaks = {pi1: smoothed(pi1)[1].max() for pi1 in (18, 24, 48)}
    assert peaks[18] > 1.7 * peaks[24]
    assert peaks[48] < 0.2 * peaks[24]
    assert peaks[48] < 0.1 * peaks[18]


@pytest.mark.parametrize("pi1", [18, 24])
def test_link_density_steps_across_the_tine(pi1):
    """In every snapshot the best step of two levels is at the tine: from hardly any link to all.

    A kink ahead of the tine leaves one pitch where the strands run side by side, of the two and a
    half that are averaged. Whether one is there hangs on the last bits, thus on the processor
    (pi1 = 24: none on one, on another in 6 of 12 snapshots; in none of six perturbed runs), so
    single snapshots may lack a turn, their mean may not.
    """
    run, pitch = combed(pi1), pi1 * R
    on_the_way = (run.displacements > 0.2 * HEIGHT) & (run.displacements < 0.4 * HEIGHT)
    assert on_the_way.sum() >= 10
    levels = []
    for i in np.flatnonzero(on_the_way):
        depth = pitch + run.displacements[i]
        table = sim.link_density(*run.strands(i), resolution=pitch)
        s, turns = table["s"].to_numpy(), table["link"].to_numpy() * pitch
        step = best_step(*(v[(s > 2 * pitch) & (s < depth + 3 * pitch)] for v in (s, turns)))
        behind = turns[(s > 2 * pitch) & (s < depth - pitch)].mean()
        levels.append(turns[(s > depth + pitch / 2) & (s < depth + 3 * pitch)].mean())
        assert abs(step - depth) < 0.4 * pitch
        assert behind < 0.35
        assert turns.max() > 1.1
    assert np.mean(levels) > 0.85
    assert min(levels) > 0.5


def best_step(s, values):
    """Return where two constant levels, changing once, fit best by least squares."""
    count, total = np.arange(1, len(s)), np.cumsum(values)
    below, above = total[:-1] / count, (total[-1] - total[:-1]) / (len(s) - count)
    k = int(np.argmax(count * below**2 + (len(s) - count) * above**2))
    return (s[k] + s[k + 1]) / 2


@pytest.mark.parametrize("pi1", [18, 24, 48])
def test_link_is_twist_plus_writhe_along_a_whole_combing(pi1):
    """To rounding for every snapshot, through kinks and whirls, up to whole turns of the ribbon.

    Where strands whirl far apart, the straight line from a node to its partner may cross a strand.
    A loose helix does not whirl, and none does at first.
    """
    run = combed(pi1)
    parts = np.array([link_twist_writhe(*run.strands(i)) for i in range(len(run.times))])
    link = parts[:, 0]
    crossed = link - parts[:, 1] - parts[:, 2]
    np.testing.assert_allclose(crossed, np.round(crossed), atol=1e-6)
    quiet = run.displacements < (HEIGHT if pi1 == 48 else 0.1 * HEIGHT)
    np.testing.assert_allclose(crossed[quiet], 0, atol=1e-6)
    assert link[0] == pytest.approx(HEIGHT / (pi1 * R), abs=0.05)
    assert link[-1] < 1.5

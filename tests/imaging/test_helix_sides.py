"""Phase of strands that hang apart behind a tine, from their sides and who is in front."""

import numpy as np
import pytest
from drawn.helix import draw_helix

from imaging import Photo
from imaging.helix import helix
from imaging.helix.sides import _hidden, _phase, _scale

R = 6.0
PITCH = 18 * R
LENGTH = 7 * PITCH
TINE = 4 * PITCH
STRANDS = ((200, 40, 40), (40, 70, 190))


def wound(shape, x):
    """Give the turns a pitch at x pitches from the tine."""
    behind = {"half": 0.5 + 0 * x, "none": 0 * x, "back": 0.35 * np.cos(2 * np.pi * x / 6)}[shape]
    return np.where(x < 0, behind, 1.2) * (1 - np.exp(-((x / 0.25) ** 4)))


def drawn(shape, phase, sign):
    """Strands that part by half their radius behind a tine, and about it by three radii."""

    def radius(s):
        apart = 0.25 * (1 - np.tanh((s - TINE) / (0.2 * PITCH)))
        return R * (1 + apart + 2.2 * np.exp(-(((s - TINE) / (0.3 * PITCH)) ** 2)))

    return draw_helix(
        R, lambda s: sign * wound(shape, (s - TINE) / PITCH) / PITCH, LENGTH, helix_radius=radius,
        phase=phase, colours=STRANDS, rng=3,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("shape", "phase", "sign", "within"),
    [("half", 2.0, -1, 0.1), ("none", 1.9, 1, 0.1), ("back", 0.9, 1, 0.2)],
)
def test_link_behind_a_tine_is_that_drawn(shape, phase, sign, within):
    """Over a pitch, RMS over lambda_0, and in its intervals."""
    picture = drawn(shape, phase, sign)
    found = helix(Photo(picture.pixels), tine=(*_place(picture), 2 * R))
    table = found.phase.assign(link=found.link_density["link"], link_sd=found.link_density["sd"])
    table = table[table["resolved"] & (table["s"] < TINE - PITCH / 4)]
    assert len(table) * found.phase["s"].iloc[1] > 3.5 * PITCH
    low, high = (table["s"] - PITCH / 2).clip(lower=0), (table["s"] + PITCH / 2).clip(upper=TINE)
    phase, s = picture.truth["phi"], picture.truth["s"]
    true = (np.interp(high, s, phase) - np.interp(low, s, phase)) / (high - low) / (2 * np.pi)
    error, sides = PITCH * (table["link"] - true), table["by"] == "sides"
    assert np.sqrt(np.mean(error**2)) < within
    assert np.mean((np.abs(error) < 1.96 * PITCH * table["link_sd"])[sides]) > 0.9


def _place(picture):
    row = picture.truth.iloc[(picture.truth["s"] - TINE).abs().argmin()]
    return float(row["x"]), float(row["y"])


def test_strands_do_not_run_into_each_other():
    h, v = np.array([[0.0, 3.0, 20.0]]), np.array([[-1.0, 2.0, 5.0]])
    phi = _phase(h, v, 5.0)
    radius = np.hypot(h, h * np.tan(phi))
    assert phi[0] == pytest.approx([-np.pi / 2, np.arctan2(4, 3), np.arctan2(5, 20)])
    assert radius[0, 1] == pytest.approx(5.0)


def test_a_strand_seen_alone_hides_the_other_or_something_else_does():
    """Sides swap: a crossing. They lie apart on the same side before and after: a tine."""
    alone = np.array([0, 0, 1, 1, 0, 0, 1, 1, 0], bool)
    h = np.array([9.0, 6.0, 0, 0, -6.0, -9.0, 0, 0, -8.0])
    assert _hidden(alone, h, 5.0).tolist() == [False] * 6 + [True, True, False]


def test_the_scale_of_bends_is_that_of_integrated_white_noise():
    rng, step, scale = np.random.default_rng(1), 2.0, 3e-4
    noise = rng.normal(0, np.sqrt(scale / step), 40_000)
    h = np.cumsum(np.cumsum(noise) * step) * step
    known = np.ones(len(h), bool)
    g = step * np.arange(len(h))
    assert _scale(h, known, g, 5.0, 60.0, np.inf)[0] == pytest.approx(scale, rel=0.1)

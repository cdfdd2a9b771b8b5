"""Zero, sign and drift of a load cell."""

import numpy as np
import pytest

from instron import Rig, scale
from instron.virtual import SHAPES, combing, hump, jams, plateau, teeth

RIG = Rig(r=4.25e-4, E=2.8e9)


def drifted(shape, by, rows=3000):
    log = combing(shape, rows, sd=0.002, rng=3)
    return log.assign(force=lambda t: t["force"] + by * np.linspace(0, 1, rows))


@pytest.mark.parametrize("shape", [hump, jams, teeth, plateau])
@pytest.mark.parametrize("by", [0.12, -0.08])
def test_a_drift_is_taken_off_and_said_with_its_consequence(shape, by):
    true, found = (scale(drifted(shape, b), RIG).attrs for b in (0.0, by))
    for key in ("D", "f_max", "W"):
        assert found[key] == pytest.approx(true[key], rel=0.02)
    note = next(note for note in found["warnings"] if "start and end differ" in note)
    assert "a drift" in note
    assert "f_max" in note
    assert "W" in note


def test_a_preload_is_no_drift():
    """A start that bears load and a flat free end: the end is the zero, and that is said."""
    log = combing(plateau, 3000, sd=0.002, rng=0)
    log.loc[:400, "force"] += np.linspace(0.1, 0, 401)
    found = scale(log, RIG).attrs
    assert found["rules"]["zero"].startswith("free")
    assert any("zero = 'drift' would give" in note for note in found["warnings"])


def test_a_steady_cell_is_not_accused():
    for shape in (hump, jams, teeth, plateau):
        for seed in range(5):
            assert scale(combing(shape, 3000, sd=0.005, rng=seed), RIG).attrs["warnings"] == []


@pytest.mark.parametrize("drift", [0.05, -0.05])
@pytest.mark.parametrize("name", SHAPES)
def test_a_drift_of_a_tenth_of_the_peak_leaves_the_work_alone(name, drift):
    """The rows after combing fall or rise by it: they are the free tine's nevertheless."""
    log = combing(SHAPES[name], 1500, sd=0.005, rng=3)
    before = scale(log, RIG).attrs
    log["force"] += drift * np.linspace(0, 1, len(log))
    found = scale(log, RIG).attrs
    assert found["rules"]["zero"].startswith("drift")
    assert found["W"] == pytest.approx(before["W"], rel=0.02)
    assert found["D"] == pytest.approx(before["D"], abs=2e-4)
    assert found["f_max_low"] < before["f_max"] < found["f_max_high"]

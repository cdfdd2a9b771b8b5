import math

import pytest

from instron import Rig, RigError, load_rig


def write(tmp_path, text):
    path = tmp_path / "rig.toml"
    path.write_text(text)
    return path


def test_rigidity_of_a_round_filament(tmp_path):
    rig = load_rig(write(tmp_path, "r = 4.25e-4\nE = 2.8e9\nu_r = 0.01\nu_E = 0.03\n"))
    assert rig.rigidity == pytest.approx(math.pi / 4 * 2.8e9 * 4.25e-4**4)
    assert rig.l0 == 0.01
    # A 1 % error in r is 4 % in f.
    assert rig.relative_uncertainty == pytest.approx(0.05)


def test_an_uncertainty_that_nobody_stated_is_not_zero():
    assert math.isnan(Rig(r=1e-4, E=1e9).relative_uncertainty)
    assert Rig(r=1e-4, E=1e9, u_E=0.02).relative_uncertainty == 0.02


def test_twisting_rigidity_of_an_incompressible_wire_is_two_thirds():
    assert Rig(B=3.0).twisting == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("r = -1e-3\nE = 1e9", "r = -0.001: input should be greater than 0"),
        ("r = 1e-3\nE = 1e9\nrr = 2", "unknown key 'rr'; known are r, E, B"),
        ("r = 1e-3", "give B, or both r and E"),
        ("B = 1e-3\nE = 1e9", "either B or E"),
        ("B = 'stiff'", "B = 'stiff'"),
        ("B = nan", "B = nan"),
        ("B = 1e-3\nzero = 'sometimes'", "zero = 'sometimes'"),
        ("B = ", "not valid TOML"),
        ("r = 0.425\nE = 2.8e9", "r = 0.425 m is out of range .*: is it in mm"),
        ("r = 0.037\nE = 4e9", "r = 0.037 m is out of range .*: is it in mm"),
        ("r = 4.25e-4\nE = 2.8", "E = 2.8 Pa is out of range .*: is it in GPa"),
        ("r = 4.25e-4\nE = 2800", "E = 2800 Pa is out of range .*: is it in GPa or MPa"),
        ("B = 1e-4\npitch = 7.65", "pitch = 7.65 m is out of range"),
        ("B = 1e-4\naverage_over = 1.3", "average_over = 1.3 m is out of range"),
    ],
)
def test_wrong_rigs_are_refused_in_one_line(text, reason, tmp_path):
    with pytest.raises(RigError, match=reason) as caught:
        load_rig(write(tmp_path, text))
    assert "rig.toml" in str(caught.value)
    assert "\n" not in str(caught.value)

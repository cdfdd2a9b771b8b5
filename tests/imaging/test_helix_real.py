"""Real pairs: pipe cleaners on cardboard under a lamp, with shadows, lettering and loose fibres."""

from pathlib import Path

import numpy as np
import pytest
from drawn.helix import Light, draw_helix
from drawn.ply import draw_ply

from imaging import Photo, Unmeasurable, read_photo
from imaging.helix import helices, helix
from imaging.helix.find import find_pairs
from imaging.helix.turning import PLACES, WIDE, turning

PHOTOGRAPHS = Path(__file__).parent / "photographs"


@pytest.mark.parametrize("roi", [None, (0, 60, 1024, 640)])
def test_two_pairs_in_one_picture_are_told_apart_and_counted(roi):
    first, second = helices(read_photo(PHOTOGRAPHS / "two_pairs.jpg", roi=roi), root="left")
    assert [first.handedness, second.handedness] == ["left", "left"]
    assert len(first.crossings) == pytest.approx(30, abs=1)
    assert len(second.crossings) == pytest.approx(28, abs=1)
    assert np.abs(first.axis[:, 1].mean() - second.axis[:, 1].mean()) > 50
    for found in (first, second):
        assert found.phase["resolved"].mean() > 0.85
        assert (found.link_density["sd"].dropna() > 0).all()


def test_a_pair_beside_one_folded_and_plied_back_which_is_refused_by_name():
    pair, folded = helices(read_photo(PHOTOGRAPHS / "plied_and_plied_back.jpg"), root="left")
    assert pair.handedness == "left"
    assert 2 * abs(pair.total_link) == pytest.approx(27, abs=1)
    assert pair.phase["resolved"].mean() > 0.9
    assert isinstance(folded, Unmeasurable)
    assert "four strands" in str(folded)


def test_a_picture_in_which_nothing_winds_is_refused():
    pixels = np.full((300, 400, 3), 200, np.uint8)
    pixels[100:110], pixels[200:210] = (200, 30, 30), (30, 30, 200)
    with pytest.raises(Unmeasurable, match="wind round each other"):
        helix(Photo(pixels))


@pytest.mark.parametrize("sign", [1, -1])
def test_phase_of_a_drawn_band_is_followed(sign):
    """Sections of two tubes, R = r, P = 18 r, drawn without the program's own pictures."""
    s = np.arange(0, 90, 1 / 3)
    phi = sign * 2 * np.pi * s / 18 + 0.4
    u = np.linspace(-2 * WIDE, 2 * WIDE, PLACES)
    a = np.abs(u - np.cos(phi)[:, None]) < 1
    b = np.abs(u + np.cos(phi)[:, None]) < 1
    front = np.sin(phi)[:, None] > 0
    shown = np.stack([a & (front | ~b), b & (~front | ~a), ~a & ~b], axis=-1)
    found = turning(shown.astype(float), 1 / 3, 1.0)
    error = np.angle(np.exp(1j * (found.phi - phi)))
    assert np.abs(error).max() < 0.3
    assert found.phi[-1] - found.phi[0] == pytest.approx(phi[-1] - phi[0], abs=0.3)


@pytest.mark.parametrize(("r", "shine"), [(6.0, 0.3), (12.0, 0.4)])
def test_gloss_makes_no_four_strands_of_two_and_four_stay_four(r, shine):
    """A thick pair's highlight parts each strand in two; it was refused as four strands."""
    light = Light(highlight=shine)
    pair = draw_helix(r, lambda s: 1 / (16 * r), 5 * 16 * r, phase=4.0, light=light, rng=11)
    assert not any(found.four for found in find_pairs(Photo(pair.pixels))[0])
    assert helix(Photo(pair.pixels)).total_link == pytest.approx(4.5, abs=0.6)
    for seed in (1, 2):
        ply = draw_ply(r, np.random.default_rng(seed), light=light)
        with pytest.raises(Unmeasurable, match="four strands"):
            helix(Photo(ply))

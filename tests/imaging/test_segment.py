"""Colours are found without being told how many, in any light, on any plain ground."""

import cv2
import numpy as np
import pytest
from drawn.helix import draw_helix
from drawn.strands import Look, Picture, render

from imaging import Photo, Unmeasurable, segment, trace
from imaging.photo import bands
from imaging.segment.coverage import _without_dirt
from imaging.segment.ground import Ground, ground_of
from imaging.segment.palette import find_colours

SHAPE = (240, 320)


def parallel(count: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Wavy strands side by side, one diagonal strand on top of the others."""
    y = np.linspace(10, 230, 300)
    lines = [
        np.stack([30 + 260 * i / max(count - 2, 1) + 6 * np.sin(y / 25 + i), y], axis=1)
        for i in range(count - 1)
    ]
    lines.append(np.stack([np.linspace(15, 305, 400), np.linspace(30, 210, 400)], axis=1))
    heights = [np.full(len(line), 30.0 * (i == count - 1)) for i, line in enumerate(lines)]
    return lines, heights


def picture(colours: list[tuple[float, float, float]], look: Look, radius: float = 4) -> Picture:
    lines, heights = parallel(len(colours))
    return render(lines, heights, colours, radius, SHAPE, look=look, rng=7)


def agreement(found: np.ndarray, truth: np.ndarray) -> float:
    """Share of the labelled strand pixels whose label stands for the strand that is there."""
    both = (truth > 0) & (found > 0)
    best = sum(
        np.bincount(found[both & (truth == strand)]).max() for strand in range(1, truth.max() + 1)
    )
    return best / both.sum()


BRIGHT = [(0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8), (0.95, 0.85, 0.1)]
GREYS = [(0.02, 0.02, 0.02), (0.97, 0.97, 0.97), (0.8, 0.2, 0.2), (0.5, 0.5, 0.5)]
SCENES = {
    "on white": (BRIGHT, Look()),
    "on black": (BRIGHT, Look(background=(0.03, 0.03, 0.03))),
    "greys on green cloth": (GREYS, Look(background=(0.35, 0.55, 0.4), uneven=0.15)),
    "uneven light": (BRIGHT, Look(uneven=0.6)),
    "yellow lamp": (BRIGHT, Look(background=(0.9, 0.75, 0.5))),
    "noise": (BRIGHT, Look(noise=0.04)),
    "blur": (BRIGHT, Look(blur=1.6)),
    "highlights": (BRIGHT, Look(highlight=0.6)),
}


@pytest.mark.parametrize("scene", SCENES)
def test_colours_are_counted_and_placed(scene):
    colours, look = SCENES[scene]
    drawn = picture(colours, look)
    found = segment(Photo(drawn.pixels))
    assert len(found.colours) == len(colours)
    assert agreement(found.labels, drawn.labels) > 0.97
    core = cv2.erode((drawn.labels > 0).astype(np.uint8), np.ones((5, 5))) > 0
    near = cv2.dilate((drawn.labels > 0).astype(np.uint8), np.ones((3, 3))) > 0
    assert (found.labels[core] > 0).mean() > 0.97
    assert not found.labels[~near].any()


def test_exposure_does_not_matter():
    drawn = picture(BRIGHT, Look(uneven=0))
    dark = (drawn.pixels * 0.6).astype(np.uint8)
    a, b = segment(Photo(drawn.pixels)), segment(Photo(dark))
    assert ((a.labels > 0) != (b.labels > 0)).mean() < 0.01
    assert len(a.colours) == len(b.colours)


def test_membership_is_coverage_and_halves_at_the_edge():
    drawn = picture(BRIGHT, Look(noise=0))
    found = segment(Photo(drawn.pixels))
    assert found.membership.dtype == np.float32
    assert found.membership.shape == (len(BRIGHT), *SHAPE)
    assert found.membership.min() >= 0
    assert found.membership.sum(axis=0).max() <= 1 + 1e-5
    np.testing.assert_array_equal(found.labels > 0, found.membership.sum(axis=0) > 0.5)


@pytest.mark.parametrize("radius", [2.5, 4, 7])
def test_width_is_that_of_the_tubes_within_the_blur(radius):
    """The curve of sRGB moves the half-contrast edge by about a blur: in on white, out on black."""
    on_white = segment(Photo(picture(BRIGHT, Look(noise=0), radius).pixels)).width
    black = Look(noise=0, background=(0.03, 0.03, 0.03))
    on_black = segment(Photo(picture(BRIGHT, black, radius).pixels)).width
    assert 2 * radius - 2.2 < on_white < 2 * radius
    assert 2 * radius - 0.1 < on_black < 2 * radius + 2.2


def test_sixteen_bits_give_the_same():
    drawn = picture(BRIGHT, Look())
    deep = Photo(drawn.pixels.astype(np.uint16) * 257)
    np.testing.assert_array_equal(segment(deep).labels, segment(Photo(drawn.pixels)).labels)


def test_what_is_ignored_is_background():
    drawn = picture(BRIGHT, Look())
    ignore = np.zeros(SHAPE, bool)
    ignore[:, :100] = True
    assert not segment(Photo(drawn.pixels, ignore=ignore)).labels[:, :98].any()


@pytest.mark.parametrize("level", [0, 128, 255])
def test_a_blank_picture_is_refused(level):
    with pytest.raises(Unmeasurable, match="nothing stands out"):
        segment(Photo(np.full((*SHAPE, 3), level, np.uint8)))


def test_noise_alone_is_refused():
    noise = np.random.default_rng(0).normal(128, 5, (*SHAPE, 3)).clip(0, 255).astype(np.uint8)
    with pytest.raises(Unmeasurable):
        segment(Photo(noise))


def test_a_clamp_is_no_strand():
    drawn = picture(BRIGHT, Look())
    pixels = drawn.pixels.copy()
    pixels[:30, 40:140] = (40, 40, 45)
    found = segment(Photo(pixels))
    assert len(found.colours) == len(BRIGHT)
    assert not found.labels[3:27, 45:135].any()


@pytest.mark.parametrize("background", [(235, 235, 230), (25, 25, 25)], ids=["light", "dark"])
@pytest.mark.parametrize("radius", [4, 8, 12])
def test_two_strands_that_touch_all_along_have_two_colours(radius, background):
    """The medial axis of a twisted pair runs on the border between the two."""
    drawn = draw_helix(
        radius, lambda s: 1 / (18 * radius), 90 * radius, phase=1, background=background, rng=1
    )
    found = segment(Photo(drawn.pixels))
    truth = np.where(drawn.membership.sum(axis=0) > 0.5, drawn.membership.argmax(axis=0) + 1, 0)
    assert len(found.colours) == 2
    assert agreement(found.labels, truth) > 0.965


@pytest.mark.parametrize("radius", [20, 60])
def test_a_disc_is_no_strand(radius):
    pixels = np.full((*SHAPE, 3), 235, np.uint8)
    cv2.circle(pixels, (160, 120), radius, (20, 20, 200), -1)
    with pytest.raises(Unmeasurable, match="no strand"):
        segment(Photo(pixels))


def test_scattered_colours_are_no_colour():
    scattered = np.random.default_rng(0).uniform(-300, 300, (400, 3))
    centres, colours = find_colours(scattered, scattered, 10)
    assert centres.shape == colours.shape == (0, 3)


def test_specks_are_dropped_wherever_they_lie():
    """Against connected components: in the loop of a strand, in another speck, at a border."""
    mask = np.zeros((120, 90), np.uint8)
    cv2.circle(mask, (45, 60), 35, 1, 4)
    cv2.circle(mask, (45, 60), 5, 1, 1)
    mask[59:62, 44:47] = mask[0, 0] = mask[119, 80:] = mask[10:12, 10:12] = 1
    _, blobs, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    long = np.hypot(*stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].T) > 5 * 4.0
    long[0] = False
    np.testing.assert_array_equal(_without_dirt(mask.view(bool), 4.0), long[blobs])
    assert long.sum() == 1


def test_the_ground_in_bands_is_the_ground_interpolated_at_once():
    coarse = np.random.default_rng(5).random((17, 40, 3), np.float32)
    ground = Ground(coarse, 8000)
    found = np.concatenate([ground.rows(band) for band in bands((8000, 40))])
    np.testing.assert_allclose(found, cv2.resize(coarse, (40, 8000)), atol=1e-6)
    places = np.array([0, 3, 4321, 160_000, 319_999])
    np.testing.assert_allclose(ground.at(places), found.reshape(-1, 3)[places], atol=1e-6)


def test_a_picture_of_one_row_has_the_ground_of_its_row():
    lab = np.full((1, 50, 3), (60, 5, -8), np.float32)
    np.testing.assert_allclose(ground_of(lab).rows(slice(0, 1)), lab, atol=1e-3)


def test_a_short_strand_of_the_colour_of_a_long_one_is_kept():
    pixels = np.full((300, 500, 3), 235, np.uint8)
    pixels[40:50, 20:480] = pixels[220:230, 200:330] = (200, 40, 50)
    pixels[10:290, 260:270] = (40, 90, 200)
    strands = trace(segment(Photo(pixels)))
    assert sorted(round(len(s.line), -1) for s in strands) == [130, 280, 460]

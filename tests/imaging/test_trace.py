"""Strands through crossings, against rendered truth."""

import numpy as np
import pytest
from drawn.helix import draw_helix
from drawn.strands import Look, random_curl, render
from scipy.spatial import cKDTree

from imaging import Photo, crossings, segment, trace
from imaging.trace.centreline import resample

RED, GREEN, BLUE = (0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8)
SHAPE = (260, 320)


def traced(lines, heights, colours, look=None, radius=4.0, shape=SHAPE):
    drawn = render(lines, heights, colours, radius, shape, look=look, rng=3)
    found = segment(Photo(drawn.pixels))
    return trace(found), found


def distance(line: np.ndarray, truth: np.ndarray) -> np.ndarray:
    return cKDTree(resample(truth, 0.05)).query(line)[0]


def sine(phase: float = 0.0, height: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    y = np.linspace(20, 240, 400)
    x = 160 + 60 * np.sin(y / 35 + phase)
    return np.stack([x, y], axis=1), np.full(400, height)


@pytest.mark.parametrize(
    ("look", "limit"),
    [
        (Look(noise=0, highlight=0, ambient=1, uneven=0, blur=0.5), 0.05),
        (Look(noise=0.01, highlight=0, uneven=0), 0.15),
        (Look(noise=0.01), 0.2),
        (Look(noise=0.03, blur=1.5, highlight=0.4, uneven=0.5), 0.35),
    ],
    ids=["perfect", "shaded", "photograph", "poor photograph"],
)
def test_accuracy_ladder(look, limit):
    line, height = sine()
    strands, _ = traced([line], [height], [RED], look)
    assert len(strands) == 1
    error = distance(strands[0].line, line)
    assert np.sqrt((error[10:-10] ** 2).mean()) < limit


def test_two_strands_swap_over_and_under():
    (a, za), (b, zb) = sine(), sine(phase=np.pi)
    zb = 20 * np.cos(np.pi * b[:, 1] / 110)  # below at the first crossing, above at the second
    strands, found = traced([a, b], [za, zb], [RED, GREEN])
    assert len(strands) == 2
    table = crossings(strands, found)
    order = [int(np.argmin([distance(s.line, t).mean() for s in strands])) + 1 for t in (a, b)]
    truth = crossings([a, b])
    assert len(table) == len(truth) == 2
    np.testing.assert_allclose(np.sort(table["y"]), np.sort(truth["y"]), atol=1.0)
    assert table.sort_values("y")["over"].tolist() == [order[0], order[1]]
    assert table["confidence"].min() > 0.75


def test_loop_is_one_strand_that_crosses_itself():
    t = np.linspace(-1.6, 1.6, 500)
    line = np.stack([160 + 50 * (t**3 - t), 130 + 50 * (t**2 - 1)], axis=1)
    assert 10 < line.min() < line[:, 0].max() < 310
    strands, found = traced([line], [np.linspace(0, 40, len(line))], [BLUE])
    assert len(strands) == 1
    table = crossings(strands, found)
    assert table["kind"].tolist() == ["self"]
    assert table["over"].isna().all()
    assert distance(strands[0].line, line)[5:-5].max() < 1


@pytest.mark.parametrize("background", [(235, 235, 230), (25, 25, 25)], ids=["light", "dark"])
@pytest.mark.parametrize("radius", [4, 8, 12])
def test_a_twisted_pair_is_two_strands(radius, background):
    """From end to end, but for the last half turn of whichever is behind there."""
    drawn = draw_helix(
        radius, lambda s: 1 / (18 * radius), 90 * radius, phase=1, background=background, rng=1
    )
    strands = trace(segment(Photo(drawn.pixels)))
    assert len(strands) == 2
    for strand in strands:
        errors = [distance(strand.line, truth[:, :2]) for truth in drawn.strands]
        assert min(np.percentile(error, 95) for error in errors) < 0.5 * radius
        assert np.ptp(strand.line[:, 1]) > (90 - 18) * radius


def test_two_strands_of_one_colour_side_by_side_are_two():
    """Along twenty-five widths they touch and look like one strand twice as wide."""
    y = np.linspace(20, 580, 900)
    apart = 2.9 + 30 * ((np.abs(y - 300) - 75).clip(0) / 100) ** 2
    lines = [np.stack([230 + side * apart, y], axis=1) for side in (-1, 1)]
    flat = np.zeros(len(y))
    strands, _ = traced(lines, [flat, flat], [BLUE, BLUE], radius=3, shape=(600, 460))
    assert len(strands) == 2
    for strand in strands:
        assert np.ptp(strand.line[:, 1]) > 550


def test_ends_are_free_clipped_or_hidden():
    y = np.linspace(-10, 200, 300)
    clipped = np.stack([np.full(300, 60.0), y], axis=1)
    bar = np.stack([np.linspace(20, 300, 400), np.full(400, 150.0)], axis=1)
    below = np.stack([np.full(300, 200.0), np.linspace(20, 149, 300)], axis=1)
    heights = [np.full(300, 30.0), np.full(400, 20.0), np.zeros(300)]
    strands, _ = traced([clipped, bar, below], heights, [RED, GREEN, BLUE])
    by_place = sorted(strands, key=lambda s: np.ptp(s.line[:, 0]))
    assert len(strands) == 3
    kinds = {round(s.line[:, 0].mean(), -1): s.ends for s in by_place[:2]}
    assert kinds[60] == ("clipped", "free")
    assert kinds[200] == ("free", "hidden")
    assert by_place[2].ends == ("free", "free")


def test_strands_run_root_to_tip():
    line, height = sine()
    strands, _ = traced([line[::-1]], [height], [RED])
    assert strands[0].line[0, 1] < strands[0].line[-1, 1]


PALETTE = np.array(
    [
        [230, 25, 75], [60, 180, 75], [255, 225, 25], [0, 90, 200], [245, 130, 48], [145, 30, 180],
        [70, 240, 240], [240, 50, 230], [0, 0, 0], [170, 110, 40], [128, 128, 0], [0, 0, 128],
    ]
) / 255  # fmt: skip


def curl(seed: int):
    rng = np.random.default_rng(seed)
    lines, heights = random_curl(12, 700, 300, slope=0.3, rng=rng)
    lines = [line + [260, 25] for line in lines]
    drawn = render(lines, heights, PALETTE, 3, (760, 520), rng=rng)
    found = segment(Photo(drawn.pixels))
    return lines, trace(found), found


def test_curl_of_twelve_strands():
    right, errors, ratios = 0, [], []
    lines, strands, _ = curl(2)
    for strand in strands:
        truth = min(lines, key=lambda line: np.median(distance(strand.line, line)))
        error = distance(strand.line, truth)
        back = cKDTree(strand.line).query(truth)[0]
        right += (error < 6).mean() > 0.97 and (back < 6).mean() > 0.95
        errors.append(error)
        ratios.append(error / strand.sd)
    assert len(strands) == 12
    assert right >= 11
    assert np.sqrt(np.median(np.concatenate(errors) ** 2)) < 0.15
    assert 0.9 < (np.concatenate(ratios) < 1.96).mean() <= 0.98

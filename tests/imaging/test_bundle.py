"""Lines worked on together come out as each by itself."""

import numpy as np
import pytest

from imaging.trace.bundle import bundled, normals_of, resampled
from imaging.trace.centreline import centred, normals, resample, smoothed


def lines() -> list[np.ndarray]:
    """Arcs of different lengths, the shortest of three points."""
    angles = [np.linspace(0, turn, n) for turn, n in ((2.0, 150), (0.1, 3), (3.0, 7), (1.0, 80))]
    return [60 * np.stack([1.5 + np.cos(a), 1.5 + np.sin(a)], axis=1) for a in angles]


@pytest.mark.parametrize("step", [1.0, 1.7])
def test_points_at_equal_distances(step):
    found = resampled(bundled(lines()), step)
    for one, line in zip(found.parted(found.points), lines(), strict=True):
        np.testing.assert_allclose(one, resample(line, step), atol=1e-9)


def test_normals():
    found = bundled(lines())
    for one, line in zip(found.parted(normals_of(found)), lines(), strict=True):
        np.testing.assert_allclose(one, normals(line), atol=1e-12)


def test_smoothing_ends_with_each_line():
    rng = np.random.default_rng(3)
    rough = [line + rng.normal(0, 0.5, line.shape) for line in lines()]
    weights = [rng.uniform(0.2, 1, len(line)) for line in rough]
    weights[3][4:] = 0  # too little is known of the last line
    together = bundled(rough)
    found = smoothed(together.points, np.concatenate(weights), 5.0, together.sizes)
    parts = together.parted(found)
    for part, line, weight in zip(parts, rough, weights, strict=True):
        np.testing.assert_allclose(part, smoothed(line, weight, 5.0), atol=1e-9)
    assert np.abs(parts[0] - rough[0]).max() > 0.1
    for left in (1, 2, 3):
        np.testing.assert_allclose(parts[left], rough[left], atol=1e-9)


def test_centrelines_of_several_pieces():
    y, x = np.indices((240, 240))
    own = np.float32(np.abs(np.hypot(x - 90, y - 90) - 60) < 4)
    long = [line for line in lines() if len(line) > 10]
    for one, line in zip(centred(long, own, own, 8.0), long, strict=True):
        np.testing.assert_allclose(one, centred([line], own, own, 8.0)[0], atol=1e-9)
        assert np.abs(np.hypot(*(one[10:-10] - 90).T) - 60).max() < 0.3

"""What visits only what a mask covers finds the same as what visits every pixel."""

import cv2
import numpy as np
import pytest
from skimage.morphology import skeletonize

from imaging.helix.turning import HOP, _walk
from imaging.segment.depths import depth_of, nearest_level, places_of, summit
from imaging.segment.skeleton import blobs, thinned


def mask(seed, shape=(61, 73)):
    rng = np.random.default_rng(seed)
    return cv2.GaussianBlur(rng.random(shape), (0, 0), 2.5) > 0.49


@pytest.mark.parametrize("seed", range(5))
def test_depths_and_their_summits_are_those_of_all_pixels(seed):
    seen = mask(seed)
    np.testing.assert_array_equal(places_of(seen), np.flatnonzero(seen))
    depth = cv2.distanceTransform(seen.view(np.uint8), cv2.DIST_L2, 5)
    np.testing.assert_allclose(depth_of(seen), depth, atol=1e-5)
    highest = cv2.dilate(depth, np.ones((3, 3), np.uint8))
    top = (depth > 1.2) & (depth >= highest - np.float32(0.3))
    np.testing.assert_array_equal(summit(depth, 1.2), np.flatnonzero(top))


@pytest.mark.parametrize("seed", range(5))
def test_pieces_are_thinned_as_the_whole(seed):
    np.testing.assert_array_equal(thinned(mask(seed)), skeletonize(mask(seed)))


def test_a_piece_within_the_ring_of_another_is_its_own():
    seen = np.zeros((40, 40), np.uint8)
    cv2.circle(seen, (20, 20), 15, 1, 2)
    seen[18:22, 18:22] = 1
    sizes = sorted(int(own.sum()) for _, own in blobs(seen > 0))
    assert sizes == [16, int(seen.sum()) - 16]
    assert [own.shape for _, own in blobs(seen > 0, least=10, rim=2)] == [(37, 37)]


def test_each_strip_has_the_level_of_its_own_ridge():
    seen = np.zeros((30, 50), bool)
    seen[2:7, 2:48] = seen[8:13, 2:48] = True  # a pixel apart
    ridge = np.concatenate([4 * 50 + np.arange(4, 46), 10 * 50 + np.arange(4, 46)])
    level = np.where(ridge < 7 * 50, 5.0, 9.0)
    at = places_of(seen)
    found = nearest_level(at, ridge, level, seen.shape)
    np.testing.assert_array_equal(found, np.where(at < 7 * 50, 5, 9))


def test_the_walk_over_phases_is_that_of_its_matrix():
    rng = np.random.default_rng(3)
    rates, phases, n = 3, 12, 20
    move = np.array([-1.3, 0.0, 0.7])
    emitted = (4 * rng.standard_normal((n, rates, phases))).astype(np.float32)
    step = np.zeros((rates, phases, rates, phases))
    for r in range(rates):
        for c in range(phases):
            for q in range(max(r - 1, 0), min(r + 2, rates)):
                hop = 1 - 2 * HOP if q == r else HOP
                to, part = int(np.floor(move[q])), move[q] % 1
                step[r, c, q, (c + to) % phases] += hop * (1 - part)
                step[r, c, q, (c + to + 1) % phases] += hop * part
    step = step.reshape(rates * phases, -1)
    likely = np.exp(emitted.reshape(n, -1).astype(float))
    forth, back = [likely[0] / step.shape[0]], [np.ones(step.shape[0])]
    for t in range(1, n):
        forth.append((forth[-1] @ step) * likely[t])
        back.append(step @ (likely[n - t] * back[-1]))
    whole = np.array(forth) * np.array(back)[::-1]
    evidence, posterior = _walk(emitted, move)
    assert evidence == pytest.approx(np.log(forth[-1].sum()), abs=1e-3)
    expected = whole / whole.sum(axis=1, keepdims=True)
    np.testing.assert_allclose(posterior.reshape(n, -1), expected, atol=1e-4)

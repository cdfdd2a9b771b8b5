"""The best joins of the ends of pieces."""

import numpy as np
import pytest

from imaging.trace import matching
from imaging.trace.branches import End


@pytest.mark.parametrize("seed", range(5))
def test_two_ways_to_the_best_joins_agree(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    ends = [End(i // 2, bool(i % 2), *rng.normal(size=(2, 2))) for i in range(60)]
    pairs = {tuple(sorted(pair)) for pair in rng.integers(0, 60, (150, 2)).tolist()}
    pairs = [(i, j) for i, j in sorted(pairs) if i // 2 != j // 2]
    gains = [(i, j, gain) for (i, j), gain in zip(pairs, rng.uniform(1, 40, 150), strict=False)]
    refunds = rng.uniform(-20, 20, 30).tolist()
    found = []
    for many in (0, len(gains) + 31):
        monkeypatch.setattr(matching, "MANY", many)
        found.append(matching.join(ends, refunds, gains))
    assert found[0] == found[1]
    assert len(found[0]) > 10

"""What the figures of the interactions show, read back from the figures."""

import numpy as np
import pandas as pd

from imaging.report.figures import histogram, kymograph


def test_the_kymograph_shows_strands_in_interactions_by_section_and_photograph():
    found = pd.DataFrame(
        {
            "photo": ["late"] * 4 + ["early"] * 4,
            "section": [2, 2, 1, 1] * 2,
            "N": [2, 3] * 4,
            "count": [1, 0, 0, 2, 3, 0, 0, 0],
        }
    )
    axes = kymograph(found).axes[0]
    shown = axes.images[0].get_array()
    np.testing.assert_array_equal(shown, [[6, 0], [2, 6]])  # sections down, photographs as given
    assert [label.get_text() for label in axes.get_xticklabels()] == ["late", "early"]


def test_the_histogram_shows_densities_with_their_intervals():
    dense = pd.DataFrame(
        {"N": [2, 3], "count": [4, 1], "density": [8.0, 2.0], "low": [2.2, 0.1], "high": [20, 11.1]}
    )
    dense.attrs["n_sec"] = 20
    axes = histogram(dense, "m").axes[0]
    assert [bar.get_height() for bar in axes.patches] == [8, 2]
    segments = axes.collections[0].get_segments()
    np.testing.assert_allclose([s[:, 1] for s in segments], [[2.2, 20], [0.1, 11.1]])
    assert "m" in axes.get_ylabel()
    assert "20 sections" in axes.get_title()

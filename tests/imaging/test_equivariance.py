"""A photograph turned, mirrored or taken from farther away shows the same strands and crossings.

On photographs that nobody here drew, and without their truth.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from imaging import Photo, crossings, read_photo, segment, trace

MBEST = Path(__file__).parents[3] / "shared" / "real" / "mBEST"
SEEN: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "turned": np.rot90,
    "mirrored": np.fliplr,
    "smaller by 0.7": lambda pixels: smaller(pixels, 0.7),
    "smaller by half": lambda pixels: smaller(pixels, 0.5),
}


def smaller(pixels: np.ndarray, factor: float) -> np.ndarray:
    return cv2.resize(pixels, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)


def counted(pixels: np.ndarray) -> tuple[int, int, int]:
    """Count strands, crossings of two, and of one with itself."""
    found = segment(Photo(np.ascontiguousarray(pixels)))
    strands = trace(found)
    kind = crossings(strands, found)["kind"]
    return len(strands), int((kind == "inter").sum()), int((kind == "self").sum())


@pytest.mark.slow
@pytest.mark.skipif(not MBEST.is_dir(), reason="photographs of mBEST are not here")
@pytest.mark.parametrize("group", ["S1", "S2", "S3"])
def test_counts_do_not_depend_on_how_it_is_seen(group):
    differing = []
    for path in sorted((MBEST / group / "images").glob("*.jpg")):
        pixels = read_photo(path).pixels
        expected = counted(pixels)
        for name, change in SEEN.items():
            if (found := counted(change(pixels))) != expected:
                differing.append((path.stem, name, found, expected))
    assert not differing

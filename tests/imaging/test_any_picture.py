"""No picture takes the program down: each is measured, or refused in one line."""

import cv2
import numpy as np
import pytest

from imaging import Photo, Unmeasurable
from imaging.measure import measure
from imaging.report.tables import (
    crossings_table,
    densities_table,
    link_table,
    strands_table,
    unresolved_table,
)

PICTURES = ("noise", "blobs", "half", "bar", "line", "wheel", "glow", "text", "ring")


def picture(kind: str, rng: np.random.Generator) -> np.ndarray:
    height, width = rng.integers(16, 260, 2)
    y, x = np.mgrid[:height, :width]
    flat = np.full((height, width, 3), int(rng.integers(0, 256)), np.uint8)
    if kind == "noise":
        return rng.integers(0, 256, (height, width, 3)).astype(np.uint8)
    if kind == "blobs":
        rough = cv2.GaussianBlur(rng.normal(size=(height, width, 3)), (0, 0), rng.uniform(1, 6))
        return np.clip(128 + 60 * rough / rough.std(), 0, 255).astype(np.uint8)
    if kind in ("half", "bar", "line"):
        thick = {"half": height // 2, "bar": 12, "line": 1}[kind]
        flat[height // 3 : height // 3 + thick] = rng.integers(0, 256, 3)
    if kind == "wheel":  # every hue, some colours where a smooth ground would be darker than black
        hue = (np.arctan2(y - height / 2, x - width / 2) * 90 / np.pi + 90).astype(np.uint8)
        full = np.full_like(hue, 255)
        return cv2.cvtColor(np.dstack([hue, full, full]), cv2.COLOR_HSV2RGB)
    if kind == "glow":
        light = 255 * np.exp(-((x - width / 2) ** 2 + (y - height / 2) ** 2) / 400)
        return np.repeat(light[..., None], 3, axis=2).astype(np.uint8)
    if kind == "text":
        for row in range(20, height, 22):
            cv2.putText(flat, "no strand", (2, row), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 2)
    if kind == "ring":
        cv2.circle(flat, (int(width) // 2, int(height) // 2), 40, (200, 30, 30), 9)
    return flat


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("kind", PICTURES)
def test_any_picture_is_measured_or_refused(kind, seed):
    pixels = picture(kind, np.random.default_rng(seed))
    try:
        found = measure(Photo(pixels))
    except Unmeasurable:
        return
    assert len(strands_table(found, "a")) > 0


def test_tables_without_rows_have_the_types_of_others():
    strands = [((20, 30), (280, 150)), ((20, 180), (280, 20))]
    tables = []
    for count in (1, 2):
        pixels = np.full((200, 300, 3), 230, np.uint8)
        for (start, end), colour in zip(
            strands[:count], ((200, 20, 20), (20, 20, 200)), strict=False
        ):
            cv2.line(pixels, start, end, colour, 8, cv2.LINE_AA)
        found = measure(Photo(pixels))
        tables.append(
            [table(found, "a") for table in (crossings_table, unresolved_table, link_table)]
            + [densities_table(found.densities, found, "a")]
        )
    empty, filled = tables
    assert [len(table) for table in empty] == [0] * 4
    for without, rows in zip(empty, filled, strict=True):
        for column in without:
            assert without[column].dtype == rows[column].dtype, column

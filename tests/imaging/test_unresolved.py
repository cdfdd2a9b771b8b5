"""Contact that cannot be resolved is said to be so, with its extent; what is clear is not."""

import numpy as np
import pandas as pd
import pytest
from drawn.strands import render

from imaging import (
    Photo,
    Strand,
    crossings,
    densities,
    interactions,
    segment,
    trace,
    unresolved,
)
from imaging.count.unresolved import contact_of
from imaging.measure import measure

RED, GREEN = (0.85, 0.1, 0.2), (0.1, 0.6, 0.25)
SHAPE = (260, 160)
Y = np.arange(20.0, 240)
WIDTH = 6.0


def drawn(x: np.ndarray) -> Photo:
    """Draw a straight strand at x = 80 on top of one that runs through x."""
    lines = [np.stack([at, Y], axis=1) for at in (np.full(len(Y), 80.0), x)]
    heights = [np.full(len(Y), 20.0), np.zeros(len(Y))]
    return Photo(render(lines, heights, [RED, GREEN], WIDTH / 2, SHAPE, rng=2).pixels)


def dip(excursion: float) -> np.ndarray:
    """Come from the left and out on the right of x = 80 by `excursion` px, then go back."""
    return 55 + (25 + excursion) * np.exp(-(((Y - 130) / 55) ** 2))


def found(photo: Photo) -> tuple[pd.DataFrame, pd.DataFrame]:
    segmentation = segment(photo)
    strands = trace(segmentation)
    assert len(strands) == 2
    table = crossings(strands, segmentation)
    return table, unresolved(strands, table)


@pytest.mark.parametrize("excursion", [-1, 0, 0.5, 1])
def test_two_crossings_or_none_is_unresolved(excursion):
    """The centrelines part by less than a sixth of a width, hidden under the strand on top."""
    _, stretches = found(drawn(dip(excursion)))
    (row,) = stretches.to_dict("records")
    assert (row["strand_a"], row["strand_b"], row["kind"]) == (1, 2, "inter")
    assert row["crossings"] in (0, 2)
    assert row["y_from"] < 130 < row["y_to"]
    assert 10 < row["s_a_to"] - row["s_a_from"] < 60
    assert row["x_from"] == pytest.approx(80, abs=2)


@pytest.mark.parametrize("excursion", [-9, -6, -4, 2.5, 6])
def test_what_the_picture_tells_is_resolved(excursion):
    table, stretches = found(drawn(dip(excursion)))
    assert len(table) == (2 if excursion > 0 else 0)
    assert stretches.empty


@pytest.mark.parametrize("degrees", [4, 15, 60])
def test_strands_that_change_sides_cross_once(degrees):
    table, stretches = found(drawn(80 + np.tan(np.radians(degrees)) * (Y - 130)))
    assert len(table) == 1
    assert table["y"].item() == pytest.approx(130, abs=2)
    assert stretches.empty


def test_the_measurement_names_it():
    measured = measure(drawn(dip(0.5)))
    (note,) = [note for note in measured.notes if "unresolved" in note]
    assert note.startswith("unresolved contact in 1 place,")
    assert "1 and 2" in note
    inside = measured.crossings["contact"].notna().sum()
    assert inside == measured.unresolved["crossings"].item() == len(measured.crossings)


def strand(x: np.ndarray, sd: float = 0.1) -> Strand:
    line = np.stack([x, np.arange(400.0)], axis=1)
    width, spread = np.full(400, WIDTH), np.full(400, sd)
    return Strand(line, width, spread, np.full(400, 2), np.zeros(400, int), ("free", "free"))


def test_a_crossing_too_long_to_place():
    slow = strand(100 + 0.01 * (np.arange(400) - 200.5), sd=0.5)
    (row,) = unresolved([strand(np.full(400, 100.0), sd=0.5), slow], crossings_of(slow)).to_dict(
        "records"
    )
    # |x - 100| < 2 sqrt(0.5^2 + 0.5^2) within 141 px of the crossing
    assert row["crossings"] == 1
    assert row["y_from"] == pytest.approx(200.5 - 141, abs=1.5)
    assert row["y_to"] == pytest.approx(200.5 + 141, abs=1.5)


def crossings_of(slow: Strand) -> pd.DataFrame:
    return crossings([strand(np.full(400, 100.0), sd=0.5), slow])


def test_a_loop_that_lies_on_itself():
    x = np.arange(20.0, 320)
    bend = np.linspace(-np.pi / 2, np.pi / 2, 100)
    there = np.stack([x, np.full(300, 50.0)], axis=1)
    turn = np.stack([320 + 30 * np.cos(bend), 80 + 30 * np.sin(bend)], axis=1)
    back = np.stack([x, 50.2 + 60 * ((x - 120) / 200) ** 2], axis=1)[::-1]
    line = np.concatenate([there, turn, back])
    n = len(line)
    loop = Strand(
        line, np.full(n, WIDTH), np.full(n, 0.4), np.full(n, 2), np.zeros(n, int), ("free", "free")
    )
    (row,) = unresolved([loop], crossings([loop])).to_dict("records")
    assert (row["kind"], row["strand_a"], row["strand_b"], row["crossings"]) == ("self", 1, 1, 0)
    # 60 ((x - 120) / 200)^2 + 0.2 < 2 sqrt(0.4^2 + 0.4^2) within 25 px of x = 120
    assert row["x_from"] == pytest.approx(95, abs=2)
    assert row["x_to"] == pytest.approx(145, abs=2)


def test_interactions_that_rest_on_it():
    """Strands 1 and 2 touch near y = 210, 2 and 3 cross near y = 240, 3 and 4 at y = 50."""
    y = np.arange(400.0)
    wave = np.exp(-(((y - 210) / 20) ** 2))
    strands = [
        strand(100 + 0 * y),
        strand(120 - 19.95 * wave),
        strand(121 - 9 * np.tanh((y - 240) / 10)),
        strand(130 + 0.1 * (y - 50)),
    ]
    table = crossings(strands)
    contacts = unresolved(strands, table)
    assert contacts[["strand_a", "strand_b"]].to_numpy().tolist() == [[1, 2]]
    sections = interactions(strands, 4, table=table, contacts=contacts)
    shown = sections[sections["count"] > 0]
    assert shown[["section", "N", "count"]].to_numpy().tolist() == [[1, 2, 1], [3, 2, 1]]
    assert shown["unresolved"].tolist() == [0, 1]  # 2 and 3, or 1, 2 and 3
    assert densities(sections)["unresolved"].sum() == 1
    assert "unresolved" not in interactions(strands, 4, table=table)


def test_crossings_know_their_contact():
    table = pd.DataFrame(
        {"strand_a": [1, 1, 2], "strand_b": [2, 2, 3], "s_a": [5.0, 50, 5], "s_b": [5.0, 50, 5]}
    )
    extent = {"s_a_from": 40.0, "s_a_to": 60.0, "s_b_from": 40.0, "s_b_to": 60.0}
    stretches = pd.DataFrame([{"strand_a": 1, "strand_b": 2, **extent}])
    assert contact_of(table, stretches).tolist() == [pd.NA, 1, pd.NA]

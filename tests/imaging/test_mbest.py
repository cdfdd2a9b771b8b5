"""Real photographs of coloured tubes with truth (Choi et al., IEEE RA-L 8, 4863, 2023)."""

from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from scipy.optimize import linear_sum_assignment

from imaging import crossings, read_photo, segment, trace

FOLDER = Path(__file__).parents[3] / "shared" / "real" / "mBEST"
pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"real photographs absent: {FOLDER}")
QUICK = range(0, 30, 5)
DICE = {"S1": 0.985, "S2": 0.98, "S3": 0.97}


def measured(group: str, number: int):
    photo = read_photo(FOLDER / group / "images" / f"img{number}.jpg")
    found = segment(photo)
    truth = cv2.imread(str(FOLDER / group / "labels" / f"img{number}.png"), cv2.IMREAD_UNCHANGED)
    strands = trace(found, photo)
    return truth, found, strands, crossings(strands, found)


def overlaps(truth: np.ndarray, labels: np.ndarray) -> tuple[float, dict[int, int]]:
    """Mean Dice of the best pairing of true and found colours; found colour -> true label."""
    table = np.array(
        [
            [
                2
                * ((truth == i) & (labels == j)).sum()
                / ((truth == i).sum() + (labels == j).sum())
                for j in range(1, labels.max() + 1)
            ]
            for i in range(1, truth.max() + 1)
        ]
    )
    rows, columns = linear_sum_assignment(-table)
    pairs = {int(c): int(r) + 1 for r, c in zip(rows, columns, strict=True)}
    return float(table[rows, columns].sum() / len(table)), pairs


def true_crossings(group: str, number: int) -> pd.DataFrame:
    table = pd.read_csv(FOLDER / "crossings.csv")
    return table[(table["set"] == group) & (table["image"] == number)]


@pytest.mark.parametrize("group", DICE)
def test_strands_masks_and_crossings(group):
    dice, strand_counts, missed, false, wrong_over = [], 0, 0, 0, 0
    for number in QUICK:
        truth, found, strands, table = measured(group, number)
        score, label_of = overlaps(truth, found.labels)
        dice.append(score)
        strand_counts += len(strands) == truth.max()
        known = true_crossings(group, number).query("kind == 'inter'")
        inter = table.query("kind == 'inter'").reset_index(drop=True)
        far = np.hypot(
            inter["x"].to_numpy()[:, None] - known["x"].to_numpy(),
            inter["y"].to_numpy()[:, None] - known["y"].to_numpy(),
        )
        rows, columns = linear_sum_assignment(np.minimum(far, 100))
        good = far[rows, columns] < 5
        missed += len(known) - good.sum()
        false += len(inter) - good.sum()
        for i, j in zip(rows[good], columns[good], strict=True):
            if not pd.isna(inter["over"][i]):
                colour = strands[int(inter["over"][i]) - 1].colour
                wrong_over += label_of[colour] != known["top"].iloc[j]
    assert strand_counts == len(QUICK)
    assert np.mean(dice) > DICE[group]
    assert missed == false == wrong_over == 0


@pytest.mark.slow
@pytest.mark.parametrize("group", DICE)
def test_number_of_strands_in_all_photographs(group):
    right = 0
    for number in range(30):
        truth, _, strands, _ = measured(group, number)
        right += len(strands) == truth.max()
    assert right >= 29


def test_a_photograph_on_its_side_is_read_upright():
    """One of the thirty stands on its side in the file and says so in EXIF."""
    shapes = {read_photo(path).shape for path in sorted((FOLDER / "S1" / "images").glob("*.jpg"))}
    assert shapes == {(896, 672)}

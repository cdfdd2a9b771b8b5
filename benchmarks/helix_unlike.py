"""Do the intervals of a helix hold in photographs by an unlike renderer (`drawn.unlike`)?

One picture gives one value of lambda a pitch, its total link, R and lean; shares are over them,
by kind, size, tilt and light.
"""

import sys

import numpy as np
import pandas as pd
from drawn.helix_accuracy import beside_truth, total_link_error
from drawn.unlike import LIGHTS, Unlike, draw_unlike
from tqdm import tqdm

from imaging import Photo, Unmeasurable
from imaging.helix import helix
from imaging.helix.measurement import HelixMeasurement

KINDS, SIZES, TILTS = ("straight", "step", "wave"), (4, 6, 9, 12), (0, 10)
GROUPS = ("kind", "r", "tilt", "light")
QUANTITIES = ("lambda", "link", "R", "lean")
FIRST = 90_000  # seed; 80 000 to 89 999 are to calibrate with
PITCHES = 4.5


def case(index: int) -> dict:
    """Kind, size, tilt and light of a picture: any 96 in a row hold every combination once."""
    turn, size = index // 4, index % 4
    return {
        "light": LIGHTS[(turn + turn // 12 + size) % 4],
        "r": SIZES[size],
        "kind": KINDS[turn % 3],
        "tilt": TILTS[turn // 3 % 2],
    }


def picture(seed: int) -> Unlike:
    asked, rng = case(seed), np.random.default_rng(seed)
    r = float(asked["r"])
    pitch = r * rng.uniform(15, 20)
    length, depth, sign = PITCHES * pitch, rng.uniform(0.05, 0.15), rng.choice([-1, 1])
    place = rng.uniform(0.4, 0.6) * length
    wave = rng.uniform(3, 6) * pitch

    def link(s: np.ndarray) -> np.ndarray:
        change = {
            "straight": 0 * s,
            "step": np.sign(s - place),
            "wave": np.sin(2 * np.pi * s / wave),
        }
        return sign * (1 + depth * change[asked["kind"]]) / pitch

    return draw_unlike(
        r, link, length, asked["light"], rng, tilt=np.radians(asked["tilt"]),
        bend=rng.uniform(-0.2, 0.2),
    )  # fmt: skip


def errors(found: HelixMeasurement, drawn: Unlike, tilt: float) -> pd.DataFrame:
    """Quantity, error and sd: lambda relative, link in turns, R relative, lean in degrees."""
    table = beside_truth(found, drawn)
    pitch = 1 / drawn.truth["link"].abs().median()
    one = table.groupby((table["true_s"] // pitch).astype(int)).nth(len(table) // 9)
    three = one[["link", "true_link", "sd"]].to_numpy()
    rows = [("lambda", value / true - 1, sd / abs(true)) for value, true, sd in three]
    rows += [
        ("link", total_link_error(table, found), found.total_link_sd),
        ("R", found.R / drawn.radius - 1, found.R_sd / drawn.radius),
        ("lean", np.degrees(found.lean) - tilt, np.degrees(found.lean_sd)),
    ]
    return pd.DataFrame(rows, columns=["quantity", "error", "sd"])


def measured(seeds: range) -> pd.DataFrame:
    """Errors over many pictures; one that is refused, or only counted, gives a row without."""
    tables = []
    for seed in tqdm(seeds, disable=not sys.stderr.isatty()):
        drawn, asked = picture(seed), case(seed)
        try:
            found = helix(Photo(drawn.pixels))
            table = errors(found, drawn, asked["tilt"])
            asked["by"] = "counts" if found.fit is None else "edges"
        except Unmeasurable as error:
            table, asked["by"] = pd.DataFrame({"quantity": ["none"]}), f"refused: {error}"
        tables.append(table.assign(seed=seed, **asked))
    return pd.concat(tables, ignore_index=True)


def shares(table: pd.DataFrame) -> pd.DataFrame:
    """Percentage of 95 % intervals that hold the truth: quantities over groups, and all."""
    held = table[table["quantity"].isin(QUANTITIES)].copy()
    held["held"] = 100.0 * (held["error"].abs() < 1.96 * held["sd"])
    every = {("all", ""): held.groupby("quantity")["held"].mean()}
    for group in GROUPS:
        for name, part in held.groupby(group):
            every[group, str(name)] = part.groupby("quantity")["held"].mean()
    return pd.DataFrame(every).T[list(QUANTITIES)]


def main(count: int, first: int = FIRST) -> pd.DataFrame:
    table = measured(range(first, first + count))
    per_picture = table.drop_duplicates("seed")
    print(f"{count} pictures of `drawn.unlike`; percentage of 95 % intervals that hold (92 - 98)")
    print(shares(table).round(0).to_string())
    typical = table[table["quantity"].isin(QUANTITIES)].groupby("quantity")
    spread = typical[["error", "sd"]].agg(lambda x: np.sqrt(np.mean(np.square(x))))
    print("RMS error and sd (lambda, R relative; link in turns; lean in degrees)")
    print(spread.round(4).to_string())
    print("by:", per_picture["by"].str[:60].value_counts().to_dict())
    return table

"""What a new user has: nine logs in three dialects, photographs with a ruler; of known truth."""

from pathlib import Path

import cv2
import numpy as np
import pandas as pd
from drawn.helix import draw_helix

import instron

GREY = (70, 72, 75)
D = 0.09  # m
HEIGHTS = {14: (2.4, 2.7, 3.0), 18: (1.3, 1.5, 1.6), 24: (0.7, 0.75, 0.8)}  # N
R, METRES = 8.0, 4.25e-4  # filament radius [px], [m]
PITCH, TURNS = 18 * R, 8
PLACES = {"tine_1": 3.5, "tine_2": 5.5}  # pitches from the clamp
BEHIND, AHEAD = 0.5, 1.2  # of lambda_0
RULER = (30, 60, 941.18)  # x, y of its zero and its length of 50 mm [px]


def shape(x: np.ndarray) -> np.ndarray:
    """Return a force that rises to 1 at x = 2/3 and is released at x = 1."""
    return np.where(x < 1, np.sin(0.75 * np.pi * x), 0.0)


def log(height: float) -> pd.DataFrame:
    """Return what a machine reads of a combing of so high a force [N], with noise."""
    d = np.linspace(0, 1.2 * D, 2401)
    noise = np.random.default_rng(int(1e3 * height)).normal(0, 2e-3, len(d))
    force = height * shape(d / D) + noise
    return pd.DataFrame({"time": 600 * d, "displacement": d, "force": force})


def _bluehill(path: Path, table: pd.DataFrame) -> None:
    instron.write_bluehill(path.with_suffix(".csv"), table, {"Text Inputs : Label": path.name})


def _german(path: Path, table: pd.DataFrame) -> None:
    """Semicolons, commas as decimal marks, force in mN."""
    rows = [f"{t:.2f};{1e3 * d:.5f};{1e3 * F:.2f}".replace(".", ",")
            for t, d, F in table.itertuples(index=False)]  # fmt: skip
    text = "\n".join(["Prüfzeit;Standardweg;Standardkraft", "s;mm;mN", *rows, ""])
    path.with_suffix(".txt").write_text(text, encoding="cp1252")


def _inches(path: Path, table: pd.DataFrame) -> None:
    """Tabs, inches, pounds; the gauge shows tension as negative."""
    rows = [f"{t:.2f}\t{d / 0.0254:.6f}\t{-F / 4.4482216:.6f}"
            for t, d, F in table.itertuples(index=False)]  # fmt: skip
    text = "\n".join(["Time (sec)\tExtension (in)\tLoad (lbf)", *rows, ""])
    path.with_suffix(".dat").write_text(text, encoding="utf-8")


def photograph(place: float | None) -> np.ndarray:
    """Draw the pair, with the tine so many pitches from the clamp, beside a ruler (h, w, 3)."""

    def link(s):
        if place is None:
            return np.full_like(s, 1 / PITCH)
        wound = np.where(s < place * PITCH, BEHIND, AHEAD) / PITCH
        return np.where(np.abs(s - place * PITCH) < 0.25 * PITCH, 0.0, wound)

    def radius(s):
        apart = 0.0 if place is None else (s - place * PITCH) / (0.3 * PITCH)
        return R * (1 + (0.0 if place is None else 1.8 * np.exp(-(apart**2))))

    beside = 0.3 if place is None else -2 * np.pi * BEHIND * (place - 0.25)
    drawn = draw_helix(R, link, TURNS * PITCH, helix_radius=radius, phase=beside, rng=3)
    if place is not None:
        at = np.abs(drawn.truth["s"] - place * PITCH).argmin()
        x, y = drawn.truth.loc[at, ["x", "y"]].round().astype(int)
        cv2.circle(drawn.pixels, (x, y), round(1.6 * R), GREY, -1, cv2.LINE_AA)
    return with_ruler(drawn.pixels)


def with_ruler(pixels: np.ndarray) -> np.ndarray:
    """Put a ruler with a line a millimetre on the left of a picture."""
    x, y, length = RULER
    seen = np.full((pixels.shape[0], pixels.shape[1] + 120, 3), pixels[2, 2], np.uint8)
    seen[:, 120:] = pixels
    for line in range(51):
        at = round(y + length * line / 50)
        seen[at - 1 : at + 1, x : x + (40 if line % 10 == 0 else 20)] = 40
    return seen


def write(folder: Path) -> None:
    """Write the user's files into `folder`."""
    for name in ("logs", "photos"):
        (folder / name).mkdir()
    for value, heights in HEIGHTS.items():
        for number, (height, dialect) in enumerate(
            zip(heights, (_bluehill, _german, _inches), strict=True), start=1
        ):
            dialect(folder / "logs" / f"pi{value}_{number}", log(height))
    for name, place in {"before": None, **PLACES}.items():
        cv2.imwrite(str(folder / "photos" / f"{name}.png"), photograph(place)[..., ::-1])

"""How far the axis leaves the picture, and what becomes of lengths where edges do not tell."""

from dataclasses import replace
from typing import Any

import numpy as np

from imaging.helix.fit import Fit
from imaging.helix.splines import basis

Array = np.ndarray
LEANING = 0.065  # sine; by which lights unlike the model's move the lean (helix_unlike.py)
SMALL = 6.0  # px; strands thinner than this do not tell how their axis leans
TOLD = 2.0  # sd; a lean nearer to none than this is not told
STEEP = np.radians(5.0)  # a lean out of the picture that the user should hear of


def mean_lean(fitted: Fit, t: Array) -> tuple[float, float]:
    """Mean angle out of the picture and its sd, which holds what unlike lights do to it."""
    where = fitted.model.layout.blocks["lean"]
    mean = basis(fitted.model.layout.lean, t).toarray().mean(axis=0)
    sine = float(np.clip(mean @ fitted.model.part("lean"), -0.9, 0.9))
    sd = np.hypot(np.sqrt(mean @ fitted.covariance[where, where] @ mean), LEANING)
    return float(np.arcsin(sine)), float(sd / np.sqrt(1 - sine**2))


def is_told(lean: float, sd: float, r: float) -> bool:
    """Whether edges tell that the axis leans, by strands of radius ``r`` [px]."""
    return r >= SMALL and abs(lean) > TOLD * sd


def upright(fitted: Fit, lean: float) -> Fit:
    """Return the fit with its mean lean taken out; how the lean varies stays."""
    beta = fitted.model.beta.copy()
    beta[fitted.model.layout.blocks["lean"]] -= np.sin(lean)
    return replace(fitted, model=fitted.model.moved(beta))


def length_sd(lean: float | Array, sd: float | Array, untold: float | None) -> Any:
    """Relative sd of a length divided by the cosine of a lean, or, where that is untold, by 1.

    The root of the mean square error, to second order, where the true lean is distributed
    normally. Uncorrected, a length is short by half the square of a lean about ``untold``.
    """
    if untold is None:
        return np.hypot(np.tan(lean) * sd, np.sqrt(3) / 2 * np.square(sd))
    return np.sqrt(untold**4 + 6 * np.square(untold * sd) + 3 * np.power(sd, 4)) / 2


def said_of_lean(lean: Array, mean: float, sd: float, *, told: bool) -> list[str]:
    """Warn of a lean that lengths are corrected for, and of one that they are not."""
    said = []
    if not told and abs(mean) > STEEP:
        said.append(
            f"the axis may lean {np.degrees(mean):+.0f} +- {np.degrees(sd):.0f} degrees out of the "
            "picture, which these edges do not tell; lengths are not corrected for it, their sd "
            "holds it"
        )
    if np.abs(lean).max() < STEEP:
        return said
    low, high = np.degrees(np.percentile(lean, [0, 100]))
    longer = 100 * (float(np.mean(1 / np.cos(lean))) - 1)
    angle = f"{low:+.1f}" if high - low < 1 else f"{low:+.1f} to {high:+.1f}"
    return [
        *said,
        f"the axis leans {angle} degrees out of the picture (tip away from the viewer > 0); "
        f"lengths are corrected by {longer:.2f} %",
    ]

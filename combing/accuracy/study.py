"""Which knobs are turned, how far, and what comes out as tables."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import pandas as pd

from combing.accuracy.cantilever import Cantilever
from combing.accuracy.capstan import Capstan
from combing.accuracy.jam import Jam
from combing.accuracy.measurement import Measurement, Problem

COLUMNS = [
    "case", "knob", "value", "quantity", "closed_form", "error", "textbook", "error_textbook",
    "place", "seconds", "relative_time", "steps",
]  # fmt: skip
FINER_IS_LARGER = {"elements": True, "stiffness": True, "safety": False, "speed": False}
IMPERFECTION = 0.02  # of the helix's curvature, in the ensemble


class Series(NamedTuple):
    """One knob of one case, varied alone."""

    case: str
    knob: str
    points: list[Problem]


class Teeth(NamedTuple):
    """Longer combings: the same one on other meshes and at other speeds, and perturbed ones."""

    meshes: Mapping[str, Problem]
    ensemble: Mapping[str, Problem]

    @property
    def runs(self) -> dict[str, Problem]:
        """All of them by name."""
        return {**self.meshes, **self.ensemble}


def vary(case: str, base: Any, knob: str, values: tuple[float, ...]) -> Series:
    """Return the series of a problem with one of its fields replaced by each value."""
    return Series(case, knob, [replace(base, **{knob: value}) for value in values])


def all_series(quick: bool) -> list[Series]:
    """Return every knob of every case; quick leaves out the costly points."""
    more = not quick
    rod, strand, helix = Cantilever(), Capstan(), Jam()
    steps = (*([0.25] * more), 0.5, 0.75, 0.95)
    wraps = (math.pi / 2, math.pi, 2 * math.pi)
    return [
        vary("cantilever", rod, "elements", (4, 8, 16, 32, 64, *([128, 256] * more))),
        vary("cantilever", rod, "safety", steps),
        vary("capstan", strand, "elements", (2, 3, 5, 7, 10, 14, 20, *([28, 40] * more))),
        vary("capstan", strand, "safety", steps),
        vary("capstan", strand, "speed", (*([0.005] * more), 0.01, 0.02, 0.05, 0.1)),
        vary(
            "capstan", strand, "stiffness", (4e-6, 1.25e-5, 4e-5, 1.25e-4, 4e-4, *([4e-3] * more))
        ),
        vary("capstan, mu = 0.1", Capstan(friction=0.1), "wrap", wraps),
        vary("capstan, mu = 0.3", strand, "wrap", wraps),
        vary("first jam", helix, "elements", (6, 12, 18, 24, *([36, 48] * more))),
        vary("first jam", helix, "safety", steps),
        vary("first jam", helix, "speed", (*([0.05] * more), 0.1, 0.2, 0.4, 0.8)),
        vary("first jam", helix, "stiffness", (0.03, 0.1, 0.3, 1.0, *([3.0] * more))),
    ]


def all_teeth(quick: bool) -> Teeth:
    """Return the longer combings, over 50 mm or 100 mm, and 4 or 16 perturbed ones."""
    base = Jam(reach=0.05 if quick else 0.1, height=0.15)
    meshes = {
        "12 elements, 0.2 m/s": base,
        "18 elements, 0.2 m/s": replace(base, elements=18),
        "12 elements, 0.3 m/s": replace(base, speed=0.3),
    }
    perturbed = {
        f"seed {seed}": replace(base, imperfection=IMPERFECTION, seed=seed)
        for seed in range(1, 5 if quick else 17)
    }
    return Teeth(meshes, perturbed)


def table(series: list[Series], results: Mapping[Problem, Measurement]) -> pd.DataFrame:
    """Return one row for each point.

    Returns
    -------
    DataFrame
        Columns case, knob, value, quantity, closed_form, `error` relative to it, or where there is
        none to the series' most accurate point, whose own error is then missing, textbook and
        error_textbook, place [m], seconds, relative_time (to the cheapest of the series), steps.
    """
    rows = [row for each in series for row in _rows(each, results)]
    return pd.DataFrame(rows, columns=COLUMNS)


def _rows(series: Series, results: Mapping[Problem, Measurement]) -> list[dict[str, Any]]:
    found = [results[point] for point in series.points]
    best = _best(series, results)
    cheapest = min(one.seconds for one in found if one.seconds > 0)
    rows = []
    for point, one in zip(series.points, found, strict=True):
        reference = one.closed_form or (None if point == best else results[best].quantity)
        rows.append(
            {
                "case": series.case,
                "knob": series.knob,
                "value": getattr(point, series.knob),
                "quantity": one.quantity,
                "closed_form": one.closed_form,
                "error": _relative(one.quantity, reference),
                "textbook": one.textbook,
                "error_textbook": _relative(one.quantity, one.textbook),
                "place": one.place,
                "seconds": one.seconds,
                "relative_time": one.seconds / cheapest,
                "steps": one.steps,
            }
        )
    return rows


def _best(series: Series, results: Mapping[Problem, Measurement]) -> Problem:
    """Return the series' most accurate point that gave a quantity at all."""
    good = [point for point in series.points if results[point].quantity is not None]
    sign = 1 if FINER_IS_LARGER.get(series.knob, True) else -1
    return max(good or series.points, key=lambda point: sign * getattr(point, series.knob))


def _relative(quantity: float | None, reference: float | None) -> float:
    return quantity / reference - 1 if quantity and reference else math.nan

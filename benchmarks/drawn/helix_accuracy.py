"""How far a measured helix lies from the truth of a drawn one."""

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from drawn.helix import SyntheticHelix
from imaging.helix.measurement import HelixMeasurement

Array = np.ndarray


def beside_truth(measured: HelixMeasurement, drawn: SyntheticHelix) -> pd.DataFrame:
    """Put every resolved point beside the truth at the nearest point of the true axis.

    Means by sides are left out (`imaging.helix.sides`). Both must be in pixels. Columns
    ``s, phi, link, sd`` as measured, ``true_s, true_phi,
    true_link``, and ``miss``, the distance between the two axes [px].
    """
    table = measured.phase.assign(
        link=measured.link_density["link"], sd=measured.link_density["sd"]
    )
    table = table[table["resolved"] & (table["by"] != "sides")]
    s, distance = _foot(table[["x", "y"]].to_numpy(), drawn.truth)
    truth = {name: np.interp(s, drawn.truth["s"], drawn.truth[name]) for name in ("phi", "link")}
    return table[["s", "phi", "link", "sd"]].assign(
        true_s=s, true_phi=truth["phi"], true_link=truth["link"], miss=distance
    )


def window_errors(table: pd.DataFrame, length: float) -> Array:
    """Relative errors of the link density averaged over windows of ``length`` [px].

    Windows that reach over an unresolved gap are left out.
    """
    s, true_s = table["s"].to_numpy(), table["true_s"].to_numpy()
    ends = np.searchsorted(true_s, true_s + length)
    start = np.flatnonzero(ends < len(s))
    end = ends[start]
    step = np.median(np.diff(true_s))
    whole = (true_s[end] - true_s[start]) / (end - start) < 1.2 * step
    start, end = start[whole], end[whole]
    found = (table["phi"].to_numpy()[end] - table["phi"].to_numpy()[start]) / (s[end] - s[start])
    true = table["true_phi"].to_numpy()
    return found / ((true[end] - true[start]) / (true_s[end] - true_s[start])) - 1


def total_link_error(table: pd.DataFrame, measured: HelixMeasurement) -> float:
    """Error of the total link [turns]."""
    phase = table["true_phi"].to_numpy()
    return measured.total_link - float(phase[-1] - phase[0]) / (2 * np.pi)


def _foot(points: Array, truth: pd.DataFrame) -> tuple[Array, Array]:
    """Arclength of the true axis nearest to points, and the distance."""
    axis, s = truth[["x", "y"]].to_numpy(), truth["s"].to_numpy()
    _, nearest = cKDTree(axis).query(points)
    middle = np.clip(nearest, 1, len(s) - 2)
    along = axis[middle + 1] - axis[middle - 1]
    part = ((points - axis[middle]) * along).sum(axis=1) / (along**2).sum(axis=1)
    foot = axis[middle] + part[:, None] * along
    return s[middle] + part * (s[middle + 1] - s[middle - 1]), np.linalg.norm(points - foot, axis=1)

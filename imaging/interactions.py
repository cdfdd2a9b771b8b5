"""N-body interactions of a curl: how many strands are entangled together, and how often."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.special import gammaincinv

from imaging.crossings import crossings
from imaging.errors import Unmeasurable
from imaging.trace import Strand


def interactions(
    strands: Sequence[Strand | np.ndarray],
    n_sec: int = 20,
    *,
    table: pd.DataFrame | None = None,
    axis: np.ndarray | None = None,
) -> pd.DataFrame:
    """Count N-body interactions section by section (the rule of Plumb-Reyes et al.).

    The axis of the curl, from the first to the last strand point along it, is cut into `n_sec`
    equal sections. In each, strands are the vertices of a graph and an edge joins two strands that
    cross there; each connected component of N >= 2 strands is one N-body interaction.

    Parameters
    ----------
    strands : sequence of Strand or (n, 2) array
        Root to tip, in pixels or metres; simulated strands projected into the plane serve as well.
    n_sec : int
        Number of sections. The counts depend strongly on it: state it beside every density.
    table : DataFrame, optional
        Result of ``crossings(strands)``, to save its computation.
    axis : (2,) array, optional
        Direction of the curl; by default the mean of the strands' root-to-tip directions, or their
        principal direction where these cancel.

    Returns
    -------
    DataFrame
        ``section`` (from 1 at the roots), ``N`` (2 to the number of strands), ``count``,
        ``density`` = count over the section's length [1 / unit of the strands]. The mean density
        over the sections is rho_N. ``attrs``: ``n_sec``, ``rule``, ``length`` of the curl,
        ``axis``.

    Raises
    ------
    Unmeasurable
        When there are fewer than two strands or `n_sec` is below 1.
    """
    lines = _checked(strands, n_sec)
    direction = curl_axis(lines) if axis is None else np.asarray(axis, float)
    direction = direction / np.hypot(*direction)
    along = np.concatenate(lines) @ direction
    start, length = along.min(), np.ptp(along)
    table = crossings(strands) if table is None else table
    inter = table[table["kind"] == "inter"]
    place = (inter[["x", "y"]].to_numpy() @ direction - start) / length
    section = np.clip((place * n_sec).astype(int), 0, n_sec - 1)
    sizes = _component_sizes(inter, section, n_sec, len(lines))
    counts = pd.crosstab(sizes["section"], sizes["N"]).reindex(
        index=range(n_sec), columns=range(2, len(lines) + 1), fill_value=0
    )
    found = pd.DataFrame(
        {
            "section": np.repeat(np.arange(1, n_sec + 1), len(lines) - 1),
            "N": np.tile(np.arange(2, len(lines) + 1), n_sec),
            "count": counts.to_numpy().ravel(),
        }
    )
    found["density"] = found["count"] * n_sec / length
    found.attrs = {
        "rule": "components of the crossing graph in equal sections of the axis",
        "n_sec": n_sec,
        "length": float(length),
        "axis": direction.tolist(),
    }
    return found


def _checked(strands: Sequence[Strand | np.ndarray], n_sec: int) -> list[np.ndarray]:
    if len(strands) < 2:
        raise Unmeasurable(f"{len(strands)} strand(s); interactions need at least two")
    if n_sec < 1:
        raise Unmeasurable(f"n_sec = {n_sec}; a curl is cut into at least one section")
    return [np.asarray(s.line if isinstance(s, Strand) else s, float) for s in strands]


def curl_axis(lines: list[np.ndarray]) -> np.ndarray:
    """Return the unit vector along which the strands run: mean root-to-tip direction.

    Where the directions cancel (strands that run both ways) it is the principal direction of all
    points, pointing down the picture.
    """
    across = np.array([line[-1] - line[0] for line in lines])
    mean = (across / np.maximum(np.hypot(*across.T), 1e-300)[:, None]).mean(axis=0)
    if np.hypot(*mean) > 0.3:
        return mean / np.hypot(*mean)
    points = np.concatenate(lines)
    principal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    return principal if principal[1] >= 0 else -principal


def _component_sizes(
    inter: pd.DataFrame, section: np.ndarray, n_sec: int, count: int
) -> pd.DataFrame:
    """Strands in each component of each section's crossing graph, components of one left out."""
    a = section * count + inter["strand_a"].to_numpy() - 1
    b = section * count + inter["strand_b"].to_numpy() - 1
    nodes = n_sec * count
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(nodes, nodes))
    _, component = connected_components(graph, directed=False)
    sizes = np.bincount(component)
    first = np.full(len(sizes), nodes)
    np.minimum.at(first, component, np.arange(nodes))
    several = sizes >= 2
    return pd.DataFrame({"section": first[several] // count, "N": sizes[several]})


def densities(found: pd.DataFrame, level: float = 0.95) -> pd.DataFrame:
    """Sum a table of interactions up to densities with Poisson intervals.

    Parameters
    ----------
    found : DataFrame
        From `interactions` or `events`.
    level : float
        Coverage of the interval.

    Returns
    -------
    DataFrame
        ``N``, ``count``, ``density`` rho_N = count / length, ``low``, ``high``: the exact interval
        of a Poisson count (Garwood 1936), over the length. ``attrs`` as in `found`.
    """
    total = found.groupby("N")["count"].sum()
    length = found.attrs["length"]
    tail = (1 - level) / 2
    k = total.to_numpy()
    low = np.where(k > 0, gammaincinv(np.maximum(k, 1), tail), 0.0)
    high = gammaincinv(k + 1, 1 - tail)
    summed = pd.DataFrame(
        {
            "N": total.index,
            "count": k,
            "density": k / length,
            "low": low / length,
            "high": high / length,
        }
    )
    summed.attrs = dict(found.attrs)
    return summed


def events(
    strands: Sequence[Strand | np.ndarray],
    radius: float,
    *,
    table: pd.DataFrame | None = None,
) -> pd.DataFrame:
    """Count N-body interactions without sections: crossings whose overlaps touch are one event.

    Two strands of radius r that cross at an angle theta overlap in a rhombus of half-length
    r cot(theta/2) along each. Consecutive crossings on a strand belong together when closer along
    it than r [cot(theta_1/2) + cot(theta_2/2)].

    Parameters
    ----------
    strands : sequence of Strand or (n, 2) array
    radius : float
        Strand radius in the unit of the strands.
    table : DataFrame, optional
        Result of ``crossings(strands)``.

    Returns
    -------
    DataFrame
        ``N``, ``count``, ``density`` [1 / unit]; ``attrs`` as in `interactions`.
    """
    lines = _checked(strands, 1)
    table = crossings(strands) if table is None else table
    inter = table[table["kind"] == "inter"].reset_index(drop=True)
    sizes = _event_sizes(inter, radius)
    counts = np.bincount(sizes, minlength=len(lines) + 1)[2:]
    length = float(np.ptp(np.concatenate(lines) @ curl_axis(lines)))
    found = pd.DataFrame({"N": np.arange(2, len(lines) + 1), "count": counts})
    found["density"] = found["count"] / length
    found.attrs = {"rule": "touching overlap rhombi", "radius": radius, "length": length}
    return found


def _event_sizes(inter: pd.DataFrame, radius: float) -> np.ndarray:
    """Distinct strands in each group of crossings whose overlaps touch."""
    half = radius / np.tan(inter["angle"].to_numpy() / 2)
    ends = pd.concat(
        [
            pd.DataFrame({"strand": inter[f"strand_{c}"], "s": inter[f"s_{c}"], "half": half})
            for c in "ab"
        ]
    ).reset_index(names="crossing")
    ends = ends.sort_values(["strand", "s"], ignore_index=True)
    following = ends.shift(-1)
    touch = (ends["strand"] == following["strand"]) & (
        following["s"] - ends["s"] < ends["half"] + following["half"]
    )
    a = ends["crossing"][touch].to_numpy()
    b = following["crossing"][touch].to_numpy().astype(int)
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(len(inter), len(inter)))
    _, group = connected_components(graph, directed=False)
    ends["group"] = group[ends["crossing"]]
    return ends.groupby("group")["strand"].nunique().to_numpy()

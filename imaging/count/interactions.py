"""N-body interactions of a curl: how many strands are entangled together, and how often."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.special import gammaincinv

from imaging.count.crossings import crossings
from imaging.count.unresolved import contact_of
from imaging.errors import Unmeasurable
from imaging.trace import Strand

Component = frozenset[int]  # of nodes: section * number of strands + strand, from 0


def interactions(
    strands: Sequence[Strand | np.ndarray],
    n_sec: int = 20,
    *,
    table: pd.DataFrame | None = None,
    axis: np.ndarray | None = None,
    contacts: pd.DataFrame | None = None,
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
    contacts : DataFrame, optional
        Result of ``unresolved(strands, table)``: adds the column ``unresolved``.

    Returns
    -------
    DataFrame
        ``section`` (from 1 at the roots), ``N`` (2 to the number of strands), ``count``,
        ``density`` = count over the section's length [1 / unit of the strands]; ``unresolved``,
        those of `count` that would not be there, or of other strands, if in all unresolved contact
        strands crossed wherever they may, or nowhere. The mean density over the sections is rho_N.
        ``attrs``: ``n_sec``, ``rule``, ``length`` of the curl, ``axis``.

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
    section = partial(_section, along=direction, start=start, length=length, n_sec=n_sec)
    edges = _edges(inter).assign(section=section(inter["x"], inter["y"]))
    components = _components(edges, n_sec, len(lines))
    found = _counted(components, n_sec, len(lines), "count")
    found["density"] = found["count"] * n_sec / length
    if contacts is not None:
        sure = edges[contact_of(inter, contacts).isna()]
        doubtful = components - _in_any_case(sure, _spans(contacts, section), n_sec, len(lines))
        found["unresolved"] = _counted(doubtful, n_sec, len(lines), "unresolved")["unresolved"]
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


def _section(
    x: pd.Series, y: pd.Series, along: np.ndarray, start: float, length: float, n_sec: int
) -> np.ndarray:
    """Section of the axis, from 0, in which points lie."""
    place = (np.stack([x, y], axis=1) @ along - start) / length
    return np.clip((place * n_sec).astype(int), 0, n_sec - 1)


def _spans(contacts: pd.DataFrame, section: Callable[..., np.ndarray]) -> pd.DataFrame:
    """Pairs of strands in unresolved contact, with the first and last section it reaches into."""
    inter = contacts[contacts["kind"] == "inter"]
    ends = [section(inter[f"x_{end}"], inter[f"y_{end}"]) for end in ("from", "to")]
    return _edges(inter).assign(first=np.minimum(*ends), last=np.maximum(*ends))


def _edges(table: pd.DataFrame) -> pd.DataFrame:
    """Pairs of strands, counted from 0."""
    return pd.DataFrame({"a": table["strand_a"] - 1, "b": table["strand_b"] - 1}, dtype=int)


def _components(edges: pd.DataFrame, n_sec: int, count: int) -> set[Component]:
    """Components of two strands and more of each section's crossing graph."""
    a = (edges["section"] * count + edges["a"]).to_numpy(int)
    b = (edges["section"] * count + edges["b"]).to_numpy(int)
    nodes = n_sec * count
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(nodes, nodes))
    _, component = connected_components(graph, directed=False)
    members: dict[int, list[int]] = {}
    for node in np.union1d(a, b).tolist():
        members.setdefault(int(component[node]), []).append(node)
    return {frozenset(group) for group in members.values()}


def _in_any_case(sure: pd.DataFrame, spans: pd.DataFrame, n_sec: int, count: int) -> set[Component]:
    """Components that are the same whether strands in unresolved contact cross or not.

    Parameters
    ----------
    sure : DataFrame
        Crossings outside unresolved contact: ``a``, ``b``, ``section``.
    spans : DataFrame
        Unresolved contact: ``a``, ``b``, ``first`` and ``last`` section it reaches into.
    """
    reach = (spans["last"] - spans["first"] + 1).to_numpy(int)
    may = spans.loc[spans.index.repeat(reach), ["a", "b"]]
    may["section"] = np.concatenate(
        [np.arange(first, first + n) for first, n in zip(spans["first"], reach, strict=True)]
        or [np.empty(0, int)]
    )
    possible = pd.concat([sure, may], ignore_index=True)
    return _components(sure, n_sec, count) & _components(possible, n_sec, count)


def _counted(components: set[Component], n_sec: int, count: int, name: str) -> pd.DataFrame:
    """Count the components in each section (from 1) by how many strands they hold."""
    table = np.zeros((n_sec, count - 1), int)
    for component in components:
        table[min(component) // count, len(component) - 2] += 1
    sections, sizes = np.indices(table.shape).reshape(2, -1)
    return pd.DataFrame({"section": sections + 1, "N": sizes + 2, name: table.ravel()})


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
        of a Poisson count (Garwood 1936), over the length; ``unresolved`` summed, if it is there.
        ``attrs`` as in `found`.
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
    if "unresolved" in found:
        summed["unresolved"] = found.groupby("N")["unresolved"].sum().to_numpy()
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

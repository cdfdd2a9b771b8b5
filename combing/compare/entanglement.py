"""How entangled a simulated tangle is, in space and as a camera sees it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import imaging
import sim
from combing.compare.curl_views import ANGLES, seen_from

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tangle:
    """Entanglement of the n strands of one moment.

    Attributes
    ----------
    pairs : DataFrame
        Every pair: `strand_a, strand_b`, its Gauss `link`, average crossing number `crossings`,
        the mean number of crossings `seen` over the directions of view, and `contacts`.
    views : DataFrame
        Every pair and direction: `strand_a, strand_b, degrees, seen`.
    strands : DataFrame
        Every strand: `strand`, `crossings` with all others and `own` with itself (average crossing
        numbers), `writhe`, `contacts`, `cluster`.
    along : DataFrame
        Every segment, as `sim.Entanglement.segments`, with the distance to the `nearest` other
        strand [m].
    contacts : DataFrame
        As `sim.ContactNetwork.contacts`.
    field : DataFrame
        As `sim.Entanglement.field`.
    """

    pairs: pd.DataFrame
    views: pd.DataFrame
    strands: pd.DataFrame
    along: pd.DataFrame
    contacts: pd.DataFrame
    field: pd.DataFrame


def tangle_of(strands: Sequence[Array], distance: float, cell: float) -> Tangle:
    """Measure the entanglement of strands in space and in pictures of them.

    Parameters
    ----------
    strands : sequence of (n, 3) arrays
        At least two, hanging along -z [m].
    distance : float
        Between centrelines that counts as a contact [m].
    cell : float
        Edge of the cubes of the field [m].
    """
    exact, network = sim.entanglement(strands), sim.contact_network(strands, distance)
    views = _views(strands)
    a, b = np.triu_indices(len(strands), 1)
    pairs = pd.DataFrame({"strand_a": a + 1, "strand_b": b + 1, "link": exact.link[a, b]})
    pairs["crossings"] = exact.crossings[a, b]
    pairs["seen"] = views.groupby(["strand_a", "strand_b"])["seen"].mean().to_numpy()
    touching = pd.DataFrame({"a": network.contacts["strand_a"], "b": network.contacts["strand_b"]})
    counts = touching.value_counts()
    pairs["contacts"] = [int(counts.get(pair, 0)) for pair in zip(a + 1, b + 1, strict=True)]
    own = np.diag(exact.crossings)
    each = pd.DataFrame({"strand": np.arange(1, len(strands) + 1)})
    each = each.assign(crossings=exact.crossings.sum(axis=1) - own, own=own)
    each = each.assign(writhe=np.diag(exact.link), contacts=network.per_strand)
    along = exact.segments.assign(nearest=_at_middles(sim.nearest_strand(strands)))
    field = exact.field(cell)
    return Tangle(
        pairs, views, each.assign(cluster=network.cluster + 1), along, network.contacts, field
    )


def _views(strands: Sequence[Array]) -> pd.DataFrame:
    """Count the crossings of every pair in pictures from several sides."""
    a, b = np.triu_indices(len(strands), 1)
    parts = []
    for degrees in ANGLES:
        seen = imaging.crossing_matrix(
            imaging.crossings(seen_from(strands, degrees)), len(strands)
        )[a, b]
        rows = {"strand_a": a + 1, "strand_b": b + 1, "degrees": degrees, "seen": seen}
        parts.append(pd.DataFrame(rows))
    return pd.concat(parts, ignore_index=True)


def _at_middles(at_nodes: Sequence[Array]) -> Array:
    return np.concatenate([(one[1:] + one[:-1]) / 2 for one in at_nodes])

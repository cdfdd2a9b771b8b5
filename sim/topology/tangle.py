"""Entanglement of any number of open strands: link and crossings by pair, along and in space.

The average crossing number is the number of crossings that a picture shows, averaged over all
directions of view; the Gauss link counts the same crossings with their sign, halved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from sim.kernels.tangle import fill_pairs
from sim.topology.pair import curve_of

Array = NDArray[np.float64]

ERROR = 1e-3  # of the crossings of segments far from each other


@dataclass(frozen=True, repr=False)
class Entanglement:
    """How n strands are entangled.

    Attributes
    ----------
    link : (n, n) array
        Gauss link of every two strands, symmetric; on the diagonal their writhe.
    crossings : (n, n) array
        Average crossing number of every two strands, symmetric; diagonal: of each with itself.
    segments : DataFrame
        Every segment: `strand`, its middle's arclength `s` and place `x, y, z` [m], its `length`
        [m], and its densities `crossings` and `link` [1/m] with all others, its own strand's
        included. What two segments have belongs to either in halves: integrated over all strands,
        `crossings` gives the number of them, `link` half the number with sign.
    error : float
        Bound of the relative error of `crossings`, and of the error of `link` over `crossings`.
    """

    link: Array
    crossings: Array
    segments: pd.DataFrame
    error: float

    def __repr__(self) -> str:
        """Say how many strands there are and how entangled they are."""
        return (
            f"<Entanglement of {len(self.link)} strands: {self.between:.4g} crossings between them "
            f"in a mean view, {np.trace(self.crossings):.4g} of strands with themselves>"
        )

    @property
    def between(self) -> float:
        """Average crossing number of all pairs of different strands together."""
        return float(np.triu(self.crossings, 1).sum())

    def field(self, cell: float) -> pd.DataFrame:
        """Return the density of crossings in space, cube by cube.

        Parameters
        ----------
        cell : float
            Edge of the cubes [m].

        Returns
        -------
        DataFrame
            Of every cube that strands pass: its middle `x, y, z` [m], `crossings` [1/m^3] and
            `length` of strand per volume [1/m^2]. A segment counts where its middle is.
        """
        one, axes = self.segments, ["x", "y", "z"]
        amounts = one.assign(crossings=one["crossings"] * one["length"])
        cubes = np.floor(one[axes] / cell).astype(int)
        total = amounts.groupby([cubes[axis] for axis in axes])[["crossings", "length"]].sum()
        places = (total.index.to_frame(index=False) + 0.5) * cell
        return pd.concat([places, total.reset_index(drop=True) / cell**3], axis=1)


def entanglement(strands: Sequence[ArrayLike], *, error: float = ERROR) -> Entanglement:
    """Measure how strands are entangled.

    Parameters
    ----------
    strands : sequence of (n, 3) arrays
        Nodes [m]; a closed strand repeats its first node at the end.
    error : float
        Largest relative error of the crossings of segments that are far from each other; 0 for the
        exact value of every pair, at several times the cost.

    Raises
    ------
    ValueError
        There is no strand, or one is not a curve in space.

    Notes
    -----
    Near segments by Arai (PTEP 2013, 063A01); far ones by the second-order expansion of Gauss's
    integral about their middles, whose remainder is bounded by its fourth derivatives. The local
    share of a segment is the row sum of Klenin & Langowski, Biopolymers 54, 307 (2000).
    """
    curves = [curve_of(strand) for strand in strands]
    if not curves:
        raise ValueError("entanglement needs at least one strand")
    starts = np.concatenate([[0], np.cumsum([len(curve) for curve in curves])]).astype(np.int64)
    nodes = np.concatenate(curves)
    edges = np.diff(nodes, axis=0, append=nodes[-1:])
    edges[starts[1:] - 1] = 0.0
    middles, lengths = nodes + edges / 2, np.linalg.norm(edges, axis=1)
    link, crossings = (np.zeros((len(curves), len(curves))) for _ in range(2))
    on_link, on_crossings = np.zeros(len(nodes)), np.zeros(len(nodes))
    fill_pairs(
        nodes, starts, middles, edges, lengths, error, link, crossings, on_link, on_crossings
    )
    np.fill_diagonal(link, 2 * np.diag(link))  # the writhe counts a pair of segments both ways
    strand = np.repeat(np.arange(1, len(curves) + 1), [len(curve) for curve in curves])
    s = np.concatenate([np.cumsum(one) - one / 2 for one in np.split(lengths, starts[1:-1])])
    table = pd.DataFrame({"strand": strand, "s": s, **dict(zip("xyz", middles.T, strict=True))})
    real = lengths > 0
    table = table.assign(length=lengths)[real]
    table["crossings"] = on_crossings[real] / lengths[real]
    table["link"] = on_link[real] / lengths[real]
    return Entanglement(
        link + np.triu(link, 1).T,
        crossings + np.triu(crossings, 1).T,
        table.reset_index(drop=True),
        error,
    )

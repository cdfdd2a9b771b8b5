"""What densities of a curl hang on: its strands, the number of sections, the direction of view."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import imaging

Array = NDArray[np.float64]
SECTIONS = (10, 15, 20, 30, 40)
ANGLES = (0, 30, 60, 90, 120, 150)  # degrees about the vertical; half a turn on is the mirror image
POINTS = 250  # of a strand in a table


def seen_from(strands: Sequence[Array], degrees: float = 0.0) -> list[Array]:
    """Project hanging strands (n, 3) as a distant camera sees them, x right and y down, (n, 2) [m].

    At 0 degrees the camera looks along y; it goes round the vertical.
    """
    angle = np.radians(degrees)
    right = np.array([-np.cos(angle), -np.sin(angle), 0.0])
    return [np.column_stack([strand @ right, -strand[:, 2]]) for strand in strands]


def strand_table(name: str, source: str, sample: str, strands: Sequence[Array]) -> pd.DataFrame:
    """Return the centrelines of a curl, root to tip: set, source, sample, strand, x, y, z [m].

    Those of a photograph are in its plane, x right and y down, without z. A strand of many points
    is thinned.
    """
    parts = []
    for number, strand in enumerate(strands, start=1):
        step = -(-len(strand) // POINTS)
        thin = np.vstack([strand[:-1:step], strand[-1:]])
        parts.append(pd.DataFrame(dict(zip("xyz", thin.T, strict=False))).assign(strand=number))
    table = pd.concat(parts, ignore_index=True).assign(set=name, source=source, sample=sample)
    return table.reindex(columns=["set", "source", "sample", "strand", "x", "y", "z"])


def over_sections(
    strands: Sequence[imaging.Strand | Array],
    table: pd.DataFrame,
    unit: float,
    sections: Sequence[int] = SECTIONS,
) -> pd.DataFrame:
    """Return rho_N of a curl cut into other numbers of sections.

    Parameters
    ----------
    strands : sequence of Strand or (n, 2) array
        In lengths of `unit` [m].
    table : DataFrame
        Their crossings.
    unit : float
        Length that strands are given in [m].
    sections : sequence of int
        Numbers of sections.

    Returns
    -------
    DataFrame
        what (``sections``), value, N, density [1/m].
    """
    rows = [
        _mean(imaging.interactions(strands, n, table=table), unit).assign(value=n) for n in sections
    ]
    return pd.concat(rows, ignore_index=True).assign(what="sections")


def over_views(
    strands: Sequence[Array], n_sec: int, angles: Sequence[float] = ANGLES
) -> pd.DataFrame:
    """Return rho_N of a simulated curl, (n, 3) [m], seen from other directions.

    Returns
    -------
    DataFrame
        what (``view``), value [degrees], N, density [1/m].
    """
    rows = [
        _mean(imaging.interactions(seen_from(strands, angle), n_sec), 1.0).assign(value=angle)
        for angle in angles
    ]
    return pd.concat(rows, ignore_index=True).assign(what="view")


def _mean(found: pd.DataFrame, unit: float) -> pd.DataFrame:
    count = found.groupby("N", as_index=False)["count"].sum()
    length = found.attrs["length"] * unit
    return pd.DataFrame({"N": count["N"], "density": count["count"] / length})


def shares(table: pd.DataFrame) -> Iterator[str]:
    """Say how far the density of pairs moves with the number of sections and with the view."""
    pairs = table[table["N"] == 2]
    for (source, what), rows in pairs.groupby(["source", "what"], sort=False):
        mean = rows.groupby("value")["density"].mean()
        low, high = mean.min(), mean.max()
        across = "sections" if what == "sections" else "degrees about the vertical"
        yield (
            f"{str(source).capitalize()}: pairs {low:.3g} to {high:.3g} 1/m over "
            f"{mean.index.min():g} to {mean.index.max():g} {across}."
        )

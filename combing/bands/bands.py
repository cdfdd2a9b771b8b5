"""Bands about f(d), lambda(s) and the numbers of a run, from the runs behind them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import sim
from combing.bands.intervals import LEVEL, around, mesh_error, prediction
from combing.bands.quantities import Quantities
from combing.tables import write_table

COLUMNS = ["value", "low", "high", "kind", "mesh", "mean", "sd"]


@dataclass(frozen=True)
class Bands:
    """What of a run is uncertain, and by how much.

    Every table has columns `value` (of the run itself), `low` and `high` (the band at 95 %), `kind`
    ("mesh": where an infinitely fine mesh would be; "spread": where one more specimen would be),
    `mesh` (half-width by the mesh, a bias, wherever it is known), `mean` and `sd` (over members).
    Numbers are of kind "spread": each depends on what comes after the first release, or on draws.

    Attributes
    ----------
    force : DataFrame
        f over `d` [m] and `x` = d/D, averaged as f_max is; empty where nothing combs.
    link : DataFrame
        lambda [1/m] over `s` [m] of every `snapshot`, averaged over a pitch; empty but for pairs.
    numbers : DataFrame
        A row a `quantity`: f_max, D [m], w, first_jam of a combing; rho_N [1/m] of a curl.
    about : dict
        members, size of their random curvature, level, elements and those of the coarser run,
        mesh_to [m]: up to where the mesh makes the band; newton: F/f [N]; notes.
    """

    force: pd.DataFrame
    link: pd.DataFrame
    numbers: pd.DataFrame
    about: dict[str, Any]

    def write(self, folder: Path) -> None:
        """Write numbers.csv, band_force.csv and band_link.csv, those that are not empty."""
        tables = {"numbers": self.numbers, "band_force": self.force, "band_link": self.link}
        about = [
            f"bands at {100 * self.about['level']:g} %, kind mesh: of the mesh, "
            f"{self.about['elements']} against {self.about['coarse_elements']} elements; spread: "
            f"one more of {self.about['members']} members, random curvature {self.about['size']:g}",
            "SI units; f scaled by l0 = 0.01 m; mesh is a half-width wherever it is known",
        ]
        for name, table in tables.items():
            if len(table):
                write_table(folder / f"{name}.csv", table, about)

    def said(self) -> dict[str, str]:
        """Return every number and its band in words."""
        return {row["quantity"]: _in_words(row, self.about) for _, row in self.numbers.iterrows()}


def make_bands(runs: Mapping[int, sim.Run], size: float) -> Bands:
    """Return the bands of run 0, from members 1, 2, ... and the run on a coarser mesh, -1.

    Parameters
    ----------
    runs : mapping
        Finished runs of `scenes_of_bands`; members or the coarser one may be missing.
    size : float
        Of the members' random curvature, for the record.
    """
    found = {key: Quantities(run) for key, run in runs.items()}
    nominal, coarse = found[0], found.get(-1)
    members = [found[key] for key in sorted(found) if key > 0]
    mesh_to = _mesh_to(nominal, coarse)
    return Bands(
        force=_force(nominal, coarse, members, mesh_to) if nominal.combs else pd.DataFrame(),
        link=_link(nominal, coarse, members, mesh_to) if nominal.pair else pd.DataFrame(),
        numbers=_numbers(nominal, coarse, members),
        about={
            "members": len(members),
            "size": size,
            "level": LEVEL,
            "elements": _elements(nominal),
            "coarse_elements": _elements(coarse) if coarse else 0,
            "mesh_to": mesh_to,
            "newton": _newton(nominal),
        },
    )


def _mesh_to(nominal: Quantities, coarse: Quantities | None) -> float:
    """Return up to which displacement the mesh makes the band [m].

    The place of the release is unsure itself, by the distance of those on both meshes.
    """
    if coarse is None:
        return 0.0
    if not nominal.combs:
        return np.inf
    places = [one.jam[0] for one in (nominal, coarse) if one.jam[0] is not None]
    last = min(places, default=float(nominal.places[-1]))
    return last - (abs(places[0] - places[1]) if places[1:] and last == places[0] else 0.0)


def _band(
    value: np.ndarray,
    coarse: np.ndarray | None,
    members: Sequence[np.ndarray],
    smooth: np.ndarray | bool,
    ratio: float = np.nan,
    reach: int = 0,
) -> pd.DataFrame:
    """Return a table of COLUMNS; errors of the mesh hold `reach` rows to either side."""
    mean = sd = half = np.full(value.shape, np.nan)
    if len(members) > 1:
        mean, half = prediction(np.array(members))
        sd = np.std(members, axis=0, ddof=1)
    mesh = np.full(value.shape, np.nan) if coarse is None else mesh_error(value, coarse, ratio)
    if reach:
        mesh = np.where(smooth, around(np.where(smooth, mesh, 0.0), reach), np.nan)
    by_mesh = smooth & np.isfinite(mesh)
    columns = [
        value,
        np.where(by_mesh, value - mesh, mean - half),
        np.where(by_mesh, value + mesh, mean + half),
        np.where(by_mesh, "mesh", "spread"),
        *(mesh, mean, sd),
    ]
    return pd.DataFrame(dict(zip(COLUMNS, columns, strict=True)))


def _force(
    nominal: Quantities, coarse: Quantities | None, members: list[Quantities], mesh_to: float
) -> pd.DataFrame:
    d = nominal.places
    reach = round(_pitch(nominal) / 2 / (d[1] - d[0])) if len(d) > 1 else 0
    table = _band(
        nominal.force(d),
        coarse.force(d) if coarse else None,
        [one.force(d) for one in members],
        d <= mesh_to,
        _ratio(nominal, coarse),
        reach,
    )
    table.insert(0, "d", d)
    table.insert(1, "x", d / nominal.curve.attrs["D"])
    return table


def _link(
    nominal: Quantities, coarse: Quantities | None, members: list[Quantities], mesh_to: float
) -> pd.DataFrame:
    pitch, tables = _pitch(nominal), []
    for snapshot, d in enumerate(nominal.run.displacements):
        s, value = nominal.link(snapshot, None, pitch)
        table = _band(
            value,
            coarse.link(snapshot, s, pitch)[1] if coarse else None,
            [one.link(snapshot, s, pitch)[1] for one in members],
            d <= mesh_to,
            _ratio(nominal, coarse),
            round(pitch / 2 / (s[1] - s[0])),
        )
        tables.append(pd.DataFrame({"snapshot": snapshot, "displacement": d, "s": s}).join(table))
    return pd.concat(tables, ignore_index=True)


def _numbers(
    nominal: Quantities, coarse: Quantities | None, members: list[Quantities]
) -> pd.DataFrame:
    own, rough = nominal.scalars(), coarse.scalars() if coarse else {}
    others = [one.scalars() for one in members]
    tables = []
    for name, value in own.items():
        drawn = [one[name] for one in others if np.isfinite(one.get(name, np.nan))]
        table = _band(
            np.array([value]),
            np.array([rough[name]]) if name in rough else None,
            [np.array([one]) for one in drawn],
            False,
            _ratio(nominal, coarse),
        )
        table.insert(0, "quantity", name)
        tables.append(table)
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()


def _in_words(row: pd.Series, about: Mapping[str, Any]) -> str:
    if np.isnan(row["value"]):
        return "none"
    said = f"{row['value']:.4g}"
    if np.isfinite(row["low"]):
        level = f"{100 * about['level']:g} %"
        said += f"; one more specimen: {row['low']:.4g} to {row['high']:.4g} ({level})"
    if np.isfinite(row["mesh"]):
        said += f"; the mesh: ± {row['mesh']:.2g}"
    return said


def _elements(one: Quantities) -> int:
    return sum(rod.elements for rod in one.run.scene.rods)


def _ratio(nominal: Quantities, coarse: Quantities | None) -> float:
    return _elements(nominal) / _elements(coarse) if coarse else np.nan


def _pitch(one: Quantities) -> float:
    """Return the length over which the phase of a winding pair drops out [m]."""
    rod = one.run.scene.rods[0]
    if rod.shape.kind == "helix":
        return rod.shape.pitch
    return float(np.linalg.norm(np.diff(one.run.strands(0)[0], axis=0), axis=1).sum()) / 10


def _newton(one: Quantities) -> float:
    return one.curve.attrs["B"] / one.curve.attrs["l0"] ** 2 if one.combs else np.nan

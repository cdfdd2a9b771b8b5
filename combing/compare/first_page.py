"""What a reader meets first: how far experiment and simulation agree, and where; what to cite."""

from collections.abc import Callable, Iterator, Mapping

import numpy as np
import pandas as pd

from combing import __version__
from combing.compare.comparison import Comparison
from combing.compare.sweep import PEAKS_OVER
from combing.report import Section, shown

BIBTEX = """\
@article{plumbreyes2021combing,
  title   = {Combing a double helix},
  author  = {Plumb-Reyes, Thomas Bolton and Charles, Nicholas and Mahadevan, L.},
  journal = {arXiv:2103.05211},
  year    = {2021}
}
@software{combing,
  title   = {combing: measure tangled strands},
  author  = {{The combing developers}},
  version = {VERSION}
}"""
METHODS = {
    "force": "Force logs were scaled as f = l0² F/B over x = d/D with l0 = 10 mm, B the bending "
    "rigidity of one filament and D the displacement at which combing ends; highest force, D and "
    "jams are those of the force averaged over three filament radii of displacement.",
    "link": "Link density λ(s) was measured on photographs from the edges of both strands and, in "
    "simulations, as the row sum of the Gauss link matrix averaged over the length that the "
    "photograph resolves.",
    "interactions": "N-body interactions are connected components of strands that cross within one "
    "of {n_sec} equal sections of the curl's axis.",
    "all": "Strands were simulated as Cosserat rods (Gazzola et al., R. Soc. Open Sci. 5, 171628, "
    "2018; combing {version}, solver {solver}).",
}


def found_section(comparisons: Mapping[str, Comparison]) -> list[Section]:
    """Return the section that says what was found; none where nothing stands beside anything."""
    said: dict[str, Callable[[Comparison], Iterator[str]]] = {
        "force": _force, "sweep": _sweep, "link": _link, "interactions": _curls,
    }  # fmt: skip
    text = [one for kind, say in said.items() if kind in comparisons
            for one in say(comparisons[kind])]  # fmt: skip
    return [Section("What was found", text)] if text else []


def closing_section(kinds: Mapping[str, Comparison], n_sec: int, solver: str) -> Section:
    """Return a paragraph of methods to paste, and what to cite."""
    parts = [METHODS[one] for one in ("force", "link", "interactions") if one in kinds]
    if "sweep" in kinds and "force" not in kinds:
        parts.insert(0, METHODS["force"])
    text = " ".join([*parts, METHODS["all"]])
    methods = text.format(n_sec=n_sec, version=__version__, solver=solver)
    return Section("Methods, to paste", [methods], quote=BIBTEX.replace("VERSION", __version__))


def _force(found: Comparison) -> Iterator[str]:
    numbers = dict(found.numbers)
    apart, peaks = (
        numbers.get(one, pd.DataFrame())
        for one in ("Simulation against every repeat", "Force peak, work and distance")
    )
    for name in apart["set"].unique() if len(apart) else []:
        row = apart[apart["set"] == name].iloc[-1]
        own = peaks[peaks["set"] == name]
        model = float(own.loc[own["curve"] == "simulation", "f_max"].iloc[0])
        single = own["curve"].str.startswith("experiment, ") & ~own["curve"].str.contains("mean of")
        low, high = own.loc[single, "f_max"].min(), own.loc[single, "f_max"].max()
        inside = "within" if low <= model <= high else "outside"
        x, size = _where(found.plotted[found.plotted["set"] == name])
        yield (
            f"{name}: the simulation's highest force is {_signed(row['f_max_error'])} the "
            f"experiment's, {inside} its range of {low:.3g} to {high:.3g}; the work is "
            f"{_signed(row['work_error'])}. Curves differ by {row['nrmse']:.0%} of the range "
            f"(r.m.s.), most at x = {x:.2f}, by {shown(size, 2)}."
        )


def _where(plotted: pd.DataFrame) -> tuple[float, float]:
    """Where the simulation is farthest from the mean of the experiment, and how far."""
    mean = plotted[(plotted["source"] == "experiment") & (plotted["curve"] == "mean")]
    run = plotted[plotted["source"] == "simulation"]
    apart = np.interp(mean["x"], run["x"], run["f"]) - mean["f"].to_numpy()
    most = int(np.nanargmax(np.abs(apart)))
    return float(mean["x"].iloc[most]), float(apart[most])


def _sweep(found: Comparison) -> Iterator[str]:
    for title, table in found.numbers:
        over = title.removeprefix(PEAKS_OVER)
        if over == title:
            continue
        for name, rows in table.groupby("set", sort=False):
            for source, own in rows.groupby("source", sort=False):
                yield from _course(f"{name}, {source}", over, own.sort_values(over))
            both = rows.pivot(index=over, columns="source", values="f_max").dropna()
            if {"experiment", "simulation"} <= set(both) and len(both):
                apart = both["simulation"] / both["experiment"] - 1
                yield (
                    f"{name}: the simulation's highest force is {_signed(apart.min())} to "
                    f"{_signed(apart.max())} the experiment's, farthest from it at {over} = "
                    f"{apart.abs().idxmax():g}."
                )


def _course(name: str, over: str, rows: pd.DataFrame) -> Iterator[str]:
    """Say how the highest force goes over the values of a set."""
    if len(rows) < 2:
        return
    peaks, values = rows["f_max"].to_numpy(), rows[over].to_numpy()
    steps = np.diff(peaks)
    way = "rising" if (steps > 0).all() else "falling" if (steps < 0).all() else "up and down"
    yield (
        f"{name}: the highest force is {peaks[0]:.3g} at {over} = {values[0]:g} and "
        f"{peaks[-1]:.3g} at {over} = {values[-1]:g}, {way} between the {len(rows)} values."
    )


def _link(found: Comparison) -> Iterator[str]:
    table = dict(found.numbers).get("Link density", pd.DataFrame())
    if "RMS difference (1/m)" not in table:
        return
    for name, rows in table.dropna(subset=["RMS difference (1/m)"]).groupby("set", sort=False):
        apart = rows["RMS difference (1/m)"] / rows["λ, experiment (1/m)"].abs()
        worst = rows.iloc[int(np.argmax(apart))]
        yield (
            f"{name}: λ(s) of photograph and simulation differ by {apart.min():.0%} to "
            f"{apart.max():.0%} of λ (r.m.s. over what is resolved), most with the tine at "
            f"d = {1e3 * worst['d (m)']:.0f} mm."
        )


def _curls(found: Comparison) -> Iterator[str]:
    table = dict(found.numbers).get("Mean density of N-body interactions (1/m)", pd.DataFrame())
    if not {"experiment", "simulation"} <= set(table):
        return
    for _, row in table[table["N"] == 2].iterrows():
        spread = [row[f"{one}, sd over curls"] for one in ("experiment", "simulation")]
        gap = abs(row["experiment"] - row["simulation"])
        agree = "agree within" if gap <= np.hypot(*spread) else "differ by more than"
        yield (
            f"{row['set']}: {row['experiment']:.0f} interactions of pairs per metre in "
            f"photographs, {row['simulation']:.0f} in simulations; they {agree} the scatter over "
            "curls."
        )


def _signed(error: float) -> str:
    return f"{abs(error):.0%} {'above' if error > 0 else 'below'}"

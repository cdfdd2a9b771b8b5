"""N-body interactions of photographed and simulated curls, counted by the same rule."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

import imaging
import sim
from combing.bands import read_bands
from combing.bands.quantities import SECTIONS
from combing.compare.comparison import Comparison, error_row, says_synthetic, stacked
from combing.compare.curl_views import over_sections, over_views, seen_from, strand_table
from combing.photographs import Refused, content_of, measured_only
from combing.study import CurlSet
from combing.tables import read_table
from combing.view import said_of
from imaging.measure import BESIDE, measure


def measure_curl(path: Path, chosen: CurlSet, n_sec: int) -> pd.DataFrame:
    """Count the N-body interactions in one photograph, as `combing photo` does.

    Returns
    -------
    DataFrame
        ``section, N, count, density`` [1/m]; ``attrs`` hold ``sample``, ``strands`` found,
        ``crossings``, ``length`` [m], ``notes``, ``content`` (a hash), ``synthetic``, ``lines`` [m]
        and densities in other ``sections``.

    Raises
    ------
    imaging.Unmeasurable
        If the photograph does not show at least two strands.
    """
    photo = chosen.view.read(path)
    said = said_of(photo, BESIDE, f"[[curl]] {chosen.name!r}", colours=chosen.colours)
    seen = measure(photo, chosen.view.scale, n_sec, corrections=said)
    if seen.interactions is None or seen.scale is None:
        raise imaging.Unmeasurable(f"{path}: {len(seen.strands)} strand(s); a curl has several")
    unit = seen.scale.metres_per_pixel
    found = _counted(seen.strands, seen.interactions, seen.crossings, unit)
    found.attrs |= {"sample": path.stem, "synthetic": says_synthetic(photo.exif)}
    found.attrs |= {"content": content_of(photo), "notes": seen.notes}
    return found


def count_interactions(
    strands: Sequence[imaging.Strand | np.ndarray], unit: float, n_sec: int
) -> pd.DataFrame:
    """Count interactions of strands given in lengths of `unit` [m]; densities come out in 1/m."""
    table = imaging.crossings(strands)
    return _counted(strands, imaging.interactions(strands, n_sec, table=table), table, unit)


def _counted(
    strands: Sequence[imaging.Strand | np.ndarray],
    interactions: pd.DataFrame,
    crossings: pd.DataFrame,
    unit: float,
) -> pd.DataFrame:
    """Take interactions from lengths of `unit` to metres, with how much was counted."""
    found = interactions.assign(density=interactions["density"] / unit)
    lines = [one.line if isinstance(one, imaging.Strand) else one for one in strands]
    found.attrs = {
        **interactions.attrs,
        "strands": len(strands),
        "crossings": int((crossings["kind"] == "inter").sum()),
        "length": interactions.attrs["length"] * unit,
        "lines": [unit * line for line in lines],
        "sections": over_sections(strands, crossings, unit),
    }
    return found


def project_curl(run: sim.Run) -> list[np.ndarray]:
    """Project the settled curl on a vertical plane as a distant camera sees it, (n, 2) [m]."""
    return seen_from(run.strands(-1))


def simulated_curl(run: sim.Run, sample: str, n_sec: int) -> pd.DataFrame:
    """Count the interactions of a simulated curl; as `measure_curl`, and other ``views``."""
    found = count_interactions(project_curl(run), 1.0, n_sec)
    lines = run.strands(-1)
    found.attrs |= {"sample": sample, "lines": lines, "views": over_views(lines, n_sec)}
    found.attrs["bands"] = _bands(run) if n_sec == SECTIONS else {}
    return found


def _bands(run: sim.Run) -> dict[int, tuple[float, float]]:
    """Return the band of one more specimen's density of each N, where the run carries bands."""
    if (bands := read_bands(run)) is None:
        return {}
    rows = bands.numbers.dropna(subset=["low", "high"])
    rows = rows[rows["quantity"].str.startswith("rho_")]
    places = zip(rows["quantity"], rows["low"], rows["high"], strict=True)
    return {int(name.removeprefix("rho_")): (max(low, 0.0), high) for name, low, high in places}


def compare_curl(
    chosen: CurlSet,
    photographed: Sequence[pd.DataFrame | Refused],
    runs: Mapping[Path, sim.Run],
    n_sec: int,
) -> Comparison:
    """Compare the densities of photographed curls with those of simulated ones.

    Parameters
    ----------
    chosen : CurlSet
        From the study.
    photographed : list of DataFrame or Refused
        From `measure_curl`, in the order of ``chosen.photos``.
    runs : mapping
        Finished runs by the path that names them in the study.
    n_sec : int
        Sections each curl is cut into.
    """
    _, measured, notes = measured_only(chosen.name, photographed)
    paths = chosen.simulations or []
    simulated = [simulated_curl(runs[path], path.stem, n_sec) for path in paths]
    counted = [("experiment", found) for found in measured]
    counted += [("simulation", found) for found in simulated]
    parts = [_densities(chosen.name, source, found) for source, found in counted]
    plotted = _without_empty(pd.concat(parts, ignore_index=True))
    sensitivity = stacked(_elsewhere(chosen.name, source, found) for source, found in counted)
    return Comparison(
        plotted=plotted,
        numbers=[
            ("Curls", _curls(chosen.name, measured, simulated)),
            ("Mean density of N-body interactions (1/m)", _means(plotted)),
        ],
        errors=_errors(chosen, measured),
        notes=[
            *notes,
            *_doubts(chosen, measured),
            *_wrong_counts(chosen, measured),
            *_unrest({path: runs[path] for path in paths}),
        ],
        synthetic=any(found.attrs["synthetic"] for found in measured),
        curves=stacked(
            _lead(chosen.name, source, curls)
            for source, curls in (("experiment", measured), ("simulation", simulated))
        ),
        strands=stacked(
            strand_table(chosen.name, source, found.attrs["sample"], found.attrs["lines"])
            for source, found in counted
        ),
        sensitivity=sensitivity,
    )


def _elsewhere(name: str, source: str, found: pd.DataFrame) -> pd.DataFrame:
    """Return the densities of a curl in other sections and views, with its name."""
    tables = [found.attrs[what] for what in ("sections", "views") if what in found.attrs]
    return stacked(tables).assign(set=name, source=source, sample=found.attrs["sample"])


def _lead(name: str, source: str, curls: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return one row a curl: by how much pairs lead over the next most frequent N, over all."""
    rows = []
    for found in curls:
        count = found.groupby("N")["count"].sum()
        lead = count.get(2, 0) - count.drop(2, errors="ignore").max()
        rows.append({"value": found.attrs["strands"], "lead_of_pairs": lead / count.sum()})
    return pd.DataFrame(rows).assign(set=name, over="N", source=source)


def _densities(name: str, source: str, found: pd.DataFrame) -> pd.DataFrame:
    """Density over the whole curl of each N [1/m], with its 95 % interval over the sections.

    A simulated curl that carries bands has those of one more specimen instead.
    """
    groups = found.groupby("N")
    count, sections = groups["count"].sum(), groups["density"]
    half = stats.t.ppf(0.975, sections.count() - 1) * sections.sem()
    density = count / found.attrs["length"]
    table = pd.DataFrame(
        {"count": count, "density": density, "low": density - half, "high": density + half}
    )
    for n, ends in found.attrs.get("bands", {}).items():
        if n in table.index:
            table.loc[n, ["low", "high"]] = ends
    named = table.reset_index().assign(set=name, source=source, sample=found.attrs["sample"])
    return named[["set", "source", "sample", "N", "count", "density", "low", "high"]]


def _without_empty(plotted: pd.DataFrame) -> pd.DataFrame:
    """Leave out the large N that no curl of either kind shows."""
    seen = plotted.loc[plotted["count"] > 0, "N"]
    return plotted[plotted["N"] <= max(seen.max() if len(seen) else 2, 3)].reset_index(drop=True)


def _curls(
    name: str, photographed: list[pd.DataFrame], simulated: list[pd.DataFrame]
) -> pd.DataFrame:
    rows = []
    for source, curls in (("photograph", photographed), ("simulation", simulated)):
        for found in curls:
            facts = found.attrs
            rows.append(
                {
                    "set": name,
                    "curl": f"{source} {facts['sample']}",
                    "strands": facts["strands"],
                    "crossings": facts["crossings"],
                    "interactions": int(found["count"].sum()),
                    "length (m)": facts["length"],
                }
            )
    return pd.DataFrame(rows)


def _means(plotted: pd.DataFrame) -> pd.DataFrame:
    rows = []
    for n in sorted(plotted["N"].unique()):
        row: dict[str, object] = {"set": plotted["set"].iloc[0], "N": int(n)}
        for source in plotted["source"].unique():
            chosen = plotted[(plotted["source"] == source) & (plotted["N"] == n)]
            row[source] = float(chosen["density"].mean())
            row[f"{source}, sd over curls"] = float(chosen["density"].std())
        rows.append(row)
    return pd.DataFrame(rows)


def _doubts(chosen: CurlSet, photographed: list[pd.DataFrame]) -> list[str]:
    """Say what is doubtful in the photographs, and which were corrected by hand."""
    return [
        f"{chosen.name}, {found.attrs['sample']}: {note}"
        for found in photographed
        for note in found.attrs.get("notes", [])
    ]


def _unrest(runs: Mapping[Path, sim.Run]) -> list[str]:
    """Say which simulated curls still moved when they were counted."""
    return [f"{path}: {said}" for path, run in runs.items() if (said := run.unrest())]


def _wrong_counts(chosen: CurlSet, photographed: list[pd.DataFrame]) -> list[str]:
    if chosen.strands is None:
        return []
    return [
        f"{chosen.name}, {found.attrs['sample']}: {found.attrs['strands']} strands found "
        f"where there are {chosen.strands}"
        for found in photographed
        if found.attrs["strands"] != chosen.strands
    ]


def _errors(chosen: CurlSet, photographed: list[pd.DataFrame]) -> pd.DataFrame:
    if chosen.truth is None:
        return pd.DataFrame()
    truth = read_table(chosen.truth, ["photo", "section", "N", "count"])
    rows = []
    for found in photographed:
        label = found.attrs["sample"]
        true = truth[truth["photo"] == label].groupby("N")["count"].sum()
        measured = found.groupby("N")["count"].sum()
        for n in range(2, max(true.index.max(), measured.index.max()) + 1):
            counted, there = float(measured.get(n, 0)), float(true.get(n, 0))
            if counted or there:
                row = error_row(chosen.name, label, f"count, N = {n}", counted, there, "")
                rows.append(row)
    return pd.DataFrame(rows)

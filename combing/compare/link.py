"""lambda(s) at several places of the tine: photographed, simulated, and simulated but photographed.

A simulation is measured twice: exactly, by the topology of its strands in space, and through the
camera, by rendering a photograph of it. The difference is the error of the imaging.
"""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

import imaging
import sim
from combing.compare.comparison import Comparison, error_row, says_synthetic
from combing.compare.link_change import changes
from combing.errors import UserError
from combing.photographs import Refused, content_of, measured_only
from combing.study import LinkSet, tine_positions
from combing.tables import read_table
from combing.unlinking import nearest_snapshot
from combing.view import measure_pair
from combing.virtual_lab.helix_photos import Shot, take
from combing.virtual_lab.photographs import MARKER_SIDE
from imaging.helix import helix
from imaging.helix.measurement import HelixMeasurement
from imaging.scale import from_marker


def measure_link(path: Path, chosen: LinkSet) -> pd.DataFrame:
    """Measure the link density in one photograph.

    Returns
    -------
    DataFrame
        As `link_table` has it; ``attrs`` hold ``photo``, ``resolution`` [m],
        ``total_link``, ``R``, ``r`` [m], ``lean`` [rad], ``warnings``, ``content`` (a hash),
        ``synthetic``, ``first`` (`imaging.first_link`) and ``jump``, `imaging.link_jump` as a
        function of lambda_0.

    Raises
    ------
    imaging.Unmeasurable
        If the photograph does not show two strands wound round each other.
    """
    photo, measured = measure_pair(
        path, chosen.view, root=chosen.root, pair=chosen.pair, tine=chosen.tine_in(path)
    )
    found = link_table(measured)
    found.attrs |= {"photo": path.stem, "synthetic": says_synthetic(photo.exif)}
    found.attrs |= {"content": content_of(photo)}
    return found


def link_table(found: HelixMeasurement) -> pd.DataFrame:
    """Return the link density (s, link, sd, sides) of a helix measured in metres, with its facts.

    Where ``sides``, it is the mean over a pitch that is cut at the tine (`imaging.helix.sides`).
    """
    table = found.link_density.assign(sides=found.phase["by"] == "sides")
    table.attrs = {
        "tine": found.tine,
        "resolution": found.resolution,
        "total_link": found.total_link,
        "R": found.R,
        "r": found.r,
        "lean": found.lean,
        "first": imaging.first_link(found),
        "jump": lambda lambda_0: imaging.link_jump(found, lambda_0),
        "warnings": list(found.warnings),
    }
    return table


def compare_link(
    chosen: LinkSet,
    before: pd.DataFrame | Refused | None,
    photographed: Sequence[pd.DataFrame | Refused],
    runs: Mapping[Path, sim.Run],
) -> Comparison:
    """Compare photographed link densities with the simulation's at the same tine positions.

    Parameters
    ----------
    chosen : LinkSet
        From the study.
    before : DataFrame, Refused or None
        `measure_link` of the photograph before the tine was inserted.
    photographed : list of DataFrame or Refused
        `measure_link` of the others, in the order of ``chosen.photos``.
    runs : mapping
        Finished runs by the path that names them in the study.
    """
    places, measured, notes = measured_only(chosen.name, photographed)
    positions = [tine_positions(chosen)[i] for i in places]
    if isinstance(before, Refused):
        notes += [f"{chosen.name}, {before.photo.stem}: no reference, {before.reason}"]
        before = None
    run = runs[chosen.simulation] if chosen.simulation else None
    reference = None if before is None else before.attrs["first"][0]
    parts, rows = [], []
    notes += _warnings(chosen.name, [before, *measured])
    for d, seen in zip(positions, measured, strict=True):
        curves = {"experiment": seen}
        if run is not None:
            curves["simulation"] = simulated_link(run, d, seen.attrs["resolution"])
            if chosen.photograph_simulation:
                try:
                    curves["camera"] = photographed_link(run, d)
                except imaging.Unmeasurable as error:
                    notes.append(f"{chosen.name}, simulation at d = {d:g} m: no camera, {error}")
        tine = d + tine_start(run) if run is not None else np.nan
        place = {"set": chosen.name, "photo": seen.attrs["photo"], "d": d, "tine": tine}
        parts += [_plotted(place, source, curve) for source, curve in curves.items()]
        rows.append(_row(chosen.name, seen.attrs["photo"], d, curves))
    plotted = pd.concat(parts, ignore_index=True)
    plotted["reference"] = reference if reference is not None else plotted["link"].median()
    everything = measured if before is None else [before, *measured]
    return Comparison(
        plotted=plotted,
        numbers=[("Link density", pd.DataFrame(rows))],
        errors=_errors(chosen, everything),
        notes=notes,
        synthetic=any(found.attrs["synthetic"] for found in everything),
        change=changes(chosen, before, measured, positions, run),
    )


def simulated_link(run: sim.Run, d: float, resolution: float) -> pd.DataFrame:
    """Link density in the snapshot nearest to tine displacement `d`, averaged like a photograph."""
    snapshot = nearest_snapshot(run, d)
    first, second = run.strands(snapshot)[:2]
    found = sim.link_density(first, second, resolution=resolution)
    found.attrs |= {"d": float(run.displacements[snapshot])}
    return found


def photographed_link(run: sim.Run, d: float) -> pd.DataFrame:
    """Link density of the same snapshot through the camera: rendered, then measured.

    Raises
    ------
    combing.errors.UserError
        If pyvista is not installed.
    """
    snapshot = nearest_snapshot(run, d)
    shot = Shot(f"simulation_{snapshot}", snapshot, float(run.displacements[snapshot]))
    picture = imaging.Photo(take(run, shot, rng=snapshot), source=shot.name)
    scale, photo = from_marker(picture, MARKER_SIDE)
    return link_table(helix(photo, scale=scale))


def tine_start(run: sim.Run) -> float:
    """Distance of the tine's first place from the clamp along its way [m]."""
    tine = run.scene.tines[0]
    way = np.array(tine.direction) / np.linalg.norm(tine.direction)
    return float(np.dot(tine.position, way))


def averaged(
    s: np.ndarray, link: np.ndarray, at: np.ndarray, width: float, end: float = np.inf
) -> np.ndarray:
    """Mean of a link density over a `width` around every `at`, cut at `end` (all in m)."""
    turns = np.concatenate([[0], np.cumsum((link[1:] + link[:-1]) / 2 * np.diff(s))])
    low, high = np.maximum(at - width / 2, s[0]), np.minimum(at + width / 2, min(s[-1], end))
    return (np.interp(high, s, turns) - np.interp(low, s, turns)) / np.maximum(high - low, 1e-12)


def _plotted(place: dict, source: str, curve: pd.DataFrame) -> pd.DataFrame:
    columns = {name: curve[name].to_numpy() for name in ("s", "link", "sd")}
    return pd.DataFrame(place | {"source": source} | columns)


def _row(name: str, photo: str, d: float, curves: Mapping[str, pd.DataFrame]) -> dict:
    seen = curves["experiment"]
    row: dict[str, object] = {
        "set": name,
        "photo": photo,
        "d (m)": d,
        "λ, experiment (1/m)": float(seen["link"].mean()),
        "resolved": f"{seen['link'].notna().mean():.0%}",
        "lean (°)": float(np.degrees(seen.attrs["lean"])),
    }
    if "simulation" in curves:
        model = curves["simulation"]
        there = np.interp(seen["s"], model["s"], model["link"])
        row["λ, simulation (1/m)"] = float(np.mean(there[seen["link"].notna()]))
        row["RMS difference (1/m)"] = rms(seen["link"] - there)
        row["d, simulation (m)"] = model.attrs["d"]
    if "camera" in curves:
        camera, model = curves["camera"], curves["simulation"]
        there = np.interp(camera["s"], model["s"], model["link"])
        row["RMS error of the imaging (1/m)"] = rms(camera["link"] - there)
    return row


def rms(difference: pd.Series | np.ndarray) -> float:
    """Root mean square, leaving out what is not resolved."""
    return float(np.sqrt(np.nanmean(np.square(difference))))


def _warnings(name: str, measured: list[pd.DataFrame | None]) -> list[str]:
    return [
        f"{name}, {found.attrs['photo']}: {warning}"
        for found in measured
        if found is not None
        for warning in found.attrs["warnings"]
    ]


def _errors(chosen: LinkSet, photographed: list[pd.DataFrame]) -> pd.DataFrame:
    if chosen.truth is None:
        return pd.DataFrame()
    truth = read_table(chosen.truth, ["photo", "s", "link"])
    rows = []
    for found in photographed:
        label = found.attrs["photo"]
        true = truth[truth["photo"] == label]
        if true.empty:
            raise UserError(f"{chosen.truth}: holds no rows with photo = {label}")
        rows += _photo_errors(chosen.name, label, found, true)
    return pd.DataFrame(rows)


def _photo_errors(name: str, label: str, found: pd.DataFrame, true: pd.DataFrame) -> list[dict]:
    seen = found[found["link"].notna() & ~found["sides"]]
    s, link = true["s"].to_numpy(), true["link"].to_numpy()
    there = averaged(s, link, seen["s"].to_numpy(), found.attrs["resolution"])
    row = partial(error_row, name, label)
    rows = [row("mean λ", float(seen["link"].mean()), float(there.mean()), "1/m")]
    spread = {"λ(s), RMS": rms(seen["link"].to_numpy() - there)}
    behind = found[found["sides"] & (found["s"] < (found.attrs["tine"] or 0.0))]
    if len(behind):
        there = averaged(
            s, link, behind["s"].to_numpy(), abs(1 / seen["link"].median()), found.attrs["tine"]
        )
        spread["λ over a pitch behind the tine, RMS"] = rms(behind["link"].to_numpy() - there)
    unknown = {"measured": np.nan, "truth": np.nan}
    return rows + [rows[0] | unknown | {"quantity": what, "error": e} for what, e in spread.items()]

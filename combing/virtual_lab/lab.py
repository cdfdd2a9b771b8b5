"""Make the data set: simulate the specimens, photograph and comb them, write down the truth."""

import hashlib
import json
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from tqdm import tqdm

import instron
import sim
from combing import __version__
from combing.render import load_pyvista
from combing.runs import model_version, simulating
from combing.tables import write_table
from combing.virtual_lab import curl_photos, helix_photos
from combing.virtual_lab.machine import draw_cell, record
from combing.virtual_lab.overview import draw_overview
from combing.virtual_lab.papers import RIG, STUDY, readme
from combing.virtual_lab.photographs import save_photo
from combing.virtual_lab.specimens import SEED, Specimen, curls, helices, study_scenes

N_SEC = 20
SYNTHETIC = "synthetic data: made by the virtual lab, not measured"


def make(out: Path, runs_folder: Path, *, jobs: int | None = None, quiet: bool = False) -> None:
    """Make the virtual lab's data set in `out`.

    Runs and photographs that exist are used again as long as neither the solver nor the lab has
    changed, so an interrupted call goes on where it stopped.

    Parameters
    ----------
    out : Path
        Folder of the data set.
    runs_folder : Path
        Where the specimens' runs are kept; not part of the data set.
    jobs : int, optional
        Simulations at once; as many as there are cores when absent.
    quiet : bool
        Show no progress.

    Raises
    ------
    combing.errors.UserError
        If pyvista is not installed.
    """
    load_pyvista()
    combed, hanging = helices(), curls()
    scenes = {specimen.name: specimen.scene for specimen in (*combed, *hanging)}
    with simulating(scenes, runs_folder, jobs=jobs, quiet=quiet) as wait:
        runs = wait()
    _write_manifest(out, [*combed, *hanging])
    _write_papers(out)
    _write_logs(out, combed, runs)
    _write_link_truth(out, runs[combed[0].name])
    _write_interaction_truth(out, hanging, runs)
    _write_strands(out, combed[0], hanging, runs)
    _take_photographs(out, combed[0], hanging, runs, quiet)
    draw_overview(out)


def lab_version() -> str:
    """Hash of the sources that decide what a photograph looks like, and of the solver."""
    folder = Path(__file__).parent
    sources = [
        *sorted(folder.glob("*.py")),
        folder.parent / "render.py",
        folder.parent / "camera.py",
    ]
    content = b"".join(path.read_bytes() for path in sources)
    return hashlib.sha256(content + model_version().encode()).hexdigest()[:12]


def _write_manifest(out: Path, specimens: list[Specimen]) -> None:
    """Write what was made with what; photographs of another version of the lab are removed."""
    path = out / "truth" / "synthetic_manifest.json"
    old = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    manifest = {
        "what": SYNTHETIC,
        "combing": __version__,
        "lab": lab_version(),
        "solver": model_version(),
        "specimens": {one.name: one.parameters for one in specimens},
    }
    if old.get("lab") != manifest["lab"]:
        for photo in (out / "photos").glob("synthetic_*.jpg"):
            photo.unlink()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")


def _write_papers(out: Path) -> None:
    """Write the README, the rig, the study and its scenes."""
    texts = {"README.md": readme(), "rig.toml": RIG, "study.toml": STUDY}
    texts |= {f"scenes/{name}": text for name, text in study_scenes().items()}
    for name, text in texts.items():
        path = out / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def _write_logs(out: Path, combed: list[Specimen], runs: Mapping[str, sim.Run]) -> None:
    """Write what the testing machine exports of every combing, and the true forces."""
    (out / "logs").mkdir(parents=True, exist_ok=True)
    truth = []
    for number, specimen in enumerate(combed, start=1):
        rng = np.random.default_rng([SEED, number, 7])
        true = runs[specimen.name].force_log()
        cell = draw_cell(rng)
        log = record(true, cell, samples=len(true), rng=rng)
        facts = {
            "General : Origin": SYNTHETIC,
            "General : Method": "combing of a double helix, virtual lab",
            "Text Inputs : Specimen label": specimen.name,
            "Number Inputs : Friction coefficient": specimen.parameters["friction"],
            "Number Inputs : P/r": specimen.parameters["pi1"],
        }
        instron.write_bluehill(out / "logs" / f"{specimen.name}.csv", log, facts)
        truth.append(true[["time", "displacement", "force"]].assign(log=specimen.name))
    table = pd.concat(truth)[["log", "time", "displacement", "force"]]
    write_table(out / "truth" / "synthetic_force.csv", table, [SYNTHETIC, "s, m, N"])


def _write_link_truth(out: Path, run: sim.Run) -> None:
    chosen = helix_photos.shots(run)
    link = pd.concat([helix_photos.true_link(run, shot) for shot in chosen])
    write_table(out / "truth" / "synthetic_link.csv", link, [SYNTHETIC, "s in m, link in 1/m"])
    places = pd.DataFrame(
        {"photo": [f"{one.name}.jpg" for one in chosen], "d": [one.d for one in chosen]}
    )
    about = [SYNTHETIC, "tine displacement d in m; none before the tine is inserted"]
    write_table(out / "photos" / "synthetic_helix_positions.csv", places, about)


def _write_interaction_truth(
    out: Path, hanging: list[Specimen], runs: Mapping[str, sim.Run]
) -> None:
    tables = [curl_photos.true_interactions(runs[one.name], one.name, N_SEC) for one in hanging]
    table = pd.concat(tables)
    about = [SYNTHETIC, f"{N_SEC} sections; counts of zero left out"]
    path = out / "truth" / "synthetic_interactions.csv"
    write_table(path, table[table["count"] > 0], about)


def _write_strands(
    out: Path, combed: Specimen, hanging: list[Specimen], runs: Mapping[str, sim.Run]
) -> None:
    """Write the nodes of everything photographed, (n, 3) [m], one array a strand."""
    arrays: dict[str, np.ndarray] = {}
    for shot in helix_photos.shots(runs[combed.name]):
        strands = runs[combed.name].strands(shot.snapshot)
        arrays |= {f"{shot.name}/{k}": strand for k, strand in enumerate(strands, start=1)}
    for one in hanging:
        hairs = runs[one.name].strands(-1)
        arrays |= {f"{one.name}/{k}": hair for k, hair in enumerate(hairs, start=1)}
    np.savez_compressed(out / "truth" / "synthetic_strands.npz", allow_pickle=False, **arrays)


def _take_photographs(
    out: Path,
    combed: Specimen,
    hanging: list[Specimen],
    runs: Mapping[str, sim.Run],
    quiet: bool,
) -> None:
    run = runs[combed.name]
    pictures: dict[str, Callable] = {
        shot.name: partial(helix_photos.take, run, shot) for shot in helix_photos.shots(run)
    }
    pictures |= {one.name: partial(curl_photos.take, runs[one.name]) for one in hanging}
    named = tqdm(pictures.items(), desc="taking photographs", disable=quiet)
    for number, (name, take) in enumerate(named):
        path = out / "photos" / f"{name}.jpg"
        if not path.exists():
            pixels = take(rng=SEED + number)
            save_photo(path, pixels, {"what": name, "seed": SEED + number})

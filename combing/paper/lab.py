"""Machine exports of the panels' specimens from the virtual lab: synthetic, and labelled so."""

import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import instron
from combing.ensemble import Member, members
from combing.errors import UserError
from combing.paper.panels import Panel
from combing.runs import trying
from combing.virtual_lab.machine import draw_cell, record
from combing.virtual_lab.specimens import FRICTION, SEED

SYNTHETIC = "synthetic data: made by the virtual lab, not measured"
Specimen = tuple[str, Member]


def write_logs(
    chosen: Sequence[Panel], repeats: int, out: Path, *, jobs: int | None, quiet: bool
) -> list[str]:
    """Comb the specimens of every measured panel; return what could not be combed, and why.

    Each specimen has a friction coefficient of its own between 0.1 and 0.3, and the imperfections
    of `combing.ensemble`; the load cell adds offset, drift and noise. The exports are in
    ``out/lab``, the runs in ``out/runs``.
    """
    specimens = dict(
        one for panel in chosen if panel.measured for one in specimens_of(panel, repeats)
    )
    scenes = {name: member.scene for name, member in specimens.items()}
    (out / "lab").mkdir(parents=True, exist_ok=True)
    for stale in (out / "lab").glob("synthetic_*.csv"):  # of another size
        stale.unlink()
    failed = []
    with trying(scenes, out / "runs", jobs=jobs, quiet=quiet) as wait:
        for name, run in wait().items():
            if isinstance(run, Exception):
                failed.append(f"virtual lab, {name}: {run}")
                continue
            rng = np.random.default_rng([SEED, zlib.crc32(name.encode())])
            log = record(run.force_log(), draw_cell(rng), samples=4000, rng=rng)
            facts = {"General : Origin": SYNTHETIC, "Text Inputs : Specimen label": name}
            instron.write_bluehill(out / "lab" / f"{name}.csv", log, facts)
    if len(failed) == len(scenes):
        raise UserError(failed[0])
    return failed


def specimens_of(panel: Panel, repeats: int) -> Iterator[Specimen]:
    """Return name and scene of every specimen of a panel."""
    for value in panel.values:
        for number in range(1, repeats + 1):
            seed = zlib.crc32(f"{panel.stem} {value:g} {number}".encode())
            friction = np.random.default_rng([SEED, seed]).uniform(*FRICTION)
            asked = {**panel.fixed, panel.over: value, "friction": round(float(friction), 3)}
            (member,) = members("double_helix", asked, [seed])
            yield f"synthetic_{panel.stem}_{value:g}_{number}", member

"""Write the paper's study, with the virtual lab's data in the lab's place, and carry it out."""

import json
import logging
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from combing import __version__
from combing.compare import Result, compare
from combing.compare.curl_pages import first_photo
from combing.paper.figures import write_figures
from combing.paper.lab import write_logs
from combing.paper.panels import REPEATS, Panel, panels
from combing.report import write_report
from combing.study import Study, load_study
from combing.virtual_lab.packaged import data_folder
from combing.virtual_lab.papers import photographed
from combing.virtual_lab.specimens import RADIUS, YOUNG
from sim.records.files import replacing

log = logging.getLogger("combing")
RIG = f"""\
# The virtual lab's specimens (synthetic). SI units.
r = {RADIUS}
E = {YOUNG:.6g}
poisson = 0.4
"""


def make_paper(
    out: Path, *, quick: bool = False, jobs: int | None = None, quiet: bool = False
) -> Result:
    """Make figures, costs and claims in `out`.

    Strategy: specimens are combed in the virtual lab, their exports, the packaged photographs and
    ``study.toml`` written, and the study carried out like any other; a study that was edited is
    carried out as it is. Then the paper's figures are drawn by their numbers into ``out/figures``,
    with ``out/paper.html`` to look at. Runs are kept in ``out/runs``, so the same call goes on
    where it stopped.

    Parameters
    ----------
    out : Path
        Folder for the study and the report.
    quick : bool
        Helices of 0.06 m, one run a value and few photographs instead of 0.15 m, five and all.
    jobs : int, optional
        Simulations at once; as many as there are cores when absent.
    quiet : bool
        Show no progress.
    """
    failed = []
    if _is_edited(out / "study.toml"):
        log.info("%s was edited: carried out as it is", out / "study.toml")
    else:
        failed = _write_study(out, quick, jobs=jobs, quiet=quiet)
    study = load_study(out / "study.toml")
    result = compare(study, out, jobs=jobs, quiet=quiet)
    _write_page(study, result, out)
    return Result(result.report, result.comparisons, failed + result.left_out)


def _write_study(out: Path, quick: bool, *, jobs: int | None, quiet: bool) -> list[str]:
    """Comb the specimens, put photographs beside them, write the study; return what failed."""
    chosen, repeats = panels(quick), _repeats(quick)
    failed = write_logs(chosen, repeats, out, jobs=jobs, quiet=quiet)
    for folder in ("photos", "scenes", "truth"):
        shutil.copytree(data_folder() / folder, out / "lab" / folder, dirs_exist_ok=True)
    text = study_text(chosen, repeats, quick)
    for name, content in (("rig.toml", RIG), ("study.toml", text)):
        with replacing(out / name) as temporary:
            temporary.write_text(content, encoding="utf-8")
    return failed


def _write_page(study: Study, result: Result, out: Path) -> None:
    found = result.comparisons
    curls = found.get("interactions")
    photo = first_photo(study.curl[0], curls) if curls and study.curl else None
    sections = write_figures(found, photo, out / "figures")
    write_report(
        out / "paper.html",
        f"{study.title}: the paper's figures",
        sections,
        about=f"combing {__version__}; each figure is a PNG, an SVG and a CSV in figures/",
        footer="Tables, claims, notes and where the numbers come from: report.html.",
        synthetic=any(one.synthetic for one in found.values()),
        files="figures/",
    )


def _repeats(quick: bool) -> int:
    return 1 if quick else REPEATS


def _is_edited(path: Path) -> bool:
    """Tell whether a lab has put its own files into a study, which then is left alone."""
    own = [study_text(panels(quick), _repeats(quick), quick) for quick in (True, False)]
    return path.exists() and path.read_text(encoding="utf-8") not in own


def study_text(chosen: Sequence[Panel], repeats: int, quick: bool) -> str:
    """Return the study file of the panels and of the virtual lab's photographs."""
    lines = [
        "# The paper's figures. Exports and photographs are synthetic (virtual lab): name your own",
        "# files in their place, or leave sets out, and call combing paper again.",
        "# docs/study.md lists the keys.",
        'title = "Combing a double helix"',
    ]
    for panel in chosen:
        table = {"name": panel.name, "over": panel.over, "values": list(panel.values)}
        if panel.measured:
            table |= {"logs": f"lab/synthetic_{panel.stem}_{{value}}_*.csv", "rig": "rig.toml"}
        lines += ["", "[[sweep]]", *(f"{key} = {json.dumps(one)}" for key, one in table.items())]
        lines += [f"fixed = {_inline(panel.fixed)}", f"seeds = {repeats}"]
    numbers = {"helices": "[25]", "curls": "[1]"} if quick else {}
    return "\n".join(lines) + "\n" + photographed("lab/", **numbers)


def _inline(table: Mapping[str, Any]) -> str:
    """Write an inline table of TOML."""
    return "{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in table.items()) + " }"

"""Write the paper's study, with exports of the virtual lab in the lab's place, and carry it out."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from combing.compare import Result, compare
from combing.errors import UserError
from combing.paper.lab import write_logs
from combing.paper.panels import REPEATS, Panel, panels
from combing.study import load_study
from combing.virtual_lab.specimens import RADIUS, YOUNG
from sim.files import replacing

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

    Strategy: specimens are combed in the virtual lab, their exports and ``study.toml`` written, and
    the study carried out like any other. Runs are kept in ``out/runs``, so the same call goes on
    where it stopped.

    Parameters
    ----------
    out : Path
        Folder for the study and the report.
    quick : bool
        Helices of 0.06 m and one run a value instead of 0.15 m and five.
    jobs : int, optional
        Simulations at once; as many as there are cores when absent.
    quiet : bool
        Show no progress.

    Raises
    ------
    UserError
        The study in `out` is not this command's own any more.
    """
    _refuse_edited(out / "study.toml")
    chosen, repeats = panels(quick), _repeats(quick)
    failed = write_logs(chosen, repeats, out, jobs=jobs, quiet=quiet)
    for name, text in (("rig.toml", RIG), ("study.toml", study_text(chosen, repeats))):
        with replacing(out / name) as temporary:
            temporary.write_text(text, encoding="utf-8")
    result = compare(load_study(out / "study.toml"), out, jobs=jobs, quiet=quiet)
    return Result(result.report, result.comparisons, failed + result.left_out)


def _repeats(quick: bool) -> int:
    return 1 if quick else REPEATS


def _refuse_edited(path: Path) -> None:
    """Leave a study alone that a lab has put its own files into."""
    own = [study_text(panels(quick), _repeats(quick)) for quick in (True, False)]
    if path.exists() and path.read_text(encoding="utf-8") not in own:
        raise UserError(
            f"{path}: was edited and would be lost; carry it out with combing compare {path}, or "
            "give another folder with -o"
        )


def study_text(chosen: Sequence[Panel], repeats: int) -> str:
    """Return the study file of the panels."""
    lines = [
        "# The paper's force curves. The exports are synthetic (virtual lab): name your own files",
        "# in their place, or leave logs out. docs/study.md lists the keys.",
        'title = "Combing a double helix: the force curves"',
    ]
    for panel in chosen:
        table = {"name": panel.name, "over": panel.over, "values": list(panel.values)}
        if panel.measured:
            table |= {"logs": f"lab/synthetic_{panel.stem}_{{value}}_*.csv", "rig": "rig.toml"}
        lines += ["", "[[sweep]]", *(f"{key} = {json.dumps(one)}" for key, one in table.items())]
        lines += [f"fixed = {_inline(panel.fixed)}", f"seeds = {repeats}"]
    return "\n".join(lines) + "\n"


def _inline(table: Mapping[str, Any]) -> str:
    """Write an inline table of TOML."""
    return "{ " + ", ".join(f"{key} = {json.dumps(value)}" for key, value in table.items()) + " }"

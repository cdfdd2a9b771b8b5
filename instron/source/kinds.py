"""Kinds of files by their names: exports, and what testing machines save for themselves."""

import re
from pathlib import Path

from instron.errors import NoLog

EXPORTS = frozenset(
    (".csv", ".txt", ".tra", ".dat", ".tsv", ".asc", ".lvm",
     ".xlsx", ".xlsm", ".xls", ".ods", ".zs2")
)  # fmt: skip
BLUEHILL = "export the raw data from Bluehill as CSV (Method: Export; or Results: Export raw data)"
TESTXPERT = "export the specimens from testXpert as ASCII (.TRA, .txt) or Excel"
OWN = {
    r"\.is_\w+": f"a Bluehill sample: {BLUEHILL}",
    r"\.im_\w+": f"a Bluehill method: {BLUEHILL}",
    r"\.id_\w+": f"a Bluehill data file: {BLUEHILL}",
    r"\.(zs2|zp2|zse)": f"a testXpert series: {TESTXPERT}",
}
NAMED = 5  # other files of a folder that are named


def own_format(path: Path) -> str | None:
    """Say what a file is that a testing machine saves for itself, and how to export it."""
    suffix = path.suffix.casefold()
    return next((what for name, what in OWN.items() if re.fullmatch(name, suffix)), None)


def exports(folder: str | Path) -> tuple[list[Path], list[tuple[Path, str]]]:
    """Return the files of a folder that may be exports, and what is passed over and why.

    Parameters
    ----------
    folder
        Looked at without the folders in it.

    Returns
    -------
    files : list of Path
        By name, with an ending that exports have.
    passed : list of (Path, str)
        Files that a testing machine saved for itself, each with how to export it, and the folder
        itself with the names of others, if there are any.

    Raises
    ------
    NoLog
        When no file has such an ending.
    """
    folder = Path(folder)
    inside = sorted(p for p in folder.iterdir() if p.is_file() and not p.name.startswith("."))
    files = [path for path in inside if path.suffix.casefold() in EXPORTS]
    passed = [(p, f"{p}: {own_format(p)}") for p in inside if p not in files and own_format(p)]
    known = {*files, *(path for path, _ in passed)}
    if not files:
        raise NoLog("; ".join([f"{folder}: no exports ({', '.join(sorted(EXPORTS))}) in this"
                               " folder", *(why for _, why in passed[:1])]))  # fmt: skip
    others = [path.name for path in inside if path not in known]
    if others:
        names = ", ".join(others[:NAMED]) + ", ..." * (len(others) > NAMED)
        passed.append(
            (folder, f"{folder}: {len(others)} with another ending not looked at: {names}")
        )
    return files, passed

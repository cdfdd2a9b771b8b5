"""What every set holds: how many files, specimens, photographs and runs; and what is beside them.

A pattern that catches one of three repeats gives a curve like any other; only the count tells.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import pandas as pd

from combing.study import CurlSet, ForceSet, LinkSet, Study, SweepSet

COUNTS = ("files", "specimens", "photographs", "measured", "runs")
SHOWN = 5  # names of files that a note lists


def holdings(rows: Iterable[tuple[str, str, Mapping[str, int]]]) -> pd.DataFrame:
    """Return a table of (kind, set, counts); what a kind of set does not have stays empty."""
    table = pd.DataFrame(
        [{"kind": kind, "set": name} | dict(counts) for kind, name, counts in rows],
        columns=["kind", "set", *COUNTS],
    )
    return table.astype(dict.fromkeys(COUNTS, "Int64"))


def spoken(kind: str, name: str, counts: Mapping[str, int]) -> str:
    """Say in one line what a set holds."""
    parts = [f"{counts[what]} {what}" for what in COUNTS if what in counts]
    return f"{kind} {name!r}: {', '.join(parts)}".replace(" 1 files", " 1 file")


def overlooked(study: Study) -> list[str]:
    """Return notes on files that lie beside a set's own, of the same kind, and are in no set."""
    sets = study.sets
    used = {path.resolve() for one in sets for path in one.named}
    notes = []
    for folder, ending in sorted({(p.parent, p.suffix) for one in sets for p in one.data}):
        beside = sorted(folder.glob(f"*{ending}")) if ending else []
        others = [path.name for path in beside if path.is_file() and path.resolve() not in used]
        if others:
            notes.append(f"{folder}: {_number(others)} of the same kind in no set: {_some(others)}")
    return notes


def shared(study: Study) -> list[str]:
    """Return notes on files that several sets of one kind hold."""
    notes = []
    for kind in (ForceSet, SweepSet, LinkSet, CurlSet):
        owners: dict[Path, list[str]] = {}
        for one in study.sets:
            for path in one.data if isinstance(one, kind) else []:
                owners.setdefault(path.resolve(), []).append(one.name)
        together: dict[tuple[str, ...], list[str]] = {}
        for path, names in owners.items():
            if len(names) > 1:
                together.setdefault(tuple(names), []).append(path.name)
        notes += [f"{' and '.join(names)} share {_some(f)}" for names, f in together.items()]
    return notes


def _number(names: Sequence[str]) -> str:
    return f"{len(names)} file{'s' if len(names) > 1 else ''}"


def _some(names: Sequence[str]) -> str:
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return ", ".join(names[:SHOWN]) + more

"""Where the tine was in each photograph of a set."""

from pathlib import Path

import pandas as pd

from combing.study.errors import StudyError
from combing.study.sets import LinkSet
from combing.tables import read_table


def tine_positions(link: LinkSet) -> list[float]:
    """Tine displacement d [m] of each photograph, in the order of ``link.photos``.

    Raises
    ------
    StudyError
        If the list or the table does not hold one number per photograph.
    """
    if isinstance(link.positions, Path):
        return [_looked_up(photo.name, link.positions) for photo in link.photos]
    if len(link.positions) != len(link.photos):
        raise StudyError(
            f"[[link]] {link.name!r}: {len(link.photos)} photographs but "
            f"{len(link.positions)} positions; give one d per photograph, in the order of names"
        )
    return link.positions


def _looked_up(photo: str, path: Path) -> float:
    table = read_table(path, ["photo", "d"])
    rows = table.loc[table["photo"] == photo, "d"]
    if len(rows) != 1 or not pd.api.types.is_numeric_dtype(rows):
        raise StudyError(f"{path}: needs one row with a number d for {photo}, has {len(rows)}")
    return float(rows.iloc[0])

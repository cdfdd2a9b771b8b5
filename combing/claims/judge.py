"""Hold every claim against the curves of a study."""

import importlib
import pkgutil
from pathlib import Path

import pandas as pd

from combing.claims.claim import Claim, Verdict

COLUMNS = [
    "claim", "sentence", "where", "set", "source", "curves", "quantity", "value", "low", "high",
    "threshold", "verdict",
]  # fmt: skip


def all_claims() -> dict[str, Claim]:
    """Return every claim by the name of its module."""
    found = {}
    for module in pkgutil.iter_modules([str(Path(__file__).parent)]):
        claim = getattr(importlib.import_module(f"combing.claims.{module.name}"), "CLAIM", None)
        if isinstance(claim, Claim):
            found[module.name] = claim
    return found


def judge(curves: pd.DataFrame) -> pd.DataFrame:
    """Hold every claim against every set that varies what it is about.

    Parameters
    ----------
    curves : DataFrame
        One row a curve: set, over, source, value, f_max, jams, plateaus
        (`combing.compare.sweep.every_curve`).

    Returns
    -------
    DataFrame
        One row a claim, set and source; a claim that no set is about has one row and the verdict
        "cannot tell".
    """
    rows = []
    for name, claim in all_claims().items():
        about = curves[curves["over"] == claim.over] if len(curves) else curves
        said = {"claim": name.replace("_", " "), "sentence": claim.sentence, "where": claim.where}
        said |= {"quantity": claim.quantity, "threshold": claim.threshold}
        if not len(about):
            rows.append(said | {"set": f"none over {claim.over}", "verdict": str(Verdict.OPEN)})
            continue
        for (one, source), own in about.groupby(["set", "source"], sort=False):
            found = claim.measure(own)
            numbers = {} if found is None else vars(found)
            verdict = str(claim.verdict(found))
            place = {"set": one, "source": source, "curves": len(own)}
            rows.append(said | place | numbers | {"verdict": verdict})
    return pd.DataFrame(rows, columns=COLUMNS)

"""What a laboratory reports of one combing: forces, work and load events by their usual names."""

import numpy as np
import pandas as pd

from instron.events import events
from instron.scaling.average import averaged

MIDDLE = (0.25, 0.75)  # of D: the mid-length of a combing
END = 0.75  # of D: where the end peak is looked for


def summary(curve: pd.DataFrame) -> dict[str, float]:
    """Return the numbers of one combing.

    Parameters
    ----------
    curve
        From ``scale``.

    Returns
    -------
    dict
        ``f_max`` with ``f_max_low``, ``f_max_high``, ``x_max``; ``w``; ``W`` [J], the total work;
        ``D`` [m] with ``D_low``, ``D_high``; ``work_per_length`` = W/D [N]; ``mid_force`` [N], the
        mean force over the middle half of D; ``end_peak`` [N], the highest averaged force in the
        last quarter of D; ``peaks``, the number of load events (jams and peaks of ``events``);
        ``event_size`` and ``largest_event`` [N], mean and largest of what the force loses after
        one. Mid-length force and end peak are those of Garcia & Diaz, J. Soc. Cosmet. Chem. 27,
        379 (1976), and Kamath & Weigmann, ibid. 37, 111 (1986); NaN where the record has none.
    """
    facts = curve.attrs
    keys = ("f_max", "f_max_low", "f_max_high", "x_max", "w", "W", "D", "D_low", "D_high")
    smooth = averaged(curve)
    middle = smooth["F"][smooth["x"].between(*MIDDLE)]
    end = smooth["F"][smooth["x"] >= END]
    found = events(curve)
    drops = found.loc[found["kind"] != "plateau", "drop"] * facts["B"] / facts["l0"] ** 2
    return {key: float(facts[key]) for key in keys} | {
        "work_per_length": float(facts["W"] / facts["D"]),
        "mid_force": float(middle.mean()),
        "end_peak": float(end.max()),
        "peaks": len(drops),
        "event_size": float(drops.mean()) if len(drops) else np.nan,
        "largest_event": float(drops.max()) if len(drops) else np.nan,
    }

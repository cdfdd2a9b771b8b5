"""The power law that a table of errors follows, if it follows one."""

import math

import numpy as np
import pandas as pd

SCATTER = 0.5  # in log(error), about a power law that is worth stating


def slope(rows: pd.DataFrame) -> float:
    """Return d log|error| / d log(value) over the rows of a series.

    NaN where there are fewer than three, or where they follow no power law within SCATTER.
    """
    used = rows[rows["error"].abs() > 0]
    if len(used) < 3:
        return math.nan
    x, y = np.log(used["value"]), np.log(used["error"].abs())
    (found, _), residuals, *_ = np.polyfit(x, y, 1, full=True)
    return float(found) if residuals[0] < SCATTER**2 * len(used) else math.nan

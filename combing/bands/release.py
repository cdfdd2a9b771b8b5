"""Where a combing first lets go: up to there a single run says something, beyond it ensembles."""

import numpy as np

RELEASE = 0.85  # of the highest force so far: below it the jam has let go


def first_jam(d: np.ndarray, f: np.ndarray, floor: float) -> tuple[float | None, float | None]:
    """Return place and height of the highest force before the first release, None if none came.

    Parameters
    ----------
    d, f : (n,)
        Displacement, and force averaged over a length of it.
    floor : float
        Force that a jam exceeds.
    """
    highest = np.maximum.accumulate(f)
    released = np.flatnonzero((f < RELEASE * highest) & (highest > floor))
    if not len(released):
        return None, None
    top = int(np.argmax(f[: released[0]]))
    return float(d[top]), float(f[top])

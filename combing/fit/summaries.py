"""What of a curve and of a photograph a fit looks at: the same numbers of logs and of runs.

All but the link density are of F averaged as everywhere (`instron.scale`), so that a log and a run
go through one operator. Logarithms, because scatter grows with what scatters.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd

import instron
import sim
from combing.runs import scaled
from combing.unlinking import nearest_snapshot

PARTS = 5  # of the stroke, over which F is averaged
FLOOR = 0.1  # of f_max: what a jam stands out by, in a quiet run as in a noisy log
PLACES = (0.2, 0.4, 0.6, 0.8)  # of the length before combing, at which lambda is looked at
LEVEL = ("log mean force", "log highest force")  # these alone grow with the rigidity
SHAPE = ("log D", *(f"share of part {k}" for k in range(1, PARTS)), "log spacing of jams")
FORCE = (*LEVEL, *SHAPE)


def of_curve(curve: pd.DataFrame) -> dict[str, float]:
    """Return the summaries of a scaled curve, in newtons and metres.

    Parameters
    ----------
    curve : DataFrame
        From `instron.scale`.

    Returns
    -------
    dict
        By the names of FORCE: W/D and the highest averaged F [N], D [m]; the force in each fifth of
        the stroke but the last, over the mean; D/(1 + jams), the mean way from one release to the
        next, start and end among them [m].
    """
    facts = curve.attrs
    mean = instron.work(curve)[0] / facts["D"]
    x = (np.arange(PARTS) + 0.5) / PARTS
    shares = instron.on_grid(curve, x) * facts["B"] / facts["l0"] ** 2 / mean
    found = instron.events(curve, floor=FLOOR)
    jams = int((found["kind"] == "jam").sum())
    values = [
        np.log(mean),
        np.log(facts["f_max"] * facts["B"] / facts["l0"] ** 2),
        np.log(facts["D"]),
        *shares[:-1],
        np.log(facts["D"] / (1 + jams)),
    ]
    return dict(zip(FORCE, map(float, values), strict=True))


def of_run(run: sim.Run, links: Sequence["Shot"] = ()) -> dict[str, float]:
    """Return the summaries of a combing, with those that photographs show.

    Raises
    ------
    instron.Unscalable
        No force stands out, or combing does not end within the run.
    """
    curve = scaled(run)
    if not curve.attrs["ended"]:
        raise instron.Unscalable(f"{run.data.attrs['title']}: combing does not end within the run")
    return of_curve(curve) | {name: value for shot in links for name, value in shot.of(run)}


class Shot:
    """A photograph: where the tine was in it, and lambda P where it shows lambda.

    Parameters
    ----------
    name : str
    d : float
        Displacement of the tine [m].
    pitch, length : float
        Of the helix before combing [m].
    seen : DataFrame, optional
        As `combing.compare.link.link_table` has it; without it
        all PLACES are looked at, with lambda averaged over a pitch.
    """

    def __init__(
        self, name: str, d: float, pitch: float, length: float, seen: pd.DataFrame | None = None
    ) -> None:
        self.name, self.d, self.pitch = name, d, pitch
        self.resolution = pitch if seen is None else float(seen.attrs["resolution"])
        self.places = [share * length for share in PLACES]
        self.values: list[float] = []
        self.sd: list[float] = []
        if seen is not None:
            self._read(seen)

    def _read(self, seen: pd.DataFrame) -> None:
        # What sides tell behind a tine is a mean that ends at the tine, no plain average.
        known = seen[~seen["sides"]].dropna(subset=["link", "sd"])
        far = self.resolution / 2
        self.places = [s for s in self.places if (known["s"] - s).abs().min() < far]
        for column, into in (("link", self.values), ("sd", self.sd)):
            into += list(np.interp(self.places, known["s"], known[column].abs() * self.pitch))

    @property
    def names(self) -> list[str]:
        """Names of its summaries."""
        return [f"lambda P, {self.name}, s = {1e3 * s:.3g} mm" for s in self.places]

    def of(self, run: sim.Run) -> list[tuple[str, float]]:
        """Return the same of a run, by `sim.link_density` averaged like the photograph."""
        strands = run.strands(nearest_snapshot(run, self.d))
        found = sim.link_density(*strands[:2], resolution=self.resolution)
        link = np.interp(self.places, found["s"], found["link"].abs() * self.pitch)
        return list(zip(self.names, map(float, link), strict=True))

"""What is measured of every run behind a band, by the same operators as everywhere."""

from functools import cached_property

import numpy as np

import imaging
import sim
from combing.bands.release import first_jam
from combing.runs import scaled
from instron.scaling.average import Profile, profile

FLOOR = 0.1  # of the highest force: what a jam exceeds
SECTIONS = 20  # of a curl's axis, in the count of interactions


class Quantities:
    """A run, measured.

    Parameters
    ----------
    run : sim.Run
    """

    def __init__(self, run: sim.Run) -> None:
        self.run = run

    @property
    def combs(self) -> bool:
        """Whether a tine moves."""
        return any(tine.travel > 0 for tine in self.run.scene.tines)

    @property
    def pair(self) -> bool:
        """Whether there are two strands that wind about each other."""
        return len(self.run.scene.rods) == 2

    @cached_property
    def curve(self):
        """The scaled curve; its attributes hold f_max, D, w, B, l0 and the averaging length."""
        return scaled(self.run)

    @cached_property
    def _profile(self) -> Profile:
        return profile(self.curve["d"].to_numpy(), self.curve["f"].to_numpy())

    @property
    def places(self) -> np.ndarray:
        """Displacements [m] at which f is averaged over its length."""
        return self._profile.places(self.curve.attrs["average_over"])

    def force(self, d: np.ndarray) -> np.ndarray:
        """Return averaged f at displacements d [m]."""
        return self._profile.mean(d, self.curve.attrs["average_over"])

    @cached_property
    def jam(self) -> tuple[float | None, float | None]:
        """Place [m] and height f of the first jam."""
        f = self.force(self.places)
        return first_jam(self.places, f, FLOOR * float(f.max()))

    def link(self, snapshot: int, s: np.ndarray | None, pitch: float) -> np.ndarray:
        """Return (places, lambda) of a snapshot [m, 1/m], averaged over a pitch, (2, n)."""
        table = sim.link_density(*self.run.strands(snapshot), resolution=pitch)
        found = table["s"].to_numpy(), table["link"].to_numpy()
        return np.array(found if s is None else (s, np.interp(s, *found)))

    def scalars(self) -> dict[str, float]:
        """Return f_max, D [m], w and the first jam of a combing, rho_N [1/m] of a curl."""
        if not self.combs:
            return self._interactions()
        facts = {key: float(self.curve.attrs[key]) for key in ("f_max", "D", "w")}
        return facts | {"first_jam": np.nan if self.jam[1] is None else self.jam[1]}

    def _interactions(self) -> dict[str, float]:
        """Return density of the N-body interactions of the last snapshot, seen from the front."""
        seen = [np.column_stack([-x[:, 0], -x[:, 2]]) for x in self.run.strands(-1)]
        if len(seen) < 2:
            return {}
        found = imaging.interactions(seen, SECTIONS, table=imaging.crossings(seen))
        density = found.groupby("N")["count"].sum() / found.attrs["length"]
        return {f"rho_{n}": float(value) for n, value in density.items()}

"""How far two runs of one combing are apart up to the first release."""

from typing import NamedTuple

import numpy as np
from scipy.interpolate import PchipInterpolator

import sim
from combing.bands.quantities import Quantities
from combing.errors import UserError

MARGIN = 0.95  # of the way to the release, at whose brink curves part
SCATTER = 0.1  # of the way: about three sd of the place of the first release over members
FEWEST = 8  # places of a curve, which are a sixteenth of its averaging length apart
SHOTS = 8  # snapshots before it at which lambda is looked at


class Apart(NamedTuple):
    """Largest difference of f, over the highest f, and of lambda, over lambda_0 = 1/P.

    That of lambda is NaN without a pair, or without a snapshot before the release.
    """

    force: float
    link: float

    @property
    def worst(self) -> float:
        """The larger of the two."""
        return float(np.nanmax(self))


def apart(run: sim.Run, reference: sim.Run) -> Apart:
    """Return how far a run is from a reference, from the start to the first release.

    The place of the release scatters: what differs by less than SCATTER is compared up to the first
    of both releases, a run that lets go earlier than that up to the reference's.

    Parameters
    ----------
    run, reference : sim.Run
        The same combing of helices at other settings.

    Raises
    ------
    UserError
        The reference lets go before there is a curve.
    """
    one, other = Quantities(run), Quantities(reference)
    last = MARGIN * _release(one.jam[0], other.jam[0] or float(other.places[-1]))
    d = other.places[other.places <= last]
    if len(d) < FEWEST:
        raise UserError(
            f"{reference.data.attrs['title']}: the tine is let go within {1e3 * last:.2g} mm: "
            "there is no curve before the first release that could be within a tolerance"
        )
    f = other.force(d)
    force = float(np.abs(one.force(d) - f).max() / f.max())
    return Apart(force, _link_apart(one, other, last) if other.pair else np.nan)


def _release(one: float | None, reference: float) -> float:
    return min(one, reference) if one and one > (1 - SCATTER) * reference else reference


def _link_apart(one: Quantities, other: Quantities, last: float) -> float:
    """Compare snapshots at the same places of the tine, those of `one` from around them."""
    pitch = other.run.scene.rods[0].shape.pitch  # type: ignore[union-attr]
    before = np.flatnonzero((other.run.displacements > 0) & (other.run.displacements <= last))
    largest = 0.0 if len(before) else np.nan
    for snapshot in before[:: max(1, len(before) // SHOTS)]:
        s, link = other.link(int(snapshot), None, pitch)
        there = _at(one, float(other.run.displacements[snapshot]), s, pitch)
        largest = max(largest, float(np.abs(there - link).max() * pitch))
    return largest


def _at(one: Quantities, d: float, s: np.ndarray, pitch: float) -> np.ndarray:
    """Return lambda over s with the tine at d [m], monotone between the four nearest snapshots.

    Of those with the tine at one place the last: before it moves it is not even inserted at first.
    """
    places = one.run.displacements
    moving = np.flatnonzero(np.diff(places, append=np.inf) > 0)
    first = int(np.clip(np.searchsorted(places[moving], d) - 2, 0, max(len(moving) - 4, 0)))
    near = moving[first : first + 4]
    around = np.array([one.link(int(k), s, pitch)[1] for k in near])
    at = np.clip(d, places[near[0]], places[near[-1]])
    return np.asarray(PchipInterpolator(1e3 * places[near], around)(1e3 * at))

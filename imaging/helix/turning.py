"""How far two strands have turned about each other, from which colour is seen where along a band.

Every section of the band shows the front strand whole and what the other leaves uncovered. A hidden
Markov chain walks along the sections: its states are the phase and the pitch, what it emits is the
picture that two tubes of that phase and pitch give. No edge is needed to a fraction of a pixel, and
fibres that stand off, or a shadow, spoil some sections, not the count.
"""

from dataclasses import dataclass
from functools import lru_cache

import numba
import numpy as np

Array = np.ndarray
PHASES = 48
PITCHES = 5.0 * 1.22 ** np.arange(13)  # strand radii, for either hand
RATES = np.sort(np.r_[-1 / PITCHES, 0.0, 1 / PITCHES])  # turns a strand radius
STILL = len(PITCHES)  # index of the rate of strands that do not wind
WIDE = 1.5  # times the pair's half width that a band reaches to either side
PLACES = 25  # across a band
ODD = 0.06  # of what is seen, whatever the strands do: fibres, dirt, gloss
SAID = 0.35  # of a place's colour is news: neighbours, a sixth of the half width apart, are alike
SHIFTS = (-2, -1, 0, 1, 2)  # places by which the axis may be off
SLOWEST = 0.5 * RATES[RATES > 0].min()
KNOWN = 0.7  # length of the mean of exp(i phi)
HOP = 0.1  # chance a section to go to the next pitch
LEAST = 1e-18  # probability of a state
WANDER = 0.05  # chance a section that the phase of strands that do not wind goes one on


@dataclass(frozen=True)
class Turning:
    """Phase along a band, as far as the colours tell it.

    Attributes
    ----------
    phi : (n,) array
        Phase [rad], lifted from section to section; pi/2 + 2 pi n where strand a is in front.
    sure : (n,) array
        Length of the mean of exp(i phi) over its distribution: 1 where it is known.
    rate : (n,) array
        Turns a strand radius.
    agreement : (n,) array
        Share of what either strand shows that two tubes of that phase would show.
    gain : float
        Log evidence per strand radius of axis for strands that wind against strands that lie still.
    ratio : float
        Helix radius over strand radius.
    """

    phi: Array
    sure: Array
    rate: Array
    agreement: Array
    gain: float
    ratio: float

    @property
    def winds(self) -> np.ndarray:
        """Sections in which the strands wind, and which way is known."""
        return (np.abs(self.rate) > SLOWEST) & (self.sure > KNOWN)


def turning(shown: Array, step: float, ratio: float) -> Turning:
    """Follow the phase along a band.

    Parameters
    ----------
    shown : (n, PLACES, 3) array
        How much of each place strand a, strand b and neither cover; places run over WIDE times the
        pair's half width to either side, along the axis' normal.
    step : float
        Distance between sections over the strand radius.
    ratio : float
        Helix radius over strand radius.
    """
    pictures = _pictures(ratio)
    said = np.log((1 - ODD) * shown + ODD / 3).astype(np.float32)
    emitted = SAID * _matched(said, pictures)
    emitted = emitted.reshape(len(shown), len(RATES), PHASES)
    evidence, posterior = _walk(emitted, RATES * step * PHASES)
    mean = posterior.sum(axis=1) @ np.exp(2j * np.pi * np.arange(PHASES) / PHASES)
    likely = posterior.reshape(len(shown), -1).argmax(axis=1)
    gain = (evidence - _still(emitted[:, STILL])) / (len(shown) * step)
    agreement = _agreement(shown, pictures.reshape(-1, PLACES, 3)[likely])
    rate = posterior.sum(axis=2) @ RATES
    return Turning(np.unwrap(np.angle(mean)), np.abs(mean), rate, agreement, gain, ratio)


@lru_cache(maxsize=8)
def _pictures(ratio: float) -> Array:
    """Draw what each state shows, (rates * phases, PLACES * 3): strand a, strand b or neither.

    Sections of tubes about the curves +-ratio cos(phi), the higher one in front.
    """
    reach = WIDE * (1 + ratio)
    u, x = np.linspace(-reach, reach, PLACES), np.arange(-2.5, 2.51, 0.125)
    start = 2 * np.pi * np.arange(PHASES)[:, None] / PHASES
    shown = np.empty((len(RATES), PHASES, PLACES, 3), np.float32)
    for j, rate in enumerate(RATES):
        phi = start + 2 * np.pi * rate * x
        a, b = (_height(side * ratio, phi, x, u) for side in (1.0, -1.0))
        bare = np.isinf(a) & np.isinf(b)
        shown[j] = np.stack([(a >= b) & ~bare, (b > a) & ~bare, bare], axis=-1)
    return shown.reshape(len(RATES) * PHASES, -1)


def _height(radius: float, phi: Array, x: Array, u: Array) -> Array:
    """Height (phases, places) of a tube of radius 1 above the section's places; -inf beside it."""
    square = x**2 + (u[:, None] - radius * np.cos(phi)[:, None]) ** 2
    foot = square.argmin(axis=2)
    near = square.min(axis=2)
    axis = np.take_along_axis(radius * np.sin(phi), foot, axis=1)
    return np.where(near < 1, axis + np.sqrt(np.maximum(1 - near, 0)), -np.inf)


def _matched(said: Array, pictures: Array) -> Array:
    """Log probability (n, states) of each section, the axis being off by the best of SHIFTS."""
    best, match = np.full((2, len(said), len(pictures)), -np.inf, np.float32)
    bare = np.log(np.array([ODD / 3, ODD / 3, 1 - 2 * ODD / 3], np.float32))
    for shift in SHIFTS:
        moved = np.roll(said, shift, axis=1)
        moved[:, slice(0, shift) if shift > 0 else slice(said.shape[1] + shift, None)] = bare
        np.matmul((moved if shift else said).reshape(len(said), -1), pictures.T, out=match)
        np.maximum(best, match, out=best)
    return best


def _agreement(shown: Array, pictures: Array) -> Array:
    """Of the places where picture and likeliest state show a strand, the share with the same one.

    (n,), each section at the shift of the axis that suits it best.
    """
    same = np.empty((len(SHIFTS), len(shown)))
    other = np.empty_like(same)
    for k, shift in enumerate(SHIFTS):
        moved = np.roll(shown, shift, axis=1)[..., :2]
        same[k] = (moved * pictures[..., :2]).sum(axis=(1, 2))
        other[k] = (moved * pictures[..., 1::-1]).sum(axis=(1, 2))
    best = (same - other).argmax(axis=0), np.arange(len(shown))
    return same[best] / np.maximum(same[best] + other[best], 1.0)


def _walk(emitted: Array, move: Array) -> tuple[float, Array]:
    """Log evidence, and distribution (n, rates, phases) of the states (forward-backward)."""
    top = emitted.max(axis=(1, 2), keepdims=True)
    posterior = np.exp(np.maximum(emitted - top, np.log(LEAST, dtype=np.float32)))
    totals = np.empty(len(posterior))
    whole = np.floor(move)
    _forth_and_back(posterior, whole.astype(int), (move - whole).astype(np.float32), totals)
    return float(np.log(totals).sum() + top.sum()), posterior


@numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz"})
def _forth_and_back(likely, whole, part, totals):
    """Turn likelihoods (n, rates, phases) into the distribution of the states."""
    n, rates, phases = likely.shape
    seen = likely.copy()
    moved = np.full((rates, phases), np.float32(1 / (rates * phases)), likely.dtype)
    twice = np.empty(2 * phases, likely.dtype)
    for t in range(n):
        if t:
            _hop_and_move(likely[t - 1], whole, part, twice, moved)
        totals[t] = _weighed(moved, seen[t], likely[t])
    back = np.ones((rates, phases), likely.dtype)
    for t in range(n - 2, -1, -1):
        _weighed(back, seen[t + 1], back)
        _move_back_and_hop(back, whole, part, twice, moved)
        _weighed(likely[t], back, likely[t])


@numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz"})
def _weighed(p, by, out):
    """Multiply two distributions, so that they sum to one; returns what they summed to.

    Nothing falls below LEAST: numbers too small to be normal would take a hundred times as long.
    """
    total = np.float32(0)
    for r in range(len(p)):
        for c in range(p.shape[1]):
            out[r, c] = p[r, c] * by[r, c]
            total += out[r, c]
    each = np.float32(1.0 / (total + LEAST))
    for r in range(len(p)):
        for c in range(p.shape[1]):
            out[r, c] = max(out[r, c] * each, np.float32(LEAST))
    return total


@numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz"})
def _neighbours(p, r, out):
    """Let the rate go to its neighbours: row ``r`` of what is left."""
    above, below = p[max(r - 1, 0)], p[min(r + 1, len(p) - 1)]
    up, down = np.float32(HOP * (r > 0)), np.float32(HOP * (r < len(p) - 1))
    for c in range(p.shape[1]):
        out[c] = np.float32(1 - 2 * HOP) * p[r, c] + up * above[c] + down * below[c]


@numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz"})
def _hop_and_move(p, whole, part, twice, out):
    """Let the rate hop, then turn on by each rate's cells, shared between two."""
    phases = p.shape[1]
    for r in range(len(p)):
        _neighbours(p, r, twice[:phases])
        twice[phases:] = twice[:phases]
        at = -(whole[r] + 1) % phases
        before = twice[at : at + phases + 1]
        for c in range(phases):
            out[r, c] = (1 - part[r]) * before[c + 1] + part[r] * before[c]


@numba.njit(cache=True, fastmath={"reassoc", "contract", "nsz"})
def _move_back_and_hop(p, whole, part, twice, moved):
    """Bring to each state what those weigh that it turns into (the transpose of the above)."""
    phases = p.shape[1]
    for r in range(len(p)):
        twice[:phases] = p[r]
        twice[phases:] = p[r]
        at = whole[r] % phases
        after = twice[at : at + phases + 1]
        for c in range(phases):
            moved[r, c] = (1 - part[r]) * after[c] + part[r] * after[c + 1]
    for r in range(len(p)):
        _neighbours(moved, r, p[r])


def _still(emitted: Array) -> float:
    """Log evidence of (n, phases) for strands whose phase only wanders."""
    top = emitted.max(axis=1, keepdims=True)
    return float(top.sum() + _wander(np.exp(emitted - top).astype(float)))


@numba.njit(cache=True)
def _wander(likely):
    """Log evidence of likelihoods (n, phases)."""
    phases = likely.shape[1]
    p, evidence = np.full(phases, 1 / phases), 0.0
    for seen in likely:
        p = ((1 - 2 * WANDER) * p + WANDER * (np.roll(p, 1) + np.roll(p, -1))) * seen
        total = p.sum()
        evidence += np.log(total)
        p /= total
    return evidence

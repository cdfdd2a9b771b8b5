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
    best = np.full((len(said), len(pictures)), -np.inf, np.float32)
    bare = np.log(np.array([ODD / 3, ODD / 3, 1 - 2 * ODD / 3], np.float32))
    for shift in SHIFTS:
        moved = np.roll(said, shift, axis=1)
        moved[:, slice(0, shift) if shift > 0 else slice(said.shape[1] + shift, None)] = bare
        match = (moved if shift else said).reshape(len(said), -1) @ pictures.T
        best = np.maximum(best, match)
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
    posterior = np.exp(emitted - top)
    totals = np.empty(len(posterior))
    whole = np.floor(move)
    _forth_and_back(posterior, whole.astype(int), (move - whole).astype(np.float32), totals)
    return float(np.log(totals).sum() + top.sum()), posterior


@numba.njit(cache=True)
def _forth_and_back(likely, whole, part, totals):
    """Turn likelihoods (n, rates, phases) into the distribution of the states."""
    n = len(likely)
    seen = likely.copy()
    p = np.full(likely.shape[1:], 1 / likely[0].size, likely.dtype)
    moved = p.copy()
    for t in range(n):
        if t:
            _hop(p, moved)
            _move(moved, whole, part, p)
        p *= seen[t]
        totals[t] = p.sum()
        p /= totals[t]
        likely[t] = p
    back = np.ones_like(p)
    for t in range(n - 2, -1, -1):
        back *= seen[t + 1]
        _move_back(back, whole, part, moved)
        _hop(moved, back)
        back /= back.sum()
        likely[t] *= back
        likely[t] /= max(likely[t].sum(), 1e-30)


@numba.njit(cache=True)
def _hop(p, out):
    """Let the rate go to its neighbours."""
    rates = len(p)
    for r in range(rates):
        for c in range(p.shape[1]):
            beside = (p[r - 1, c] if r else 0.0) + (p[r + 1, c] if r < rates - 1 else 0.0)
            out[r, c] = (1 - 2 * HOP) * p[r, c] + HOP * beside


@numba.njit(cache=True)
def _move(p, whole, part, out):
    """Turn a distribution on by each rate's cells, shared between two."""
    phases = p.shape[1]
    for r in range(len(p)):
        at = -whole[r] % phases
        for c in range(phases):
            out[r, c] = (1 - part[r]) * p[r, at] + part[r] * p[r, at - 1]
            at = at + 1 if at < phases - 1 else 0


@numba.njit(cache=True)
def _move_back(p, whole, part, out):
    """Bring to each state what those weigh that it turns into (the transpose of `_move`)."""
    phases = p.shape[1]
    for r in range(len(p)):
        at = whole[r] % phases
        for c in range(phases):
            after = at + 1 if at < phases - 1 else 0
            out[r, c] = (1 - part[r]) * p[r, at] + part[r] * p[r, after]
            at = after


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

"""Newton's method for rods that hang at rest: steps, how far each may go, and when to stop."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from sim.guards.passing import deep_pairs, newcomer
from sim.marching import Marching
from sim.statics.balance import Balance, to_lab, turned

Array = NDArray[np.float64]

STRAINED = 10.0  # by how much more the strain must be out of balance than the couples
STEPS, HALVINGS = 80, 12


class Static(NamedTuple):
    """Whether Newton's method has come to a stable rest, in how many steps, and how far it is."""

    converged: bool
    steps: int
    residual: float
    rod: int


def settle(march: Marching, tolerance: float, far: float = np.inf) -> Static:
    """Bring the rods of a march to rest; leave them where they came to.

    Parameters
    ----------
    march : Marching
        Rods clamped at their roots, their other ends free or under dead loads, without friction.
        Its forces, couples and strains are those of the state found, its velocities zero.
    tolerance : float
        Largest out-of-balance force on a node, over its weight (see `rest.scale`).
    far : float
        Give up where a node is farther than this from where it was [m].
    """
    for name in ("V0", "V1", "V2", "W0", "W1", "W2"):
        march.state.row(name)[:] = 0.0
    deep = deep_pairs(march)
    balance = Balance(march)
    step, good, before = 0, True, march.state.rows("X0 X1 X2")
    while good and step < STEPS:
        turning, pulling = balance.turning(), balance.pulling()
        residual, worst = max((float(x.max()), int(np.argmax(x))) for x in (turning, pulling))
        if residual <= tolerance:
            break
        # Where strands press on each other the strain follows what is nearly in balance: sooner, a
        # wrong force stretches the rod, which presses it deeper into its neighbour.
        if march.contact is None or pulling.max() > STRAINED * turning.max():
            balance.restrain()
        step, good = step + 1, _step(balance)
        moved = np.linalg.norm(march.state.rows("X0 X1 X2") - before, axis=0).max()
        good = good and moved <= far
    # Newton's method may come to rest on a maximum. In contact the march shows that: the stiffness
    # leaves out how the planes between elements turn, and is not exact enough for its signs.
    good = good and residual <= tolerance and (march.contact is not None or _solve(balance)[1])
    through = march.contact is not None and newcomer(deep_pairs(march), deep) is not None
    _leave(balance)
    return Static(good and not through, step, residual, int(balance.rod[worst]))


def _leave(balance: Balance) -> None:
    """Leave in the rows what the march leaves there: inner forces and couples."""
    state = balance.march.state
    balance.evaluate(balance.frames)
    inner = (balance.strain - [0, 0, 1]) * balance.stiffness
    normal, shear = (
        to_lab(balance.frames, inner),
        balance.length[:, None] * np.cross(balance.strain, inner),
    )
    for axis in range(3):
        state.row(f"N{axis}")[:] = np.where(balance.real, normal[:, axis], 0.0)
        state.row(f"E{axis}")[:] = np.where(balance.real, shear[:, axis], 0.0)


def _step(balance: Balance) -> bool:
    """Take one step; return whether it led nearer to rest."""
    if not balance.contacts():
        return False
    frames, couple = balance.frames, balance.couple
    turns, _ = _solve(balance)
    share = balance.reach(turns)[np.maximum(balance.rod, 0)]
    together = balance.march.contact is not None
    for _ in range(HALVINGS):
        step = share[:, None] * turns
        balance.evaluate(turned(frames, step))
        work = np.where(balance.real, ((couple + balance.couple) * step).sum(axis=1), 0.0)
        gained = _by_rod(balance, work, together)
        if (gained >= 0).all():
            return True
        share = np.where(gained[np.maximum(balance.rod, 0)] >= 0, share, 0.5 * share)
    size = np.abs(couple).max()
    return bool(np.abs(balance.couple).max() < size)


def _by_rod(balance: Balance, values: Array, together: bool) -> Array:
    """Return the sum of values of elements over each rod, over all if they go together."""
    found = np.bincount(
        balance.rod[balance.real], values[balance.real], len(balance.march.scene.rods)
    )
    return np.full(len(found), found.sum()) if together else np.asarray(found, float)


def _solve(balance: Balance) -> tuple[Array, bool]:
    """Return the turns that Newton's method asks for, and whether the state is one of stability.

    Where it is not, what lowers the energy's curvature is left out of it.
    """
    factor, shift = _factor(balance.tridiagonal())

    def solved(values: Array) -> Array:
        return np.asarray(cho_solve_banded((factor, False), values))

    free, stiff, lever = solved(balance.couple.ravel()), balance.stiff, balance.lever
    if len(stiff) == 0:
        return free.reshape(-1, 3), shift == 0
    arms = lever.reshape(len(stiff), -1)
    bent = solved(arms.T)
    give = arms @ bent
    softer = np.count_nonzero(np.linalg.eigvalsh(np.diag(1 / stiff) + give) < 0)
    stable = softer == np.count_nonzero(stiff < 0)
    if not stable:
        keep = stiff > 0
        stiff, arms, bent, give = stiff[keep], arms[keep], bent[:, keep], give[keep][:, keep]
    force = np.linalg.solve(np.diag(1 / stiff) + give, arms @ free)
    return (free - bent @ force).reshape(-1, 3), stable and shift == 0


def _factor(band: Array) -> tuple[Array, float]:
    """Return the Cholesky factor of a band, and by what part its diagonal was raised for it."""
    shift = 0.0
    while True:
        try:
            more = band.copy()
            more[5] += shift * np.abs(band[5])
            return cholesky_banded(more), shift
        except np.linalg.LinAlgError:
            shift = max(4 * shift, 1e-4)

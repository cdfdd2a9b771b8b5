"""Newton's method for rods that hang at rest: steps, how far each may go, and when to stop.

A step solves (K + m M) p = net, K the stiffness, M the inertia of the march. With a large m [1/s^2]
it is a step of the march's own fall under drag; m is raised where K has directions in which the
energy curves downwards or the step led too far, lowered where it led well, and nothing at the end.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from sim import rest
from sim.guards.passing import deep_pairs, newcomer
from sim.march.marching import Marching
from sim.march.neighbours import rebuild
from sim.statics.balance import Balance
from sim.statics.stiffness import stiffness

Array = NDArray[np.float64]

STEPS, CUTS = 100, 12
LEAST, MOST = 0.1, 0.7  # of a step that led too far, the next one tried
SMALL = 0.3  # of what may be gone at once: a step that led less far was too bold
GAIN, SLOW, LOSS = 4.0, 1.5, 3.0  # by how much m falls after good and cut steps, rises after bad
SLIGHT, HOPELESS = 1e-4, 1e15  # of m's unit: less is nothing, more does not help
ROUNDS, PUSH = 30, 0.02  # of inverse iteration; rad, by how much rods leave a saddle


class Static(NamedTuple):
    """Whether Newton's method has come to a stable rest, in how many steps, and how far it is."""

    converged: bool
    steps: int
    residual: float
    rod: int


def settle(march: Marching, tolerance: float, far: float = np.inf, soft: float = 1.0) -> Static:
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
    soft : float
        Its strains of stretch and shear belong to rigidities multiplied by this.
    """
    for name in ("V0", "V1", "V2", "W0", "W1", "W2"):
        march.state.row(name)[:] = 0.0
    rebuild(march)
    deep, before = deep_pairs(march), march.state.rows("X0 X1 X2")
    balance, pull = Balance(march, soft), Pull()
    step, stable, residual = 0, False, np.inf
    while step < STEPS:
        residual = float(rest.imbalance(march).max())
        if residual <= tolerance:
            stable = _leave_saddle(balance, pull)
        if stable or not (residual <= tolerance or _step(balance, pull)):
            break
        step += 1
        rebuild(march)
        if np.linalg.norm(march.state.rows("X0 X1 X2") - before, axis=0).max() > far:
            break
    through = newcomer(deep_pairs(march), deep) is not None
    return Static(stable and not through, step, residual, rest.worst(march))


class Pull:
    """m, by which steps are held back [1/s^2], in units of (pace/length)^2."""

    unit, now = 1.0, 0.0

    def more(self, by: float) -> None:
        """Hold steps back more."""
        self.now = max(by * self.now, self.unit)

    def less(self, by: float) -> None:
        """Hold steps back less, and not at all below a slight part of the unit."""
        self.now = self.now / by if self.now > SLIGHT * self.unit else 0.0


def factor(matrix: sparse.csc_matrix, balance: Balance, pull: float) -> tuple[SuperLU, bool]:
    """Return the factors of K + m M and whether it is positive definite.

    Without pivots off the diagonal the signs of U's are those of the eigenvalues (Sylvester).
    """
    held = matrix + pull * sparse.diags_array(balance.inertia[balance.free])
    found = splu(
        sparse.csc_matrix(held), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )  # fmt: skip
    symmetric = bool((found.perm_r == found.perm_c).all())
    return found, symmetric and bool((found.U.diagonal() > 0).all())


def _held_back(balance: Balance, pull: Pull) -> tuple[SuperLU, bool]:
    """Return the factors of K + m M, and whether some m makes it positive definite."""
    matrix = stiffness(balance)
    balance.evaluate()  # the rows that the differences have used
    march = balance.march
    pull.unit = (rest.pace(march) / rest.longest(march)) ** 2  # without gravity known from loads
    factors, stable = factor(matrix, balance, pull.now)
    while not stable and pull.now < HOPELESS * pull.unit:
        pull.more(GAIN)
        factors, stable = factor(matrix, balance, pull.now)
    return factors, stable


def _leave_saddle(balance: Balance, pull: Pull) -> bool:
    """Tell whether rods in balance are at a minimum of energy; push them off where they are not.

    Along the direction in which the energy falls fastest, by inverse iteration; of its two signs
    one is taken, always the same.
    """
    pull.now = 0.0
    factors, _ = _held_back(balance, pull)
    if pull.now == 0.0:
        return True
    free, heavy = balance.free, balance.inertia[balance.free]
    along = np.random.default_rng(0).standard_normal(len(heavy))
    for _ in range(ROUNDS):
        along = factors.solve(heavy * along)
        along /= np.abs(along).max()
    push = np.zeros_like(balance.net)
    push[free] = along * PUSH / np.abs(along[np.nonzero(free)[1] >= 3]).max()
    share = balance.of_rod(balance.reach(push))
    balance.step(balance.frames, balance.strain, push, share)
    return False


def _step(balance: Balance, pull: Pull) -> bool:
    """Take one step down in energy; return whether there was one."""
    factors, stable = _held_back(balance, pull)
    if not stable:
        return False
    move = np.zeros_like(balance.net)
    move[balance.free] = factors.solve(balance.net[balance.free])
    whole = balance.reach(move)
    taken = _search(balance, move, whole)
    if (taken < SMALL * whole).any():
        pull.more(LOSS)
    else:
        free = balance.march.contact is None
        pull.less(GAIN if free or (taken == 1).all() else SLOW)
    return bool((taken > 0).all())


def _search(balance: Balance, move: Array, share: Array) -> Array:
    """Go as far along a step as it leads down, rod by rod; return which parts of it.

    The work of all forces along it, the loss of energy, must not be negative.
    """
    frames, strain = balance.frames, balance.strain
    slope = balance.by_rod((balance.net * move).sum(axis=1))
    residual = float(rest.imbalance(balance.march).max())
    for _ in range(CUTS):
        balance.step(frames, strain, move, balance.of_rod(share))
        end = balance.by_rod((balance.net * move).sum(axis=1))
        if (slope + end >= 0).all() or rest.imbalance(balance.march).max() < 0.5 * residual:
            return share
        cut = np.clip(slope / np.maximum(slope - end, 1e-300), LEAST, MOST)
        share = np.where(slope + end >= 0, share, cut * share)
    balance.put(frames, strain)
    return np.zeros_like(share)

"""How smooth the phase, axis, radius and lean of a double helix are taken to be, from the data."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d
from scipy.special import digamma, gammaln

from imaging.helix.banded import Bordered, Rows
from imaging.helix.model import Model
from imaging.helix.space import heading

Array = np.ndarray
Mask = np.ndarray
ABRUPT, SMOOTH = 1.0, np.inf  # degrees of freedom of changes: few and large, or many
BLIND = 3  # knots by which the place of an abrupt change may be missed
PENALISED = {"phi": 2, "mid": 2, "R": 1, "lean": 1}  # block -> order of the difference
REACH = 0.5  # pitch; over which smoothness is alike
STRETCH = 0.3  # weight of the whole stretch in it
AS_BENT, STRAIGHTER = 1.0, 100.0  # least and largest weight of the lean's differences
LEAST_BEND = 0.02  # rad a pitch


@dataclass(frozen=True)
class Prior:
    """How stiff each block of unknowns is: sum of weight * local * difference^2.

    The weight varies along the axis: it is that of differences nearby, mixed with those of the
    whole stretch between two gaps (``groups``), by the matrices ``means``. A kink is not as smooth
    as what hangs below it, and what a tine has combed not as even as what it has not.

    Differences may be few and large, as where the link density steps: they are taken to follow
    Student's distribution with ABRUPT degrees of freedom, so that the local weight falls where a
    step is seen and the rest stays smooth. Those of the phase have ``tail`` degrees of freedom:
    where the link density varies smoothly, a Gaussian's (SMOOTH) describe them.

    Where nothing is fitted the axis would run on as straight as it came. ``seen`` are weights and
    values that hold its coefficients there to the middle of what is seen.

    ``shading`` is by how much [px] light from one side may move the two edges of a strand: those of
    both strands alike, and those of one against those of the other.
    """

    differences: dict[str, Rows]
    groups: dict[str, np.ndarray]
    means: dict[str, Array]
    tail: float = ABRUPT
    seen: tuple[Array, Array] | None = None
    shading: tuple[float, float] = (0.2, 0.2)
    weights: dict[str, Array] = field(default_factory=dict)
    local: dict[str, Array] = field(default_factory=dict)

    def stiffened(self, matrix: Bordered) -> Bordered:
        """Add D' diag(weight * local) D of each block."""
        for name, d in self.differences.items():
            matrix = matrix.plus(d, self._stiffness(name))
        return matrix

    def updated(self, x: Array, covariance: Bordered, stiffest: dict[str, float]) -> "Prior":
        """Re-estimate the weights from the sorted unknowns x (Fellner-Schall; Student's mean).

        w <- (m - w tr(V S)) / (beta' S beta), Wood & Fasiolo, Biometrics 73 (2017), with sums
        over nearby differences.
        """
        weights, local = {}, dict(self.local)
        for name, d in self.differences.items():
            here = self.local.get(name, np.ones(len(d.values)))
            spread = d.spread(covariance)
            size = d.times(x) ** 2
            held, seen = (
                self.means[name] @ value
                for value in (self.weights.get(name, 1.0) * here * spread, here * size)
            )
            free = np.maximum(1 + STRETCH - held, 1e-6)
            least = AS_BENT if name == "lean" else 0.0
            weights[name] = np.clip(free / np.maximum(seen, 1e-300), least, stiffest[name])
            tail = self.tails[name]
            if np.isfinite(tail):
                local[name] = (tail + 1) / (tail + weights[name] * (size + spread))
        return replace(self, weights=weights, local=local)

    def _stiffness(self, name: str) -> Array:
        """Weight of each difference."""
        ones = np.ones(len(self.differences[name].values))
        return self.weights.get(name, 1.0) * self.local.get(name, 1.0) * ones

    @property
    def tails(self) -> dict[str, float]:
        """Degrees of freedom of each block's differences."""
        return {"phi": self.tail, "mid": ABRUPT, "R": ABRUPT, "lean": SMOOTH}

    def blunted(self) -> "Prior":
        """Return the prior with abrupt changes possible wherever one is within BLIND knots.

        The local weights say where a change is as if its place were known.
        """
        size = 2 * BLIND + 1
        local = {name: minimum_filter1d(here, size) for name, here in self.local.items()}
        return replace(self, local=local)

    def localised(self, model: Model) -> "Prior":
        """Return the prior with a smoothness of the phase that varies along the axis."""
        near = _means(self.groups["phi"], REACH * model.pitch / _spacing(model, "phi"))
        return replace(self, means=self.means | {"phi": near})

    def fresh(self, tail: float) -> "Prior":
        """Return the prior with nothing estimated yet, and this ``tail`` of the phase's."""
        return Prior(self.differences, self.groups, self.means, tail, self.seen, self.shading)

    def expected(self, x: Array, covariance: Bordered) -> float:
        """Mean log density of sorted unknowns of this mean and covariance (a lower bound).

        Local weights follow Gamma(n/2, n/2), which makes the differences Student's with n degrees
        of freedom (Tipping & Lawrence, Neurocomputing 69 (2005)).
        """
        total = 0.0
        for name, d in self.differences.items():
            spread = d.spread(covariance)
            weight, tail = self.weights[name], self.tails[name]
            size = weight * (d.times(x) ** 2 + spread)
            total += float(np.sum(0.5 * np.log(weight) + _gain(size, tail)))
            # Where the prior alone decides, the bound is loose by as much as at size 1.
            undecided = float(np.sum(weight * self.local.get(name, 1.0) * spread))
            total -= undecided * float(_gain(np.array(1.0), tail) - _gain(np.array(1.0), SMOOTH))
        return total


def first_prior(model: Model, held: dict[str, Mask]) -> Prior:
    """Return the prior to start from.

    Parameters
    ----------
    model : Model
    held : dict
        For each penalised block, the differences (bool) to penalise; False in gaps, so that what
        lies before and behind a tine is fitted apart.
    """
    differences = {name: _differences(model, name, held[name]) for name in PENALISED}
    lean, bend = differences["lean"], _bend(model)[held["lean"]]
    differences["lean"] = replace(lean, values=lean.values / bend[:, None])
    groups = {name: _groups(held[name]) for name in PENALISED}
    reach = {name: REACH * model.pitch / _spacing(model, name) for name in PENALISED}
    reach["phi"] = np.inf
    means = {name: _means(groups[name], reach[name]) for name in PENALISED}
    return Prior(differences, groups, means, SMOOTH)


def _differences(model: Model, name: str, held: Mask) -> Rows:
    """Differences of one block of unknowns, those not ``held`` left out."""
    order, layout = PENALISED[name], model.layout
    places = layout.blocks[name].start + np.flatnonzero(held)[:, None] + np.arange(order + 1)
    signs = np.diff(np.eye(order + 1), n=order, axis=0)
    return Rows(layout.rank[places], np.repeat(signs, len(places), axis=0))


def _bend(model: Model) -> Array:
    """Angle [rad] by which the axis bends in the picture between knots of the lean, as typical.

    No view is special: a pair that bends in the picture bends about as much out of it.
    """
    table, middles = model.table, model.layout.lean[2:-2]
    step = table.s[1] - table.s[0]
    curvature = np.gradient(heading(model), table.s)
    typical = np.sqrt(gaussian_filter1d(curvature**2, 0.5 * model.pitch / step))
    here = np.interp(0.5 * (middles[1:] + middles[:-1]), table.s, typical)
    return np.maximum(here, LEAST_BEND / model.pitch) * np.diff(middles)


def _groups(held: Mask) -> np.ndarray:
    """Return the number of the run that each held difference belongs to."""
    return np.unique(np.cumsum(~held)[held], return_inverse=True)[1]


def _spacing(model: Model, name: str) -> float:
    knots = getattr(model.layout, name)
    return float(knots[1] - knots[0])


def _means(groups: np.ndarray, reach: float) -> Array:
    """Matrix of the mean over near values of a group, plus STRETCH times that over all of it."""
    means = np.zeros((len(groups), len(groups)))
    for group in np.unique(groups):
        own = np.flatnonzero(groups == group)
        all_alike = np.full((len(own), len(own)), 1 / len(own))
        near = all_alike
        if np.isfinite(reach):
            near = gaussian_filter1d(np.eye(len(own)), reach, axis=0, mode="constant")
            near /= near.sum(axis=1, keepdims=True)
        means[np.ix_(own, own)] = near + STRETCH * all_alike
    return means


def _gain(size: Array, tail: float) -> Array:
    """E[log(u)/2 - u size/2] - KL(u) of local weights u with their best distribution."""
    if np.isinf(tail):
        return -0.5 * size
    a, b, a0 = (tail + 1) / 2, (tail + size) / 2, tail / 2
    log_u = digamma(a) - np.log(b)
    apart = (
        (a - a0) * digamma(a) - gammaln(a) + gammaln(a0) + a0 * np.log(b / a0) + a * (a0 / b - 1)
    )
    return 0.5 * log_u - 0.5 * a / b * size - apart

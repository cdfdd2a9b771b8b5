"""Fit the phase, axis, radius and lean of two twisted strands to their visible edges.

Strategy: every edge point must lie at the effective tube radius from the nearest point of its
strand's centreline. Least squares with Tukey weights; second differences of the phase and the axis
and first differences of the radius and the lean are penalised, with weights from the data
(`imaging.helix.prior`). Neighbouring edge points err together, so the noise variance that enters is
the one of independent points: the residuals' variance nearby times their correlation length.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from imaging.errors import Unmeasurable
from imaging.helix.banded import Bordered, Rows, inverse, log_determinant, solve
from imaging.helix.edges import NO_EDGE, OUTER, Edges
from imaging.helix.model import Model, feet, positions
from imaging.helix.prior import ABRUPT, PENALISED, STRAIGHTER, Prior, first_prior
from imaging.helix.splines import weights

Array = np.ndarray
Mask = np.ndarray
TUKEY = 4.685
RUN = 10.0  # edge points along which shading errs alike
FACING = 0.5  # sine of the lean that a photographer may leave
LEAST_NOISE = 1e-3  # px
LONE = 20.0  # times the typical distance from the outline; more counts as this much
UPDATES = 4  # of the prior, each step
FEWER = 0.7  # of the phase's free parameters; measured: 0.3 and 0.5 beside a tine, 0.9 in waves
EVEN = 1e6  # largest ratio of a penalty to the information in the data


@dataclass(frozen=True)
class Fit:
    """A fitted model with what is needed for its uncertainty.

    Attributes
    ----------
    model : Model
    certainty : Bordered
        Inverse of the posterior covariance of the sorted unknowns.
    prior : Prior
        Penalties, as estimated.
    freedom : dict
        Effective number of free parameters of each block.
    noise : float
        Robust standard deviation of one edge point [px].
    correlation : float
        Number of neighbouring edge points that err as one.
    residual : (n,) array
        Distance of every edge point from the fitted outline [px].
    """

    model: Model
    certainty: Bordered
    prior: Prior
    freedom: dict[str, float]
    noise: float
    correlation: float
    residual: Array

    @cached_property
    def covariance(self) -> Array:
        """Posterior covariance (p, p) of the unknowns."""
        rank = self.model.layout.rank
        return inverse(self.certainty.dense())[np.ix_(rank, rank)]


def fit_best(first: Fit, edges: Edges, held: dict[str, Mask], rounds: int = 6) -> Fit:
    """Fit again, with smooth and with abrupt changes of phase; return the more probable fit.

    Smooth changes may then be smoother here than there; many weights would not be compared fairly
    with one. How much the lean may vary is taken anew from the bends of the axis fitted first.
    """
    old = first.prior
    prior = replace(first_prior(first.model, held), seen=old.seen, shading=old.shading)
    smooth = fit(first.model, edges, replace(prior, weights=first.prior.weights), rounds)
    # From a slack prior, or the smooth fit would hold the local weights alike.
    abrupt = fit(smooth.model, edges, prior.fresh(ABRUPT), 2 * rounds)
    precision = _noise(smooth.model, smooth.residual, edges)[2]
    gain = evidence(abrupt, edges, precision) - evidence(smooth, edges, precision)
    # That precision leaves out what smooth changes cannot follow, as near a tine; where they need
    # many more parameters for the rest all the same, they follow ripples of the edges' errors.
    if gain > 0 or abrupt.freedom["phi"] < FEWER * smooth.freedom["phi"]:
        return abrupt
    return fit(smooth.model, edges, smooth.prior.localised(smooth.model), rounds)


def fit(model: Model, edges: Edges, prior: Prior, rounds: int = 6) -> Fit:
    """Fit a model to edges.

    Parameters
    ----------
    model : Model
        Where to start; must be within about a quarter turn.
    edges : Edges
    prior : Prior
        Differences to penalise, and the penalty weights to start from.
    rounds : int
        Gauss-Newton steps.

    Raises
    ------
    Unmeasurable
        When there are no edges.
    """
    if not len(edges.s):
        raise Unmeasurable(NO_EDGE)
    layout, order = model.layout, model.layout.order
    for _ in range(rounds):
        residual, design = _linearised(model, edges)
        noise, correlation, precision = _noise(model, residual, edges)
        information = _information(model, design, precision)
        moved = residual + design.times(model.beta[order])
        target = design.transposed(precision * moved, layout.size)
        if prior.seen is not None:
            target[layout.rank[layout.blocks["mid"]]] += np.prod(prior.seen, axis=0)
        x, prior = _penalised(model, information, target, prior)
        model = model.moved(x[layout.rank])
    certainty = prior.stiffened(_held(model, information, prior))
    freedom = _freedom(model, information, certainty)
    residual, _ = _linearised(model, edges)
    return Fit(model, certainty, prior, freedom, noise, correlation, residual)


def miss(residual: Array, edges: Edges, s: Array, reach: float) -> Array:
    """Mean distance [px] of the outer edges within ``reach`` of ``s`` from the outline."""
    outer = edges.border == OUTER
    place, size = edges.s[outer], np.abs(residual[outer])
    if not size.size:
        return np.zeros(len(s))
    total = np.concatenate([[0.0], np.cumsum(np.minimum(size, LONE * np.median(size)))])
    first, last = (np.searchsorted(place, s + side * reach) for side in (-1, 1))
    return (total[last] - total[first]) / np.maximum(last - first, 1)


def worse(model: Model, residual: Array, edges: Edges, s: Array) -> Array:
    """How many times more than typical the outer edges near ``s`` miss the outline, at least 1."""
    reach = model.pitch / 4
    typical = float(np.median(miss(residual, edges, edges.s, reach)))
    return np.maximum(miss(residual, edges, s, reach) / max(typical, LEAST_NOISE), 1.0)


def widened(fitted: Fit, edges: Edges) -> Fit:
    """Return a fit whose covariance holds that the places of abrupt changes are not known."""
    residual, design = _linearised(fitted.model, edges)
    precision = _noise(fitted.model, residual, edges)[2]
    held = _held(fitted.model, _information(fitted.model, design, precision), fitted.prior)
    return replace(fitted, certainty=fitted.prior.blunted().stiffened(held))


def evidence(fitted: Fit, edges: Edges, precision: Array) -> float:
    """Log probability of the edges under the prior (a lower bound), but for a constant.

    The bound holds for any mean and covariance of the unknowns, so fits may be compared at one
    precision.
    """
    model, x = fitted.model, fitted.model.beta[fitted.model.layout.order]
    residual, design = _linearised(model, edges)
    information = _information(model, design, precision)
    covariance = solve(fitted.certainty, x)[1]
    bound = -0.5 * float(precision @ residual**2)
    bound -= 0.5 * float(covariance.row_products(information).sum())
    bound -= 0.5 * log_determinant(fitted.certainty)
    return bound + fitted.prior.expected(x, covariance)


def _linearised(model: Model, edges: Edges) -> tuple[Array, Rows]:
    """How far edges lie outside the model's outline, and the derivative of the outline (n, p)."""
    table, strand, layout = model.table, edges.strand, model.layout
    s = feet(model, strand, edges.s, edges.points)
    out = edges.points - positions(model, strand, s)
    distance = np.linalg.norm(out, axis=1)
    out /= np.maximum(distance, 1e-9)[:, None]
    v = model.at(s)
    tangent = np.column_stack([np.interp(s, table.s, table.tangents[:, i]) for i in (0, 1)])
    along = (out * tangent).sum(axis=1)
    across = out[:, 0] * tangent[:, 1] - out[:, 1] * tangent[:, 0]
    e = 1.0 - 2.0 * strand
    c, d = np.cos(v.phi), np.sin(v.phi)
    turn = e * v.R * (across * v.lean * d - along * c)
    leaning = e * v.R * along * d
    factors = {
        "phi": e * v.R * (along * v.lean * c - across * d),
        "mid": across,
        "R": e * (across * c + along * v.lean * d),
        "lean": leaning,
    }
    columns, values = [], []
    for name, factor in factors.items():
        first, spline = weights(getattr(layout, name), s)
        columns.append(layout.blocks[name].start + first[:, None] + np.arange(4))
        values.append(factor[:, None] * spline)
    values[1] += turn[:, None] * weights(layout.mid, s, 1)[1]
    common = np.column_stack([np.zeros_like(edges.kind), 1 + edges.kind])
    columns.append(layout.blocks["sight"].start + common)
    values += [leaning[:, None] * model.sight(s), np.ones((len(s), 1))]
    design = Rows(layout.rank[np.hstack(columns)], np.hstack(values))
    return distance - model.part("radii")[edges.kind], design


def _information(model: Model, design: Rows, precision: Array) -> Bordered:
    """Return what the edges tell of the sorted unknowns."""
    layout = model.layout
    nothing = Bordered.zero(layout.size - layout.shared, layout.shared, layout.width)
    return nothing.plus(design, precision)


def _noise(model: Model, residual: Array, edges: Edges) -> tuple[float, float, Array]:
    """Robust sd of a residual, mean correlation length, weight of each edge point.

    Edges against the background and edges in contact are weighted by their own scatter: shading
    moves the latter more. Where outer edges miss the outline by more than typical, within a
    quarter of a pitch, all edges are taken to be that much worse.
    """
    precision = np.zeros(len(residual))
    off = worse(model, residual, edges, edges.s)
    lengths = []
    for border in np.unique(edges.border):
        own = edges.border == border
        typical = max(1.4826 * float(np.median(np.abs(residual[own]))), LEAST_NOISE)
        scatter = np.maximum(typical, edges.doubt) * off
        robust = (1 - np.clip(np.abs(residual) / (TUKEY * scatter), 0, 1) ** 2) ** 2
        tracks = [own & (edges.track == k) for k in range(4)]
        length = float(np.mean([_correlation(residual[k], robust[k] > 0.05) for k in tracks]))
        # What shading leaves is alike along an edge.
        length = max(length, RUN if edges.doubt[own].max() > typical else 1.0)
        precision[own] = (robust / (scatter**2 * length))[own]
        lengths.append(length)
    noise = 1.4826 * float(np.median(np.abs(residual)))
    return noise, float(np.mean(lengths)), precision


def _correlation(residual: Array, good: Mask) -> float:
    """1 + 2 sum of the autocorrelations of a series until they vanish; 1 for white noise."""
    x = residual[good]
    n = len(x)
    if n < 50:
        return 1.0
    x = x - x.mean()
    spectrum = np.abs(np.fft.rfft(x, 2 * n)) ** 2
    rho = np.fft.irfft(spectrum)[: n // 4]
    rho = rho / rho[0]
    end = int(np.argmax(rho < 2 / np.sqrt(n))) or len(rho)
    return float(1 + 2 * rho[1:end].sum())


def _penalised(
    model: Model, information: Bordered, target: Array, prior: Prior
) -> tuple[Array, Prior]:
    """Solve the penalised normal equations, re-estimating the prior: sorted unknowns, prior."""
    layout, diagonal = model.layout, information.diagonal
    held = _held(model, information, prior)
    target = target + _ridge(information) * model.beta[layout.order]
    stiffest = {k: EVEN * float(diagonal[layout.rank[layout.blocks[k]]].max()) for k in PENALISED}
    stiffest["lean"] = STRAIGHTER
    for _ in range(UPDATES):
        x, near = solve(prior.stiffened(held), target)
        prior = prior.updated(x, near, stiffest)
    return x, prior


def _ridge(information: Bordered) -> Array:
    """Hold where they are unseen stretches, which have neither data nor penalty."""
    diagonal = information.diagonal
    return 1e-9 * diagonal + 1e-9 * diagonal.mean()


def _held(model: Model, information: Bordered, prior: Prior) -> Bordered:
    """Add to the information in the data what is known beforehand but for smoothness."""
    blocks, known = model.layout.blocks, np.zeros(model.layout.size)
    if prior.seen is not None:
        known[blocks["mid"]] = prior.seen[0]
    known[blocks["lean"]] = 1 / FACING**2
    matrix = information.on_diagonal(_ridge(information) + known[model.layout.order])
    matrix.corner[1:, 1:] += np.kron(np.eye(2), _shading(*prior.shading))
    return matrix


def _shading(alike: float, apart: float) -> Array:
    """Return what is known of the effective radii a-, a+, b-, b+ against one kind of border.

    Light from one side moves the edges of both strands alike. Moved apart, as if strand a lay more
    to the right wherever it is seen, they would look like a pair that leans.
    """
    both, one = np.array([-1.0, 1, -1, 1]) / 2, np.array([-1.0, 1, 1, -1]) / 2
    return np.outer(both, both) / alike**2 + np.outer(one, one) / apart**2


def _freedom(model: Model, information: Bordered, certainty: Bordered) -> dict[str, float]:
    covariance = solve(certainty, np.zeros(model.layout.size))[1]
    share = covariance.row_products(information)[model.layout.rank]
    return {name: float(share[where].sum()) for name, where in model.layout.blocks.items()}
